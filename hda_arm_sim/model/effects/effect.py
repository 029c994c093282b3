"""
What an effect is: a physical cause with a name, a place on the arm, parameters and one law.

The law is one compiled function of the effect's own record and the signals of its place. Three
consumers call it and none rewrites it. The kernel calls it with the true state, the estimator with
the measured signals of one sample, the diagnosis with a whole recording at once.
"""

from dataclasses import dataclass
from enum import Enum
from typing import Any, ClassVar

import numpy as np

from .hypothesis import Hypothesis, Typical
from .place import Place, Signal
from .words import Words
from ...foundation.parameter import Declared


class Site(Enum):
    """Which balance of the arm an effect breaks."""

    MOTOR = 'motor'
    TORSION = 'torsion'
    LINK = 'link'
    TIMING = 'timing'
    SENSING = 'sensing'


class Scope(Enum):
    """Whether an effect belongs to one joint or to the arm as a whole."""

    JOINT = 'joint'
    ARM = 'arm'


@dataclass(frozen=True)
class Effect(Declared):
    """
    One effect of the catalogue; its defaults are neutral, so that it does nothing.

    `acts` names the numbers of which one at least must differ from zero for the law to do
    anything; without names the law always acts. `spatial` names those that chains have alone. A
    `planar` effect is one of two links in a plane.
    """

    name: ClassVar[str]
    cause: ClassVar[str]
    site: ClassVar[Site]
    place: ClassVar[Place]
    acts: ClassVar[tuple[str, ...]] = ()
    spatial: ClassVar[tuple[str, ...]] = ()
    scope: ClassVar[Scope] = Scope.JOINT
    planar: ClassVar[bool] = False
    law: ClassVar[Any]
    law_slope: ClassVar[Any] = None     # how the law changes with its angle, where a place asks
    law_rate: ClassVar[Any] = None      # how the law changes with time, where a place asks
    law_chain: ClassVar[Any] = None     # how the law acts on a chain of links, where it differs
    hypothesis: ClassVar[Hypothesis | None] = None      # how balances tell it
    typical: ClassVar[Typical | None] = None            # size worth finding
    words: ClassVar[Words]              # how a page speaks of it
    # its number that an arm is given with, and which of the arm's tolerances that number has
    tolerance: ClassVar[tuple[str, str] | None] = None

    def record(self) -> Any:
        """Return the parameters as compiled code reads them."""
        return np.array(self.values(), self.record_type())[()]

    def __call__(self, **signals: Signal | Any) -> Any:
        """Return the law's value for signals of its place, a number or an array as they are."""
        return type(self).law(self.record(), self.place.reads(**signals))


_NEUTRAL: dict[type[Effect], Effect] = {}


def neutral(kind: type[Effect]) -> Effect:
    """Return an effect that does nothing; nobody can change it, so there is one."""
    if kind not in _NEUTRAL:
        _NEUTRAL[kind] = kind()
    return _NEUTRAL[kind]

"""
What an effect is: a physical cause with a name, a place on the arm, parameters and one law.

The law is one compiled function of the effect's own record and the signals of its place. Three
consumers call it and none rewrites it. The kernel calls it with the true state, the estimator with
the measured signals of one sample, the diagnosis with a whole recording at once.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum
from functools import cache
from operator import attrgetter
from typing import Any, ClassVar, NamedTuple

import numpy as np

from .hypothesis import Hypothesis, Typical, Unmeasured
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


class KnownBy(NamedTuple):
    """
    The arm's tolerance by which numbers of an effect are known, and what is said beyond it.

    Words take the `size` that was learnt, or `percent` of it; of a wave its `order` as well.
    """

    tolerance: str
    numbers: tuple[str, ...]
    beyond: str


@dataclass(frozen=True)
class Effect(Declared):
    """
    One effect of the catalogue; its defaults are neutral, so that it does nothing.

    `acts` names the numbers of which one at least must differ from zero for the law to do
    anything; without names the law always acts. `spatial` names those that chains have alone. A
    `planar` effect is one of two links in a plane. `stated` are numbers that joint or base have,
    by where these stand there.

    What the place asks for beside the law is declared here too. A law with a state, as bristles
    have, states where that stands after a while (`law_after`).
    """

    name: ClassVar[str]
    cause: ClassVar[str]
    site: ClassVar[Site]
    place: ClassVar[Place]
    acts: ClassVar[tuple[str, ...]] = ()
    spatial: ClassVar[tuple[str, ...]] = ()
    scope: ClassVar[Scope] = Scope.JOINT
    planar: ClassVar[bool] = False
    stated: ClassVar[Mapping[str, str]] = {}
    law: ClassVar[Any]
    law_slope: ClassVar[Any] = None     # how the law changes with its angle, where a place asks
    law_rate: ClassVar[Any] = None      # how the law changes with time, where a place asks
    law_chain: ClassVar[Any] = None     # how the law acts on a chain of links, where it differs
    law_after: ClassVar[Any] = None     # where the state of the law stands later
    law_stiffness: ClassVar[Any] = None     # torque per deflection of that state
    law_damping: ClassVar[Any] = None   # torque per rate, where the law has one
    law_energy: ClassVar[Any] = None    # of which the law is the slope [J]
    hypothesis: ClassVar[Hypothesis | None] = None      # how balances identify it
    typical: ClassVar[Typical | None] = None            # size worth finding
    unmeasured: ClassVar[Unmeasured | None] = None      # scatter, where calibrations look for it
    words: ClassVar[Words]              # how a page speaks of it
    # its number that an arm is given with, and which of the arm's tolerances that number has
    tolerance: ClassVar[tuple[str, str] | None] = None
    known_by: ClassVar[KnownBy | None] = None   # which tolerance its numbers may replace

    @classmethod
    def as_stated(cls, part: Any) -> 'Effect':
        """Return the effect with the numbers that a joint or a base has of it."""
        return cls(**{number: reads(part) for number, reads in cls._readers()})

    @classmethod
    @cache
    def _readers(cls) -> tuple[tuple[str, Callable[[Any], float]], ...]:
        return tuple((number, attrgetter(where)) for number, where in cls.stated.items())

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

"""
What an effect is: a physical cause with a name, a place in the arm, parameters and one law.

The law is one compiled function of signals, then parameters, by their names. Three consumers call
it and none rewrites it: the kernel with the true state, the estimator with the measured signals
of one sample, the diagnosis with a whole recording at once.
"""

from dataclasses import dataclass
from enum import Enum
import inspect
from typing import Any, ClassVar, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..parameter import Declared

Signal: TypeAlias = float | NDArray[np.float64]


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


class Signals(NamedTuple):
    """The signals that laws read, each a number or an array over time, SI units."""

    angle: Signal = 0.0                 # of the encoder that the law speaks of [rad]
    velocity: Signal = 0.0              # of that encoder's side [rad/s]
    acceleration: Signal = 0.0          # of that encoder's side [rad/s^2]
    motor_angle: Signal = 0.0           # shaft [rad]
    motor_velocity: Signal = 0.0        # shaft [rad/s]
    torsion: Signal = 0.0               # motor side minus link side, at the output [rad]
    torsion_rate: Signal = 0.0          # at the output [rad/s]
    state: Signal = 0.0                 # of a law with memory


@dataclass(frozen=True)
class Effect(Declared):
    """One effect of the catalogue; its defaults are neutral, so that it does nothing."""

    name: ClassVar[str]
    cause: ClassVar[str]
    site: ClassVar[Site]
    scope: ClassVar[Scope] = Scope.JOINT
    law: ClassVar[Any]

    @classmethod
    def signals(cls) -> tuple[str, ...]:
        """Return the names of the signals that the law reads, in order."""
        own = {rule.name for rule in cls.declarations()}
        arguments = inspect.signature(cls.law.py_func).parameters
        return tuple(name for name in arguments if name not in own)

    def __call__(self, signals: Signals) -> Any:
        """Return the law's value for these signals, a number or an array as they are."""
        return type(self).law(*(getattr(signals, name) for name in self.signals()),
                              *self.values())

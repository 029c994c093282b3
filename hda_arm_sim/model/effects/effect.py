"""
What an effect is: a physical cause with a name, a place in the arm, parameters and one law.

The law is one compiled function of signals, then parameters, by their names. Three consumers call
it and none rewrites it: the kernel with the true state, the estimator with the measured signals
of one sample, the diagnosis with a whole recording at once.
"""

from dataclasses import dataclass
from enum import Enum
from functools import cache
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

    time: Signal = 0.0                  # since the start of the recording [s]
    angle: Signal = 0.0                 # of the encoder that the law speaks of [rad]
    velocity: Signal = 0.0              # of that encoder's side [rad/s]
    acceleration: Signal = 0.0          # of that encoder's side [rad/s^2]
    motor_angle: Signal = 0.0           # shaft [rad]
    motor_velocity: Signal = 0.0        # shaft [rad/s]
    link_angle: Signal = 0.0            # of the joint [rad]
    torsion: Signal = 0.0               # motor side minus link side, at the output [rad]
    torsion_rate: Signal = 0.0          # at the output [rad/s]
    joint_torque: Signal = 0.0          # through the gear, at the output [N*m]
    command: Signal = 0.0               # motor torque asked for, at the shaft [N*m]
    last_command: Signal = 0.0          # the one before it [N*m]
    elapsed: Signal = 0.0               # time since the command, or since the state [s]
    budget: Signal = 0.0                # dry friction before the law, at the shaft [N*m]
    sense: Signal = 0.0                 # of sliding: 1, -1, or 0 at rest
    tilt_moment: Signal = 0.0           # of the weight on the bearing [N*m]
    push: Signal = 0.0                  # of the links on the base, along its swing [N]
    offset: Signal = 0.0                # of the base along its swing [m]
    offset_rate: Signal = 0.0           # of the base along its swing [m/s]
    state: Signal = 0.0                 # of a law with memory
    state_rate: Signal = 0.0            # of a law with memory
    chance: Signal = 0.0                # evenly drawn from [0, 1)
    nominal: Signal = 0.0               # the number that a parameter's error changes
    ratio: Signal = 100.0               # of the gear
    gravity: Signal = 9.80665           # [m/s^2]
    inertia: Any = None                 # rigid.Inertia of the links
    length1: Signal = 0.0               # of the links [m]
    length2: Signal = 0.0


@dataclass(frozen=True)
class Effect(Declared):
    """One effect of the catalogue; its defaults are neutral, so that it does nothing."""

    name: ClassVar[str]
    cause: ClassVar[str]
    site: ClassVar[Site]
    scope: ClassVar[Scope] = Scope.JOINT
    law: ClassVar[Any]

    @classmethod
    @cache
    def arguments(cls) -> tuple[str, ...]:
        """Return the names of what the law takes, in order: signals and own parameters."""
        return tuple(inspect.signature(cls.law.py_func).parameters)

    @classmethod
    @cache
    def signals(cls) -> tuple[str, ...]:
        """Return the names of the signals that the law reads, in order."""
        own = {rule.name for rule in cls.declarations()}
        return tuple(name for name in cls.arguments() if name not in own)

    def __call__(self, signals: Signals) -> Any:
        """Return the law's value for these signals, a number or an array as they are."""
        read = self.signals()
        return type(self).law(*(getattr(signals if name in read else self, name)
                                for name in self.arguments()))

"""What `hda new` must know of each joint, and of the links."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
import math
from typing import NamedTuple, TypeVar

from hda_arm_sim.model.gear_catalogue import Gear
from hda_arm_sim.model.parts import Joint
from hda_msgs_json.errors import HdaError

Value = TypeVar('Value')
_LAG = Joint.declaration('effort_lag')


class NewError(HdaError):
    """Answers from which no arm can be made."""


class JointOption(NamedTuple):
    """One thing to know of every joint: its option, unit and meaning."""

    name: str
    unit: str
    meaning: str
    required: bool = False
    unless: str = ''            # what stands for it where nobody knows
    low: float = 0.0
    high: float = math.inf      # which it may reach unless it is infinite

    @property
    def option(self) -> str:
        """Return the option of the command line."""
        return '--' + self.name.replace('_', '-')

    def with_unit(self, text: str) -> str:
        """Return a text with the unit behind it, if there is one."""
        return f'{text} [{self.unit}]' if self.unit else text

    @property
    def takes(self) -> str:
        """Return which numbers it takes, in words."""
        if math.isinf(self.high):
            return f'a number >= {self.low:g}'
        return f'a number from {self.low:g} to {self.high:g}'

    def read(self, text: str) -> float | None:
        """Return the number in a text, None where it is none that this takes."""
        try:
            value = float(text)
        except ValueError:
            return None
        return value if math.isfinite(value) and self.low <= value <= self.high else None


ANSWERS = (
    JointOption('motor_inertia', 'kg*m^2',
                'inertia of the rotor and what turns with it, without that '
                'of the wave generator; unless given, that of both of a servo actuator of the '
                'size', True, 'a class default'),
    JointOption('motor_torque', 'N*m', 'largest torque of the motor, at its shaft', True),
    JointOption('motor_counts', '1/turn', 'counts of the motor encoder per turn of the motor, 0 '
                'where nobody knows', True),
    JointOption('link_counts', '1/turn', 'counts of the link encoder per turn of the link, 0 '
                'where nobody knows', True),
    JointOption('ratio', '',
                'turns of the motor per turn of the link, where it is not that of the '
                'name: one more with the output at the circular spline, or with a belt'),
    JointOption('torque_constant', 'N*m/A', 'with --motor-current in the place of --motor-torque'),
    JointOption('motor_current', 'A', 'largest current of the drive'),
    JointOption('motor_speed', 'rad/s',
                'largest speed of the motor; that of the gear unless given'),
    JointOption('peak_torque', 'N*m',
                'repeated peak torque of the gear, at its output; that of the '
                'catalogue unless given'),
    JointOption('starting_torque', 'N*m', 'dry friction of motor and gear, at the motor shaft; 0, '
                'unknown, unless given'),
    JointOption('viscous_friction', 'N*m*s/rad',
                'its slope, at the motor shaft; 0, unknown, unless '
                'given'),
    JointOption('hysteresis_loss', 'arcmin',
                'of the gear, at its output; that of the catalogue unless '
                'given, 0 for none'),
    JointOption('effort_lag', 'samples',
                'by which a logged motor torque acts after its stamp: 0.5 of a '
                'command that is held, as unless given, 0 of a measured current',
                low=_LAG.low, high=_LAG.high),
)


@dataclass(frozen=True)
class JointAnswers:
    """What is known of one joint; None for what was not stated, in the units of `ANSWERS`."""

    label: str
    gear: Gear
    motor_inertia: float | None
    motor_torque: float
    motor_counts: float
    link_counts: float
    ratio: float | None = None
    torque_constant: float | None = None
    motor_current: float | None = None
    motor_speed: float | None = None
    peak_torque: float | None = None
    starting_torque: float | None = None
    viscous_friction: float | None = None
    hysteresis_loss: float | None = None
    effort_lag: float | None = None
    origins: Mapping[str, str] = field(default_factory=dict)    # of what a recording showed

    def origin(self, name: str) -> str:
        """Return where an answer comes from."""
        return self.origins.get(name, 'as stated')


@dataclass(frozen=True)
class Rods:
    """Links as uniform rods."""

    lengths: tuple[float, ...]          # [m]
    masses: tuple[float, ...]           # [kg]

    def inertia(self) -> tuple[float, ...]:
        """Return p1, or p1, p2, p3 of `Links` [kg*m^2]."""
        own = [mass * length ** 2 / 3.0 for mass, length in zip(self.masses, self.lengths)]
        if len(own) == 1:
            return own[0],
        mass, length = self.masses[1], self.lengths[0]
        return (own[0] + own[1] + mass * length ** 2, own[1],
                mass * length * self.lengths[1] / 2.0)

    def mass_moments(self) -> tuple[float, ...]:
        """Return the mass moments about the joints [kg*m]."""
        own = [mass * length / 2.0 for mass, length in zip(self.masses, self.lengths)]
        return (own[0],) if len(own) == 1 else (own[0] + self.masses[1] * self.lengths[0], own[1])


def spread(values: Sequence[Value] | None, joints: int, option: str) -> list[Value | None]:
    """Return a value for each joint from one for all, one for each, or none; raises NewError."""
    if not values:
        return [None] * joints
    if len(values) not in (1, joints):
        raise NewError(f'{option} needs one value for all joints or {joints}, got {len(values)}')
    return [*values] if len(values) == joints else [*values] * joints

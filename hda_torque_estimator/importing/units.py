"""Units in which a table may state its columns, once: their factor to the unit of a bag."""

from dataclasses import dataclass
import math

from hda_arm_sim.foundation.parameter import Declaration

COUNTS_PER_TURN = Declaration(
    'counts_per_turn', math.nan, '1/turn', 1.0, 1e10, 'counts of the encoder per turn')
TORQUE_CONSTANT = Declaration(
    'torque_constant', math.nan, 'N*m/A', 1e-9, 1e4, 'torque per ampere')
CONSTANTS = (COUNTS_PER_TURN, TORQUE_CONSTANT)


@dataclass(frozen=True)
class Unit:
    """One unit: `factor` times a constant of the device, or divided by it, gives the bag's."""

    factor: float
    times: Declaration | None = None
    over: Declaration | None = None


@dataclass(frozen=True)
class Quantity:
    """A kind of column: its units (the first is the bag's) and how the gear carries it."""

    name: str
    units: dict[str, Unit]
    power_of_ratio: int = 0     # motor side = link side * ratio ** power_of_ratio


ANGLE = Quantity('angle', {
    'rad': Unit(1.0),
    'deg': Unit(math.pi / 180.0),
    'turn': Unit(2.0 * math.pi),
    'count': Unit(2.0 * math.pi, over=COUNTS_PER_TURN),
}, power_of_ratio=1)
SPEED = Quantity('speed', {
    'rad/s': Unit(1.0),
    'deg/s': Unit(math.pi / 180.0),
    'turn/s': Unit(2.0 * math.pi),
    'rpm': Unit(math.pi / 30.0),
    'count/s': Unit(2.0 * math.pi, over=COUNTS_PER_TURN),
}, power_of_ratio=1)
TORQUE = Quantity('torque', {
    'N*m': Unit(1.0),
    'mN*m': Unit(1e-3),
    'A': Unit(1.0, times=TORQUE_CONSTANT),
    'mA': Unit(1e-3, times=TORQUE_CONSTANT),
}, power_of_ratio=-1)
TIME = Quantity('time', {
    's': Unit(1.0),
    'ms': Unit(1e-3),
    'us': Unit(1e-6),
    'ns': Unit(1e-9),
})

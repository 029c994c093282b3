"""Units in which a table may state its columns, once: their factor to the unit of a bag."""

from dataclasses import dataclass
import math

from hda_arm_sim.foundation.parameter import Declaration

COUNTS_PER_TURN = Declaration(
    'counts_per_turn', math.nan, '1/turn', 1.0, 1e10, 'counts of the encoder per turn')
TORQUE_CONSTANT = Declaration(
    'torque_constant', math.nan, 'N*m/A', 1e-9, 1e4, 'torque per ampere')
RESISTANCE = Declaration(
    'resistance', math.nan, 'ohm', 1e-6, 1e6, 'of the winding, as the torque constant counts it')
SUPPLY = Declaration('supply', math.nan, 'V', 1e-3, 1e5, 'voltage at full scale of the PWM')
FULL_SCALE = Declaration(
    'full_scale', math.nan, '1', 1e-6, 1e9, 'number of the PWM at which the supply is on')
OF_VOLTAGE = (TORQUE_CONSTANT, RESISTANCE)
CONSTANTS = (COUNTS_PER_TURN, TORQUE_CONSTANT, RESISTANCE, SUPPLY, FULL_SCALE)
SHORT = {'kt': TORQUE_CONSTANT.name, 'R': RESISTANCE.name}
"""What data sheets of motors call them."""


@dataclass(frozen=True)
class Unit:
    """
    One unit: `factor` times a constant of the device, or divided by it, gives the bag's.

    One of a voltage gives volts; constants of the motor and its speed make a torque of them.
    """

    factor: float
    times: Declaration | None = None
    over: Declaration | None = None
    is_voltage: bool = False


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
VOLTAGES = {
    'V': Unit(1.0, is_voltage=True),
    'mV': Unit(1e-3, is_voltage=True),
    'pwm': Unit(1.0, times=SUPPLY, over=FULL_SCALE, is_voltage=True),
}
"""Units of what drives a motor, which become a torque at its shaft."""
TIME = Quantity('time', {
    's': Unit(1.0),
    'ms': Unit(1e-3),
    'us': Unit(1e-6),
    'ns': Unit(1e-9),
})

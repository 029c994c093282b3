"""How large an effect is on an arm of another size than the nominal one, for which it is drawn."""

from collections.abc import Mapping
from dataclasses import replace

from . import nominal
from .arms import DrawnArm, NOMINAL_TORQUE
from .effect import Hidden
from .layout import EFFECTS

LOWER = 0.7                     # ceiling of torque over that of README.md: motions here ask less
MOST_TILT = 0.3                 # of a base that should stand level [rad]

# Parameter of an effect -> the scale of the arm with which it grows.
GROWS: dict[tuple[str, str], str] = {
    ('coulomb_friction', 'level'): 'motor', ('viscous_friction', 'slope'): 'drag',
    ('stribeck_friction', 'excess'): 'motor', ('stribeck_friction', 'speed'): 'pace',
    ('presliding_friction', 'stiffness'): 'motor', ('presliding_friction', 'damping'): 'motor',
    ('thermal_viscosity', 'amplitude'): 'drag', ('link_bearing_friction', 'level'): 'gear',
    ('torque_ripple', 'amplitude_2'): 'motor', ('torque_ripple', 'amplitude_4'): 'motor',
    ('motor_cogging', 'amplitude'): 'motor', ('drive_offset', 'offset'): 'motor',
    ('torque_saturation', 'limit'): 'ceiling', ('stiffening_error', 'curvature'): 'curvature',
    ('wave_generator_compliance', 'psi'): 'psi', ('torsional_hysteresis', 'level'): 'gear',
    ('torsional_hysteresis', 'width'): 'torsion', ('structural_damping', 'coefficient'): 'damping',
    ('backlash', 'half_width'): 'torsion', ('kinematic_error', 'amplitude_2'): 'torsion',
    ('kinematic_error', 'amplitude_4'): 'torsion',
    ('loaded_kinematic_error', 'amplitude'): 'compliance',
    ('bearing_crosstalk', 'coefficient'): 'tilting',
    ('link_encoder_eccentricity', 'amplitude_1'): 'torsion',
    ('link_encoder_eccentricity', 'amplitude_2'): 'torsion',
    ('encoder_scale_error', 'relative_error'): 'torsion',
    ('encoder_interpolation_error', 'amplitude'): 'count',
    ('coarse_quantisation', 'step'): 'counted', ('payload', 'mass'): 'load',
    ('base_tilt', 'tilt'): 'weight', ('cable_spring', 'stiffness'): 'gear',
    ('external_contact', 'force'): 'force', ('base_vibration', 'amplitude'): 'mobility',
    ('link_torque_line', 'amplitude'): 'gear', ('motor_torque_line', 'amplitude'): 'motor',
    ('cubic_spring', 'coefficient'): 'gear',
    ('third_order_kinematic_error', 'amplitude'): 'torsion',
    ('tooth_torque', 'amplitude'): 'gear', ('encoder_drift', 'rate'): 'torsion'}


def scales(arm: DrawnArm, joint: str | None) -> Mapping[str, float]:
    """Return how much larger each kind of number is on a joint, or on the arm, than nominally."""
    axis = arm.axes[1 if joint == 'joint2' else 0]
    gear, pace = axis.torque / NOMINAL_TORQUE, axis.fastest / 9.0 / nominal.PACE
    motor, torsion = axis.limit / nominal.TORQUE_LIMIT, gear * nominal.STIFFNESS / axis.stiffness
    moment = sum(arm.moments) / sum(nominal.MASS_MOMENTS)
    inertia, reach = arm.links[0] / nominal.LINK_INERTIA[0], sum(arm.lengths) / 0.3
    return {
        'motor': motor, 'ceiling': LOWER * motor, 'gear': gear, 'pace': pace,
        'drag': motor / pace, 'torsion': torsion,
        'curvature': axis.curvature / nominal.CURVATURE, 'psi': axis.psi / nominal.PSI,
        'damping': axis.damping / nominal.DAMPING, 'compliance': torsion / gear,
        'tilting': torsion / moment, 'load': inertia / reach ** 2, 'weight': gear / moment,
        'force': gear / reach, 'mobility': inertia / moment ** 2,
        'count': max(torsion, 4e6 / arm.counts[1])}


def scaled(hidden: Hidden, arm: DrawnArm, shrink: float = 1.0) -> Hidden:
    """Return an effect as large on an arm as it is on the nominal one, times a factor."""
    scale, numbers = dict(scales(arm, hidden.joint)), dict(hidden.parameters)
    side = 0 if numbers.get('motor_side', 0.0) > 0.5 else 1
    scale['counted'] = (16384.0, 4e6)[side] / arm.counts[side]
    for parameter in EFFECTS[hidden.effect].parameters:
        name = parameter.name
        neutral = parameter.neutral if parameter.is_size else numbers[name]
        factor = scale.get(GROWS.get((hidden.effect, name), ''), 1.0)
        if (hidden.effect, name) == ('nonlinear_viscous_friction', 'coefficient'):
            factor = scale['motor'] / scale['pace'] ** numbers['exponent']
        numbers[name] = factor * (neutral + shrink * (numbers[name] - neutral))
    if 'tilt' in numbers:
        numbers['tilt'] = min(numbers['tilt'], MOST_TILT)
    return replace(hidden, parameters=numbers)

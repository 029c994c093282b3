"""Sizes at which effects are worth finding: those of a drive that is neither new nor broken."""

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import Effect, effect_named

_LIMIT, _RATIO = 0.3, 100.0     # motor torque [N*m] and gear ratio of the axis that sizes are for

# Added to what the arm has; numbers of _SET replace it. Torques of _OUTPUT act behind the gear.
_SIZES: dict[str, dict[str, float]] = {
    'coulomb_friction': {'level': 0.012},
    'viscous_friction': {'slope': 2e-4},
    'nonlinear_viscous_friction': {'coefficient': 3e-3, 'exponent': 0.5},
    'stribeck_friction': {'excess': 0.02, 'speed': 8.0},
    'presliding_friction': {'stiffness': 2.0, 'damping': 0.01},
    'asymmetric_friction': {'asymmetry': 0.2},
    'load_dependent_friction': {'coefficient': 0.15},
    'thermal_viscosity': {'amplitude': 3e-4, 'time_constant': 15.0},
    'position_dependent_friction': {'amplitude': 0.3, 'order': 2.0, 'phase': 0.5},
    'torque_ripple': {'amplitude_2': 8e-3, 'phase_2': 0.5, 'amplitude_4': 2e-3, 'phase_4': 1.0},
    'motor_cogging': {'amplitude': 8e-3, 'order': 14.0, 'phase': 0.5},
    'torque_constant_error': {'error': 0.06},
    'drive_offset': {'offset': 7e-3},
    'current_loop_lag': {'time_constant': 4e-3},
    'command_delay': {'delay': 3.3e-3},
    'torque_saturation': {'limit': 0.15},
    'motor_inertia_error': {'error': 0.1},
    'stiffness_error': {'error': 0.1},
    'stiffening_error': {'error': 0.8},
    'wave_generator_compliance': {'compliance': 0.5},
    'torsional_hysteresis': {'level': 0.8, 'width': 2e-4},
    'structural_damping': {'coefficient': 15.0},
    'backlash': {'half_width': 8e-5},
    'kinematic_error': {'amplitude_2': 8e-5, 'phase_2': 0.5, 'amplitude_4': 2e-5, 'phase_4': 1.0},
    'link_encoder_eccentricity': {'amplitude_1': 2e-4, 'phase_1': 0.5, 'amplitude_2': 6e-5,
                                  'phase_2': 1.0},
    'motor_encoder_eccentricity': {'amplitude': 0.01, 'phase': 0.5},
    'encoder_scale_error': {'error': 3e-4},
    'clock_skew': {'skew': 1.5e-4},
    'link_bearing_friction': {'level': 0.8},
    'payload': {'mass': 1.0},
    'link_inertia_error': {'error': 0.1},
    'inertial_coupling': {'share': 1.0},
    'base_tilt': {'tilt': 0.03, 'direction': 0.7},
    'cable_spring': {'stiffness': 0.8, 'rest_angle': 0.5},
    'external_contact': {'force': 20.0, 'direction': 0.7, 'onset': 6.0, 'duration': 1.0},
    'base_vibration': {'frequency': 11.0, 'damping': 0.04, 'amplitude': 0.025, 'direction': 0.7},
    'bearing_crosstalk': {'coefficient': 1e-5},
}
_SET = frozenset({'exponent', 'speed', 'time_constant', 'order', 'limit', 'width', 'direction',
                  'rest_angle', 'onset', 'duration', 'frequency', 'phase', 'phase_1', 'phase_2',
                  'phase_4'})
_OUTPUT = frozenset({'torsional_hysteresis', 'structural_damping', 'link_bearing_friction',
                     'cable_spring'})
SIZED = tuple(_SIZES)


def typical(arm: Arm, name: str, joint: str | None) -> Effect:
    """
    Return an effect of SIZED on an arm at a typical size, on top of what the arm has of it.

    Torques grow with what the joint's motor can give. Raises ArmError for a wrong place.
    """
    present, kind = arm.effect(name, joint), effect_named(name)
    values = {}
    for number, size in _SIZES[name].items():
        rule = kind.declaration(number)
        scaled = size * _strength(arm, name, joint) if rule.unit.startswith('N*m') else size
        wanted = scaled if number in _SET else getattr(present, number) + scaled
        values[number] = min(max(wanted, rule.low), rule.high)
    kept = {rule.name: getattr(present, rule.name) for rule in kind.declarations()}
    return kind(**{**kept, **values})


def _strength(arm: Arm, name: str, joint: str | None) -> float:
    """Return how strong a joint is beside the one that sizes are stated for."""
    if joint is None:
        return 1.0
    axis = arm.joint(joint)
    return axis.torque_limit / _LIMIT * (axis.ratio / _RATIO if name in _OUTPUT else 1.0)

"""The effects of the catalogue, their parameters and the sizes in which they are hidden."""

from collections.abc import Mapping

import numpy as np

from .effect import (
    angle, between, Draw, Effect, either_sign, one_of, Parameter, shape, size)
from .nominal import (
    BRISTLE_DAMPING, BRISTLE_STIFFNESS, CURVATURE, PACE, PSI, TORQUE_LIMIT)

ARM = ()


def relative_error(low: float, high: float) -> Parameter:
    """Return the parameter of an effect that makes a nominal number larger or smaller."""
    return size('relative_error', '1', 0.0, either_sign(low, high))


def torque_at_typical_rate(low: float, high: float) -> Draw:
    """Return a draw of the coefficient of a power law by its torque at the typical rate."""
    def draw(rng: np.random.Generator, drawn: Mapping[str, float]) -> float:
        return float(rng.uniform(low, high) / PACE ** drawn['exponent'])
    return draw


def fractional_delay(low: float, high: float, dt: float = 1e-3) -> Draw:
    """Return a draw of a delay that is no whole number of samples [s]."""
    def draw(rng: np.random.Generator, drawn: Mapping[str, float]) -> float:
        whole = rng.integers(round(low / dt), round(high / dt))
        return float(dt * (whole + rng.uniform(0.2, 0.8)))
    return draw


def coarse_step(rng: np.random.Generator, drawn: Mapping[str, float]) -> float:
    """Return a step of the encoder: 1000 to 6000 counts at a motor, some 1e5 at a link."""
    if drawn['motor_side']:
        return float(2.0 * np.pi / rng.integers(1000, 6000))
    return float(rng.uniform(1e-5, 6e-5))


FRICTION = (
    Effect('coulomb_friction', 'motor', 'motor_rate', (
        size('level', 'N*m', 0.0, between((0.009, 0.030), (-0.018, -0.009))),)),
    Effect('viscous_friction', 'motor', 'motor_rate', (
        size('slope', 'N*m*s/rad', 0.0, between((1.2e-4, 3.6e-4))),)),
    Effect('nonlinear_viscous_friction', 'motor', 'motor_rate', (
        shape('exponent', '1', 1.0, between((0.3, 0.7))),
        size('coefficient', 'N*m*(s/rad)^exponent', 0.0,
             torque_at_typical_rate(0.012, 0.035)))),
    Effect('stribeck_friction', 'motor', 'motor_rate', (
        size('excess', 'N*m', 0.0, between((0.011, 0.037))),
        shape('speed', 'rad/s', 5.0, between((3.0, 20.0))))),
    Effect('presliding_friction', 'motor', 'reversal', (
        size('stiffness', 'N*m/rad', BRISTLE_STIFFNESS, between((0.8, 4.0))),
        size('damping', 'N*m*s/rad', BRISTLE_DAMPING, between((0.005, 0.02))))),
    Effect('asymmetric_friction', 'motor', 'motor_rate', (
        size('asymmetry', '1', 0.0, either_sign(0.15, 0.40)),)),
    Effect('load_dependent_friction', 'motor', 'torque', (
        size('coefficient', '1', 0.0, between((0.12, 0.25))),)),
    Effect('thermal_viscosity', 'motor', 'time', (
        size('amplitude', 'N*m*s/rad', 0.0, between((1.8e-4, 4.8e-4))),
        shape('time_constant', 's', 15.0, between((10.0, 25.0))))),
    Effect('position_dependent_friction', 'motor', 'link_angle', (
        size('amplitude', '1', 0.0, between((0.25, 0.60))),
        shape('order', '1', 1.0, one_of(1, 2, 3, 4)),
        shape('phase', 'rad', 0.0, angle()))),
    Effect('link_bearing_friction', 'link', 'link_rate', (
        size('level', 'N*m', 0.0, between((0.4, 1.5))),)),
)
DRIVE = (
    Effect('torque_ripple', 'motor', 'motor_angle', (
        size('amplitude_2', 'N*m', 0.0, between((0.004, 0.015))),
        shape('phase_2', 'rad', 0.0, angle()),
        size('amplitude_4', 'N*m', 0.0, between((0.001, 0.005))),
        shape('phase_4', 'rad', 0.0, angle()))),
    Effect('motor_cogging', 'motor', 'motor_angle', (
        size('amplitude', 'N*m', 0.0, between((0.004, 0.012))),
        shape('order', '1', 14.0, one_of(7, 12, 14)),
        shape('phase', 'rad', 0.0, angle()))),
    Effect('torque_constant_error', 'motor', 'command', (relative_error(0.04, 0.12),)),
    Effect('drive_offset', 'motor', 'constant', (
        size('offset', 'N*m', 0.0, either_sign(0.003, 0.012)),)),
    Effect('current_loop_lag', 'motor', 'command', (
        size('time_constant', 's', 0.0, between((0.002, 0.008))),)),
    Effect('command_delay', 'motor', 'command', (
        size('delay', 's', 0.0, fractional_delay(0.002, 0.005)),)),
    Effect('torque_saturation', 'motor', 'command', (
        size('limit', 'N*m', TORQUE_LIMIT, between((0.13, 0.165))),)),
    Effect('motor_inertia_error', 'motor', 'motor_acceleration', (relative_error(0.06, 0.20),)),
)
TORSION = (
    Effect('stiffness_error', 'torsion', 'torque', (relative_error(0.08, 0.20),)),
    Effect('stiffening_error', 'torsion', 'torque', (
        size('curvature', '1/(N*m)', CURVATURE, between((0.0, 0.03), (0.14, 0.18))),)),
    Effect('wave_generator_compliance', 'torsion', 'torque', (
        size('psi', 'rad', PSI, between((0.6e-4, 1.2e-4), (4.5e-4, 8.0e-4))),)),
    Effect('torsional_hysteresis', 'torsion', 'torsion_history', (
        size('level', 'N*m', 0.0, between((0.5, 1.5))),
        shape('width', 'rad', 2e-4, between((1e-4, 3e-4))))),
    Effect('structural_damping', 'torsion', 'torsion_rate', (
        size('coefficient', 'N*m*s/rad', 0.0, between((8.0, 32.0))),)),
    Effect('backlash', 'torsion', 'torque', (
        size('half_width', 'rad', 0.0, between((0.4e-4, 1.5e-4))),)),
    Effect('kinematic_error', 'torsion', 'motor_angle', (
        size('amplitude_2', 'rad', 0.0, between((0.4e-4, 1.5e-4))),
        shape('phase_2', 'rad', 0.0, angle()),
        size('amplitude_4', 'rad', 0.0, between((0.1e-4, 0.4e-4))),
        shape('phase_4', 'rad', 0.0, angle()))),
    Effect('loaded_kinematic_error', 'torsion', 'motor_angle', (
        size('amplitude', 'rad/(N*m)', 0.0, between((1.5e-6, 4.5e-6))),
        shape('phase', 'rad', 0.0, angle()))),
    Effect('bearing_crosstalk', 'torsion', 'posture', (
        size('coefficient', 'rad/(N*m)', 0.0, either_sign(0.6e-5, 2e-5)),),
        joints=('joint1',)),
)
SENSING = (
    Effect('link_encoder_eccentricity', 'torsion', 'link_angle', (
        size('amplitude_1', 'rad', 0.0, between((1e-4, 3e-4))),
        shape('phase_1', 'rad', 0.0, angle()),
        size('amplitude_2', 'rad', 0.0, between((0.3e-4, 1e-4))),
        shape('phase_2', 'rad', 0.0, angle()))),
    Effect('motor_encoder_eccentricity', 'torsion', 'motor_angle', (
        size('amplitude', 'rad', 0.0, between((0.005, 0.020))),
        shape('phase', 'rad', 0.0, angle()))),
    Effect('encoder_scale_error', 'torsion', 'link_angle', (relative_error(1.5e-4, 5e-4),)),
    Effect('encoder_interpolation_error', 'sensing', 'link_angle', (
        size('amplitude', 'rad', 0.0, between((5e-6, 2e-5))),
        shape('lines', '1', 2500.0, one_of(2500, 3600, 5000, 9000)),
        shape('phase', 'rad', 0.0, angle()))),
    Effect('coarse_quantisation', 'sensing', 'angle', (
        shape('motor_side', '1', 0.0, one_of(0, 1)),
        size('step', 'rad', 0.0, coarse_step))),
    Effect('clock_skew', 'timing', 'link_rate', (
        size('skew', 's', 0.0, either_sign(5e-5, 3e-4)),)),
    Effect('dropped_samples', 'timing', 'time', (
        size('rate', '1', 0.0, between((0.002, 0.02))),), joints=ARM),
    Effect('clock_jitter', 'timing', 'time', (
        size('jitter', 's', 0.0, between((5e-5, 1e-4))),), joints=ARM),
)
ENVIRONMENT = (
    Effect('payload', 'link', 'link_acceleration', (
        size('mass', 'kg', 0.0, between((0.7, 3.0))),), joints=ARM),
    Effect('link_inertia_error', 'link', 'link_acceleration', (relative_error(0.06, 0.20),)),
    Effect('inertial_coupling', 'link', 'link_acceleration', (
        size('share', '1', 0.0, one_of(1.0)),), joints=ARM),
    Effect('base_tilt', 'link', 'posture', (
        size('tilt', 'rad', 0.0, between((0.0122, 0.0524))),
        shape('direction', 'rad', 0.0, angle())), joints=ARM),
    Effect('cable_spring', 'link', 'link_angle', (
        size('stiffness', 'N*m/rad', 0.0, between((0.4, 1.5))),
        shape('rest_angle', 'rad', 0.0, between((-0.8, 1.8))))),
    Effect('external_contact', 'link', 'time', (
        size('force', 'N', 0.0, between((15.0, 30.0))),
        shape('direction', 'rad', 0.0, angle()),
        shape('onset', 's', 10.0, between((6.0, 30.0))),
        shape('duration', 's', 1.0, between((0.5, 2.0)))), joints=ARM),
    Effect('base_vibration', 'link', 'base_motion', (
        shape('frequency', 'Hz', 12.0, between((8.0, 14.0))),
        shape('damping', '1', 0.05, between((0.02, 0.06))),
        size('amplitude', '1/kg', 0.0, between((0.018, 0.035))),
        shape('direction', 'rad', 0.0, angle())), joints=ARM),
)
CATALOGUE = (*FRICTION, *DRIVE, *TORSION, *SENSING, *ENVIRONMENT)

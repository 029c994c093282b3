"""The effects of the catalogue, their parameters and the sizes in which they are hidden."""

from collections.abc import Mapping

import numpy as np

from .effect import angle, between, Draw, Effect, either_sign, one_of, Parameter
from .nominal import (
    BRISTLE_DAMPING, BRISTLE_STIFFNESS, CURVATURE, PSI, TORQUE_LIMIT)

ARM = ()
TYPICAL_RATE = 50.0             # motor rate at which a curved viscous law is compared [rad/s]


def relative_error(low: float, high: float) -> Parameter:
    """Return the parameter of an effect that makes a nominal number larger or smaller."""
    return Parameter('relative_error', '1', 0.0, either_sign(low, high))


def torque_at_typical_rate(low: float, high: float) -> Draw:
    """Return a draw of the coefficient of a power law by its torque at the typical rate."""
    def draw(rng: np.random.Generator, drawn: Mapping[str, float]) -> float:
        return float(rng.uniform(low, high) / TYPICAL_RATE ** drawn['exponent'])
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
        Parameter('level', 'N*m', 0.0, between((0.009, 0.030), (-0.018, -0.009))),)),
    Effect('viscous_friction', 'motor', 'motor_rate', (
        Parameter('slope', 'N*m*s/rad', 0.0, between((1.2e-4, 3.6e-4))),)),
    Effect('nonlinear_viscous_friction', 'motor', 'motor_rate', (
        Parameter('exponent', '1', 1.0, between((0.3, 0.7))),
        Parameter('coefficient', 'N*m*(s/rad)^exponent', 0.0,
                  torque_at_typical_rate(0.012, 0.035)))),
    Effect('stribeck_friction', 'motor', 'motor_rate', (
        Parameter('excess', 'N*m', 0.0, between((0.011, 0.037))),
        Parameter('speed', 'rad/s', 5.0, between((3.0, 20.0))))),
    Effect('presliding_friction', 'motor', 'reversal', (
        Parameter('stiffness', 'N*m/rad', BRISTLE_STIFFNESS, between((0.8, 4.0))),
        Parameter('damping', 'N*m*s/rad', BRISTLE_DAMPING, between((0.005, 0.02))))),
    Effect('asymmetric_friction', 'motor', 'motor_rate', (
        Parameter('asymmetry', '1', 0.0, either_sign(0.15, 0.40)),)),
    Effect('load_dependent_friction', 'motor', 'torque', (
        Parameter('coefficient', '1', 0.0, between((0.08, 0.25))),)),
    Effect('thermal_viscosity', 'motor', 'time', (
        Parameter('amplitude', 'N*m*s/rad', 0.0, between((1.8e-4, 4.8e-4))),
        Parameter('time_constant', 's', 15.0, between((10.0, 25.0))))),
    Effect('position_dependent_friction', 'motor', 'link_angle', (
        Parameter('amplitude', '1', 0.0, between((0.25, 0.60))),
        Parameter('order', '1', 1.0, one_of(1, 2, 3, 4)),
        Parameter('phase', 'rad', 0.0, angle()))),
    Effect('link_bearing_friction', 'link', 'link_rate', (
        Parameter('level', 'N*m', 0.0, between((0.4, 1.5))),)),
)
DRIVE = (
    Effect('torque_ripple', 'motor', 'motor_angle', (
        Parameter('amplitude_2', 'N*m', 0.0, between((0.004, 0.015))),
        Parameter('phase_2', 'rad', 0.0, angle()),
        Parameter('amplitude_4', 'N*m', 0.0, between((0.001, 0.005))),
        Parameter('phase_4', 'rad', 0.0, angle()))),
    Effect('motor_cogging', 'motor', 'motor_angle', (
        Parameter('amplitude', 'N*m', 0.0, between((0.004, 0.012))),
        Parameter('order', '1', 14.0, one_of(7, 12, 14)),
        Parameter('phase', 'rad', 0.0, angle()))),
    Effect('torque_constant_error', 'motor', 'command', (relative_error(0.04, 0.12),)),
    Effect('drive_offset', 'motor', 'constant', (
        Parameter('offset', 'N*m', 0.0, either_sign(0.003, 0.012)),)),
    Effect('current_loop_lag', 'motor', 'command', (
        Parameter('time_constant', 's', 0.0, between((0.002, 0.008))),)),
    Effect('command_delay', 'motor', 'command', (
        Parameter('delay', 's', 0.0, fractional_delay(0.001, 0.005)),)),
    Effect('torque_saturation', 'motor', 'command', (
        Parameter('limit', 'N*m', TORQUE_LIMIT, between((0.10, 0.14))),)),
    Effect('motor_inertia_error', 'motor', 'motor_acceleration', (relative_error(0.06, 0.20),)),
)
TORSION = (
    Effect('stiffness_error', 'torsion', 'torque', (relative_error(0.08, 0.20),)),
    Effect('stiffening_error', 'torsion', 'torque', (
        Parameter('curvature', '1/(N*m)', CURVATURE, between((0.0, 0.03), (0.14, 0.18))),)),
    Effect('wave_generator_compliance', 'torsion', 'torque', (
        Parameter('psi', 'rad', PSI, between((0.6e-4, 1.2e-4), (4.5e-4, 8.0e-4))),)),
    Effect('torsional_hysteresis', 'torsion', 'torsion_history', (
        Parameter('level', 'N*m', 0.0, between((0.5, 1.5))),
        Parameter('width', 'rad', 2e-4, between((1e-4, 3e-4))))),
    Effect('structural_damping', 'torsion', 'torsion_rate', (
        Parameter('coefficient', 'N*m*s/rad', 0.0, between((8.0, 32.0))),)),
    Effect('backlash', 'torsion', 'torque', (
        Parameter('half_width', 'rad', 0.0, between((0.4e-4, 1.5e-4))),)),
    Effect('kinematic_error', 'torsion', 'motor_angle', (
        Parameter('amplitude_2', 'rad', 0.0, between((0.4e-4, 1.5e-4))),
        Parameter('phase_2', 'rad', 0.0, angle()),
        Parameter('amplitude_4', 'rad', 0.0, between((0.1e-4, 0.4e-4))),
        Parameter('phase_4', 'rad', 0.0, angle()))),
    Effect('bearing_crosstalk', 'torsion', 'posture', (
        Parameter('coefficient', 'rad/(N*m)', 0.0, either_sign(0.6e-5, 2e-5)),),
        joints=('joint1',)),
)
SENSING = (
    Effect('link_encoder_eccentricity', 'torsion', 'link_angle', (
        Parameter('amplitude_1', 'rad', 0.0, between((1e-4, 3e-4))),
        Parameter('phase_1', 'rad', 0.0, angle()),
        Parameter('amplitude_2', 'rad', 0.0, between((0.3e-4, 1e-4))),
        Parameter('phase_2', 'rad', 0.0, angle()))),
    Effect('motor_encoder_eccentricity', 'torsion', 'motor_angle', (
        Parameter('amplitude', 'rad', 0.0, between((0.005, 0.020))),
        Parameter('phase', 'rad', 0.0, angle()))),
    Effect('encoder_scale_error', 'torsion', 'link_angle', (relative_error(1.5e-4, 5e-4),)),
    Effect('encoder_interpolation_error', 'sensing', 'link_angle', (
        Parameter('amplitude', 'rad', 0.0, between((5e-6, 2e-5))),
        Parameter('lines', '1', 2500.0, one_of(2500, 3600, 5000, 9000)),
        Parameter('phase', 'rad', 0.0, angle()))),
    Effect('coarse_quantisation', 'sensing', 'angle', (
        Parameter('motor_side', '1', 0.0, one_of(0, 1)),
        Parameter('step', 'rad', 0.0, coarse_step))),
    Effect('clock_skew', 'timing', 'link_rate', (
        Parameter('skew', 's', 0.0, either_sign(5e-5, 3e-4)),)),
    Effect('dropped_samples', 'timing', 'time', (
        Parameter('rate', '1', 0.0, between((0.002, 0.02))),), joints=ARM),
)
ENVIRONMENT = (
    Effect('payload', 'link', 'link_acceleration', (
        Parameter('mass', 'kg', 0.0, between((0.7, 3.0))),), joints=ARM),
    Effect('link_inertia_error', 'link', 'link_acceleration', (relative_error(0.06, 0.20),)),
    Effect('inertial_coupling', 'link', 'link_acceleration', (
        Parameter('share', '1', 0.0, one_of(1.0)),), joints=ARM),
    Effect('base_tilt', 'link', 'posture', (
        Parameter('tilt', 'rad', 0.0, between((0.0122, 0.0524))),
        Parameter('direction', 'rad', 0.0, angle())), joints=ARM),
    Effect('cable_spring', 'link', 'link_angle', (
        Parameter('stiffness', 'N*m/rad', 0.0, between((0.4, 1.5))),
        Parameter('rest_angle', 'rad', 0.0, between((-0.8, 1.8))))),
    Effect('external_contact', 'link', 'time', (
        Parameter('force', 'N', 0.0, between((15.0, 30.0))),
        Parameter('direction', 'rad', 0.0, angle()),
        Parameter('onset', 's', 10.0, between((6.0, 30.0))),
        Parameter('duration', 's', 1.0, between((0.5, 2.0)))), joints=ARM),
    Effect('base_vibration', 'link', 'base_motion', (
        Parameter('frequency', 'Hz', 12.0, between((8.0, 14.0))),
        Parameter('damping', '1', 0.05, between((0.02, 0.06))),
        Parameter('amplitude', '1/kg', 0.0, between((0.018, 0.035))),
        Parameter('direction', 'rad', 0.0, angle())), joints=ARM),
)
CATALOGUE = (*FRICTION, *DRIVE, *TORSION, *SENSING, *ENVIRONMENT)

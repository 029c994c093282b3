"""
What the library should report of a hidden effect: the truth's numbers in the library's terms.

The truth knows nothing of the library. Its numbers have other names, other meanings and are those
of an arm that differs from the nominal one within its tolerances; what the library reports
contains that.
"""

from collections.abc import Callable, Mapping

import numpy as np
from truth import CATALOGUE, layout

# Effect and number of the truth -> the library's name of the number, and how it is converted.
CONVERTED: dict[tuple[str, str], tuple[str, Callable[[float], float]]] = {
    ('inertial_coupling', 'share'): ('share', lambda value: -value),    # links taken apart
    ('stiffening_error', 'curvature'): ('error', lambda value: value / 0.0831 - 1.0),
    ('wave_generator_compliance', 'psi'): (      # psi / 2 = compliance / (N c_w), (eq:compliance)
        'compliance', lambda value: 0.5 * 100.0 * 27.027 * value - 1.0 / 2.5517)}
SAME = {'relative_error': 'error'}
# Numbers that add to the arm's own, of which the library reports the sum: name there, nominal
# value.
ADDED = {('coulomb_friction', 'level'): ('dry', 0.037),                     # [N*m]
         ('viscous_friction', 'slope'): ('viscous', 5.96e-5),               # [N*m*s/rad]
         ('structural_damping', 'coefficient'): ('damping', 8.0)}           # [N*m*s/rad]
# Relative errors, of which the library reports those of the nominal arm: name of what is
# scattered.
SCALED = {('stiffness_error', 'error'): 'stiffness', ('torque_constant_error', 'error'): 'gain',
          ('link_inertia_error', 'error'): 'inertia'}
# Relative errors that are asked for in the median, and of which effects.
ASKED: dict[str, tuple[float, tuple[str, ...]]] = {
    'sensing, ripple, tilt, cable, skew': (0.03, (
        'torque_ripple', 'motor_cogging', 'kinematic_error', 'bearing_crosstalk',
        'link_encoder_eccentricity', 'motor_encoder_eccentricity', 'encoder_scale_error',
        'encoder_interpolation_error', 'clock_skew', 'dropped_samples', 'clock_jitter',
        'base_tilt', 'cable_spring', 'inertial_coupling')),
    'friction, damping, payload': (0.07, (
        'coulomb_friction', 'viscous_friction', 'nonlinear_viscous_friction',
        'stribeck_friction', 'presliding_friction', 'load_dependent_friction',
        'thermal_viscosity', 'position_dependent_friction', 'link_bearing_friction',
        'structural_damping', 'payload', 'external_contact', 'base_vibration'))}
ONE_EQUATION = ('asymmetric_friction', 'drive_offset')      # while the motor turns
NOT_ASKED = (*ONE_EQUATION, 'coarse_quantisation')          # or reported by other numbers
ASKED['stiffness, inertia, torque constant, lag, hysteresis'] = 0.12, tuple(
    effect.name for effect in CATALOGUE if effect.name not in NOT_ASKED
    and not any(effect.name in names for _, names in ASKED.values()))
Expected = dict[str, tuple[float, float]]


def scattered(seed: int) -> dict[str, list[float]]:
    """Return the numbers of the two joints of an arm over the nominal ones, by their names."""
    joints, arm = layout.nominal_joints(), layout.nominal_arm()
    given, body = joints.copy(), arm.copy()
    layout.scatter(joints, arm, np.random.default_rng([seed, 0]))
    shares = {name: (joints[name] / given[name]).tolist()
              for name in ('dry', 'viscous', 'damping', 'stiffness', 'gain')}
    return {**shares, 'inertia': [float(arm[name][0] / body[name][0]) for name in ('p1', 'p2')]}


def expected(effect: str, joint: str | None, parameters: Mapping[str, float],
             scatter: Mapping[str, list[float]]) -> Expected:
    """
    Return what the library should report by its number's name, and how much of it is hidden.

    Angles of waves and forces are left out: without their amplitudes they mean little.
    """
    numbers: Expected = {}
    for name, value in parameters.items():
        number, convert = CONVERTED.get((effect, name), (SAME.get(name, name), float))
        hidden = convert(value)
        if hidden and 'phase' not in number and 'direction' not in number:
            numbers[number] = _whole(effect, joint, number, hidden, scatter), hidden
    return numbers


def _whole(effect: str, joint: str | None, number: str, hidden: float,
           scatter: Mapping[str, list[float]]) -> float:
    """Return a hidden number together with what its arm has of it."""
    place = 1 if joint == 'joint2' else 0
    if (effect, number) in ADDED:
        name, nominal = ADDED[effect, number]
        return hidden + nominal * scatter[name][place]
    if (effect, number) in SCALED:
        whole = (1.0 + hidden) * scatter[SCALED[effect, number]][place] - 1.0
        return whole - _carried(scatter) if effect == 'link_inertia_error' and not place else whole
    return hidden


def _carried(scatter: Mapping[str, list[float]]) -> float:
    """Return the share of p1 that the library gives it with an error of p2, the truth does not."""
    body = layout.nominal_arm()[0]
    return float(body['p2'] / body['p1']) * (scatter['inertia'][1] - 1.0)

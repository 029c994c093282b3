"""
Arms of many sizes: their numbers are drawn, and stated in a file as their owner would.

All follows from the largest torque of a gear: how much it moves, how stiff it is, what its motor
weighs. So a drawn arm is one that somebody could have built.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from . import layout, nominal
from .recording import Built

RATIOS = (50.0, 80.0, 100.0, 120.0, 160.0)
MOTOR_BITS = (10, 12, 13, 14, 15, 17, 20, 24)
LINK_BITS = (12, 14, 16, 17, 18, 19, 20, 22, 24)
NOMINAL_TORQUE = nominal.RATIO * nominal.TORQUE_LIMIT       # of the arm of README.md [N*m]
HOME = (0.3, 1.2)               # link angles about which motions are made [rad]
VALID = 3.077                   # largest torque times curvature at which the spring's law holds


class Axis(NamedTuple):
    """The numbers of one joint, SI units; friction and inertia at the motor."""

    torque: float               # largest, at the output
    ratio: float
    stiffness: float
    curvature: float
    soft_torque: float
    psi: float
    damping: float
    inertia: float
    dry: float
    viscous: float
    fastest: float              # motor rate

    @property
    def limit(self) -> float:
        """Return the largest torque of the motor [N*m]."""
        return self.torque / self.ratio


class DrawnArm(NamedTuple):
    """An arm with one joint or two, its links and its encoders."""

    axes: tuple[Axis, ...]
    lengths: tuple[float, float]
    links: tuple[float, float, float]       # p1, p2, p3 [kg*m^2]
    moments: tuple[float, float]            # [kg*m]
    tilt: float
    downhill: float
    counts: tuple[float, float]             # of motor and link encoders

    def heaviest(self) -> tuple[float, ...]:
        """Return the largest inertia that each gear carries, motor included [kg*m^2]."""
        p1, p2, p3 = self.links
        return tuple(link + axis.ratio ** 2 * axis.inertia
                     for axis, link in zip(self.axes, (p1 + 2.0 * p3, p2)))


def draw_arm(rng: np.random.Generator, joints: int) -> DrawnArm:
    """Draw an arm with one joint or two."""
    torque = float(np.exp(rng.uniform(np.log(2.0), np.log(300.0))))
    quick = rng.uniform(20.0, 45.0)         # largest acceleration of link 1 [rad/s^2]
    length = float(np.clip(0.15 * (torque / 30.0) ** (1.0 / 3.0), 0.06, 0.6))
    if joints == 1:
        links = (max(torque / quick, 0.05), 0.0, 0.0)
        moments, lengths, torques = (links[0] / (0.8 * length), 0.0), (length, 0.0), (torque,)
    else:
        links, moments, lengths = _two_links(rng, max(torque / quick, 0.06), length)
        torques = (torque, torque * rng.uniform(0.25, 0.5))
    carried = (links[0] + 2.0 * links[2], links[1])
    axes = tuple(draw_axis(rng, one, inertia) for one, inertia in zip(torques, carried))
    tilt = 0.0
    if rng.random() < 0.5:                  # on a wedge, or upright and nearly balanced
        pull = rng.uniform(0.1, 0.3) * torque / (nominal.GRAVITY * sum(moments))
        tilt = float(np.arcsin(min(pull, 1.0)))
    return DrawnArm(axes, lengths, links, moments, tilt, float(rng.uniform(-np.pi, np.pi)),
                    (2.0 ** rng.choice(MOTOR_BITS), 2.0 ** rng.choice(LINK_BITS)))


def _two_links(rng: np.random.Generator, most: float, length: float) -> tuple[
        tuple[float, float, float], tuple[float, float], tuple[float, float]]:
    """Return inertias, mass moments and lengths of two links, outstretched `most` [kg*m^2]."""
    first, second = length, length * rng.uniform(0.7, 1.1)
    middle = 0.5 * second                   # of link 2, which turns about it with 0.3 m c^2
    mass = 0.5 * most / ((first + middle) ** 2 + 0.3 * middle ** 2)
    p2, p3 = 1.3 * mass * middle ** 2, mass * first * middle
    p1 = most - 2.0 * p3
    own = p1 - p2 - mass * first ** 2
    return (p1, p2, p3), (own / (0.65 * first) + mass * first, mass * middle), (first, second)


def draw_axis(rng: np.random.Generator, torque: float, inertia: float) -> Axis:
    """Draw the joint for a largest torque [N*m] and the inertia that it carries [kg*m^2]."""
    ratio = float(rng.choice(RATIOS))
    stiffness = float(np.clip(torque * 10.0 ** rng.uniform(2.4, 2.9), 2e3, 1e5))
    motor = float(np.clip(rng.uniform(0.5, 1.5) * inertia / ratio ** 2, 1e-5, 1e-3))
    fastest, soft = rng.uniform(250.0, 600.0), 0.12 * torque
    wound_up = stiffness / ratio ** 2 * rng.uniform(2.0, 4.0)       # motor side [N*m/rad]
    return Axis(
        torque, ratio, stiffness, rng.uniform(1.5, 2.6) / torque, soft,
        2.0 * soft / (ratio ** 2 * wound_up),
        2.0 * rng.uniform(0.03, 0.06) * float(np.sqrt(stiffness * inertia)), motor,
        torque / ratio * rng.uniform(0.06, 0.13),
        torque / ratio * rng.uniform(0.05, 0.12) / fastest, fastest)


def built(arm: DrawnArm, period: float) -> Built:
    """Return the arm with the controller that its maker would set, sampled every period [s]."""
    joints, whole = layout.nominal_joints(), layout.nominal_arm()
    for joint, axis, inertia, home in zip(joints, arm.axes, arm.heaviest(), HOME):
        _write(joint, axis, home)
        motor = inertia / axis.ratio ** 2
        link = inertia - axis.ratio ** 2 * axis.inertia
        swing = np.sqrt(axis.stiffness * (1.0 / link + 1.0 / (axis.ratio ** 2 * axis.inertia)))
        fast = min(0.27 * swing, 0.1 / period)
        joint['k_p'], joint['k_d'] = fast ** 2 * motor, 1.5 * fast * motor
        joint['hand'] = joint['hand_damping'] = 0.0
    whole['apart'] = float(len(arm.axes) == 1)
    p1, p2, p3 = arm.links
    whole['p1'], whole['p2'], whole['p3'] = p1, p2 or nominal.LINK_INERTIA[1], p3
    whole['moment_1'], whole['moment_2'] = arm.moments
    whole['length_1'], whole['length_2'] = arm.lengths
    whole['pull'], whole['downhill'] = nominal.GRAVITY * np.sin(arm.tilt), arm.downhill
    whole['across'] = nominal.GRAVITY * np.cos(arm.tilt)
    return Built(joints, whole)


def _write(joint: np.void, axis: Axis, home: float) -> None:
    """Write the numbers of an axis where the laws read them, every effect neutral."""
    for name in ('ratio', 'limit', 'stiffness', 'curvature', 'soft_torque', 'psi', 'damping',
                 'inertia', 'dry', 'viscous'):
        joint[name] = getattr(axis, name)
    joint['size'], joint['pace'] = axis.torque / NOMINAL_TORQUE, axis.fastest / 9.0
    joint['middle'], joint['noise'] = home, axis.limit / 300.0
    joint['torque_saturation_limit'] = axis.limit
    joint['stiffening_error_curvature'] = axis.curvature
    joint['wave_generator_compliance_psi'] = axis.psi
    for name in ('stiffness', 'damping'):
        joint[f'presliding_friction_{name}'] *= axis.limit / nominal.TORQUE_LIMIT


def stated(arm: DrawnArm) -> dict[str, Any]:
    """Return what the file of the arm says, as a mapping in the format of arm files."""
    size = arm.axes[-1].limit / nominal.TORQUE_LIMIT
    links: dict[str, Any] = {
        'lengths': list(arm.lengths[:len(arm.axes)]), 'inertia': list(arm.links),
        'mass_moments': list(arm.moments)}
    if len(arm.axes) == 1:
        links = {'lengths': [arm.lengths[0]], 'inertia': [arm.links[0]],
                 'mass_moments': [arm.moments[0]]}
    return {
        'joints': [_stated_axis(axis, f'joint{j + 1}', arm.counts)
                   for j, axis in enumerate(arm.axes)],
        'links': links,
        'base': {'tilt': arm.tilt, 'direction': arm.downhill, 'gravity': nominal.GRAVITY},
        'tolerances': {
            'torsion_zero': 1e-5 + float(np.pi) / arm.counts[1] + float(np.pi) / (
                arm.counts[0] * min(axis.ratio for axis in arm.axes)),
            'torque_ripple': 2e-4 * size, 'drive_offset': 6e-4 * size}}


def _stated_axis(axis: Axis, name: str, counts: tuple[float, float]) -> Mapping[str, Any]:
    soft = axis.ratio / axis.soft_torque    # curvature of the wave generator, motor side
    return {
        'name': name, 'ratio': axis.ratio, 'motor_inertia': axis.inertia,
        'dry_friction': axis.dry, 'viscous_friction': axis.viscous, 'torque_limit': axis.limit,
        'velocity_limit': axis.fastest, 'angle_limit': 3.2,
        'torsion': {
            'flexspline_stiffness': axis.stiffness, 'flexspline_curvature': axis.curvature,
            'wave_generator_stiffness': 2.0 / (axis.ratio * soft * axis.psi),
            'wave_generator_curvature': soft, 'damping': axis.damping,
            'valid_torque': VALID / axis.curvature},
        'motor_encoder': {'counts': counts[0]}, 'link_encoder': {'counts': counts[1]}}

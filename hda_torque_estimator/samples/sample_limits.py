"""
The limits of an arm's samples: what its numbers allow, wide enough that no healthy arm is accused.

Bounds state what no arm can do, not what this arm should do.
"""

import math

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.rigid import mass_matrix
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.chain_links import ChainLinks
from hda_arm_sim.model.effect_loops import numbers_at
from hda_arm_sim.model.effects.place import CLOCK, COUNTS, PLAY
from hda_arm_sim.model.link_side import loaded_inertia
from hda_arm_sim.model.stiffness_rate import masses
import numpy as np

# Limits, per joint (n, LIMITS); angles and steps of both sides at their own shafts.
(LARGEST, SPEED, ACCELERATION,          # link [rad]; shaft [rad/s, rad/s^2]
 RATIO, ZERO, STEP, WOUND, ALLOWED_APART, LATE,
 EASE,                                  # of a link, infinite without links [rad/s^2/(N*m)]
 ) = 0, 1, 2, 3, 4, 6, 8, 9, 10, 11
LIMITS = 12  # (layout)

# Choices unless stated otherwise.
FASTER = 1.5            # than the declared limit: choice; supply and overhauling loads add 10-20 %
WIDER = 0.05            # than the angle limit: a step of the reference that is let through [rad]
STRONGER = 2.0          # than limits and declared inertia give: inertia of an unnamed rotor
LATENESS = 2e-3         # between two stamps of a host: each is up to 1 ms late (choice) [s]
POSTURES = 64           # of a chain, drawn at random: choice, a tenth of a second
POSED = 2.0             # than in the lightest of them: choice; in others links are lighter still
SOFTER = 2.0            # than the declared torsion: stiffness of a gear known by its class
WIDEST = 0.05           # torsion where the law is valid without end: 30 times a usual gear [rad]
# (source: normal distribution, six deviations for each of two readings)
NOISE = 12.0            # deviations of noise between two readings: six each, never in a lifetime


def watch_limits(arm: Arm, *, apart: float = math.inf) -> Array:
    """
    Return what the samples of an arm can be (n, LIMITS).

    `apart` is how far motor angle / ratio and link angle may differ at the first sample, beyond
    torsion [rad]. It is infinite where the zeros of the encoders are not known.
    """
    made = np.zeros((len(arm.joints), LIMITS))
    for row, joint, numbers in zip(made, arm.joints, arm.record().joints):
        strongest = (joint.torque_limit + joint.dry_friction
                     + joint.torsion.valid_torque / joint.ratio)
        noise = NOISE * np.array([joint.motor_encoder.noise, joint.link_encoder.noise])
        counts = [numbers_at(numbers, COUNTS)[f'{side}_step'] for side in ('motor', 'link')]
        row[LARGEST] = joint.angle_limit + WIDER
        row[SPEED] = FASTER * joint.velocity_limit
        row[ACCELERATION] = STRONGER * strongest / numbers['motor_inertia']
        row[RATIO] = joint.ratio
        row[ZERO:ZERO + 2] = joint.motor_encoder.zero, joint.link_encoder.zero
        row[STEP:STEP + 2] = counts + noise
        wound = SOFTER * numbers['torsion']['valid_torsion']
        row[WOUND] = 2.0 * (min(wound, WIDEST) + numbers_at(numbers, PLAY)['half_width'])
        row[ALLOWED_APART] = apart
        row[LATE] = LATENESS + abs(numbers_at(numbers, CLOCK)['skew'])
    made[:, EASE] = _ease(arm)
    return made


def _ease(arm: Arm) -> Array:
    """Return the most that a torque at any joint speeds each link up, at any elbow (n,)."""
    joints = len(arm.joints)
    if arm.links is None:
        return np.full(joints, math.inf)
    if isinstance(arm.links, ChainLinks):
        return np.max([POSED * np.abs(np.linalg.inv(mass)).max(axis=1)
                       for mass in masses(arm, POSTURES)], axis=0)
    first, both, second = mass_matrix(loaded_inertia(arm.record().body),
                                      np.linspace(0.0, math.pi, 181))
    if joints == 1:
        return 1.0 / np.min(first, keepdims=True)
    whole, across = first * second - both ** 2, abs(both)
    return np.array([np.max(np.maximum(own, across) / whole) for own in (second, first)])

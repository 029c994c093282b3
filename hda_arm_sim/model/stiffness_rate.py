"""How fast an arm can swing or settle by itself, which determines how short a step must be."""

from typing import Any

import numpy as np

from .arm import Arm
from .effect_loops import total_at
from .effects.place import Bent, BRISTLES, GEAR, LOOP, Twisted
from .mass_matrices import mass_matrices
from .parts import Joint
from .torsion import torsion_of_torque
from ..foundation.arrays import Array

_POSTURES = 16          # that are looked at: a rate changes by a few percent between them


def fastest_rate(arm: Arm) -> float:
    """
    Return the largest rate of a chain's own motions behind its gears, in any posture [1/s].

    Torsions move by (M^-1 + (N^2 J)^-1) (K + D d/dt), with the stiffness of every law at the
    most that its motor can ask for. Bristles and hysteresis add their own stiffness.
    """
    joints = arm.record().joints
    reflected = joints['ratio'] ** 2 * joints['motor_inertia']
    stiff = np.array([_stiffness(joint, record['torsion'])
                      for joint, record in zip(arm.joints, joints)])
    stiff += [total_at(LOOP, 'law_stiffness', record, Twisted()) for record in joints]
    bristles = np.array([total_at(BRISTLES, 'law_stiffness', record, Bent()) for record in joints])
    damping = np.array([total_at(GEAR, 'law_damping', record, Twisted()) for record in joints])
    rates = [_rate(matrix, reflected, stiff, damping) for matrix in masses(arm, _POSTURES)]
    return float(max([*rates, *np.sqrt(bristles / joints['motor_inertia'])]))


def _stiffness(joint: Joint, law: Any) -> float:
    """Return the stiffness of a gear at the most torque that its motor can ask for [N*m/rad]."""
    most = min(joint.torque_limit * joint.ratio, float(law['valid_torque']))
    near = 0.99 * most
    return (most - near) / float(torsion_of_torque(law, joint.ratio, most)
                                 - torsion_of_torque(law, joint.ratio, near))


def masses(arm: Arm, postures: int) -> list[Array]:
    """Return the mass matrices (n, n) of a chain in its zero and in random postures."""
    angles = np.zeros((postures, len(arm.joints)))
    angles[1:] = np.random.default_rng(0).uniform(-np.pi, np.pi, angles[1:].shape)
    return list(mass_matrices(arm, angles))


def _rate(mass: Array, reflected: Array, stiff: Array, damping: Array) -> float:
    """Return the largest eigenvalue of torsions that swing between links and rotors."""
    ease, none, one = np.linalg.inv(mass) + np.diag(1.0 / reflected), 0.0 * mass, np.eye(len(mass))
    swing = np.block([[none, one], [-ease * stiff, -ease * damping]])
    return float(np.abs(np.linalg.eigvals(swing)).max())

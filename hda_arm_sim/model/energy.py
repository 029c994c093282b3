"""The energy of an arm, which no motion without inputs may increase (docs/model.md, eq:energy)."""

from typing import Any

import numpy as np

from .arm import Arm, ArmRecord
from .effect_loops import numbers_at, total_at
from .effects.place import BASE, Bent, BRISTLES, LINK_TORQUE, LOOP, Pulled, SLIDERS, Twisted
from .kernel import (BASE_OFFSET, BASE_RATE, BRISTLE, growth, LINK_ANGLE, LINK_VELOCITY,
                     MOTOR_ANGLE, MOTOR_VELOCITY, played_torsion, STRETCH, transmission)
from .link_side import base_coupling, loaded_inertia
from .torsion import torque_of_torsion, torsion_of_torque
from ..foundation import chain
from ..foundation.arrays import Array
from ..foundation.chain import Chain
from ..foundation.rigid import Inertia, mass_matrix


def energy(arm: Arm, state: Array) -> float:
    """Return the energy of an arm at a state (n, STATES): kinetic, elastic, gravity [J]."""
    record = arm.record()
    inertia = loaded_inertia(record.body)
    return (_kinetic(record, inertia, state) + _elastic(record, state)
            + _base(record.body, inertia, state)
            + _potential(record.body, inertia, state[:, LINK_ANGLE]))


def _kinetic(record: ArmRecord, inertia: Inertia | Chain, state: Array) -> float:
    motors = 0.5 * record.joints['motor_inertia'] @ state[:, MOTOR_VELOCITY] ** 2
    if isinstance(inertia, Chain):
        dq = state[:, LINK_VELOCITY]
        return float(motors + 0.5 * dq @ _placed(inertia, state[:, LINK_ANGLE]) @ dq)
    if len(state) == 1:
        return float(motors + 0.5 * inertia.p1 * state[0, LINK_VELOCITY] ** 2)
    m11, m12, m22 = mass_matrix(inertia, state[1, LINK_ANGLE])
    dq = state[:, LINK_VELOCITY]
    return float(motors + 0.5 * dq @ np.array([[m11, m12], [m12, m22]]) @ dq)


def _elastic(record: ArmRecord, state: Array) -> float:
    """Return the energy in springs, cables, bristles and hysteresis."""
    total = 0.0
    for row, joint in zip(state, record.joints):
        error, _ = transmission(joint, row[MOTOR_ANGLE])
        torsion = row[MOTOR_ANGLE] / joint['ratio'] + error - row[LINK_ANGLE]
        growing, _ = growth(joint, row[MOTOR_ANGLE])
        bristles = total_at(BRISTLES, 'law_stiffness', joint, Bent())
        loop = total_at(LOOP, 'law_stiffness', joint, Twisted())
        total += _integral(joint, torsion, growing) + 0.5 * (
            bristles * row[BRISTLE] ** 2 + loop * np.mean(row[STRETCH:STRETCH + SLIDERS] ** 2))
        total += total_at(LINK_TORQUE, 'law_energy', joint, Pulled(row[LINK_ANGLE]))
    return total


def _integral(joint: Any, torsion: float, growing: float) -> float:
    """Return the integral of the spring's torque over its torsion, from corner to corner [J]."""
    law, ratio = joint['torsion'], float(joint['ratio'])
    growing *= float(np.sign(torsion))          # all else of the law is odd
    reach = abs(played_torsion(joint, torsion))
    corners = [float(torsion_of_torque(law, ratio, torque)) - growing * torque
               for torque in (float(law[end]) for end in ('knee_1', 'knee_2', 'valid_torque'))]
    edges = np.unique(np.minimum([0.0, *corners, reach], reach))
    nodes, weights = np.polynomial.legendre.leggauss(20)
    total = 0.0
    for begin, half in zip(edges[:-1], 0.5 * np.diff(edges)):
        points = begin + half * (1.0 + nodes)
        total += half * sum(weight * torque_of_torsion(law, ratio, point, growing)
                            for point, weight in zip(points, weights))
    return total


def _base(body: Any, inertia: Inertia | Chain, state: Array) -> float:
    """Return the energy of a swinging base: its own, and what its speed adds to the links'."""
    swing = numbers_at(body, BASE)
    if swing['amplitude'] == 0.0:
        return 0.0
    offset, rate = state[0, BASE_OFFSET], state[0, BASE_RATE]
    coupling = _couplings(inertia, float(swing['direction']), state[:, LINK_ANGLE])
    pace = 2.0 * np.pi * swing['frequency']
    own = 0.5 * (rate ** 2 + (pace * offset) ** 2) / swing['amplitude']
    return float(own + rate * sum(c * dq for c, dq in zip(coupling, state[:, LINK_VELOCITY])))


def _couplings(inertia: Inertia | Chain, direction: float, q: Array) -> Any:
    """Return the torque on each joint per acceleration of the base [kg*m]."""
    if not isinstance(inertia, Chain):
        return base_coupling(inertia, direction, q[0], q[-1] if len(q) == 2 else 0.0)
    _placed(inertia, q)
    chain.base_couplings(inertia.table, (np.cos(direction), np.sin(direction), 0.0))
    return inertia.table[1:-1, chain.COUPLING]


def _placed(inertia: Chain, q: Array) -> Array:
    """Place a chain and return its mass matrix (n, n)."""
    table = inertia.table
    table[1:-1, chain.ANGLE] = q
    chain.place(table)
    chain.mass_matrix(table)
    return table[1:-1, chain.MATRIX:chain.MATRIX + len(q)]


def _potential(body: Any, inertia: Inertia | Chain, q: Array) -> float:
    if isinstance(inertia, Chain):
        _placed(inertia, q)
        moments = inertia.table[1:-1, chain.MOMENT_HERE:chain.MOMENT_HERE + 3]
        return float(-(moments @ inertia.table[0, chain.DOWN:chain.DOWN + 3]).sum())
    down = float(body['direction'])
    far = inertia.second * np.cos(down - q.sum()) if len(q) == 2 else 0.0
    return float(-body['pull'] * (inertia.first * np.cos(down - q[0]) + far))

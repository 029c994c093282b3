"""
Find which torque feedback K_J an arm bears at its rate, with the gains that it has.

The arm is linear near rest: sliding motors, gears without load, the links stretched, bent and
folded, free and held by what they touch. (A gear that stiffens under load bears less, which dry
friction then has to make up for.) The loop is sampled. An answer to one sample is in force from
the next one on. Speeds are low-passed differences, and so is the rate of the torsion, of which
damping makes torque.
"""

from collections.abc import Iterator
import math
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.chain_links import ChainLinks
from hda_arm_sim.model.stiffness_rate import masses
import numpy as np
from scipy.linalg import expm

from .controller import ControllerSettings
from ..estimating.estimator import EstimatorSettings

# Choices unless stated otherwise.
ELBOWS = (0.0, 0.5 * math.pi, math.pi)     # of the plants: stretched, bent, folded [rad]
POSTURES = 4            # of a chain: its zero and some at random
LOWEST, HIGHEST = -2.0, 0.99    # what `torque_feedback` may be at all
_GROWS = 1.0 + 1e-7             # beyond it an eigenvalue is no rounded one
_HALVINGS = 7                   # of a range: ends are known to about 0.01


class SampledPlant(NamedTuple):
    """A sampled arm, states shaft angle and speed and, unless held, link angle and speed."""

    step: Array                 # (s, s) from sample to sample
    motor: Array                # (s, n) what motor torques [N*m, shaft] do until the next sample
    shaft: Array                # (n, s) picks the shaft angles
    twist: Array                # (n, s) picks the torsions at the output
    stiffness: Array            # (n,) [N*m/rad]


class StableRange(NamedTuple):
    """Between which K_J the loop does not swing by itself; NaN if it does without feedback."""

    low: float
    high: float

    def __str__(self) -> str:
        """Return the range as people read it."""
        if math.isnan(self.low):
            return 'no value, for the loop swings without torque feedback'
        return f'between {self.low:.2g} and {self.high:.2g}'


def is_stable(arm: Arm, settings: ControllerSettings, period: float) -> bool:
    """Return whether an arm does not swing with these settings, sampled every period [s]."""
    return _stable(list(plants(arm, period)), arm, settings, settings.torque_feedback, period)


def stable_range(arm: Arm, settings: ControllerSettings, period: float) -> StableRange:
    """Return the K_J around zero that an arm bears, rounded towards zero."""
    known = list(plants(arm, period))
    if not _stable(known, arm, settings, 0.0, period):
        return StableRange(math.nan, math.nan)
    return StableRange(*(_end(known, arm, settings, end, period) for end in (LOWEST, HIGHEST)))


def _end(known: list[SampledPlant], arm: Arm, settings: ControllerSettings, end: float,
         period: float) -> float:
    if _stable(known, arm, settings, end, period):
        return end
    good, bad = 0.0, end
    for _ in range(_HALVINGS):
        middle = 0.5 * (good + bad)
        if _stable(known, arm, settings, middle, period):
            good = middle
        else:
            bad = middle
    return good


def _stable(known: list[SampledPlant], arm: Arm, settings: ControllerSettings, feedback: float,
            period: float) -> bool:
    return all(np.abs(np.linalg.eigvals(closed(plant, arm, settings, feedback, period))).max()
               <= _GROWS for plant in known)


def plants(arm: Arm, period: float) -> Iterator[SampledPlant]:
    """Yield the arm in each of its states."""
    stiffness = np.asarray(arm.record().joints['torsion']['first_stiffness'])
    for mass in _masses(arm):
        for held in (False, True):
            yield _sampled(arm, stiffness, mass, period, held=held)


def _sampled(arm: Arm, stiffness: Array, mass: Array, period: float, *,
             held: bool) -> SampledPlant:
    """Return an arm with these stiffnesses (n,) and mass matrix (n, n), its inputs held."""
    count = len(arm.joints)
    ratio, rotor = arm.record().joints['ratio'], arm.record().joints['motor_inertia']
    none, one = np.zeros((count, count)), np.eye(count)
    twist = np.hstack([np.diag(1.0 / ratio), none, -one, none])
    rate = np.hstack([none, np.diag(1.0 / ratio), none, -one])
    damping = np.array([joint.torsion.damping for joint in arm.joints])
    torque = np.diag(stiffness) @ twist + np.diag(damping) @ rate
    friction = np.diag([joint.viscous_friction for joint in arm.joints])
    motor = -np.diag(1.0 / (rotor * ratio)) @ torque
    motor[:, count:2 * count] -= friction / rotor[:, None]
    slope = np.vstack([np.hstack([none, one, none, none]), motor,
                       np.hstack([none, none, none, one]),
                       np.linalg.solve(mass, torque)])
    push = np.vstack([none, np.diag(1.0 / rotor), none, none])
    kept = slice(0, 2 * count) if held else slice(None)
    slope, push = slope[kept, kept], push[kept]
    states = len(slope)
    whole = np.zeros((states + count, states + count))
    whole[:states, :states], whole[:states, states:] = slope, push
    made = expm(period * whole)
    shaft = np.hstack([one, none, none, none])
    return SampledPlant(made[:states, :states], made[:states, states:], shaft[:, kept],
                        twist[:, kept],
                        stiffness)


def _masses(arm: Arm) -> list[Array]:
    """Return the mass matrices (n, n) of an arm in some postures."""
    if isinstance(arm.links, ChainLinks):
        return masses(arm, POSTURES)
    return [_mass(arm, elbow) for elbow in (ELBOWS[:1] if len(arm.joints) == 1 else ELBOWS)]


def _mass(arm: Arm, elbow: float) -> Array:
    links = arm.moving_links()
    if len(arm.joints) == 1:
        return np.array([[links.p1]])
    bend = links.coupled * links.p3 * math.cos(elbow)
    across = links.coupled * links.p2 + bend
    return np.array([[links.p1 + 2.0 * bend, across], [across, links.p2]])


def closed(plant: SampledPlant, arm: Arm, settings: ControllerSettings, feedback: float,
           period: float) -> Array:
    """
    Return the closed loop from sample to sample.

    Behind the plant's states stand the last shaft angles, the low-passed speeds, the last
    torsions, their low-passed rates, and the torques in force, (n,) each.
    """
    states, count = plant.motor.shape
    one = np.eye(count)
    places = [states + k * count for k in range(6)]
    angle, speed, twist, rate, force = (slice(a, b) for a, b in zip(places, places[1:]))
    made = np.zeros((places[-1], places[-1]))
    now = slice(0, states)
    made[now, now], made[now, force] = plant.step, plant.motor
    made[angle, now], made[twist, now] = plant.shaft, plant.twist
    quick = _share(settings.velocity_bandwidth, period)
    made[speed, now], made[speed, angle] = quick / period * plant.shaft, -quick / period * one
    made[speed, speed] = (1.0 - quick) * one
    quick = _share(EstimatorSettings().torsion_bandwidth, period)
    made[rate, now], made[rate, twist] = quick / period * plant.twist, -quick / period * one
    made[rate, rate] = (1.0 - quick) * one
    damping = np.diag([joint.torsion.damping for joint in arm.joints])
    share = feedback / arm.record().joints['ratio'][:, None]
    made[force] = -settings.velocity_gain * made[speed] + share * (damping @ made[rate])
    made[force, now] -= settings.position_gain * plant.shaft
    made[force, now] += share * (np.diag(plant.stiffness) @ plant.twist)
    return made


def _share(bandwidth: float, period: float) -> float:
    return 1.0 - math.exp(-2.0 * math.pi * bandwidth * period)

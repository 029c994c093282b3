"""
Measure how well and how fast an arm of seven joints estimates its torques and its wrench.

The arm is wrong in every number by as much as its tolerances say: gears, friction, drives,
encoders, and of each link mass, centre and the inertia about its joint. Its equations are the
library's own, which agree with Pinocchio (`test/test_chain.py`). Its tip is pushed and twisted
while it moves.
"""

from collections.abc import Sequence
from dataclasses import replace
import time
from typing import NamedTuple

from hda_arm_sim.foundation import chain
from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.chain_links import ChainLinks
from hda_arm_sim.model.effects import (ClockSkew, DriveOffset, Effect, KinematicError,
                                       LinkEncoderEccentricity, LinkInertiaError,
                                       TorqueConstantError, TorqueRipple)
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.model.link_side import loaded_inertia
from hda_arm_sim.model.parts import Joint, Tolerances
from hda_arm_sim.motions import motion_of
from hda_msgs_json.cdr import JointStateEncoder
from hda_torque_estimator.diagnosis.fitting.solve import REACH
from hda_torque_estimator.estimating.estimates import Estimates
from hda_torque_estimator.estimating.estimator import Estimator
from hda_torque_estimator.estimating.laws import contact, layout
from hda_torque_estimator.estimating.live_estimator import LiveEstimator
from hda_torque_estimator.samples.readings import reading_names
from hda_torque_estimator.simulating.closed_loop import ClosedLoopRun, run
import numpy as np
from pushes import BEGUN, WITHIN

ARM = 'cobot7.yaml'
DT = 1e-3
MOTIONS = ('rich', 'sine', 'turn')
FORCE, MOMENT = 20.0, 1.5       # largest of the pushes and twists [N, N*m]
CONDITIONED = 0.05              # least over largest singular value from which a pose counts
LENGTH = 0.3                    # that makes turning the tip comparable to moving it [m]
MOVING = 0.02                   # speed of the quickest joint from which on an arm moves [rad/s]
BARS = {'force': 1.5, 'held': (0.85, 0.95), 'microseconds': 60.0}
_COUNTED = 2000                 # samples of which the time is taken


class Judged(NamedTuple):
    """What the estimator says of one recording."""

    torque: float               # mean absolute error, all joints [N*m]
    force: float                # rms of a component of the tip force, pushed [N]
    moment: float               # likewise [N*m]
    counted: float              # share of the samples in such poses
    held: dict[str, float]      # shares within their 90 % regions
    alarms: int                 # contacts in the same motion without a push


def main(arms: int, first: int, seconds: float) -> None:
    """Print what is reached with arms of so many seeds."""
    found = []
    for seed in range(first, first + arms):
        for name in MOTIONS:
            found.append(judged(seed, name, seconds))
            one = found[-1]
            print(f'arm {seed}, {name}: torque {one.torque:.3f} N*m, force {one.force:.2f} N, '
                  f'moment {one.moment:.3f} N*m, {100 * one.counted:.0f} % of the poses, held '
                  + ', '.join(f'{what} {100 * share:.0f} %' for what, share in one.held.items())
                  + f', {one.alarms} alarms', flush=True)
    print('\n'.join(table(found, microseconds(read_arm(ARM)))))


def scattered(arm: Arm, seed: int) -> Arm:
    """Return the arm with every number off by as much as its tolerances say."""
    known, random = arm.tolerances, np.random.default_rng([seed, 77])
    made = numbers_off(arm, random)
    for label in arm.labels:
        for effect in _effects(known, random):
            made = made.with_effect(effect, label)
    return made


def numbers_off(arm: Arm, random: np.random.Generator) -> Arm:
    """Return the arm with stiffness, friction, damping, zeros and links off, without waves."""
    known, links = arm.tolerances, arm.links
    assert isinstance(links, ChainLinks)
    made = replace(arm, joints=tuple(_off(joint, known, random) for joint in arm.joints))
    for label, one in zip(arm.labels, links.known(known.link_inertia)):
        x, y, z, mass, error = (size * deviate(random)
                                for size in (*3 * (one.centre,), one.mass, one.inertia))
        made = made.with_effect(LinkInertiaError(
            error=error, mass=mass, centre_x=x, centre_y=y, centre_z=z), label)
    return made


def deviate(random: np.random.Generator) -> float:
    """Return how far a number is off, in deviations: no further than a diagnosis lets it be."""
    drawn = float(random.standard_normal())
    return drawn if abs(drawn) <= REACH else deviate(random)


def _off(joint: Joint, known: Tolerances, random: np.random.Generator) -> Joint:
    factor = {name: 1.0 + getattr(known, name) * deviate(random)
              for name in ('stiffness', 'dry_friction', 'viscous_friction', 'damping')}
    stiffness = factor['stiffness'] * joint.torsion.flexspline_stiffness
    torsion = replace(joint.torsion, flexspline_stiffness=stiffness,
                      damping=factor['damping'] * joint.torsion.damping)
    zero = known.torsion_zero * deviate(random)
    return replace(joint, torsion=torsion, link_encoder=replace(joint.link_encoder, zero=zero),
                   dry_friction=factor['dry_friction'] * joint.dry_friction,
                   viscous_friction=factor['viscous_friction'] * joint.viscous_friction)


def _effects(known: Tolerances, random: np.random.Generator) -> list[Effect]:
    return [KinematicError(**_waves(known.kinematic_error, (2, 4), random)),
            LinkEncoderEccentricity(**_waves(known.eccentricity, (1, 2), random)),
            TorqueRipple(**_waves(known.torque_ripple, (2, 4), random)),
            TorqueConstantError(error=known.torque_constant * deviate(random)),
            DriveOffset(offset=known.drive_offset * deviate(random)),
            ClockSkew(skew=known.clock_skew * deviate(random))]


def _waves(size: float, orders: Sequence[int], random: np.random.Generator) -> dict[str, float]:
    """Return waves of which sine and cosine have this deviation."""
    found = {}
    for order in orders:
        sine, cosine = size * random.standard_normal(2)
        found[f'amplitude_{order}'] = float(np.hypot(sine, cosine))
        found[f'phase_{order}'] = float(np.arctan2(cosine, sine))
    return found


def pushes(samples: int, random: np.random.Generator) -> Array:
    """Return soft pushes and twists, every way, from two seconds on (samples, 6) [N, N*m]."""
    moment, wrench, begin = DT * np.arange(samples), np.zeros((samples, 6)), 2.0
    while begin < moment[-1]:
        edge = np.clip(np.minimum(moment - begin, begin + 1.2 - moment) / 0.15, 0.0, 1.0)
        for part, most in ((slice(0, 3), FORCE), (slice(3, 6), MOMENT)):
            way = random.standard_normal(3)
            size = random.uniform(0.2, 1.0) * most / np.linalg.norm(way)
            wrench[:, part] += np.outer(edge ** 2 * (3.0 - 2.0 * edge), size * way)
        begin += random.uniform(1.5, 3.0)
    return wrench


def judged(seed: int, name: str, seconds: float) -> Judged:
    """Return what the nominal arm's estimator says of a scattered arm in a motion."""
    given, true = read_arm(ARM), scattered(read_arm(ARM), seed)
    path = motion_of(given, name, seconds, DT, 100 * seed)
    wrench = pushes(len(path.time), np.random.default_rng([seed, 78]))
    pushed = run(true, given, path._replace(force=wrench), seed, estimator=None)
    free = run(true, given, path, seed + 1, estimator=None)
    found, calm = (estimated(given, made) for made in (pushed, free))
    rows = np.flatnonzero(
        (conditioning(given, pushed.reading[:, :, 1]) > CONDITIONED)
        & (np.abs(pushed.reading[:, :, 3]).max(axis=1) > MOVING)
        & np.isfinite(found.base_wrench).all(axis=1) & (np.arange(len(wrench)) >= BEGUN))
    off = (found.base_wrench - wrench)[rows]
    level = calm.tip[:, layout.CONTACT_LEVEL] > contact.FREE
    return Judged(
        float(np.abs(found.torque - pushed.joint_torque)[BEGUN:].mean()),
        _rms(off[:, :3]), _rms(off[:, 3:]), len(rows) / max(len(wrench) - BEGUN, 1),
        _held(found, pushed, calm, off, rows), int(np.diff(level, prepend=False).sum() + 1) // 2)


def conditioning(arm: Arm, angles: Array) -> Array:
    """Return how well the torques determine all of a wrench at angles (k, n), from 0 to 1 (k,)."""
    table, jacobian = loaded_inertia(arm.record().body).table, np.empty((6, angles.shape[1]))
    found = np.empty(len(angles))
    for k, each in enumerate(angles):
        table[1:-1, chain.ANGLE] = each
        chain.place(table)
        chain.tip_jacobian(table, jacobian)
        jacobian[3:] *= LENGTH
        values = np.linalg.svd(jacobian, compute_uv=False)
        found[k] = values[-1] / values[0]
    return found


def _held(found: Estimates, pushed: ClosedLoopRun, calm: Estimates, off: Array,
          rows: Array) -> dict[str, float]:
    """Return which share of torques, free external torques and wrenches is as sure as stated."""
    from scipy.stats import chi2
    torque = np.abs(found.torque - pushed.joint_torque) < WITHIN * found.torque_deviation
    external = np.abs(calm.joints[:, :, layout.EXTERNAL_TORQUE]) < WITHIN * (
        calm.joints[:, :, layout.EXTERNAL_DEVIATION])
    spread = found.tip[rows, layout.WRENCH_COVARIANCE:].reshape(-1, 6, 6)[:, :3, :3]
    far = np.einsum('ki,kij,kj->k', off[:, :3], np.linalg.inv(spread), off[:, :3])
    alone = np.abs(off) < WITHIN * np.sqrt(found.tip[rows, layout.WRENCH_COVARIANCE::7])
    return {'torque': float(torque[BEGUN:].mean()), 'external': float(external[BEGUN:].mean()),
            'force': float((far < chi2.ppf(0.9, 3)).mean()),
            'each component': float(alone.mean())}


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values ** 2))) if values.size else float('nan')


def estimated(arm: Arm, made: ClosedLoopRun) -> Estimates:
    """Return the estimates of a run, from angles and commands."""
    stamps = np.round(made.time * 1e9).astype(np.int64) + 1
    return Estimator(arm).run(stamps, made.reading, made.command)


def microseconds(arm: Arm) -> float:
    """Return the median time from the bytes of a sample to those of all wrenches [us]."""
    path = motion_of(arm, 'sine', _COUNTED * DT, DT, 0)
    made, live = run(arm, arm, path, 0, estimator=None), LiveEstimator(arm)
    encode, spent, unknown = JointStateEncoder(reading_names(arm.labels)), [], np.nan
    for k in range(1, len(made.time)):
        message = encode(k * 1_000_000, made.reading[k, :, :2].ravel().tolist(),
                         made.reading[k, :, 2:].ravel().tolist(),
                         [one for torque in made.command[k].tolist() for one in (torque, unknown)])
        began = time.perf_counter()
        live(message)
        spent.append(1e6 * (time.perf_counter() - began))
    return float(np.median(spent))


def table(found: Sequence[Judged], spent: float) -> list[str]:
    """Return the table: means over recordings, and the worst of them."""
    force, low, high = [one.force for one in found], *BARS['held']
    lines = ['| seven joints, numbers off by their tolerances | at most | reached |',
             '|---|---|---|',
             f'| tip force while moving, rms of a component | {BARS["force"]:g} N | '
             f'{np.mean(force):.2f} N, worst recording {max(force):.2f} N |',
             f'| moment on the tip likewise | - | {np.mean([x.moment for x in found]):.3f} N*m |',
             f'| joint torque, mean absolute error | - | '
             f'{np.mean([x.torque for x in found]):.3f} N*m |']
    for what in found[0].held:
        shares = [100.0 * one.held[what] for one in found]
        lines.append(f'| 90 % regions hold: {what} | {100 * low:g} to {100 * high:g} % | '
                     f'{np.mean(shares):.0f} %, from {min(shares):.0f} to {max(shares):.0f} % |')
    return [*lines, f'| contacts in free motion, {len(found)} recordings | 0 | '
                    f'{sum(one.alarms for one in found)} |',
            f'| a sample to all wrenches, median | {BARS["microseconds"]:g} us | {spent:.0f} us |']

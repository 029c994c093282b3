"""Worlds of the truth as the library reads them: an arm file, joint states, torque sensors."""

import json

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.files import arm_from_text
from hda_msgs_json.samples import JointSamples, WrenchSamples
from hda_torque_estimator.measurements.measurement import Measurement
from hda_torque_estimator.measurements.sample_grid import measurement_from
from hda_torque_estimator.simulating.recorded import about_z, joint_samples
import numpy as np
from scipy.signal import lfilter
from truth import worlds


def arm_of(world: worlds.World) -> Arm:
    """Return the arm as its file states it."""
    return arm_from_text(json.dumps(worlds.stated(world.arm)), f'world {world.seed}')


def logged(world: worlds.World, arm: Arm) -> JointSamples:
    """Return the joint states of a world's log."""
    log = worlds.record(world)
    return joint_samples(arm, log.stamps, log.reading, log.command)


def as_read(world: worlds.World) -> tuple[Arm, Measurement]:
    """Return the arm as its file states it, and its measurement."""
    arm = arm_of(world)
    return arm, measurement_from(arm.labels, logged(world, arm))


def sensed(world: worlds.World, arm: Arm, gain: float | None = None) -> dict[str, WrenchSamples]:
    """
    Return what torque sensors of the joints show, which have errors of their own.

    One sigma: their zeros are off by a fifth of what the torque varies by, their gains by 2 %
    unless one is given. Their low-passes have some 3 ms, and their noise is 0.5 % of the torque.
    """
    log, random = worlds.record(world), np.random.default_rng([world.seed, 77])
    found, step = {}, float(np.median(np.diff(log.stamps))) * 1e-9
    for label, torque in zip(arm.labels, log.joint_torque.T):
        size = torque.std()
        zero, drawn = size * random.normal(0.0, 0.2), random.normal(0.0, 0.02)
        kept = np.exp(-step / max(abs(random.normal(0.0, 0.003)), 1e-6))
        slow = lfilter([1.0 - kept], [1.0, -kept], torque - torque[0]) + torque[0]
        off = drawn if gain is None else gain
        shown = (1.0 + off) * slow + zero + 0.005 * size * random.standard_normal(len(torque))
        found[label] = about_z(log.stamps, label, shown)
    return found

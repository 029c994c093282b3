"""Worlds of the truth as the library reads them: an arm file and joint states."""

import json

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.files import arm_from_text
from hda_msgs_json.samples import JointSamples
from hda_torque_estimator.simulating.recorded import joint_samples
from truth import worlds


def arm_of(world: worlds.World) -> Arm:
    """Return the arm as its file states it."""
    return arm_from_text(json.dumps(worlds.stated(world.arm)), f'world {world.seed}')


def logged(world: worlds.World, arm: Arm) -> JointSamples:
    """Return the joint states of a world's log."""
    log = worlds.record(world)
    return joint_samples(arm, log.stamps, log.reading, log.command)

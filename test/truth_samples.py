"""What a driver publishes of an arm of the truth."""

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.motions import motion
from hda_msgs_json.samples import JointSamples
from hda_torque_estimator.simulating.recorded import joint_samples
from tolerated import reading
from truth import Hidden, record, Reference

SECONDS, PERIOD = 60.0, 1e-3


def published(arm: Arm, hidden: list[Hidden], seed: int, *, name: str = 'rich',
              noise: float = 1.0, seconds: float = SECONDS,
              period: float = PERIOD) -> JointSamples:
    """Return joint states of an arm that makes a motion under a loop, stamped by its clock."""
    asked = motion(name, len(arm.joints), seconds, period, seed)
    made = record(hidden, Reference(asked.angle, asked.rate, period), seed=seed, noise=noise)
    return joint_samples(arm, made.stamps, reading(made), made.command)

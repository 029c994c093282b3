"""What a driver publishes of an arm of the truth."""

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.motions import motion
from hda_msgs_json.samples import JointSamples
from hda_torque_estimator.simulating.recorded import joint_samples
from tolerated import reading
from truth import Hidden, record

SECONDS, PERIOD = 60.0, 1e-3


def published(arm: Arm, hidden: list[Hidden], seed: int, *, name: str = 'rich',
              noise: float = 1.0) -> JointSamples:
    """Return 60 s of joint states at 1 kHz of an arm that makes a motion, stamped by its clock."""
    asked = motion(name, len(arm.joints), SECONDS, PERIOD, seed)
    made = record(hidden, motion_angle=asked.angle, motion_rate=asked.rate, dt=PERIOD, seed=seed,
                  noise=noise)
    return joint_samples(arm, made.stamps, reading(made), made.command)

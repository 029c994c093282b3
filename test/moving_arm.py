"""Joint states as the driver of a moving arm publishes them."""

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.motions import motion
from hda_msgs_json.cdr_arrays import encode_joint_rows
from hda_torque_estimator.simulating.closed_loop import run
from hda_torque_estimator.simulating.recorded import joint_samples
import numpy as np


def moving(arm: Arm) -> list[bytes]:
    """Return the messages of 0.6 s at 1 kHz, in which both joints move."""
    made = run(arm, arm, motion('sine', 2, 2.0, 1e-3, 0), 1)
    stamps = 10**9 + np.arange(len(made.time)) * 1_000_000
    samples = joint_samples(arm, stamps, made.reading, made.command)
    return [row.tobytes() for row in encode_joint_rows(samples)][900:1500]

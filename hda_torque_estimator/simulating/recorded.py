"""Write what was simulated to a bag, as the nodes would have recorded it."""

from hda_arm_sim.model.arm import Arm
from hda_msgs_json.bag import BagWriter
from hda_msgs_json.samples import JointSamples, WrenchSamples
from hda_msgs_json.topics import (BASE_FRAME, EXTERNAL_WRENCH, JOINT_STATES, link_frame,
                                  motor_name, truth_joint_torque, truth_link_wrench,
                                  TRUTH_TIP_WRENCH)
import numpy as np
from numpy.typing import NDArray

from .closed_loop import ClosedLoopRun

FIRST_STAMP = 1_000_000_000         # of an offline simulation: bags with a time of 0 look empty


def write_run(bag: BagWriter, arm: Arm, run: ClosedLoopRun) -> None:
    """Write the joint states of a run and what was true: joint torques, forces on tip and link."""
    stamps = FIRST_STAMP + np.round(run.time * 1e9).astype(np.int64)
    bag.write_joint_states(JOINT_STATES, joint_samples(arm, stamps + run.late, run.reading,
                                                       run.command))
    for label, torque in zip(arm.labels, run.joint_torque.T):
        bag.write_wrenches(truth_joint_torque(label), about_z(stamps, link_frame(label), torque))
    if run.pushed:
        bag.write_wrenches(truth_link_wrench(arm.labels[run.pushed - 1]),
                           on_tip(stamps, BASE_FRAME, run.force))
        bag.write_wrenches(TRUTH_TIP_WRENCH, on_tip(stamps, BASE_FRAME, 0.0 * run.force))
        return
    bag.write_wrenches(TRUTH_TIP_WRENCH, on_tip(stamps, BASE_FRAME, run.force))
    if run.force.any():
        bag.write_wrenches(EXTERNAL_WRENCH, on_tip(stamps, BASE_FRAME, run.force))


def joint_samples(arm: Arm, stamps: NDArray[np.int64], reading: NDArray[np.float64],
                  command: NDArray[np.float64]) -> JointSamples:
    """Return readings (k, n, 4) and motor torques (k, n) as joint states, links first."""
    names = (*arm.labels, *(motor_name(label) for label in arm.labels))
    return JointSamples(stamps, names,
                        np.concatenate([reading[:, :, 1], reading[:, :, 0]], axis=1),
                        np.concatenate([reading[:, :, 3], reading[:, :, 2]], axis=1),
                        np.concatenate([np.full_like(command, np.nan), command], axis=1))


def about_z(stamps: NDArray[np.int64], frame: str,
            torque: NDArray[np.float64]) -> WrenchSamples:
    """Return torques about z [N*m]; what a planar arm does not know is NaN."""
    unknown = np.full((len(stamps), 3), np.nan)
    values = unknown.copy()
    values[:, 2] = torque
    return WrenchSamples(stamps, frame, unknown, values)


def on_tip(stamps: NDArray[np.int64], frame: str,
           force: NDArray[np.float64]) -> WrenchSamples:
    """Return forces in the plane (k, 2) or wrenches (k, 6); what does not exist there is NaN."""
    values = np.full((len(stamps), 6), np.nan)
    values[:, :force.shape[1]] = force
    return WrenchSamples(stamps, frame, values[:, :3], values[:, 3:])

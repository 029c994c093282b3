"""Print what is compiled or loaded only after the nodes are ready, in a process of its own."""

import sys

from hda_arm_sim.health import Pace, Refusals
from hda_arm_sim.live import FIRST_STAMP, LiveArm, SimulationSettings
from hda_arm_sim.model.files import read_arm
from hda_msgs_json.cdr import decode_joint_state, encode_joint_state
from hda_msgs_json.topics import JOINT_TORQUES, motor_name
from hda_torque_estimator.controlling.controller import ControllerSettings
from hda_torque_estimator.controlling.live_controller import LiveController, TargetPoints
from hda_torque_estimator.estimating.estimate_messages import estimate_topics
from hda_torque_estimator.estimating.estimator_report import estimator_report
from hda_torque_estimator.estimating.live_estimator import LiveEstimator
import numpy as np
from test_compiled import compiled_functions

ARM = read_arm('hda_arm.yaml')
SAMPLES, REPORT, TARGET = 3000, 500, 100
PERIOD = 1e-3           # [s]
PACE = Pace(1000.0, 0.0, 0.0, 0.0)


def torques(messages: list[bytes]) -> bytes:
    """Return the joint torques of an answer."""
    return dict(zip((topic.name for topic in estimate_topics(ARM)), messages))[JOINT_TORQUES.name]


def signatures() -> set[tuple[object, ...]]:
    """Return all that has been compiled or loaded so far."""
    return {(*name, str(each)) for name, law in compiled_functions().items()
            for each in law.signatures}


def move(live: LiveArm, estimator: LiveEstimator, controller: LiveController) -> None:
    """Close the loop as the nodes do, with a target, a tare and reports on the way."""
    shafts = [motor_name(label) for label in ARM.labels]
    for k in range(SAMPLES):
        sample = live.sample()
        state = encode_joint_state(
            sample.stamp, '', [*ARM.labels, *shafts],
            [*sample.reading[:, 1], *sample.reading[:, 0]],
            [*sample.reading[:, 3], *sample.reading[:, 2]],
            [*np.zeros(len(shafts)), *sample.motor_torque])
        controller.sample(state, k * PERIOD)
        command = controller.torque(torques(estimator(state).messages), k * PERIOD)
        live.command(sample.stamp, np.array(decode_joint_state(command).effort))
        live.advance()
        if k == TARGET:
            here = controller.present()[:, 0]
            controller.follow(TargetPoints(ARM.labels, [1.0, 2.0], [here + 0.2, here], []))
            estimator.estimator.tare()
        if k % REPORT == REPORT - 1:
            estimator_report(estimator, PACE, Refusals())


def main() -> None:
    """Print each name and signature that was not there when the nodes were ready."""
    live = LiveArm(ARM, SimulationSettings(), FIRST_STAMP)
    live.sample()
    live.advance()
    estimator = LiveEstimator(ARM)
    controller = LiveController(ARM, ControllerSettings(torque_feedback=-1.0), enabled=True)
    before = signatures()
    move(live, estimator, controller)
    for late in sorted(signatures() - before):
        sys.stdout.write(f'{late}\n')


if __name__ == '__main__':
    main()

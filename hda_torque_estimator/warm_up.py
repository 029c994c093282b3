"""
Compile every law into the cache, once after an installation.

Run it as `python -m hda_torque_estimator.warm_up`.
"""

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import motion
from hda_arm_sim.plant import Plant
from hda_arm_sim.simulate import rest, rollout
import numpy as np

from .closed_loop import run
from .controller import Controller
from .estimate import TORQUE
from .estimator import Estimator

_DT = 1e-3              # [s]


def warm_up(arm: Arm) -> None:
    """Call each compiled function as the nodes and the commands call it."""
    path = motion('push', len(arm.joints), 2.0, _DT, 0)
    loop = run(arm, arm, path, 0)
    start = rest(arm, path.angle[0])
    for held in (True, False):
        rollout(arm, start, loop.command[:5], loop.force[:5], _DT, held=held)
    plant, estimator, controller = Plant(arm, start, _DT, 0), Estimator(arm), Controller(arm)
    controller.enable()
    estimator.tare()
    for k in range(3):
        reading = plant.sample()
        estimator.update(k, reading, np.zeros(len(arm.joints)))
        command = controller.update(k, reading[:, 0].copy(), estimator.joints[:, TORQUE].copy())
        plant.advance(command, np.zeros(2))
    estimator.run(np.arange(3, 6), loop.reading[:3], loop.command[:3])


if __name__ == '__main__':
    warm_up(read_arm('hda_arm.yaml'))

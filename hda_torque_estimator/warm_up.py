"""The `warm_up` executable: compile every law into the cache, once after an installation."""

import signal
import sys
from types import FrameType

from hda_arm_sim.foundation.compiled import cache_folder, say_when_compiling
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import motion
from hda_arm_sim.plant import Plant
from hda_arm_sim.ros.startup_signals import EarlyEnd
from hda_arm_sim.simulate import Course, rest, rollout
import numpy as np

from .controlling.live_controller import LiveController
from .estimating.estimator import Estimator
from .estimating.live_estimator import LiveEstimator
from .simulating.closed_loop import run

ARMS = ('hda_arm.yaml', 'paper_single_axis.yaml')       # two joints with links, one joint
_DT = 1e-3              # [s]
_USAGE = """usage: warm_up

Compile what the nodes and the commands need, once after an installation. Without it, the first
start of each takes up to a minute longer. HDA_CACHE_DIR names the folder of the compiled code.
"""


def warm_up(arm: Arm) -> None:
    """Call each compiled function as the nodes and the commands call it."""
    path = motion('push', len(arm.joints), 2.0, _DT, 0)
    loop = run(arm, arm, path, 0)
    start = rest(arm, path.angle[0])
    for held in (True, False):
        rollout(arm, start, Course(loop.command[:5], loop.force[:5]), _DT, held=held)
    LiveEstimator(arm)
    LiveController(arm)
    plant = Plant(arm, start, _DT, 0)
    plant.sample()
    plant.advance(np.zeros(len(arm.joints)), np.zeros(2))
    Estimator(arm).run(np.arange(3), loop.reading[:3], loop.command[:3])


def main() -> int:
    """Compile, say where it is kept, and return the exit code."""
    if sys.argv[1:]:
        asked = sys.argv[1:] in (['-h'], ['--help'])
        (sys.stdout if asked else sys.stderr).write(
            _USAGE if asked else f'warm_up: there are no arguments, got {sys.argv[1]!r}\n')
        return 0 if asked else 2
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, _ignore)                  # EarlyEnd sees to it
    say_when_compiling(_say)
    with EarlyEnd(1):
        for name in ARMS:
            warm_up(read_arm(name))
    sys.stdout.write(f'everything is compiled in {cache_folder("").parent}\n')
    return 0


def _say(said: str) -> None:
    sys.stderr.write(f'warm_up: {said}\n')


def _ignore(number: int, frame: FrameType | None) -> None:
    """Let another thread end the process."""


if __name__ == '__main__':
    sys.exit(main())

"""The `warm_up` executable: compile every law into the cache, once after an installation."""

import signal
import sys
from types import FrameType

from hda_arm_sim.foundation.compiled import cache_folder, say_when_compiling
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects.catalogue import effects_at
from hda_arm_sim.model.effects.place import (BASE, BEARING, LINK_INERTIA, STIFFENING, TIP,
                                             WIND_UP)
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import motion_of
from hda_arm_sim.plant import Plant
from hda_arm_sim.ros.startup_signals import EarlyEnd
from hda_arm_sim.simulate import InputHistory, rest, rollout
import numpy as np

from .controlling.live_controller import LiveController
from .diagnosis.balances.balance import Balancer
from .diagnosis.diagnose import diagnose
from .diagnosis.readings.raw_readings import RAW_EFFECTS
from .estimating.estimator import Estimator
from .estimating.live_estimator import LiveEstimator
from .measurements.measurement import Measurement
from .simulating.closed_loop import run

# Two joints with links in a plane, one joint, and a chain in space.
ARMS = ('hda_arm.yaml', 'paper_single_axis.yaml', 'cobot7.yaml')
_DT, _SECONDS = 1e-3, 12.0         # of a recording that can be diagnosed [s]
# Causes of which a search runs all that is compiled.
_TRIED = (*(effect.name for place in (TIP, BASE, BEARING, LINK_INERTIA, STIFFENING, WIND_UP)
            for effect in effects_at(place)), *RAW_EFFECTS)
_USAGE = """usage: warm_up

Compile what the nodes and the commands need, once after an installation, for two to four
minutes. Without it the first start of each does so. HDA_CACHE_DIR names the folder of
the compiled code.
"""


def warm_up(arm: Arm) -> None:
    """Call each compiled function as the nodes and the commands call it."""
    path = motion_of(arm, 'push', 2.0, _DT, 0)
    loop = run(arm, arm, path, 0)
    start = rest(arm, path.angle[0])
    for held in (True, False):
        rollout(arm, start, InputHistory(loop.command[:5], loop.force[:5]), _DT, held=held)
    LiveEstimator(arm)
    LiveController(arm)
    plant = Plant(arm, start, _DT, 0)
    plant.sample()
    plant.advance(np.zeros(len(arm.joints)), np.zeros(2))
    Estimator(arm).run(np.arange(3), loop.reading[:3], loop.command[:3])


def warm_up_diagnosis(arm: Arm) -> None:
    """Call each compiled function as a diagnosis calls it: with the causes that run them all."""
    made = run(arm, arm, motion_of(arm, 'rich', _SECONDS, _DT, 0), 0, estimator=None)
    reading = np.ascontiguousarray(made.reading[:, :, :2])
    measurement = Measurement(arm.labels, _DT, reading, made.command)
    diagnose(measurement, arm, names=_TRIED)
    Balancer(measurement).whole(arm)            # as for effects that remember


def main() -> int:
    """Compile, say where it is kept, and return the exit code."""
    if sys.argv[1:]:
        asked = sys.argv[1:] in (['-h'], ['--help'])
        (sys.stdout if asked else sys.stderr).write(
            _USAGE if asked else f'warm_up: there are no arguments, got {sys.argv[1]!r}\n')
        return 0 if asked else 2
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, _ignore)                  # EarlyEnd sees to it
    said: list[str] = []
    say_when_compiling(lambda text: said.append(_say(text)))
    parts = [(compile_part, name) for name in ARMS
             for compile_part in (warm_up, warm_up_diagnosis)]
    with EarlyEnd(1):
        for place, (compile_part, name) in enumerate(parts):
            compile_part(read_arm(name))
            if said:                                    # not where all of it is kept already
                _say(f'{place + 1} of {len(parts)} parts are compiled')
    sys.stdout.write(f'everything is compiled in {cache_folder("").parent}\n')
    return 0


def _say(text: str) -> str:
    sys.stderr.write(f'warm_up: {text}\n')
    return text


def _ignore(number: int, frame: FrameType | None) -> None:
    """Let another thread end the process."""


if __name__ == '__main__':
    sys.exit(main())

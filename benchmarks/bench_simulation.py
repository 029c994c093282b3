"""
Measure how much faster than real time the simulation runs on one core, and how `hda` starts.

    bench_simulation.py [--arm FILE] [--quick]

The step is the default one, at which the reference trajectories are met to 1e-6 rad, or the
longest that a chain bears. The closed loop adds encoders, estimator and controller at 1 kHz. Times
are those of the processor, whatever else runs. The start is a cached one, beside that of python
alone, by the clock.
"""

from collections.abc import Callable
from pathlib import Path
import statistics
import subprocess
import sys
import time

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import home_of, motion_of
from hda_arm_sim.simulate import InputHistory, longest_step, rollout, STEP, step_count
from hda_arm_sim.start import start_of
from hda_torque_estimator.simulating.closed_loop import run
import numpy as np
from size import parser, verdict

SECONDS, REPEATS = 60.0, 5
TINY = 2.0                          # of a tiny case [s]
FASTER, FASTER_CHAIN, START = 200.0, 30.0, 1.5      # than real time, for two joints and more; [s]


def best(work: Callable[[], object], repeats: int) -> float:
    """Return the least processor time of some runs, after one to warm up [s]."""
    work()
    times = []
    for _ in range(repeats):
        began = time.process_time()
        work()
        times.append(time.process_time() - began)
    return min(times)


def free(arm: Arm, length: float) -> None:
    """Simulate an arm that is pushed around, without any control."""
    moments, start = np.arange(0.0, length, 1e-3), start_of(arm, home_of(arm))
    torque = start.command + 0.1 * np.sin(np.outer(moments, 1.0 + np.arange(len(arm.joints))))
    rollout(arm, start.state, InputHistory(torque, np.zeros((len(moments), 2))), 1e-3)


def started(repeats: int, *words: str) -> float:
    """Return the median time that a command takes [s]."""
    times = []
    for _ in range(repeats + 1):
        began = time.perf_counter()
        subprocess.run(words, check=True, stdout=subprocess.DEVNULL)
        times.append(time.perf_counter() - began)
    return statistics.median(times[1:])


def main() -> int:
    """Measure everything and print a table."""
    known = parser(__doc__)
    known.add_argument('--arm', default='hda_arm.yaml', help='arm file')
    options = known.parse_args()
    quick, arm = options.quick, read_arm(options.arm)
    length, repeats = (TINY, 1) if quick else (SECONDS, REPEATS)
    asked = motion_of(arm, 'rich', length, 1e-3, 0)
    rows = [('free arm', best(lambda: free(arm, length), repeats)),
            ('closed loop', best(lambda: run(arm, arm, asked, 0), repeats))]
    step = 1e-3 / step_count(1e-3, min(STEP, longest_step(arm)))
    print(f'{length:g} s of {len(arm.joints)} joints, step {step * 1e3:.3f} ms, one core')
    for name, seconds in rows:
        print(f'{name:24}{seconds:>8.3f} s{length / seconds:>10.0f} times real time')
    hda = Path(sys.executable).with_name('hda')
    words = [str(hda)] if hda.is_file() else [sys.executable, '-m', 'hda_torque_estimator.cli']
    bare = started(repeats, sys.executable, '-c', 'pass')
    start = started(repeats, *words, 'simulate', '--help')
    for name, seconds in (('python alone', bare), ('hda simulate --help', start)):
        print(f'{name:24}{seconds:>8.3f} s{seconds / bare:>10.1f} times python')
    faster, least = length / rows[0][1], FASTER if len(arm.joints) <= 2 else FASTER_CHAIN
    kept = faster >= least and start <= START
    return verdict(f'at least {least:g} times real time and a start of at most {START:g} s', kept,
                   quick=quick)


if __name__ == '__main__':
    sys.exit(main())

"""
Measure how much faster than real time the simulation runs on one core, and how `hda` starts.

The step is the default one, at which the reference trajectories are met to 1e-6 rad. The closed
loop adds encoders, estimator and controller at 1 kHz. The start is a cached one, beside that of
python alone.
"""

from collections.abc import Callable
from pathlib import Path
import statistics
import subprocess
import sys
import time

from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import HOME, motion
from hda_arm_sim.simulate import Course, rest, rollout, STEP
from hda_torque_estimator.simulating.closed_loop import run
import numpy as np
from size import parser, verdict

SECONDS, REPEATS = 60.0, 5
TINY = 2.0                          # of a tiny case [s]
FASTER, START = 200.0, 1.5          # than real time; [s]
ARM = read_arm('hda_arm.yaml')


def best(work: Callable[[], object], repeats: int) -> float:
    """Return the shortest time of some runs, after one to warm up [s]."""
    work()
    times = []
    for _ in range(repeats):
        began = time.perf_counter()
        work()
        times.append(time.perf_counter() - began)
    return min(times)


def free(length: float) -> None:
    """Simulate an arm that is pushed around, without any control."""
    moments = np.arange(0.0, length, 1e-3)
    torque = 0.1 * np.sin(np.outer(moments, [1.0, 2.0]))
    rollout(ARM, rest(ARM, HOME), Course(torque, np.zeros((len(moments), 2))), 1e-3)


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
    quick = parser(__doc__).parse_args().quick
    length, repeats = (TINY, 1) if quick else (SECONDS, REPEATS)
    asked = motion('rich', 2, length, 1e-3, 0)
    rows = [('free arm', best(lambda: free(length), repeats)),
            ('closed loop', best(lambda: run(ARM, ARM, asked, 0), repeats))]
    print(f'{length:g} s of two joints, step {STEP * 1e3:.3f} ms, one core')
    for name, seconds in rows:
        print(f'{name:24}{seconds:>8.3f} s{length / seconds:>10.0f} times real time')
    hda = Path(sys.executable).with_name('hda')
    words = [str(hda)] if hda.is_file() else [sys.executable, '-m', 'hda_torque_estimator.cli']
    bare = started(repeats, sys.executable, '-c', 'pass')
    start = started(repeats, *words, 'simulate', '--help')
    for name, seconds in (('python alone', bare), ('hda simulate --help', start)):
        print(f'{name:24}{seconds:>8.3f} s{seconds / bare:>10.1f} times python')
    faster = length / rows[0][1]
    kept = faster >= FASTER and start <= START
    return verdict(f'at least {FASTER:g} times real time and a start of at most {START:g} s', kept,
                   quick=quick)


if __name__ == '__main__':
    sys.exit(main())

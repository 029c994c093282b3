"""
Measure what balances of one more trial cost, made of known parts, beside a run of the whole arm.

    bench_balances.py [--arm FILE] [--quick]

A trial is an arm with another size of one effect. Both ways take turns in one run, and their
balances are compared. Times are those of the processor. Beside the bearing of a link all else is
tried once more, as a search does that has accepted it.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
import statistics
import sys
import time

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import effect_named, Scope
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.model.typical_sizes import typical
from hda_arm_sim.motions import motion_of
from hda_torque_estimator.diagnosis.balances.balance import Balancer
from hda_torque_estimator.measurements.measurement import Measurement
from hda_torque_estimator.simulating.closed_loop import run
import numpy as np
from size import parser, verdict

SECONDS, TRIALS = 60.0, 15
TINY = 2.0                          # of a tiny case [s]
FASTER, CLOSE = 1.0, 1e-9           # than whole runs; of the largest torque, that ways may differ
BEARING = 'link_bearing_friction'
TRIED = {'coulomb_friction': 'level', 'stiffness_error': 'error', 'payload': 'mass',
         BEARING: 'level', 'base_vibration': 'amplitude'}


def recording(arm: Arm, seconds: float) -> Measurement:
    """Return a motion of an arm, as its encoders show it."""
    made = run(arm, arm, motion_of(arm, 'rich', seconds, 1e-3, 0), 0, estimator=None)
    return Measurement(arm.labels, 1e-3, np.ascontiguousarray(made.reading[:, :, :2]),
                       made.command)


def trials(arm: Arm, name: str, count: int) -> Iterator[Arm]:
    """Yield arms with one size after another of an effect, at the last joint."""
    joint = None if effect_named(name).scope is Scope.ARM else arm.labels[-1]
    usual, number = typical(arm, name, joint), TRIED[name]
    for share in np.linspace(0.5, 1.0, count):
        yield arm.with_effect(replace(usual, **{number: share * getattr(usual, number)}), joint)


def seconds_of(work: Callable[[], np.ndarray]) -> tuple[float, np.ndarray]:
    """Return the processor time of some work [s], and what it returns."""
    began = time.process_time()
    made = work()
    return time.process_time() - began, made


def weighed(balancer: Balancer, arms: Iterator[Arm]) -> tuple[float, float, float]:
    """Return median times by parts and by whole runs [s], and by how much links differ."""
    parts, wholes, apart = [], [], 0.0
    for arm in arms:
        fast, made = seconds_of(lambda arm=arm: balancer(arm).residual)
        slow, expected = seconds_of(lambda arm=arm: balancer.whole(arm))
        links = slice(len(arm.joints), None)
        apart = max(apart, float(np.abs(made - expected)[:, links].max()
                                 / np.abs(expected).max()))
        parts.append(fast)
        wholes.append(slow)
    return statistics.median(parts), statistics.median(wholes), apart


def main() -> int:
    """Measure everything and print a table."""
    known = parser(__doc__)
    known.add_argument('--arm', default='hda_arm.yaml', help='arm file')
    options = known.parse_args()
    length, count = (TINY, 2) if options.quick else (SECONDS, TRIALS)
    arm = read_arm(options.arm)
    balancer = Balancer(recording(arm, length))
    held = next(trials(arm, BEARING, 1))
    print(f'{length:g} s of {len(arm.joints)} joints at 1 kHz, one trial')
    ratios, apart = [], 0.0
    for beside, base in (('', arm), (' beside a bearing', held)):
        for name in TRIED:
            if beside and name in (BEARING, 'base_vibration'):  # itself, and a run of the whole
                continue
            balancer(base)
            fast, slow, away = weighed(balancer, trials(base, name, count))
            ratios.append(slow / fast)
            apart = max(apart, away)
            print(f'{name + beside:42}{1e3 * fast:>7.1f} ms{1e3 * slow:>9.1f} ms whole'
                  f'{slow / fast:>7.1f} times')
    print(f'largest difference {apart:.1e} of the largest torque')
    return verdict(f'parts never slower than whole runs, and the same within {CLOSE:g}',
                   min(ratios) >= FASTER and apart <= CLOSE, quick=options.quick)


if __name__ == '__main__':
    sys.exit(main())

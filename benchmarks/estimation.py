"""
Measure torque, tip force, contacts and intervals on the independent truth in `test/truth/`.

    estimation.py [--recordings N] [--minutes M] [--first SEED] [--quick]

Every arm is wrong by as much as its tolerances say. Prints the errors of the torque by torsion
alone and by both ways, how much 90 % intervals hold, the error of the tip force while moving, how
soon a push of 5 N is felt, and how often free motion is taken for a contact.
"""

from argparse import Namespace
from collections.abc import Sequence
from itertools import cycle, islice
from typing import NamedTuple

from hda_arm_sim.model.files import read_arm
from hda_torque_estimator.estimating.estimates import Estimates
from hda_torque_estimator.estimating.estimator import Estimator, EstimatorSettings
from hda_torque_estimator.estimating.laws import layout
from hidden_truth import TruthRecord
import numpy as np
from pushes import alarms, BEGUN, delays, force_error, PUSH, SOON, sudden, WITHIN
from size import parser
from tolerated import DT, pushed, reading, tolerated

ARM = read_arm('hda_arm.yaml')
ALONE = EstimatorSettings(fusion=0.0)
MOTIONS = ('rich', 'sine', 'turn')
SECONDS, MINUTE = 20.0, 60.0
TINY = 6.0                          # of all recordings of a tiny case [s]


class Row(NamedTuple):
    """What one recording says: means and shares, or nan."""

    alone: float                    # mean absolute error of the torque by torsion alone [N*m]
    fused: float                    # the same by both ways
    torque_held: float              # share of torques within their 90 % intervals
    external_held: float
    force: float                    # rms error of a component of the tip force [N]


def estimates(seen: TruthRecord, settings: EstimatorSettings = EstimatorSettings()) -> Estimates:
    """Return the estimates of a recording with its commands."""
    return Estimator(ARM, settings).run(seen.stamps, reading(seen), seen.command)


def moving(path: str, seed: int, seconds: float) -> Row:
    """Return what a recording with soft pushes says."""
    force = pushed(round(seconds / DT) + 1, 15.0, np.random.default_rng([seed, 5]))
    seen = tolerated(ARM.tolerances, path, seed, seconds, force)
    both, alone = estimates(seen), estimates(seen, ALONE)
    off = np.abs(both.torque - seen.joint_torque)[BEGUN:]
    pulled = np.abs(both.external_torque - seen.external)[BEGUN:]
    return Row(
        float(np.abs(alone.torque - seen.joint_torque)[BEGUN:].mean()), float(off.mean()),
        float((off < WITHIN * both.torque_deviation[BEGUN:]).mean()),
        float((pulled < WITHIN * both.joints[BEGUN:, :, layout.EXTERNAL_DEVIATION]).mean()),
        force_error(both, seen, force))


def felt_after(path: str, seed: int, seconds: float) -> list[float]:
    """Return when each sudden push was felt [ms], inf where it was not."""
    begins, force = sudden(round(seconds / DT) + 1, np.random.default_rng([seed, 9]))
    seen = tolerated(ARM.tolerances, path, seed, seconds, force)
    return delays(estimates(seen), seen, begins)


def options(arguments: Sequence[str] | None) -> Namespace:
    """Return what was asked for on the command line."""
    known = parser(__doc__)
    known.add_argument('--recordings', type=int, default=12)
    known.add_argument('--minutes', type=int, default=10)
    known.add_argument('--first', type=int, default=500, metavar='SEED')
    chosen = known.parse_args(arguments)
    if chosen.quick:
        chosen.recordings = chosen.minutes = 1
    return chosen


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure and print."""
    chosen = options(arguments)
    seconds, minute = (TINY, TINY) if chosen.quick else (SECONDS, MINUTE)
    paths = list(islice(cycle(MOTIONS), max(chosen.recordings, chosen.minutes)))
    moved = paths[:chosen.recordings]
    rows = [moving(path, chosen.first + k, seconds) for k, path in enumerate(moved)]
    felt = [delay for k, path in enumerate(moved)
            for delay in felt_after(path, chosen.first + 100 + k, seconds)]
    free = [alarms(estimates(tolerated(ARM.tolerances, path, chosen.first + 200 + k, minute)))
            for k, path in enumerate(paths[:chosen.minutes])]
    print(f'{len(rows)} recordings of {seconds:g} s, moving and pushed')
    report(rows)
    print(f'  {PUSH:g} N felt                      {sum(np.isfinite(felt))} of {len(felt)}, '
          f'{sum(np.array(felt) <= SOON)} within {SOON:g} ms, after {np.median(felt):.0f} ms, '
          f'at the latest {max(felt):.0f} ms')
    print(f'  free motion taken for contact {sum(count for count, _ in free)} times in '
          f'{len(free) * minute / 60.0:g} min; largest {max(most for _, most in free):.1f} '
          'deviations')


def report(rows: Sequence[Row]) -> None:
    """Print what recordings with soft pushes say together."""
    mean = Row(*np.mean(rows, axis=0))
    print(f'  torque, mean absolute error   torsion alone {mean.alone:.4f} N*m, both ways '
          f'{mean.fused:.4f} N*m: {100.0 * (1.0 - mean.fused / mean.alone):.0f} % lower')
    print(f'  90 % intervals hold           torque {100.0 * mean.torque_held:.1f} %, '
          f'external torque {100.0 * mean.external_held:.1f} %')
    print(f'  tip force, rms                mean {mean.force:.2f} N, worst recording '
          f'{max(row.force for row in rows):.2f} N')


if __name__ == '__main__':
    main()

"""
Measure a fleet of a thousand small recordings: time for each, and memory along the way.

Each is 12 s of one motor at 250 Hz, with friction of its own, of 50 devices. `hda diagnose --each`
goes over them. Memory is taken of the command itself and of all its processes together, what they
share once. Bar: after a tenth the command grows by 20 kB for each recording and 4 MB at most.
"""

from collections.abc import Iterator
import json
from pathlib import Path
import subprocess
import sys
import tempfile
import time
from typing import NamedTuple

from hda_msgs_json.bag import BagWriter
from hda_msgs_json.samples import JointSamples
from hda_msgs_json.topics import JOINT_STATES
import numpy as np
from size import parser, verdict

BAGS, TINY, DEVICES = 1000, 3, 50
RATE, SECONDS = 250.0, 12.0     # of a recording [Hz], [s]
MOST = 20e3             # growth of the command for each recording: its line, and room [bytes]
ROOM = 4e6              # more that it may take, as memory comes in pieces [bytes]
PAUSE = 0.5             # between two looks at the memory [s]
KIB = 1024


class Look(NamedTuple):
    """Recordings that were done at a moment, and memory then [bytes]."""

    done: int
    own: int
    together: int


def write(bag: Path, number: int) -> None:
    """Write a recording of a motor alone whose friction grows from one to the next."""
    random = np.random.default_rng(number)
    time = np.arange(round(SECONDS * RATE)) / RATE
    speed = 40.0 * np.sin(2.0 * np.pi * time / 4.0)
    torque = (0.05 + 1e-5 * number) * np.sign(speed) + 2e-3 * random.standard_normal(len(time))
    stamps = 1_700_000_000_000_000_000 + np.round(1e9 * time).astype(np.int64)
    unknown = np.full((len(time), 1), np.nan)
    with BagWriter(bag, {}) as written:
        written.write_joint_states(JOINT_STATES, JointSamples(
            stamps + number * 10**12, ('joint1_motor',), np.cumsum(speed)[:, None] / RATE,
            unknown, torque[:, None]))


def memory(process: int) -> int:
    """Return the memory of a process [bytes], 0 where it has ended."""
    try:
        reported = Path(f'/proc/{process}/smaps_rollup').read_text(encoding='utf-8')
    except OSError:
        return 0
    return int(reported.partition('Pss:')[2].split()[0]) * KIB


def family(process: int) -> Iterator[int]:
    """Yield a process and all that it has started."""
    yield process
    for children in Path(f'/proc/{process}/task').glob('*/children'):
        try:
            begun = children.read_text(encoding='utf-8').split()
        except OSError:
            continue
        for child in begun:
            yield from family(int(child))


def watched(folder: Path) -> tuple[list[Look], float]:
    """Go over a fleet, and return what its memory was, and how long it took [s]."""
    out, looks, began = folder / 'fleet', [], time.monotonic()
    with subprocess.Popen(
            [sys.executable, '-m', 'hda_torque_estimator.cli', 'diagnose', '--each', 'bags',
             '--arm', 'kinova_gen3.yaml', '--update', '--out', str(out)], cwd=folder,
            stdout=subprocess.DEVNULL) as command:
        while command.poll() is None:
            time.sleep(PAUSE)
            sizes = [memory(one) for one in family(command.pid)]
            looks.append(Look(len(list(out.glob('*/*/report.json'))), sizes[0], sum(sizes)))
    if command.returncode:
        raise SystemExit(f'hda diagnose --each ended with {command.returncode}')
    report = json.loads((out / 'fleet.json').read_text(encoding='utf-8'))
    print(f'{len(report["bags"])} recordings of {len(report["devices"])} devices: '
          f'{report["verdicts"]}; fleet.html {(out / "fleet.html").stat().st_size / 1e6:.2f} MB, '
          f'fleet.json {(out / "fleet.json").stat().st_size / 1e6:.2f} MB')
    return [look for look in looks if look.own], time.monotonic() - began


def main() -> int:
    """Print time and memory, and return whether the bar is kept."""
    arguments = parser(__doc__)
    arguments.add_argument('--bags', type=int, default=BAGS, help='recordings (%(default)s)')
    options = arguments.parse_args()
    bags = TINY if options.quick else options.bags
    with tempfile.TemporaryDirectory() as place:
        for number in range(bags):
            device = Path(place) / 'bags' / f'arm{number % DEVICES:02}'
            device.mkdir(parents=True, exist_ok=True)
            write(device / f'run{number // DEVICES:02}', number)
        looks, took = watched(Path(place))
    tenth = next((look for look in looks if look.done >= bags / 10), looks[-1])
    grown = looks[-1].own - tenth.own
    print(f'{took / bags:.2f} s for each; the command {tenth.own / 1e6:.0f} MB after a tenth, '
          f'{looks[-1].own / 1e6:.0f} MB at the end; '
          f'all its processes {max(look.together for look in looks) / 1e6:.0f} MB at most')
    return verdict('the command does not grow',
                   grown <= MOST * (looks[-1].done - tenth.done) + ROOM, quick=options.quick)


if __name__ == '__main__':
    sys.exit(main())

"""
Measure how fast a recording becomes arrays, beside the peers, and how fast it is estimated.

The recording has ten minutes of JointStates with four names at 1 kHz. The peers decode the same
bag message by message into the same arrays, in the same run. The estimates go from bag to bag; the
first time a process makes some, it loads compiled code as well.
"""

from argparse import Namespace
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
import sys
from tempfile import TemporaryDirectory
import time
import tracemalloc
from typing import Any

from hda_msgs_json.bag import BagWriter, open_recording
from hda_msgs_json.samples import JointSamples
from hda_msgs_json.topics import JOINT_STATES
from hda_torque_estimator.cli import parser_of
from hda_torque_estimator.commands import estimate_command
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
import numpy as np
from rosbags.highlevel import AnyReader
from size import parser, verdict

SECONDS, RATE, REPEATS = 600.0, 1000, 5
TINY = 3.0                          # of a tiny case [s]
FASTER, MEMORY, REAL_TIME = 50.0, 3.0, 300.0       # than a peer; of the arrays; than real time
NAMES = ('joint1', 'joint1_motor', 'joint2', 'joint2_motor')
MOTOR_STEP, LINK_STEP = 2.0 * np.pi / 16384, 2.0 * np.pi / 4e6     # of the encoders [rad]


def recording(seconds: float) -> JointSamples:
    """Return what the driver of a moving arm publishes, in steps of its encoders."""
    count = round(seconds * RATE)
    moments = np.arange(count) / RATE
    angles = np.stack([np.sin(0.7 * moments), 0.5 * np.sin(1.1 * moments)], axis=1)
    position = np.empty((count, len(NAMES)))
    position[:, ::2] = LINK_STEP * np.rint(angles / LINK_STEP)
    position[:, 1::2] = MOTOR_STEP * np.rint(100.0 * angles / MOTOR_STEP)
    velocity = np.diff(position, axis=0, append=position[-1:]) * RATE
    effort = np.full_like(position, np.nan)
    effort[:, 1::2] = 0.1 * np.sin(np.outer(moments, [1.0, 2.0]))
    stamps = 1_700_000_000_000_000_000 + (10 ** 9 // RATE) * np.arange(count)
    return JointSamples(stamps, NAMES, position, velocity, effort, 'base')


def of_rosbags(bag: Path) -> Iterator[Any]:
    """Yield the messages as rosbags decodes them."""
    with AnyReader([bag]) as reader:
        for connection, _, message in reader.messages():
            yield reader.deserialize(message, connection.msgtype)


def of_mcap(bag: Path) -> Iterator[Any]:
    """Yield the messages as mcap-ros2-support decodes them."""
    with next(bag.glob('*.mcap')).open('rb') as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        for _, _, _, message in reader.iter_decoded_messages():
            yield message


PEERS = {'rosbags': of_rosbags, 'mcap-ros2-support': of_mcap}


def gathered(read: Callable[[Path], Iterator[Any]], bag: Path) -> list[np.ndarray]:
    """Return the position, velocity and effort of a bag's messages as arrays."""
    rows = [(m.position, m.velocity, m.effort) for m in read(bag)]
    return [np.array(values) for values in zip(*rows)]


def timed(work: Callable[[], Any], repeats: int = 1) -> tuple[float, Any]:
    """Return the shortest time [s] of some runs, and what the last one gave."""
    times, found = [], None
    for _ in range(repeats):
        found = None
        began = time.perf_counter()
        found = work()
        times.append(time.perf_counter() - began)
    return min(times), found


def peak_of_arrays(bag: Path) -> float:
    """Return the most memory that reading takes, over the size of the arrays."""
    tracemalloc.start()
    samples = open_recording(bag).joint_states()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak / sum(array.nbytes for array in (
        samples.stamps, samples.position, samples.velocity, samples.effort))


def estimate_options(bag: Path, out: Path) -> Namespace:
    """Return what `hda estimate` takes from its command line."""
    return parser_of('estimate').parse_args(
        ['estimate', str(bag), '--arm', 'hda_arm.yaml', '--out', str(out)])


def faster(bag: Path, name: str, ours: float, wanted: np.ndarray) -> bool:
    """Print how long another reader takes [s]; return whether ours is as much faster as asked."""
    seconds, arrays = timed(partial(gathered, PEERS[name], bag))
    same = np.array_equal(arrays[0], wanted)
    print(f'{name:24}{seconds:>8.3f} s{seconds / ours:>10.1f} times as long, '
          f'{"the same numbers" if same else "OTHER NUMBERS"}')
    return same and seconds / ours >= FASTER


def estimated(folder: Path, length: float, repeats: int) -> float:
    """Print and return how long `hda estimate` takes over the bag of the folder [s]."""
    times = [timed(partial(estimate_command.execute, estimate_options(folder / 'bag', out)))[0]
             for out in (folder / f'estimates_{number}' for number in range(1 + repeats))]
    seconds = min(times[1:])
    for name, each in (('hda estimate, first', times[0]), ('hda estimate, again', seconds)):
        print(f'{name:24}{each:>8.3f} s{length / each:>10.0f} times real time')
    return seconds


def write(bag: Path, seconds: float) -> None:
    """Write a bag of joint states."""
    with BagWriter(bag, {}) as writer:
        writer.write_joint_states(JOINT_STATES, recording(seconds))


def main() -> int:
    """Measure everything and print a table."""
    quick = parser(__doc__).parse_args().quick
    length, repeats = (TINY, 1) if quick else (SECONDS, REPEATS)
    with TemporaryDirectory() as directory:
        bag = Path(directory) / 'bag'
        write(bag, length)
        ours, samples = timed(lambda: open_recording(bag).joint_states(), repeats)
        print(f'{length:g} s of four names at {RATE} Hz, zstd, to arrays')
        print(f'{"this project":24}{ours:>8.3f} s')
        reported = [faster(bag, name, ours, samples.position) for name in PEERS]
        memory = peak_of_arrays(bag)
        print(f'{"memory":24}{memory:>8.2f} times the arrays')
        seconds = estimated(Path(directory), length, repeats)
    kept = all(reported) and memory <= MEMORY and length / seconds >= REAL_TIME
    return verdict(f'at least {FASTER:g} times faster than either, {MEMORY:g} times the arrays at '
                   f'most, {REAL_TIME:g} times real time', kept, quick=quick)


if __name__ == '__main__':
    sys.exit(main())

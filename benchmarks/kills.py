"""
Kill recorders at random moments, repair what they leave, and count what is missing.

`kills.py [KILLS] [--quick]`, 200 unless given. Each recorder hears joint states at 500 Hz and
gets SIGKILL within two seconds, once it has learnt of who sends them. At most 0.1 s of messages
may be missing from any of the repaired bags, none from their midst, and `rosbags` must open
every one.
"""

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
import random
import subprocess
import sys
import tempfile
import time

from hda_arm_sim.ros.topics import publisher
from hda_msgs_json.bag import open_recording
from hda_msgs_json.bag_repair import repair
from hda_msgs_json.cdr import JointStateEncoder
from hda_msgs_json.topics import JOINT_STATES
from nodes import Listener, own_domain
import numpy as np
from rosbags.rosbag2 import Reader
from size import parser, verdict

RATE, TOGETHER, TINY = 500, 4, 2    # messages a second, recorders, kills of a tiny case
LATEST = 1.5            # moment of a kill after all recorders hear [s]
LEARNT = 0.5            # a reader learns of a writer later than the writer of it [s]
LIMIT = 0.1             # [s]
ENCODE = JointStateEncoder(('joint1', 'joint1_motor'), effort=False)
MODULE = 'hda_torque_estimator.recording.recorder_node'


def start(folder: Path, number: int) -> subprocess.Popen[bytes]:
    """Start a recorder that writes a bag of this number."""
    return subprocess.Popen(
        [sys.executable, '-m', MODULE, '--ros-args', '-r', f'__node:=recorder{number}',
         '-p', f'output:={folder}/bag{number}', '-p', 'topics:=[joint_states]'],
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def kill_some(folder: Path, numbers: range) -> list[tuple[Path, int, int]]:
    """Return the bags of killed recorders, with the first stamp and the last before the kill."""
    listener = Listener()       # a new one, which has not heard of those killed before
    send = publisher(listener.node, JOINT_STATES)
    running = {number: start(folder, number) for number in numbers}
    try:
        listener.until(lambda: send.get_subscription_count() == len(running), 'the recorders')
        return [(folder / f'bag{number}', first, last)
                for number, first, last in send_and_kill(send.publish, running)]
    finally:
        for process in running.values():
            process.kill()
            process.wait()
        listener.close()


def send_and_kill(
        send: Callable[[bytes], None],
        running: Mapping[int, subprocess.Popen[bytes]]) -> Iterator[tuple[int, int, int]]:
    """Yield the recorders as they are killed, with the first stamp and the last before that."""
    begin = time.monotonic()
    due = sorted((begin + LEARNT + random.uniform(0.0, LATEST), number) for number in running)
    sent, stamp = 0, time.time_ns()
    first = stamp
    while due:
        while due and time.monotonic() >= due[0][0]:
            number = due.pop(0)[1]
            running[number].kill()
            yield number, first, stamp
        stamp = time.time_ns()
        send(ENCODE(stamp, np.zeros(2), np.full(2, float(sent))))
        sent += 1
        time.sleep(max(begin + sent / RATE - time.monotonic(), 0.0))


def missing(bag: Path, first: int, last: int) -> tuple[float, int]:
    """Return the time [s] that lacks at the end of a killed bag, and messages in its midst."""
    whole = bag.with_name(f'{bag.name}_repaired')
    repair(bag, whole)
    with Reader(whole) as reader:
        opened = sum(1 for _ in reader.messages())
    recording = open_recording(whole)
    if not opened:
        return (last - first) * 1e-9, 0
    samples = recording.joint_states()
    lost = int((np.diff(samples.velocity[:, 0]) != 1.0).sum())
    return max(last - int(samples.stamps[-1]), 0) * 1e-9, lost


def main() -> int:
    """Kill, repair, count; return 1 if too much is missing."""
    known = parser(__doc__)
    known.add_argument('kills', nargs='?', type=int, default=200)
    asked = known.parse_args()
    kills = TINY if asked.quick else asked.kills
    random.seed(1)
    ends: list[float] = []
    gaps = 0
    with own_domain(), tempfile.TemporaryDirectory() as folder:
        for first in range(0, kills, TOGETHER):
            numbers = range(first, min(first + TOGETHER, kills))
            for bag, first_stamp, last in kill_some(Path(folder), numbers):
                end, lost = missing(bag, first_stamp, last)
                ends.append(end)
                gaps += lost
    kept = gaps == 0 and all(end <= LIMIT for end in ends)
    return verdict(f'{len(ends)} kills: missing at the end {np.median(ends):.3f} s in the median, '
                   f'{max(ends):.3f} s at most (limit {LIMIT:g} s), {gaps} gaps before; all bags '
                   'open', kept, quick=asked.quick)


if __name__ == '__main__':
    sys.exit(main())

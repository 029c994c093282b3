"""
Record what the arm and the estimator publish at 1 kHz, and see whether the recorder grows.

`recorder_slope.py [MINUTES] [--quick]`, ten unless given. Six topics at 1 kHz each go to one
recorder that never splits its bag. A line through its resident memory after the first minute
may rise by 1 MB an hour at most, and no message may be missing. With `--quick` it runs for
seconds, which show nothing of the slope: only the messages are judged.

In the first minute the recorder is held until its queues overflow: the pools of DDS grow with
the fullest moment and never shrink. Messages count from the end of that minute on.
"""

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path
import resource
import signal
import sys
import tempfile
import time
from typing import NamedTuple

from hda_arm_sim.ros.topics import publisher
from hda_msgs_json.bag import open_recording
from hda_msgs_json.cdr import JointStateEncoder, WrenchEncoder
from hda_msgs_json.topics import (
    BASE_FRAME, JOINT_STATE, JOINT_STATES, joint_torque, JOINT_TORQUES, motor_name, TIP_WRENCH,
    TIP_WRENCH_TOOL, Topic, WRENCH_STAMPED)
from nodes import Listener, nodes, own_domain
import numpy as np

RATE = 1000             # [Hz]
WARM_UP = 60.0          # at first a process loads code and fills its pools [s]
HELD = range(5 * RATE, 12 * RATE)       # samples for which queues of 5000 wait
QUICK = 3.0             # [s]
LIMIT = 1.0             # [MB/h]
MODULE = 'hda_torque_estimator.recording.recorder_node'
LABELS = ('joint1', 'joint2')
Encode = Callable[[int, float], bytes]


class Outcome(NamedTuple):
    """Memory of the recorder (n, 2): time [s] and size [MB]; messages sent and found."""

    memory: Sequence[tuple[float, float]]
    sent: int
    found: int


def memory(process_id: int) -> float:
    """Return the resident memory of a process [MB]."""
    pages = int(Path(f'/proc/{process_id}/statm').read_text().split()[1])
    return pages * resource.getpagesize() / 1e6


def encoders() -> dict[Topic, Encode]:
    """Return what makes the bytes of a numbered message, for each topic."""
    joints = JointStateEncoder((*LABELS, *map(motor_name, LABELS)))
    torques, wrench = JointStateEncoder(LABELS), WrenchEncoder(BASE_FRAME)

    def of_joints(encode: JointStateEncoder, count: int) -> Encode:
        return lambda stamp, value: encode(stamp, *[[value] * count] * 3)

    return {JOINT_STATES: of_joints(joints, 4), JOINT_TORQUES: of_joints(torques, 2), **{
        topic: lambda stamp, value: wrench(stamp, [value] * 3, [value] * 3)
        for topic in (*map(joint_torque, LABELS), TIP_WRENCH, TIP_WRENCH_TOOL)}}


def record(bag: Path, count: int) -> Outcome:
    """Send so many numbered samples on an absolute schedule, and look at the recorder."""
    listener, sizes = Listener(), []
    with nodes((MODULE, f'output:={bag}')) as (recorder,):
        ways = [(publisher(listener.node, topic), encode) for topic, encode in encoders().items()]
        listener.until(lambda: all(way.get_subscription_count() for way, _ in ways),
                       'the recorder')
        listener.spin(1.0)
        begin = time.monotonic()
        for number in range(count):
            time.sleep(max(begin + number / RATE - time.monotonic(), 0.0))
            if number in (HELD.start, HELD.stop):
                recorder.send_signal(signal.SIGSTOP if number in HELD else signal.SIGCONT)
            for way, encode in ways:
                way.publish(encode(stamp_of(number), number * 1e-3))
            if number % RATE == 0:
                sizes.append((time.monotonic() - begin, memory(recorder.pid)))
        listener.spin(1.0)
        recorder.send_signal(signal.SIGINT)
        recorder.wait()
    listener.close()
    first = 0 if count < HELD.stop else round(WARM_UP * RATE)
    return Outcome(sizes, (count - first) * len(ways), recorded(bag, list(encoders()), first))


def recorded(bag: Path, topics: Sequence[Topic], first: int) -> int:
    """Return how many messages from sample `first` on a bag holds."""
    recording, begin = open_recording(bag), stamp_of(first)
    read = {JOINT_STATE: recording.joint_states, WRENCH_STAMPED: recording.wrenches}
    return sum(int(np.count_nonzero(read[topic.message_type](topic.name).stamps >= begin))
               for topic in topics)


def stamp_of(number: int) -> int:
    """Return the stamp of a sample [ns]."""
    return 10**9 + number * 10**9 // RATE


def main() -> int:
    """Measure, print one line, and return 1 if the recorder grows or misses something."""
    parser = argparse.ArgumentParser(description='Does the recorder grow?')
    parser.add_argument('minutes', type=float, nargs='?', default=10.0)
    parser.add_argument('--quick', action='store_true', help='a few seconds, no slope')
    options = parser.parse_args()
    seconds = QUICK if options.quick else options.minutes * 60.0 + WARM_UP
    with own_domain(), tempfile.TemporaryDirectory() as folder:
        sizes, sent, found = record(Path(folder) / 'bag', round(seconds * RATE))
    kept = found == sent
    said = f'{sent} messages on 6 topics in {sizes[-1][0]:.0f} s, {sent - found} missing'
    if not options.quick:
        late = np.array([each for each in sizes if each[0] >= WARM_UP])
        slope = np.polyfit(late[:, 0], late[:, 1], 1)[0] * 3600.0
        kept = kept and slope <= LIMIT
        said += (f'; memory {late[0, 1]:.1f} to {late[-1, 1]:.1f} MB, slope {slope:.2f} MB/h, at '
                 f'most {LIMIT:g}')
    print(f'recorder: {said}: {"well" if kept else "NOT WELL"}')
    return 0 if kept else 1


if __name__ == '__main__':
    sys.exit(main())

"""
Record joint states at 2 kHz for a minute, and count what is missing and what it costs.

`bench_recorder.py [SECONDS] [--quick]`, 60 unless given. No message may be missing, all
must be in order, and the recorder may take a third of a core.
"""

from collections.abc import Callable
import os
from pathlib import Path
import signal
import sys
import tempfile
import time

from hda_arm_sim.ros.topics import publisher
from hda_msgs_json.bag import open_recording
from hda_msgs_json.cdr import JointStateEncoder
from hda_msgs_json.topics import JOINT_STATES
from nodes import Listener, nodes, own_domain
import numpy as np
from size import parser, verdict

RATE = 2000
TINY = 1                # time of a tiny case [s]
NAMES = ('joint1', 'joint2', 'joint1_motor', 'joint2_motor')
LIMIT = 1.0 / 3.0       # of a core
MODULE = 'hda_torque_estimator.recording.recorder_node'


def cpu(pid: int) -> float:
    """Return the processor time that a process has taken [s]."""
    fields = Path(f'/proc/{pid}/stat').read_text().rpartition(')')[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')


def stream(send: Callable[[bytes], None], count: int) -> None:
    """Send numbered samples on an absolute schedule."""
    encode, numbers = JointStateEncoder(NAMES, effort=False), np.zeros(len(NAMES))
    begin = time.monotonic()
    for number in range(count):
        time.sleep(max(begin + number / RATE - time.monotonic(), 0.0))
        numbers[:] = number
        send(encode(10**9 + number * 10**9 // RATE, numbers, numbers))


def measure(bag: Path, count: int) -> tuple[float, float]:
    """Record so many samples; returns the time that took, and processor time of the recorder."""
    listener = Listener()
    with nodes((MODULE, f'output:={bag}', 'topics:=[joint_states]')) as (recorder,):
        send = publisher(listener.node, JOINT_STATES)
        listener.until(lambda: send.get_subscription_count() == 1, 'the recorder')
        listener.spin(1.0)
        before, began = cpu(recorder.pid), time.monotonic()
        stream(send.publish, count)
        used, lasted = cpu(recorder.pid) - before, time.monotonic() - began
        listener.spin(0.5)
        recorder.send_signal(signal.SIGINT)
        recorder.wait()
    listener.close()
    return lasted, used


def main() -> int:
    """Measure, and print one line."""
    known = parser(__doc__)
    known.add_argument('seconds', nargs='?', type=int, default=60)
    asked = known.parse_args()
    count = RATE * (TINY if asked.quick else asked.seconds)
    with own_domain(), tempfile.TemporaryDirectory() as folder:
        bag = Path(folder) / 'bag'
        lasted, used = measure(bag, count)
        found = open_recording(bag).joint_states().position[:, 0]
    missing, share = count - len(found), used / lasted
    kept = missing == 0 and np.array_equal(found, np.arange(count)) and share < LIMIT
    return verdict(f'{count} joint states in {lasted:.1f} s, {missing} missing; {share:.3f} of a '
                   f'core, at most {LIMIT:.3f}; all in order and in time', kept,
                   quick=asked.quick)


if __name__ == '__main__':
    sys.exit(main())

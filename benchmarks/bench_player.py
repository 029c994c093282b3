"""
Measure how far the spacing of played messages is from the recorded one, beside a bare loop.

A bag of joint states at 1 kHz is played at rate 1, and the loop publishes the same messages when
they are due. A process of its own hears both. At the 99th percentile the player's error must stay
under 1 ms; on a busy machine that of the loop shows how much of it is the machine's.
"""

from collections.abc import Callable
import json
from pathlib import Path
import subprocess
import sys
import tempfile
import time

from hda_arm_sim.health import Level, Report
from hda_arm_sim.ros.arm_node import ReportingNode
from hda_arm_sim.ros.process import run
from hda_arm_sim.ros.topics import publisher, subscribe
from hda_msgs_json.bag import BagWriter, open_recording
from hda_msgs_json.cdr import STAMP
from hda_msgs_json.cdr_layout import STAMP_AT
from hda_msgs_json.samples import JointSamples
from hda_msgs_json.topics import JOINT_STATES
from nodes import Listener, own_domain, process
import numpy as np
from size import parser, verdict

NAMES = ('joint1', 'joint2', 'joint1_motor', 'joint2_motor')
SECONDS, TINY, RATE, START = 20, 2, 1000, 10**9
LIMIT = 1000.0          # of the player at the 99th percentile [us]
MODULE = 'hda_torque_estimator.playing.player_node'


class Ear(ReportingNode):
    """Take down when messages come, and what their stamps say."""

    def __init__(self) -> None:
        """Listen."""
        super().__init__('ear')
        self._heard: list[tuple[int, bytes]] = []
        subscribe(self, JOINT_STATES, self._hear, depth=5000)

    def _hear(self, message: bytes) -> None:
        self._heard.append((time.monotonic_ns(), message))

    def report(self) -> Report:
        """Say nothing."""
        return Report(Level.OK, '', {})

    def close(self) -> None:
        """Return how many came, and median, 99th percentile and largest error of spacing [us]."""
        stamps = [STAMP.unpack_from(message, STAMP_AT) for _, message in self._heard]
        should = np.diff([seconds * 10**9 + rest for seconds, rest in stamps])
        errors = np.abs(np.diff([came for came, _ in self._heard]) - should) * 1e-3
        sys.stdout.write(json.dumps({
            'count': len(self._heard), 'errors': np.percentile(errors, [50, 99, 100]).tolist()}))


def samples(seconds: int) -> JointSamples:
    """Return joint states at an even rate."""
    numbers = np.random.default_rng(0).normal(size=(3, seconds * RATE, len(NAMES)))
    return JointSamples(START + np.arange(seconds * RATE) * (10**9 // RATE), NAMES, *numbers)


def loop(messages: list[bytes]) -> None:
    """Publish messages when they are due."""
    listener = Listener()
    send = publisher(listener.node, JOINT_STATES)
    listener.until(lambda: send.get_subscription_count() == 1, 'the ear')
    listener.spin(1.0)
    begin = time.monotonic()
    for number, message in enumerate(messages):
        time.sleep(max(begin + number / RATE - time.monotonic(), 0.0))
        send.publish(message)
    listener.spin(0.5)
    listener.close()


def heard(play: Callable[[], object]) -> dict[str, object]:
    """Return what was heard of what is played."""
    with process(__file__, 'ear') as ear:
        play()
    return json.loads(ear.communicate()[0])


def main() -> int:
    """Measure both and print a table."""
    quick = parser(__doc__).parse_args().quick
    seconds = TINY if quick else SECONDS
    with own_domain(), tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / 'bag'
        with BagWriter(path, {}) as bag:
            bag.write_joint_states(JOINT_STATES, samples(seconds))
        messages = open_recording(path).raw('joint_states')[1]
        bare = heard(lambda: loop(messages))
        player = heard(lambda: subprocess.run(
            [sys.executable, '-m', MODULE, '--ros-args', '--log-level', 'warn', '-p',
             f'bag:={path}'], check=True))
    print(f'{"spacing error [us]":20}{"p50":>10}{"p99":>10}{"max":>10}{"messages":>10}')
    for name, row in (('bare loop', bare), ('bag_player', player)):
        print(f'{name:20}' + ''.join(f'{error:10.1f}' for error in row['errors'])
              + f'{row["count"]:>10}')
    kept = player['count'] == seconds * RATE and player['errors'][1] < LIMIT
    return verdict(f'{seconds} s at {RATE} Hz; all messages, and under {LIMIT:g} us at p99', kept,
                   quick=quick)


if __name__ == '__main__':
    if 'ear' in sys.argv:
        sys.exit(run(sys.argv[1], lambda: [Ear()], sys.argv[:1]))
    sys.exit(main())

"""
Measure a joint state in, all wrenches out: the estimator node beside a bare echo.

Each runs in a process of its own, gets the same 1 kHz stream and sends as many bytes on the same
topics to a third process; the echo estimates nothing. What the estimator does itself, from the
bytes of a sample to the bytes of its answers, is to take at most 100 us.
"""

from collections.abc import Callable, Mapping
import json
import resource
import sys
import time
from typing import Any

from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import HOME
from hda_arm_sim.ros.arm_node import ArmNode
from hda_arm_sim.ros.process import run
from hda_arm_sim.ros.topics import publisher, subscribe
from hda_msgs_json.cdr import encode_joint_state, JointStateEncoder
from hda_msgs_json.topics import ESTIMATOR_STATE, JOINT_STATES
from hda_torque_estimator.estimating.estimate_messages import estimate_topics
from hda_torque_estimator.estimating.estimator_node import TorqueEstimator
from hda_torque_estimator.estimating.live_estimator import LiveEstimator, SampleAnswer
from hda_torque_estimator.samples.readings import reading_names
from nodes import Listener, own_domain, process
import numpy as np
from size import parser, verdict

LIMIT = 100.0           # [us]
RATE, SECONDS, SKIPPED = 1000, 15, 1000
TINY = 1, 100           # seconds and samples skipped of a tiny case
ARM = read_arm('hda_arm.yaml')
NAMES = reading_names(ARM.labels)
ANGLES = np.array([100.0 * HOME[0], HOME[0], 100.0 * HOME[1], HOME[1]])
MICROSECONDS = 1e6


class Timed(LiveEstimator):
    """The estimator with a stopwatch."""

    def __init__(self) -> None:
        """Begin without any time."""
        super().__init__(ARM)
        self.times: list[float] = []

    def __call__(self, message: bytes) -> SampleAnswer:
        """Answer one sample."""
        began = time.perf_counter()
        answer = super().__call__(message)
        self.times.append(time.perf_counter() - began)
        return answer


class Echo(Timed):
    """Every sample gets the same answer."""

    def __init__(self) -> None:
        """Make the answer."""
        super().__init__()
        self._always = super().__call__(encode_joint_state(1, '', NAMES, ANGLES))

    def __call__(self, message: bytes) -> SampleAnswer:
        """Give the answer."""
        self.times.append(0.0)
        return self._always._replace(state=None)


class Measured(TorqueEstimator):
    """The node with another way to answer, and a stopwatch around its callback."""

    def __init__(self, answer: Timed, skipped: int) -> None:
        """Answer as this does; so many samples at the start do not count."""
        super().__init__()
        self._answer, self._callbacks, self._cpu, self._skipped = answer, [], 0.0, skipped

    def _on_sample(self, *heard: Any) -> None:
        began = time.perf_counter()
        super()._on_sample(*heard)
        self._callbacks.append(time.perf_counter() - began)
        if len(self._callbacks) == self._skipped:
            self._cpu = cpu()

    def close(self) -> None:
        """Return median and ninth decile of work and callback, and CPU time per sample, in us."""
        samples = len(self._callbacks) - self._skipped
        sys.stdout.write(json.dumps({
            'samples': samples, 'cpu': (cpu() - self._cpu) / samples * MICROSECONDS,
            'work': deciles(self._answer.times[-samples:]),
            'callback': deciles(self._callbacks[-samples:])}))


class Sink(ArmNode):
    """Hear everything that the estimator says."""

    def __init__(self) -> None:
        """Subscribe."""
        super().__init__('sink')
        for topic in (*estimate_topics(ARM), ESTIMATOR_STATE):
            subscribe(self, topic, len)


def cpu() -> float:
    """Return the processor time of this process [s]."""
    used = resource.getrusage(resource.RUSAGE_SELF)
    return used.ru_utime + used.ru_stime


def deciles(times: list[float]) -> list[float]:
    """Return median and ninth decile [us]."""
    return (np.percentile(times, [50, 90]) * MICROSECONDS).tolist()


def measure(kind: str, seconds: int, skipped: int) -> dict[str, Any]:
    """Return what a kind of node reports after a stream of samples."""
    listener = Listener()
    with process(__file__, 'sink'), process(__file__, kind, str(skipped)) as measured:
        send = publisher(listener.node, JOINT_STATES)
        topics = [topic.name for topic in estimate_topics(ARM)]
        listener.until(lambda: send.get_subscription_count() == 1 and all(
            listener.node.count_subscribers(name) == 1 for name in topics), 'the nodes')
        listener.spin(1.0)
        stream(send.publish, RATE * seconds)
    listener.close()
    said, _ = measured.communicate()
    return json.loads(said)


def stream(send: Callable[[bytes], None], count: int) -> None:
    """Send samples of an arm that moves a little, on an absolute schedule."""
    encode = JointStateEncoder(NAMES, effort=False)
    begin = time.monotonic()
    offsets = 1e-3 * np.sin(np.arange(count) / RATE)
    for k, offset in enumerate(offsets):
        send(encode(10**9 + k * 10**9 // RATE, ANGLES + offset, np.zeros(len(ANGLES))))
        time.sleep(max(begin + (k + 1) / RATE - time.monotonic(), 0.0))


def main() -> int:
    """Measure both and print a table."""
    quick = parser(__doc__).parse_args().quick
    size = TINY if quick else (SECONDS, SKIPPED)
    with own_domain():
        echo, estimator = measure('echo', *size), measure('estimator', *size)
    report(echo, estimator)
    return verdict(f'{estimator["samples"]} samples; own work {estimator["work"][0]:.1f} us, at '
                   f'most {LIMIT:g} us', estimator['work'][0] <= LIMIT, quick=quick)


def report(echo: Mapping[str, Any], estimator: Mapping[str, Any]) -> None:
    """Print a table of both."""
    print(f'{"us per sample":24}{"bare echo":>22}{"estimator":>22}{"ratio":>8}')
    for name, key in (('own work', 'work'), ('whole callback', 'callback')):
        bare, full = echo[key], estimator[key]
        ratio = f'{full[0] / bare[0]:.2f}' if bare[0] else ''
        print(f'{name + ", p50 / p90":24}{bare[0]:>13.1f} / {bare[1]:6.1f}'
              f'{full[0]:>13.1f} / {full[1]:6.1f}{ratio:>8}')
    print(f'{"processor time":24}{echo["cpu"]:>22.1f}{estimator["cpu"]:>22.1f}'
          f'{estimator["cpu"] / echo["cpu"]:>8.2f}')


CHILDREN = {'sink': Sink, 'echo': lambda: Measured(Echo(), int(sys.argv[2])),
            'estimator': lambda: Measured(Timed(), int(sys.argv[2]))}

if __name__ == '__main__':
    if sys.argv[1:] and sys.argv[1] in CHILDREN:
        sys.exit(run(sys.argv[1], lambda: [CHILDREN[sys.argv[1]]()], sys.argv[:1]))
    sys.exit(main())

"""
Send hostile streams to the controller, and count commands that break a limit: there must be none.

`controller_faults.py [--quick]`. In one process every stream meets a simulated arm, without and
with torque feedback, and random mixtures of them follow; a command that is not finite, beyond the
torque limit, faster than the rate limit, or not zero at a stop is a violation. Then the
controller runs as a node: how long after each of 200 bad samples comes zero torque?
"""

import argparse
from collections.abc import Callable, Iterator
from contextlib import suppress
import os
import random
import sys
import tempfile
import time
from typing import NamedTuple

from hda_arm_sim.health import Refused
from hda_arm_sim.live import LiveArm, SimulationSettings
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.ros.topics import publisher, subscribe
from hda_msgs_json.cdr import decode_joint_state, encode_joint_state
from hda_msgs_json.topics import JOINT_STATES, MOTOR_COMMAND
from hda_torque_estimator.controlling.controller import ControllerSettings
from hda_torque_estimator.controlling.live_controller import LiveController
from hostile_streams import BEGIN, mixture, Moment, STREAMS
from nodes import Listener, own_domain, process
import numpy as np
import rclpy
from std_srvs.srv import SetBool

ARM = read_arm('hda_arm.yaml')
LIMITS = np.array([joint.torque_limit for joint in ARM.joints])
PERIOD = 1e-3
STEPS, MIXTURES, STOPS = 1000, 100, 200
FRESH = 10_000_000      # age of the last answer when a bad sample is sent [ns]
GAP = 12_000_000        # between stamps at which the controller stops by itself [ns]
FEWEST = 100            # answers before a bad sample; fewer are leftovers of the last one
LONGEST = 5.0           # until a stop must have been heard [s]
MODULE = 'hda_torque_estimator.controlling.controller_node'


class Monitor:
    """Count what commands break."""

    def __init__(self, live: LiveController) -> None:
        """Watch the commands of a controller."""
        self.violations: list[str] = []
        self.effort = np.zeros_like(LIMITS)
        self._live, self._stamp = live, 0

    def take(self, command: bytes | None) -> None:
        """Judge a command."""
        if command is None:
            return
        state = decode_joint_state(command)
        effort, dt = np.array(state.effort), (state.stamp_ns - self._stamp) * 1e-9
        change = np.abs(effort - self.effort).max()
        fastest = self._live.controller.settings.rate_limit * dt + 1e-9
        self.violations += [f'{wrong}: {effort}' for wrong, found in (
            ('not finite', not np.isfinite(effort).all()),
            ('beyond the limit', (np.abs(effort) > LIMITS + 1e-12).any()),
            ('not zero at a stop', not self._live.enabled and effort.any()),
            (f'too fast, {change} N*m in {dt} s',
             self._live.enabled and self._stamp and change > fastest)) if found]
        self.effort, self._stamp = effort, state.stamp_ns


class Outcome(NamedTuple):
    """What came of a stream."""

    violations: list[str]
    stopped_after: int | None       # the first bad sample [samples]


def run(stream: Callable[[Moment], list[bytes]], feedback: float, seed: int,
        steps: int) -> Outcome:
    """Close the loop over a simulated arm while a stream comes instead of its samples."""
    arm = LiveArm(ARM, SimulationSettings(), 1_000_000_000)
    live = LiveController(ARM, ControllerSettings(torque_feedback=feedback), enabled=True)
    monitor, chance, stopped = Monitor(live), random.Random(seed), None
    for k in range(steps):
        sample = arm.sample()
        torque = encode_joint_state(sample.stamp, '', ARM.labels, [], [], sample.joint_torque)
        messages = stream(Moment(k, sample.stamp, sample.reading, chance))
        for take, each in [(live.sample, each) for each in messages] + [(live.torque, torque)]:
            with suppress(Refused):
                monitor.take(take(each, k * PERIOD))
        monitor.take(live.watch(k * PERIOD))
        if live.stopped and stopped is None:
            stopped = k - BEGIN
        if np.isfinite(monitor.effort).all():
            arm.command(sample.stamp, monitor.effort)
        arm.advance()
    return Outcome(monitor.violations, stopped)


def in_process(quick: bool) -> int:
    """Run all streams, print what came of them, and return the number of violations."""
    names = sorted(STREAMS)[:4] if quick else sorted(STREAMS)
    wrong = 0
    for name in names:
        for feedback in (0.0, -1.0):
            made = run(STREAMS[name], feedback, 0, BEGIN + 60 if quick else STEPS)
            wrong += len(made.violations)
            stop = 'goes on' if made.stopped_after is None else f'stops +{made.stopped_after}'
            print(f'{name:32} K_J {feedback:4g}  {stop:12} {"; ".join(made.violations[:2])}')
    mixtures = 2 if quick else MIXTURES
    for seed in range(mixtures):
        made = run(mixture(seed), random.Random(seed).choice((0.0, -1.0)), seed, BEGIN + 60)
        wrong += len(made.violations)
        if made.violations:
            print(f'mixture {seed}: {made.violations[:2]}')
    print(f'streams {2 * len(names) + mixtures}, violations of torque, rate, angle, NaN: {wrong}')
    return wrong


class Loop(Listener):
    """A node that sends samples at 1 kHz and hears commands."""

    def __init__(self) -> None:
        """Join the domain."""
        super().__init__()
        self.heard: list[tuple[float, bytes]] = []
        self.send = publisher(self.node, JOINT_STATES)
        subscribe(self.node, MOTOR_COMMAND,
                  lambda message: self.heard.append((time.monotonic(), message)), depth=5000)
        self._enable = self.node.create_client(SetBool, 'jtf_controller/enable')

    def play(self, stream: Callable[[Moment], list[bytes]], begin: int, steps: int,
             chance: random.Random) -> tuple[float, int]:
        """
        Send samples of a resting arm, from `begin` on a stream.

        Returns when that began [s], and the stamp of the last sample before it [ns].
        """
        arm, began, due = LiveArm(ARM, SimulationSettings(), time.time_ns()), 0.0, time.monotonic()
        last = 0
        for k in range(steps):
            sample, kind = arm.sample(), STREAMS['clean']
            if k == begin:
                began, last = time.monotonic(), sample.stamp - SimulationSettings().period
            if k >= begin:
                kind = stream
            for message in kind(Moment(BEGIN + k - begin, sample.stamp, sample.reading, chance)):
                self.send.publish(message)
            if k == 50:
                self._enable.call_async(SetBool.Request(data=True))
            arm.advance()
            due += PERIOD
            rclpy.spin_once(self.node, timeout_sec=0.0)
            while (left := due - time.monotonic()) > 0.0:
                rclpy.spin_once(self.node, timeout_sec=left)
        return began, last

    def times(self, stops: int) -> Iterator[float | None]:
        """Yield the time from each first bad sample to zero torque [s], None if none came."""
        chance, bad = random.Random(0), [name for name, stream in STREAMS.items() if stream.stops]
        for _ in range(stops):
            self.heard.clear()
            began, last = self.play(STREAMS[chance.choice(bad)], 300, 400, chance)
            end = time.monotonic() + LONGEST
            while not self.stopped() and self.heard and time.monotonic() < end:
                self.spin(0.05)
            answered = self.stopped() or last
            if len(self.heard) >= FEWEST and last - answered < FRESH:   # else it did not run
                yield self.heard[-1][0] - began if self.stopped() else None

    def stopped(self) -> int:
        """
        Return the stamp at which the motors were let go, 0 if they were not [ns].

        The last command repeats a stamp, or comes behind a gap in which samples were lost.
        """
        ends = [decode_joint_state(each) for _, each in self.heard[-2:]]
        if len(ends) < 2 or np.any(ends[1].effort):
            return 0
        return ends[1].stamp_ns if not 0 < ends[1].stamp_ns - ends[0].stamp_ns <= GAP else 0


def over_dds(quick: bool) -> int:
    """Measure the time to stop of the node; returns how often it did not stop."""
    with own_domain(), process('-m', MODULE, '--ros-args', '--log-level', 'fatal'):
        loop = Loop()
        loop.until(lambda: loop.send.get_subscription_count() > 0, 'the controller')
        loop.spin(1.0)
        times = list(loop.times(2 if quick else STOPS))
        loop.close()
    known = [each * 1e3 for each in times if each is not None]
    print(f'{len(times)} bad samples over DDS, {len(times) - len(known)} without a stop; time to '
          f'zero torque: worst {max(known, default=0.0):.1f} ms, median '
          f'{np.median(known) if known else 0.0:.1f} ms (load of this machine '
          f'{os.getloadavg()[0]:.1f})')
    return len(times) - len(known)


def main() -> int:
    """Run both parts; returns 1 where a limit was broken or a stop did not come."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--quick', action='store_true', help='a few streams and stops only')
    quick = parser.parse_args().quick
    with tempfile.TemporaryDirectory() as folder:
        os.environ.setdefault('ROS_LOG_DIR', folder)
        wrong = in_process(quick)
        return 1 if wrong + over_dds(quick) else 0


if __name__ == '__main__':
    sys.exit(main())

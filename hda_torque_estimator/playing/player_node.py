"""The `bag_player` executable: a recording onto its topics again, in time, with /clock."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from itertools import takewhile
import sys
from threading import Thread
import time
from typing import Any, ClassVar

from hda_arm_sim.foundation.parameter import ParameterError
from hda_arm_sim.health import Level, Report
from hda_arm_sim.ros.arm_node import ReportingNode
from hda_arm_sim.ros.offered_quality import strongest
from hda_arm_sim.ros.process import run
from hda_arm_sim.ros.topics import message_class, publisher
from hda_msgs_json.bag import BagError, Message, open_recording
from hda_msgs_json.cdr_fields import LITTLE_ENDIAN, pack_stamp
from hda_msgs_json.topics import CLOCK, Topic
from hda_msgs_json.worker_threads import drawn_ahead
from rclpy.duration import Duration
from rclpy.exceptions import InvalidTopicNameException
from rclpy.publisher import Publisher
from std_srvs.srv import Trigger

from .audience import Audience
from .playback import Outlets, Playback
from .player_settings import PlaySettings, RateSettings
from ..recording.topic_choice import chosen
from ..samples.sample_reader import seconds

PAGE = 64                   # messages that are read in one go: little, not to hold others up
TAKE_TURNS = 1e-4           # between threads; the usual 5 ms would be seen in the spacing [s]
LOOK = 0.02                 # between two looks at who has subscribed [s]
PATIENCE = 2.0              # at the end, with who does not acknowledge what was sent [s]
LATEST_CLOCK = 1 << 61      # the seconds of /clock have 31 bits [ns]


class BagPlayer(ReportingNode):
    """Publish the bytes of a recording in the order and at the pace of their log times."""

    PURPOSE = 'Play a recording onto its topics again, in time, with /clock.'
    OPTIONS: ClassVar[Mapping[str, tuple[Any, str]]] = {
        'bag': ('', 'directory of a bag, or an .mcap file'),
        'topics': ([''], 'names or patterns of topics to play, all without any'),
        'exclude': ([''], 'names or patterns of topics not to play'),
        'wait_for': ([''], 'topics that must have a subscriber, any without one'),
        'loop': (False, 'begin again at the end'),
        'paused': (False, 'pause before the first message')}
    GROUPS = (PlaySettings, RateSettings)

    def __init__(self) -> None:
        """Open the bag; raises what a wrong parameter or file raises."""
        super().__init__('bag_player')
        path = self.parameters.text('bag', *self.OPTIONS['bag'])
        wanted, unwanted, needed = map(self.names, ('topics', 'exclude', 'wait_for'))
        self._settings = self.parameters.group(PlaySettings)
        loop = self.parameters.flag('loop', *self.OPTIONS['loop'])
        paused = self.parameters.flag('paused', *self.OPTIONS['paused'])
        rate = self.parameters.group(RateSettings, self._change_rate).rate
        if not path:
            raise ParameterError('bag must name a recording, got nothing')
        self.hardware = path
        self._recording = open_recording(path)
        for warning in self._recording.warnings:
            self.get_logger().warning(warning)
        self._played = self._advertise(chosen(self._recording.topics, wanted, unwanted))
        self._audience = Audience(chosen(self._played, needed) if needed else (),
                                  self._settings.settle_time)
        self._begin, self._end = self._span()
        self._playback = Playback(self._read, self._outlets(), rate=rate, paused=paused, loop=loop)
        if self._playback.empty:
            raise BagError(
                self.failure or f'{path}: there is no message in what should be played')
        for name, act in (('pause', self._pause), ('resume', self._resume),
                          ('step', self._step)):
            self.serve(Trigger, name, _answering(act))
        self.begin()
        self.get_logger().info(f'started: plays {len(self._played)} topics of {path}, waits for '
                               f'a subscriber of {", ".join(needed) or "any"}')
        self._closed = False
        self._thread = Thread(target=self._play)
        self._thread.start()

    def _advertise(self, names: Sequence[str]) -> dict[str, Publisher]:
        """Return a publisher for every topic that ROS knows the type of."""
        made = {}
        for name in names:
            kind = self._recording.topics[name].message_type
            if name == CLOCK.name and self._settings.clock_rate:
                continue                                # there is one time only
            try:
                made[name] = self.create_publisher(
                    message_class(Topic(name, kind, 1)), name,
                    strongest(self._recording.qualities(name)))
            except (ImportError, AttributeError, ValueError, InvalidTopicNameException):
                self.get_logger().warning(
                    f'{name} is not played: ROS has no such name, or no type {kind} here')
        return made

    def _outlets(self) -> Outlets[Message]:
        if not self._settings.clock_rate:
            return Outlets(self._hand_over, lambda _: None, round(1e9))
        clock = publisher(self, CLOCK)
        return Outlets(self._hand_over, partial(_publish_time, clock),
                       round(1e9 / self._settings.clock_rate))

    def _span(self) -> tuple[int, int]:
        """Return the first and the last log time to play [ns]."""
        filled = [self._recording.topics[name] for name in self._played
                  if self._recording.topics[name].count]
        begin = min((topic.first for topic in filled), default=0)
        begin += round(self._settings.start_offset * 1e9)
        return begin, begin + round(self._settings.duration * 1e9)

    def _read(self) -> Iterator[Message]:
        """Yield what is to be played; a broken message is the end of it."""
        messages = takewhile(lambda message: message.log_time <= self._end,
                             self._recording.messages(self._played, self._begin))
        try:
            yield from drawn_ahead(messages, PAGE)
        except BagError as error:
            self.failure = str(error)

    def _hand_over(self, message: Message) -> None:
        self._played[message.topic].publish(message.content)

    def _play(self) -> None:
        """Play to the end, or until the node closes."""
        if self._gather() and self._playback.play():
            patience = Duration(seconds=PATIENCE / len(self._played))
            for each in self._played.values():
                each.wait_for_all_acked(patience)
            self.get_logger().info(f'{self._playback.played} messages played')
            self.finished = True

    def _gather(self) -> bool:
        """Wait until subscribers are connected; returns whether they are."""
        began = time.monotonic()
        self.get_logger().info(f'{len(self._played)} topics wait for subscribers')
        while not self._closed:
            counts = {name: each.get_subscription_count()
                      for name, each in self._played.items()}
            if self._audience.complete(counts, time.monotonic()):
                return True
            if time.monotonic() - began > self._settings.wait_time:
                self.failure = (f'nobody subscribed to {self._audience.missing()} within '
                                f'{self._settings.wait_time:g} s')
                return False
            time.sleep(LOOK)
        return False

    def _change_rate(self, settings: RateSettings) -> None:
        self._playback.run_at(settings.rate)

    def _pause(self) -> str:
        self._playback.pause()
        return 'paused'

    def _resume(self) -> str:
        self._playback.resume()
        return 'playing'

    def _step(self) -> str:
        message = self._playback.step()
        return f'{message.topic} at {seconds(message.log_time)}' if message else ''

    def report(self) -> Report:
        """Return how much was played, and how fast."""
        playback, missing = self._playback, self._audience.missing()
        values: dict[str, object] = {
            'messages played': playback.played, 'rate': playback.rate,
            'time given up [s]': playback.given_up}
        if missing:
            return Report(Level.WARN, f'nobody subscribes to {missing}', values)
        return Report(Level.OK, 'paused' if playback.paused else 'playing', values)

    def close(self) -> None:
        """End the thread that plays."""
        self._closed = True
        self._playback.end()
        self._thread.join()


def _publish_time(clock: Publisher, log_time: int) -> None:
    if log_time < LATEST_CLOCK:
        clock.publish(LITTLE_ENDIAN + pack_stamp(log_time))


def _answering(act: Callable[[], str]) -> Callable[[Trigger.Request, Trigger.Response],
                                                   Trigger.Response]:
    """Return a service that acts and says what it did; nothing to say means that it could not."""
    def answer(request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        said = act()
        response.success = bool(said)
        response.message = said or 'a step needs subscribers, a pause and a message to come'
        return response
    return answer


def main() -> int:
    """Play until the end, or until asked to end, and return the exit code."""
    sys.setswitchinterval(TAKE_TURNS)
    return run('bag_player', lambda: [BagPlayer()], kinds=[BagPlayer])


if __name__ == '__main__':
    sys.exit(main())

"""Recordings of others: their topics and names become those of this package as they are read."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from pathlib import Path
import re

from hda_msgs_json.bag import BagError, open_recording, Recording
from hda_msgs_json.bag_files import find_files
from hda_msgs_json.cdr_dynamic import decode_dynamic_joint_states
from hda_msgs_json.cdr_fields import CdrError
from hda_msgs_json.errors import HdaError
from hda_msgs_json.samples import Floats, JointSamples, Stamps
from hda_msgs_json.topics import JOINT_STATES, MOTOR_SUFFIX
import numpy as np
from numpy.typing import NDArray

from .even_stamps import evened

DYNAMIC_JOINT_STATE = 'control_msgs/msg/DynamicJointState'
_QUANTITIES = ('position', 'velocity', 'effort')


class NamingError(HdaError):
    """Topics or names that do not fit a recording."""


@dataclass(frozen=True)
class Naming:
    """How a recording names what this package calls joint_states, `joint1`, `joint1_motor`."""

    topic: str = ''
    link_topic: str = ''
    motor_topic: str = ''
    names: tuple[tuple[str, str], ...] = ()     # theirs, with one * at most, and ours
    even: bool = False                          # stamps of a host become even

    def __post_init__(self) -> None:
        """Raise NamingError for one of two topics, and for topics that exclude each other."""
        if bool(self.link_topic) != bool(self.motor_topic):
            raise NamingError('--link-topic and --motor-topic are given together, or neither')
        if self.topic and self.link_topic:
            raise NamingError('--topic has both sides of the joints; give it, or --link-topic '
                              'and --motor-topic')

    def named(self, samples: JointSamples) -> JointSamples:
        """Return samples under our names; raises NamingError where two become one."""
        names = tuple(map(self._ours, samples.names))
        if twice := sorted({name for name in names if names.count(name) > 1}):
            raise NamingError(f'two names become {twice[0]}; the recording names '
                              f'{", ".join(samples.names)}')
        return replace(samples, names=names)

    def _ours(self, name: str) -> str:
        """Return our name by the pattern that fits with most letters of its own."""
        for theirs, ours in sorted(self.names, key=lambda pair: -len(pair[0].replace('*', ''))):
            if fnmatchcase(name, re.sub(r'([\[?])', r'[\1]', theirs)):
                head, _, tail = theirs.partition('*')
                middle = name[len(head):len(name) - len(tail)] if '*' in theirs else ''
                return ours.replace('*', middle)
        return name


class RenamedRecording(Recording):
    """A recording whose joint states come under the names of this package."""

    def __init__(self, path: Path, naming: Naming) -> None:
        """Find the messages; raises BagError."""
        super().__init__(path, find_files(path))
        self._naming = naming

    def joint_states(self, topic: str = JOINT_STATES.name) -> JointSamples:
        """Return joint states, both sides of all joints for the usual topic; may raise."""
        if topic.strip('/') != JOINT_STATES.name:
            return super().joint_states(topic)
        naming = self._naming
        if naming.link_topic:
            samples = _beside(self._states(naming.link_topic), _as_motors(
                self._states(naming.motor_topic)))
        else:
            samples = self._states(naming.topic or topic)
        samples = naming.named(samples)
        return replace(samples, stamps=evened(samples.stamps)) if naming.even else samples

    def _states(self, topic: str) -> JointSamples:
        """Return the joint states of a topic, whatever its type; raises BagError."""
        kind = next((summary.message_type for name, summary in self.topics.items()
                     if name.strip('/') == topic.strip('/')), '')
        if kind != DYNAMIC_JOINT_STATE:
            return super().joint_states(topic)
        try:
            return _of_interfaces(*decode_dynamic_joint_states(self.raw(topic)[1]))
        except CdrError as error:
            raise BagError(f'{self.path}, topic {topic}: {error}') from None

    def _in_namespace(self, topic: str) -> list[str]:
        """Return a topic in the namespace of the joint states that were chosen."""
        chosen = self._naming.topic or self._naming.link_topic
        name = f'{chosen.rpartition("/")[0]}/{topic}'
        return [name] if chosen and name in self.topics else super()._in_namespace(topic)


def open_named(path: Path, naming: Naming) -> Recording:
    """Return the recording at a path under the names of this package; raises BagError."""
    return open_recording(path) if naming == Naming() else RenamedRecording(path, naming)


def _of_interfaces(stamps: Stamps, columns: dict[str, Floats]) -> JointSamples:
    """Return columns JOINT.INTERFACE as joint states; other interfaces are left out."""
    joints = list(dict.fromkeys(name.rpartition('.')[0] for name in columns))
    nothing = np.full(len(stamps), np.nan)
    position, velocity, effort = (np.column_stack([
        columns.get(f'{joint}.{quantity}', nothing) for joint in joints]).reshape(
            len(stamps), len(joints)) for quantity in _QUANTITIES)
    return JointSamples(stamps, tuple(joints), position, velocity, effort)


def _as_motors(samples: JointSamples) -> JointSamples:
    """Return samples of motor shafts, with the names of motors unless they have them."""
    return replace(samples, names=tuple(
        name if name.endswith(MOTOR_SUFFIX) else name + MOTOR_SUFFIX for name in samples.names))


def _beside(link: JointSamples, motor: JointSamples) -> JointSamples:
    """Return both sides at the stamps of the links, each motor sample the nearest in time."""
    if not len(link) or not len(motor):
        raise NamingError('both topics must have messages to be paired by their stamps, got '
                          f'{len(link)} of the links and {len(motor)} of the motors')
    rows, is_near = _nearest(link.stamps, motor.stamps)
    if not is_near.any():
        raise NamingError('no two stamps of the links and of the motors are within half a period '
                          'of each other')
    chosen, known = motor.rows(rows[is_near]), link.rows(np.flatnonzero(is_near))
    position, velocity, effort = (np.hstack([_full(known, place), _full(chosen, place)])
                                  for place in range(len(_QUANTITIES)))
    return JointSamples(known.stamps, (*known.names, *chosen.names), position, velocity, effort)


def _full(samples: JointSamples, place: int) -> Floats:
    """Return one array of samples, NaN where their messages had none."""
    values = samples.numbers[place]
    return values if values.shape[1] else np.full((len(samples), len(samples.names)), np.nan)


def _nearest(stamps: Stamps, others: Stamps) -> tuple[Stamps, NDArray[np.bool_]]:
    """Return which of others is nearest to each stamp, and whether it is within half a period."""
    order = np.argsort(others, kind='stable')
    ordered = others[order]
    after = np.minimum(np.searchsorted(ordered, stamps), len(ordered) - 1)
    before = np.maximum(after - 1, 0)
    nearest = np.where(np.abs(stamps - ordered[before]) <= np.abs(ordered[after] - stamps),
                       before, after)
    periods = [float(np.median(np.diff(np.sort(each)))) for each in (stamps, others)
               if len(each) > 1]
    reach = max([*periods, 1.0]) / 2.0
    return order[nearest], np.abs(ordered[nearest] - stamps) <= reach


def naming_of(topic: str | None, sides: Sequence[str | None], names: Sequence[str],
              *, even: bool) -> Naming:
    """Return the naming of words as they are typed; raises NamingError."""
    pairs = []
    for word in names:
        theirs, mark, ours = word.partition('=')
        if not (mark and theirs and ours) or theirs.count('*') > 1 or (
                '*' in ours and '*' not in theirs):
            raise NamingError('--name needs THEIRS=OURS, as m1=joint1_motor or '
                              f'"mot_*=joint*_motor", got {word!r:.60}')
        pairs.append((theirs, ours))
    link, motor = sides
    return Naming(topic or '', link or '', motor or '', tuple(pairs), even)

"""`hda info`: what a bag holds, how well it is sampled, what it can and cannot show."""

import argparse
from dataclasses import asdict
import math
from pathlib import Path
from typing import Any

from hda_msgs_json.bag import Recording
from hda_msgs_json.printable import printable
from hda_msgs_json.topics import JOINT_STATES

from .bag_option import add_naming, naming
from .outcome import Outcome
from .progress import progress
from ..measurements.recording_facts import (name_facts, NameFacts, shortcomings, stamp_facts,
                                            StampFacts)
from ..measurements.renamed_recording import Naming, open_named

EXAMPLES = (
    'hda info bag',
    'hda info bag --json')


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument('bag', type=Path, metavar='BAG', help='bag directory or .mcap file')
    add_naming(parser)


def execute(options: argparse.Namespace) -> Outcome:
    """Look into a bag; raises the project's errors."""
    with progress(f'reading {options.bag.name}', quiet=options.json):
        return _looked(options)


def _looked(options: argparse.Namespace) -> Outcome:
    named = naming(options)
    recording = open_named(options.bag, named)
    report: dict[str, Any] = {
        'bag': str(options.bag), 'duration': recording.duration,
        'topics': {name: asdict(topic) for name, topic in recording.topics.items()},
        'warnings': list(recording.warnings), 'metadata': dict(recording.metadata)}
    lines = [f'{options.bag}: {recording.duration:.3f} s', '', *_topic_lines(recording)]
    if named != Naming() or any(name.strip('/').rpartition('/')[2] == JOINT_STATES.name
                                for name in recording.topics):
        samples = recording.joint_states()
        time, names = stamp_facts(samples.stamps), name_facts(samples)
        references = tuple(name for name in recording.topics if 'reference/' in name)
        missing = shortcomings(time, names, references)
        report['joint_states'] = {
            **asdict(time), 'names': [_finite(asdict(fact)) for fact in names],
            'cannot_show': list(missing)}
        lines += ['', *_time_lines(time), '', *_name_lines(names), '',
                  *(f'  cannot show: {sentence}' for sentence in missing)]
    lines += [f'  warning: {sentence}' for sentence in recording.warnings]
    return Outcome('\n'.join(lines).rstrip(), report)


def _topic_lines(recording: Recording) -> list[str]:
    wide = max((len(name) for name in recording.topics), default=0)
    return [f'  {name:<{wide}}  {topic.count:>9}  {topic.message_type}'
            for name, topic in sorted(recording.topics.items())]


def _time_lines(time: StampFacts) -> list[str]:
    return [f'  joint states at {time.rate:.1f} Hz, {time.gaps} gaps (longest period '
            f'{1e3 * time.longest_gap:.2f} ms), {time.not_later} stamps repeated or backward']


def _name_lines(names: tuple[NameFacts, ...]) -> list[str]:
    shown = [printable(fact.name) for fact in names]
    wide = max(map(len, shown), default=0)
    head = f'  {"name":<{wide}}  {"from":>10} {"to rad":>10} {"rad/s":>9} {"step rad":>10}  also'
    return [head, *(
        f'  {name:<{wide}}  {fact.low:10.4f} {fact.high:10.4f} {fact.fastest:9.3f} '
        f'{fact.step:10.2e}  {", ".join(_also(fact))}' for name, fact in zip(shown, names))]


def _also(fact: NameFacts) -> list[str]:
    return (['velocity'] if fact.velocity else []) + (['effort'] if fact.effort else [])


def _finite(values: dict[str, Any]) -> dict[str, Any]:
    """Return values with null for NaN: JSON has no other way to say that there is none."""
    return {key: None if isinstance(value, float) and not math.isfinite(value) else value
            for key, value in values.items()}

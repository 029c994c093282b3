"""`hda compare`: two bags laid over each other, and how they differ."""

import argparse
from pathlib import Path
import shutil
import sys
from typing import Any

from hda_msgs_json.bag import Recording
from hda_msgs_json.samples import JointSamples, WrenchSamples
from hda_msgs_json.topics import JOINT_STATE, JOINT_STATES, WRENCH_STAMPED

from .bag_option import add_naming, naming
from .out_option import add_out
from .outcome import Outcome
from .progress import progress
from .whole_directory import check_directory, save_figures, whole_directory, write_json
from ..comparison.align import MODES
from ..comparison.compare import compare, Comparison
from ..comparison.page import page
from ..comparison.plots import figures
from ..comparison.report import document, sentences
from ..comparison.signals import bag_of, BagSignals
from ..measurements.renamed_recording import Naming, open_named
from ..version import version

EXAMPLES = (
    'hda compare before after --out comparison',
    'hda compare before after --align none --out comparison   # stamps are right')


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument('first', type=Path, metavar='BAG1', help='what the other is held against')
    parser.add_argument('second', type=Path, metavar='BAG2', help='what may differ')
    add_out(parser, 'DIR', 'directory to write: compare.html, compare.json, figures')
    parser.add_argument('--align', choices=MODES, default='drift',
                        help='what to find from the signals: offset and drift of the second '
                             'clock, its offset, or none to believe the stamps')
    add_naming(parser)


def execute(options: argparse.Namespace) -> Outcome:
    """Compare and write; raises the project's errors."""
    with progress('comparing', quiet=options.json):
        return _compared(options)


def _compared(options: argparse.Namespace) -> Outcome:
    check_directory(options.out, force=options.force, reads=[options.first, options.second])
    named = naming(options)
    first, second = (open_named(path, named) for path in (options.first, options.second))
    found = compare(_bag(first, named), _bag(second, named), options.align)
    warnings = [f'{bag.path}: {warning}' for bag in (first, second) for warning in bag.warnings]
    report = {**document(found, version()), 'warnings': warnings}
    with whole_directory(options.out, force=options.force) as partial:
        _write(found, report, partial)
    width = shutil.get_terminal_size().columns if sys.stdout.isatty() else None
    lines = [*sentences(found, width), *(f'  warning: {warning}' for warning in warnings)]
    return Outcome('\n'.join(lines), report)


def _bag(recording: Recording, named: Naming) -> BagSignals:
    """Return the joint states and wrenches of a recording as signals."""
    topics: dict[str, JointSamples | WrenchSamples] = {}
    if named != Naming():
        topics[JOINT_STATES.name] = recording.joint_states()
    for name, topic in sorted(recording.topics.items()):
        if topic.message_type == JOINT_STATE and named == Naming():
            topics[name] = recording.joint_states(name)
        elif topic.message_type == WRENCH_STAMPED:
            topics[name] = recording.wrenches(name)
    return bag_of(str(recording.path), topics)


def _write(found: Comparison, report: dict[str, Any], out: Path) -> None:
    """Write the numbers, the figures and the page."""
    write_json(out / 'compare.json', report)
    save_figures(figures(found), out, vectors=False)
    (out / 'compare.html').write_text(page(found, version()), encoding='utf-8')

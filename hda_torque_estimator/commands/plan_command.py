"""`hda plan`: a motion within the arm's limits that separates two effects, or shows some."""

import argparse
import time
from typing import Any

from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motion_file import write_motion
from hda_msgs_json.outputs import check_file
import numpy as np

from .out_option import add_out
from .outcome import Outcome
from .progress import progress
from ..planning.plan import Plan, plan, planned_motion
from ..planning.question import PlanError, Question, question, shown

_STEP = 1e-3            # of the motion before it is thinned to a table [s]
EXAMPLES = (
    'hda plan --arm hda_arm.yaml --between payload cable_spring --out motion.csv',
    'hda plan --arm hda_arm.yaml --show backlash payload --out motion.csv',
    'hda simulate --arm hda_arm.yaml --motion motion.csv --out bag')


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument('--arm', required=True, help='model file, or the name of a shipped one')
    asked = parser.add_mutually_exclusive_group(required=True)
    asked.add_argument('--between', nargs=2, metavar='EFFECT',
                       help='two effects of the catalogue to distinguish; EFFECT@JOINT names the '
                            'joint')
    asked.add_argument('--show', nargs='+', metavar='EFFECT',
                       help='effects of the catalogue that a diagnosis shall see')
    parser.add_argument('--duration', type=float, default=24.0, metavar='S',
                        help='seconds of the motion, 24 unless given')
    add_out(parser, 'FILE', 'CSV to write: time, link angles and rates')


def execute(options: argparse.Namespace) -> Outcome:
    """Plan and write; raises the project's errors."""
    begin = time.monotonic()
    arm = read_arm(options.arm)
    asked = question(arm, *options.between) if options.between else shown(arm, options.show)
    check_file(options.out, force=options.force)
    if not options.out.absolute().parent.is_dir():
        raise PlanError(f'{options.out} cannot be written: name a file in a folder that exists')
    with progress(quiet=options.json) as notify:
        found = plan(asked, options.duration, lambda done, total: notify(
            f'weighing motion {min(done + 1, total)} of {total}'))
    if found.answers:
        write_motion(options.out, planned_motion(asked, found.best.path, options.duration, _STEP),
                     asked.arm.labels, force=options.force)
    report = _report(options, asked, found, time.monotonic() - begin)
    return Outcome(_in_words(options, asked, found), report)


def _in_words(options: argparse.Namespace, asked: Question, found: Plan) -> str:
    """Return what people read."""
    verb, names = (('separates', ' from ') if asked.between else ('shows', ' and '))
    labels = names.join(suspect.label for suspect in asked.suspects)
    best, usual = found.best.strength.least, found.usual.strength.least
    if not found.answers:
        return (f'no motion {verb} {labels}: the best of them, {found.best.path.label}, leaves a '
                f'gap of {best:.3g} where {found.needed:g} is needed; nothing written')
    shares = ', '.join(f'{name} {100.0 * float(np.max(part)):.0f} %'
                       for name, part in found.load._asdict().items())
    return (f'{options.out}: {found.best.path.label}, {options.duration:g} s\n'
            f'{verb} {labels} with a gap of {best:.0f}; the motion rich '
            f'reaches {usual:.1f}, {found.needed:g} is needed\n'
            f'takes of the limits of the arm: {shares}')


def _report(options: argparse.Namespace, asked: Question, found: Plan,
            seconds: float) -> dict[str, Any]:
    """Return what machines read."""
    return {
        'schema': 'hda.plan/1', 'arm': options.arm, 'separates': found.answers,
        'between' if asked.between else 'show': [
            [suspect.effect.name, suspect.joint] for suspect in asked.suspects],
        'sizes': [{rule.name: {'value': getattr(suspect.effect, rule.name), 'unit': rule.unit}
                   for rule in suspect.effect.declarations()} for suspect in asked.suspects],
        'out': str(options.out) if found.answers else None,
        'motion': found.best.path.label, 'duration': options.duration,
        'strength': found.best.strength.least, 'needed': found.needed,
        'strength_of_rich': found.usual.strength.least,
        'share_of_limits': {name: part.tolist() for name, part in found.load._asdict().items()},
        'candidates': [{'motion': one.path.label, 'strength': one.strength.least}
                       for one in found.candidates],
        'seconds': seconds}

"""`hda new`: an arm file from a few answers, by options or asked for on a terminal."""

import argparse
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
import sys
from typing import Any, TypeVar

from hda_arm_sim.model.files import arm_from_text
from hda_arm_sim.model.gear_catalogue import gear, GearError
from hda_arm_sim.model.gear_defaults import CLASS_DEFAULT
from hda_msgs_json.outputs import check_file, whole_file

from .arm_answers import ANSWERS, JointAnswers, JointOption, NewError, Rods, spread
from .bag_option import add_naming, opener
from .gear_table import COLUMNS, described, gears_of, UrdfLinks
from .new_arm_text import arm_text
from .out_option import add_out
from .outcome import Outcome
from .progress import progress
from .recorded_answers import add_answers, origin_words, recorded_joints
from .terminal import complain

_GEAR = JointOption('gear', '',
                    'catalogue name like CSG-17-100: series CSG or CSF, size 14 to 40, '
                    'ratio', True)
Value = TypeVar('Value')
EXAMPLES = (
    'hda new --gear CSG-17-100 --motor-inertia 5e-6 --motor-torque 0.3 \\\n'
    '      --motor-counts 16384 --link-counts 4e6 --out arm.yaml',
    'hda new --from bag --gear CSG-17-100 --motor-inertia 5e-6 --out arm.yaml',
    'hda new --urdf robot.urdf --gears gears.csv --tip tool --out arm.yaml',
    'hda new --gear CSF-20-100 --out arm.yaml          # asks for the rest')


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    size = partial(_number, JointOption('size', '', ''))
    parser.add_argument('--from', dest='source', type=Path, metavar='BAG',
                        help='a recording that shows names, counts of the encoders, the ratio to '
                             'check, and the torque that the motor reaches at least')
    parser.add_argument('--joints', nargs='+', metavar='NAME',
                        help='names of the joints; joint1 and so on unless given')
    parser.add_argument(_GEAR.option, nargs='+', metavar='GEAR',
                        help=f'{_GEAR.meaning}; one for all joints, or one for each')
    for answer in ANSWERS:
        parser.add_argument(answer.option, nargs='+', type=partial(_number, answer),
                            metavar=answer.unit.upper() or answer.name.upper(),
                            help=answer.with_unit(answer.meaning))
    parser.add_argument('--lengths', nargs='+', type=size, metavar='M',
                        help='of one or two links; without them the arm has torsion only [m]')
    parser.add_argument('--masses', nargs='+', type=size, metavar='KG',
                        help='of these links, taken for uniform rods [kg]')
    parser.add_argument('--urdf', type=Path, metavar='FILE',
                        help='robot description of a chain of links; with --gears')
    parser.add_argument('--gears', type=Path, metavar='CSV',
                        help=f'a row for each joint of it; columns: {", ".join(COLUMNS)}')
    parser.add_argument('--tip', metavar='FRAME', help='of the description, where the tool is')
    add_out(parser, 'FILE', 'model file to write')
    add_naming(parser)


def execute(options: argparse.Namespace) -> Outcome:
    """Make the arm and write it; raises the project's errors."""
    check_file(options.out, force=options.force)
    origins = {}
    if options.source is not None:
        with progress(f'reading {options.source.name}', quiet=options.json):
            recorded = recorded_joints(opener(options)(options.source))
        origins = add_answers(options, recorded, options.source.name)
    joints, rods = _of_description(options) or _of_answers(options, origins)
    text = arm_text(joints, rods)
    arm = arm_from_text(text, str(options.out))     # what every command will read
    with whole_file(options.out, force=options.force) as file:
        file.write(text)
    unknown = sorted({key.partition('.')[2] for key, origin in arm.provenance
                      if origin.startswith(CLASS_DEFAULT)})
    names = ', '.join(f'{joint.label} {joint.gear.name}' for joint in joints)
    return Outcome(
        '\n'.join([f'{options.out}: {names}; every number has its source beside it',
                   *origin_words(origins),
                   f'  class defaults until hda calibrate: {", ".join(unknown)}']),
        {'arm': str(options.out), 'gears': {joint.label: joint.gear.name for joint in joints},
         'class_defaults': unknown, 'from_recording': origins, 'links': rods is not None})


def _of_answers(options: argparse.Namespace, origins: Mapping[str, str],
                ) -> tuple[list[JointAnswers], Rods | None]:
    """Return what options and answers state of joints and links; raises NewError or GearError."""
    for name in options.gear or ():
        gear(name)                                  # before anything is asked
    _complete(options)
    return _joints(options, origins), _rods(options)


def _of_description(options: argparse.Namespace) -> tuple[list[JointAnswers], UrdfLinks] | None:
    """Return what a description and a table state, None without them; raises NewError."""
    if options.urdf is None and options.gears is None and options.tip is None:
        return None
    if options.urdf is None or options.gears is None:
        raise NewError('--urdf and --gears go together, --tip with both')
    names = (_GEAR.name, *(answer.name for answer in ANSWERS), 'joints', 'lengths', 'masses',
             'source')
    if given := [name for name in names if getattr(options, name)]:
        raise NewError(f'the table of --gears states all of a joint, and --urdf its links; leave '
                       f'out --{given[0].replace("_", "-").replace("source", "from")}')
    links = described(options.urdf, options.tip, options.out)
    rows = gears_of(options.gears, links.joints)
    return [_joint(given.pop('joint'), given) for given in rows], links


def _number(answer: JointOption, text: str) -> float:
    """Return a number that an answer takes; raises ArgumentTypeError."""
    value = answer.read(text)
    if value is None:
        raise argparse.ArgumentTypeError(f'it must be {answer.takes}, got {text!r:.60}')
    return value


def _missing(options: argparse.Namespace) -> list[JointOption]:
    """Return what has to be stated and is not."""
    missing = [answer for answer in (_GEAR, *ANSWERS)
               if answer.required and not getattr(options, answer.name)]
    return [answer for answer in missing if answer.name != 'motor_torque' or not (
        options.torque_constant and options.motor_current)]


def _complete(options: argparse.Namespace) -> None:
    """Ask for what is missing on a terminal; raises NewError where nobody can be asked."""
    missing = _missing(options)
    needed = [answer.with_unit(answer.option) for answer in missing if not answer.unless]
    if sys.stdin is None or not sys.stdin.isatty():
        if needed:
            raise NewError(f'an arm needs {", ".join(needed)}')
        return
    for answer in missing if needed else ():
        read: Callable[[str], Any] = (
            _gear_name if answer is _GEAR else partial(_number, answer))
        setattr(options, answer.name, _asked(answer, read))


def _asked(answer: JointOption, read: Callable[[str], Value]) -> list[Value]:
    """
    Return what somebody types, asked again until it can be read; raises NewError at the end.

    An empty line is no answer, but where something stands for it.
    """
    known = f'; an empty line for {answer.unless}' if answer.unless else ''
    while True:
        complain(f'{answer.meaning}, one for all joints or one for each{known}', sys.stderr)
        sys.stderr.write(f'  {answer.with_unit(answer.option)}: ')
        sys.stderr.flush()
        line = sys.stdin.readline()
        if not line:
            raise NewError(f'no answer for {answer.option}')
        try:
            values = [read(word) for word in line.replace(',', ' ').split()]
        except (argparse.ArgumentTypeError, GearError) as error:
            complain(str(error), sys.stderr)
            continue
        if values or answer.unless:
            return values


def _gear_name(word: str) -> str:
    """Return the name of a gear; raises GearError."""
    return gear(word).name


def _joints(options: argparse.Namespace, origins: Mapping[str, str]) -> list[JointAnswers]:
    """Return what is known of each joint; raises NewError or GearError."""
    given: dict[str, Sequence[Any] | None] = {
        answer.name: getattr(options, answer.name) for answer in (_GEAR, *ANSWERS)}
    count = len(options.joints or ()) or max(
        len(values or ()) for values in (*given.values(), options.lengths))
    labels = options.joints or [f'joint{place + 1}' for place in range(count)]
    columns = {name: spread(values, count, JointOption(name, '', '').option)
               for name, values in given.items()}
    return [_joint(label, {'origins': origins} | {
                name: column[place] for name, column in columns.items()})
            for place, label in enumerate(labels)]


def _joint(label: str, stated: dict[str, Any]) -> JointAnswers:
    constant, current = stated['torque_constant'], stated['motor_current']
    if (constant is None) != (current is None):
        raise NewError('--torque-constant and --motor-current go together, or neither')
    if constant is not None:
        if stated['motor_torque'] is not None:
            raise NewError('the largest torque is given twice: give --motor-torque, or '
                           '--torque-constant and --motor-current')
        stated['motor_torque'] = constant * current
    return JointAnswers(label, gear(stated.pop('gear')), **stated)


def _rods(options: argparse.Namespace) -> Rods | None:
    """Return the links, if they are stated; raises NewError."""
    lengths, masses = options.lengths, options.masses
    if not lengths and not masses:
        return None
    if not lengths or not masses or len(lengths) != len(masses):
        raise NewError('--lengths and --masses need a value for each link, got '
                       f'{len(lengths or ())} and {len(masses or ())}')
    if not all((*lengths, *masses)):
        raise NewError('--lengths and --masses must be above 0')
    if len(lengths) > 2:
        raise NewError(f'links are modelled for one or two joints, got {len(lengths)}; leave '
                       '--lengths and --masses out for torsion only')
    return Rods(tuple(lengths), tuple(masses))

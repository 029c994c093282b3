"""
Write docs/reference/: what can be typed, sent, stated and refused, from the declarations.

Commands come from their parsers, parameters of nodes and arms from their declarations, topics
from the list of topics and the security policy, effects from the catalogue, errors from classes.
"""

import argparse
import ast
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from importlib import import_module
import inspect
import re
import xml.etree.ElementTree as ElementTree

from hda_arm_sim.foundation.parameter import Declaration, Declared
from hda_arm_sim.model import parts
from hda_arm_sim.model.chain_files import CHAIN_MEANINGS
from hda_arm_sim.model.effects import Effect, EFFECTS
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.model.link_numbers import LinkTolerance
from hda_arm_sim.model.torsion import TorsionLaw
from hda_arm_sim.node import ArmSim
from hda_arm_sim.ros.arm_node import ReportingNode
from hda_msgs_json import topics
from hda_torque_estimator import cli
from hda_torque_estimator.commands.fleet import ALARMED
from hda_torque_estimator.commands.parsing import MISUSED
from hda_torque_estimator.controlling.controller_node import JtfController
from hda_torque_estimator.estimating.estimator_node import TorqueEstimator
from hda_torque_estimator.estimating.number_messages import number_topics
from hda_torque_estimator.playing.player_node import BagPlayer
from hda_torque_estimator.recording.recorder_node import BagRecorder
from project_files import ROOT
from project_imports import PATHS

FOLDER = ROOT / 'docs' / 'reference'
WRITTEN = 'Written by `make docs` from the declarations in the source.'
NODES: dict[str, type[ReportingNode]] = {
    'arm_sim': ArmSim, 'torque_estimator': TorqueEstimator, 'jtf_controller': JtfController,
    'bag_recorder': BagRecorder, 'bag_player': BagPlayer}
OF_ROS = ('parameter_events', 'rosout')         # what every node of ROS 2 has
ROOT_ERROR = 'HdaError'
COMMANDS = 'hda_torque_estimator.commands'


def table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table of Markdown; bars and stars in cells are kept."""
    lines = [heads, ['---'] * len(heads), *rows]
    return ''.join(f'| {" | ".join(map(plain, line))} |\n' for line in lines)


def plain(cell: str) -> str:
    """Return a cell whose bars, and stars outside of code, mean themselves."""
    parts = cell.replace('|', r'\|').split('`')
    return '`'.join(part if number % 2 else part.replace('*', r'\*')
                    for number, part in enumerate(parts))


def code(text: object) -> str:
    """Return a text as code, nothing for nothing."""
    return f'`{text}`' if str(text) else ''


def bounds(rule: Declaration) -> str:
    """Return what a number may be, with its unit."""
    return f'{rule.low:g} to {rule.high:g} {rule.unit}'.strip()


def numbers(rules: Iterable[Declaration]) -> str:
    """Return the table of declared numbers."""
    return table(('name', 'default', 'from, to', 'meaning'), (
        (code(rule.name), f'{rule.default:g}', bounds(rule), rule.meaning) for rule in rules))


def commands() -> str:
    """Return the page of all commands with all their options."""
    page = [f'# Options of every command\n\n{WRITTEN} [Commands](../commands.md) says what each '
            'is for.\n']
    for name in cli.COMMANDS:
        parser = argparse.ArgumentParser(prog=f'hda {name}', add_help=False)
        parser.add_argument('--json', action='store_true', help='print one JSON object')
        import_module(f'{COMMANDS}.{name}_command').configure(parser)
        meaning = cli.COMMANDS[name]
        page.append(f'\n## `hda {name}`\n\n{meaning[0].upper()}{meaning[1:]}.\n\n')
        page.append(table(('argument', 'default', 'meaning'), map(_option, parser._actions)))
    return ''.join(page)


def _option(action: argparse.Action) -> tuple[str, str, str]:
    """Return the row of one argument."""
    value = action.metavar or ('' if action.nargs == 0 else (action.dest or '').upper())
    if isinstance(value, tuple):
        value = ' '.join(value)
    shown = ', '.join(action.option_strings) or str(value)
    given = f'{shown} {value}' if action.option_strings and value else shown
    default = '' if action.default in (None, False, argparse.SUPPRESS, [], ()) else action.default
    choices = f' One of {", ".join(map(str, action.choices))}.' if action.choices else ''
    meaning = (action.help or '').replace('%%', '%') + choices
    return code(given), code(default) if default != '' else '', meaning


def nodes() -> str:
    """Return the page of all parameters of all nodes."""
    page = [f'# Parameters of every node\n\n{WRITTEN} [Nodes](../nodes.md) says how they work '
            'together. `NODE --help` prints the same.\n']
    for name, kind in NODES.items():
        page.append(f'\n## `{name}`\n\n{kind.PURPOSE}\n\n')
        page.append(table(('parameter', 'default', 'meaning'), (
            (code(option), code(default if isinstance(default, str) else str(default).lower())
             if not isinstance(default, list) else '', meaning)
            for option, (default, meaning) in kind.OPTIONS.items())))
        rules = [rule for group in kind.GROUPS for rule in group.declarations()]
        page.append('\n' + numbers(rules) if rules else '')
    return ''.join(page)


def declared_topics() -> Iterator[topics.Topic]:
    """Yield every topic of the system, those of one joint for all joints."""
    for value in vars(topics).values():
        if isinstance(value, topics.Topic):
            yield value
        elif inspect.isfunction(value) and value.__annotations__ == {
                'joint': str, 'return': topics.Topic}:
            yield value('JOINT')
    plain = number_topics(read_arm('hda_arm.yaml'))
    yield from dict.fromkeys(replace(topic, name=re.sub(r'joint\d', 'JOINT', topic.name))
                             for topic in plain)


def traffic() -> str:
    """Return the page of topics and services: types, quality, and who says and hears them."""
    page = [f'# Topics and services\n\n{WRITTEN} `JOINT` stands for the name of a joint. Names '
            'are relative to the namespace of the node.\n\n']
    every = list(declared_topics())
    page.append(table(('topic', 'type'), (
        (code(topic.name), code(topic.message_type)) for topic in every)))
    page.append('\n## Quality of service\n\n')
    kinds = dict.fromkeys(map(_quality, every))
    page.append(table(('quality', 'why', 'topics'), (
        (*kind, ', '.join(code(topic.name) for topic in every if _quality(topic) == kind))
        for kind in kinds)))
    page.append('\n## Who says and hears what\n\nFor the two joints of `hda_arm.yaml`, from '
                '`config/sros2_policy.xml`.\n\n')
    page.append(table(('node', 'publishes', 'subscribes', 'services'), spoken()))
    return ''.join(page)


def _quality(topic: topics.Topic) -> tuple[str, str]:
    """Return the quality of service of a topic in words, and the reason for it."""
    return f'{topic.reliability}, {topic.durability}, depth {topic.depth}', topic.reason


def spoken() -> Iterator[tuple[str, str, str, str]]:
    """Yield what each node publishes, subscribes and serves, without what every node does."""
    policy = ElementTree.parse(ROOT / 'config' / 'sros2_policy.xml')
    for profile in policy.iter('profile'):
        node = profile.get('node') or ''
        said = [_named(profile, f'topics[@{way}]/topic') for way in ('publish', 'subscribe')]
        served = [name for name in _named(profile, 'services[@reply]/service')
                  if not name.endswith(('_parameters', '_parameter_types', '_type_description',
                                        '_atomically'))]
        yield code(node), *(', '.join(map(code, names)) for names in (*said, served))


def _named(profile: ElementTree.Element, path: str) -> list[str]:
    return [each.text or '' for each in profile.findall(path) if each.text not in OF_ROS]


def arm_file() -> str:
    """Return the page of an arm file: all its numbers, and the shipped one as an example."""
    page = [f'# The arm file\n\n{WRITTEN} [A new arm](../new_arm.md) makes one from a few '
            'answers.\nAngles are in rad, torques in N·m. Numbers of a joint are at the motor '
            'shaft, those of its torsion at the output, unless the meaning says otherwise.\n'
            'An entry under `effects` has `effect`, `joint` and `parameters` '
            '([effects](effects.md)).\n']
    for kind in arm_parts():
        words = inspect.cleandoc(kind.__doc__ or '').split('\n')[0]
        page.append(f'\n## `{kind.name}`\n\n{words}\n\n{numbers(kind.declarations())}')
    page.append(_chain())
    shipped = (ROOT / 'config' / 'hda_arm.yaml').read_text()
    return ''.join([*page, f'\n## `hda_arm.yaml`, as shipped\n\n```yaml\n{shipped}```\n'])


def _chain() -> str:
    """Return the section of links that a robot description states."""
    keys = table(('name', 'meaning'), (
        (code(name), meaning) for name, meaning in CHAIN_MEANINGS.items()))
    return ('\n## `links` of a robot description\n\nA chain of up to twelve joints that turn, in '
            'space. `cobot7.yaml` is such an arm.\nA joint turns within its limits in the '
            f'description and within its `angle_limit`.\n\n{keys}\nEach of the `tolerances` '
            f'has these numbers:\n\n{numbers(LinkTolerance.declarations())}')


def arm_parts() -> list[type[Declared]]:
    """Return the groups of numbers of an arm file, in the order of the source."""
    kinds = [kind for kind in vars(parts).values() if inspect.isclass(kind)
             and issubclass(kind, Declared) and kind.__module__ == parts.__name__]
    return [*kinds, TorsionLaw]


def effects() -> str:
    """Return the page of all effects: cause, place, parameters, likeness and experiment."""
    page = [f'# Every effect\n\n{WRITTEN} Laws and sources stand in the [model]'
            '(../model.md#effects), thresholds under [constants](../constants.md#effects). An '
            'entry without\nparameters has the typical size: of a motor of 0.3 N·m and a gear of '
            'ratio 100.\n\n']
    page.append(table(('effect', 'cause', 'site'), (
        (f'[`{effect.name}`](#{effect.name})', effect.cause, effect.site.value)
        for effect in EFFECTS)))
    return ''.join([*page, *map(_effect, EFFECTS)])


def _effect(effect: type[Effect]) -> str:
    """Return the section of one effect."""
    head = f'\n## `{effect.name}`\n\n{effect.cause[0].upper()}{effect.cause[1:]}.\n\n'
    sought, typical = effect.hypothesis, effect.typical
    sizes = {**typical.more, **typical.shape} if typical else {}
    rows = [('of', f'{effect.scope.value}, acts at: {effect.place.name}')]
    if sought is not None and sought.alike:
        rows.append(('alike', ', '.join(f'[`{name}`](#{name})' for name in sought.alike)))
    if sought is not None and sought.experiment:
        rows.append(('experiment that decides', sought.experiment))
    if sizes:
        rows.append(('typical size', ', '.join(
            f'{code(name)} {size:g}' for name, size in sizes.items())))
    rules = effect.declarations()
    return head + table(('', ''), rows) + (f'\n{numbers(rules)}' if rules else '')


def errors() -> str:
    """Return the page of errors: classes that a user reads in one line, and exit codes."""
    page = [f'# Errors and exit codes\n\n{WRITTEN} Every error that a user can cause is one line. '
            'It derives from\n`hda_msgs_json.errors.HdaError`, a `ValueError`. `HDA_DEBUG=1` '
            'shows the traceback as well.\n\n']
    page.append(table(('exit code', 'of `hda`'), (
        ('`0`', 'done, whatever was found'),
        (code(MISUSED), 'wrong use, or input that cannot be used'),
        (code(ALARMED), 'an alarm of [a fleet](../fleet.md), where `--alarm` asks for it'),
        (code(cli.INTERRUPTED), 'interrupted'))))
    page.append('\n')
    page.append(table(('error', 'module', 'meaning'), (
        (code(name), code(module), meaning) for name, module, meaning in error_classes())))
    return ''.join(page)


def error_classes() -> list[tuple[str, str, str]]:
    """Return name, module and meaning of every public class of errors, by name."""
    classes = {node.name: (module, node) for module, path in PATHS.items()
               for node in ast.parse(path.read_text()).body if isinstance(node, ast.ClassDef)}
    derived = {ROOT_ERROR}
    while new := {name for name, (_, node) in classes.items() if name not in derived
                  and derived.intersection(ast.unparse(base) for base in node.bases)}:
        derived |= new
    return sorted((name, classes[name][0], _first_line(classes[name][1]))
                  for name in derived if not name.startswith('_'))


def _first_line(node: ast.ClassDef) -> str:
    return (ast.get_docstring(node) or '').split('\n')[0]


PAGES = {'arm_file': arm_file, 'effects': effects, 'errors': errors, 'options': commands,
         'parameters': nodes, 'topics': traffic}


def write() -> None:
    """Write all pages."""
    FOLDER.mkdir(exist_ok=True)
    for name, page in PAGES.items():
        (FOLDER / f'{name}.md').write_text(page())


if __name__ == '__main__':
    write()

"""`hda effects`: the catalogue of effects with all their parameters, from the declarations."""

import argparse
from collections.abc import Mapping, Sequence
from textwrap import fill
from typing import Any

from hda_arm_sim.foundation.parameter import Declaration
from hda_arm_sim.model.effects import Effect, effect_named, EFFECTS
from hda_arm_sim.model.effects.hypothesis import Typical

from .outcome import Outcome

WIDTH = 80              # of a plain terminal
_ROW = '  {:<17} {:<10} {:<17} {:>9}  {:>9}'
_HEADS = ('parameter', 'unit', 'from .. to', 'default', 'typical')
_SCALE = ('An effect listed without parameters has its typical size, + on top of what the arm '
          'has; one without any (-) needs parameters. Sizes are those of a motor of 0.3 N*m and '
          'a gear of ratio 100; torques grow with both.')
_MORE = 'Ranges, defaults and meanings: hda effects NAME.'

EXAMPLES = (
    'hda effects',
    'hda effects backlash torsional_hysteresis')


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument('names', nargs='*', metavar='NAME',
                        help='effects to explain, parameter by parameter; all unless given')


def execute(options: argparse.Namespace) -> Outcome:
    """List effects; raises ParameterError for a name that the catalogue does not have."""
    chosen = [effect_named(name) for name in dict.fromkeys(options.names)]
    text = _details(chosen) if chosen else _table()
    return Outcome(text, {'effects': [_report(effect) for effect in chosen or EFFECTS]})


def _table() -> str:
    """Return a line for each effect: its name, all its parameters with their sizes and units."""
    indent = max(len(effect.name) for effect in EFFECTS) + 1
    lines = [f'{"effect":<{indent}}parameters with typical sizes']
    lines += [f'{effect.name:<{indent}}{_sizes(effect)}' for effect in EFFECTS]
    return '\n'.join([*lines, '', fill(f'{_SCALE} {_MORE}', WIDTH)])


def _sizes(effect: type[Effect]) -> str:
    """Return all parameters of an effect, those that make its size first."""
    rules = sorted(effect.declarations(), key=lambda rule: rule.name not in _usual(effect).more)
    return ', '.join(' '.join(filter(None, (rule.name, _typical_words(effect, rule), rule.unit)))
                     for rule in rules) or 'none: an arm has it, or not'


def _details(effects: Sequence[type[Effect]]) -> str:
    """Return all there is to say of some effects."""
    return '\n\n'.join([_ROW.format(*_HEADS).rstrip(), *map(_block, effects),
                        fill(_SCALE, WIDTH)])


def _block(effect: type[Effect]) -> str:
    """Return an effect in words: where and why it acts, and a row for each parameter."""
    where = f'{effect.name}: {effect.scope.value}, {effect.site.value}, {effect.place.name}'
    lines = [where, fill(effect.cause, WIDTH, initial_indent='  ', subsequent_indent='  ')]
    if not effect.declarations():
        lines.append('  without parameters: an arm has it, or not')
    for rule in effect.declarations():
        lines.append(_ROW.format(rule.name, rule.unit, f'{rule.low:g} .. {rule.high:g}',
                                 f'{rule.default:g}', _typical_words(effect, rule)).rstrip())
        lines.append(fill(rule.meaning, WIDTH, initial_indent=' ' * 6,
                          subsequent_indent=' ' * 6))
    return '\n'.join(lines)


def _typical_words(effect: type[Effect], rule: Declaration) -> str:
    """Return the typical size of a parameter, with + where it comes on top of the arm's."""
    size = _typical(effect, rule)
    if size is None:
        return '-'
    return f'+{size:g}' if rule.name in _usual(effect).more else f'{size:g}'


def _typical(effect: type[Effect], rule: Declaration) -> float | None:
    usual = _usual(effect)
    sizes: Mapping[str, float] = {**usual.more, **usual.shape}
    return sizes.get(rule.name)


def _usual(effect: type[Effect]) -> Typical:
    return effect.typical or Typical({})


def _report(effect: type[Effect]) -> dict[str, Any]:
    """Return an effect for machines."""
    return {'name': effect.name, 'cause': effect.cause, 'scope': effect.scope.value,
            'site': effect.site.value, 'place': effect.place.name,
            'parameters': [
                {'name': rule.name, 'meaning': rule.meaning, 'unit': rule.unit, 'low': rule.low,
                 'high': rule.high, 'default': rule.default, 'typical': _typical(effect, rule),
                 'on_top': rule.name in _usual(effect).more} for rule in effect.declarations()]}

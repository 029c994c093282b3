"""What a node says when it is asked for --help: its parameters, from their declarations."""

from collections.abc import Iterator, Sequence
import textwrap

from .arm_node import ReportingNode

ASKING = ('-h', '--help')
WIDTH = 79


def help_text(name: str, kinds: Sequence[type[ReportingNode]]) -> str:
    """Return how an executable is used that runs nodes of these classes."""
    purpose = ' '.join(kind.PURPOSE for kind in kinds)
    head = [f'usage: {name} [--ros-args [-p PARAMETER:=VALUE]... [--params-file FILE]]', '',
            *textwrap.wrap(purpose, WIDTH), '', 'parameters:']
    parameters: dict[str, list[str]] = {}
    for kind in kinds:
        parameters.update((option, list(lines)) for option, lines in _parameters(kind))
    return '\n'.join([*head, *(line for lines in parameters.values() for line in lines), ''])


def _parameters(kind: type[ReportingNode]) -> Iterator[tuple[str, Iterator[str]]]:
    """Yield names and lines, texts before numbers."""
    for name, (default, meaning) in kind.OPTIONS.items():
        shown = default if isinstance(default, str) else str(default).lower()
        yield name, _lines(name, meaning, '' if isinstance(default, list) else shown)
    for group in kind.GROUPS:
        for rule in group.declarations():
            unit = f' {rule.unit}' if rule.unit else ''
            yield rule.name, _lines(
                rule.name, f'{rule.meaning}, {rule.low:g} to {rule.high:g}{unit}',
                f'{rule.default:g}')


def _lines(name: str, meaning: str, default: str) -> Iterator[str]:
    """Yield the lines of a parameter."""
    yield f'  {name}' + (f' (default {default})' if default else '')
    yield from textwrap.wrap(meaning, WIDTH, initial_indent=' ' * 6, subsequent_indent=' ' * 6)

"""Read what the comment of a constant says: its meaning, its unit and where it comes from."""

import ast
import re
from typing import NamedTuple

GROUP = '# Choices unless stated otherwise'
ORIGIN = re.compile(r' ?\((choice|layout|(?:choice|null|measured|source): [^()]+)\)')
UNIT = re.compile(r' ?\[([^\]]+)\]')


class Constant(NamedTuple):
    """One constant of judgement, as the table shows it."""

    names: tuple[str, ...]
    value: str
    unit: str
    meaning: str
    origin: str         # empty where the source states none


def comment_of(lines: list[str], node: ast.stmt) -> str:
    """Return what comments above and behind a statement say, but for the head of its group."""
    first = last = node.lineno - 1
    while lines[first - 1].startswith('# ') and not lines[first - 1].startswith(GROUP):
        first -= 1
    behind = (line.partition('  # ')[2] for line in lines[last:node.end_lineno])
    return ' '.join([*(line[2:] for line in lines[first:last]), *filter(None, behind)])


def origin_of_group(lines: list[str], number: int) -> str:
    """Return the origin that the head of a group states for a constant at a line."""
    while number > 1 and lines[number - 2].strip():
        number -= 1
        if lines[number - 1].startswith(GROUP):
            return 'choice'
    return ''


def constant_of(names: tuple[str, ...], value: str, comment: str, origin: str) -> Constant:
    """Return a constant by its comment, with the origin of its group if it states none itself."""
    own, unit = ORIGIN.search(comment), UNIT.findall(comment)
    meaning = UNIT.sub('', ORIGIN.sub('', comment))
    return Constant(names, value.strip('()'), unit[-1] if unit else '',
                    meaning.strip(' .,;:'), own[1] if own else origin)

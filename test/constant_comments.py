"""Read what the comment of a constant says: its meaning, its unit and where it comes from."""

import ast
import re
from typing import NamedTuple

# The head of a group: what kind its constants are of, and an origin of those that state none.
GROUP = re.compile(r'# (?:(Judgement|Numerics)(?:\.$|; choices\b)|Choices\b)')
ORIGIN = re.compile(r' ?\((choice|layout|(?:choice|null|measured|source): [^()]+)\)')
UNIT = re.compile(r' ?\[([^\]]+)\]')


class Constant(NamedTuple):
    """One constant of judgement, as the table shows it."""

    names: tuple[str, ...]
    value: str
    unit: str
    meaning: str
    origin: str         # empty where the source states none
    kind: str           # 'judgement' or 'numerics', empty where the source states none


def comment_of(lines: list[str], node: ast.stmt) -> str:
    """Return what comments above and behind a statement say, but for the head of its group."""
    first = last = node.lineno - 1
    while lines[first - 1].startswith('# ') and not GROUP.match(lines[first - 1]):
        first -= 1
    behind = (line.partition('  # ')[2] for line in lines[last:node.end_lineno])
    return ' '.join([*(line[2:] for line in lines[first:last]), *filter(None, behind)])


def stated_by_group(lines: list[str], number: int) -> tuple[str, str]:
    """Return the origin and the kind that the head of a group states for a constant at a line."""
    while number > 1 and lines[number - 2].strip():
        number -= 1
        head = GROUP.match(lines[number - 1])
        if head is not None:
            return 'choice' if 'hoices' in head[0] else '', (head[1] or '').lower()
    return '', ''


def constant_of(names: tuple[str, ...], value: str, comment: str, origin: str,
                kind: str = '') -> Constant:
    """Return a constant by its comment, with the origin of its group if it states none itself."""
    own, unit = ORIGIN.search(comment), UNIT.findall(comment)
    meaning = UNIT.sub('', ORIGIN.sub('', comment))
    return Constant(names, value.strip('()'), unit[-1] if unit else '',
                    meaning.strip(' .,;:'), own[1] if own else origin, kind)

"""
Write docs/constants.md: every number that a judgement uses, with its meaning, origin and tests.

The table is read from the source. A constant is a number in capitals at the top level of a module
that judges. Its comment states its meaning, its unit in brackets, and in parentheses where the
number comes from: `(choice)`, or `(null: ...)`, `(measured: ...)`, `(source: ...)` with words. A
comment `Choices unless stated otherwise` speaks for all constants down to the next blank line.
Where a diagnosis judges, such a head says as well of which kind they are, `Judgement; choices
unless stated otherwise` or `Numerics; ...`, and `Judgement.` where each states its origin.
Positions in an array are marked `(layout)` and are no constants.
"""

import ast
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from constant_comments import comment_of, Constant, constant_of, stated_by_group
import hypothesis_table
from project_files import files, PACKAGES, ROOT
from project_imports import IMPORTS, PATHS

PAGE = ROOT / 'docs' / 'constants.md'

# Folders whose modules judge, and single modules that do, wherever they lie.
FOLDERS = {'calibrate', 'diagnosis', 'least_squares', 'planning'}
MODULES = {
    'belief', 'closed_loop', 'contact', 'controller', 'conventions', 'coupling', 'estimator',
    'followable', 'fusion', 'gaps', 'learning', 'loop_stability', 'momentum', 'payload',
    'recording_facts', 'reference', 'route_health', 'sample_judge', 'sample_limits',
    'significance', 'slips', 'stamp_order', 'standstill', 'tip_force'}

# Where constants state their kind.
TOLD_APART = {'diagnosis', 'significance'}

NUMPY = {'np.arange', 'np.geomspace', 'np.linspace'}
MOST_TESTS = 3
COMMAND_LINE = f'{PACKAGES[-1]}.cli'      # imports commands by their names
COLUMNS = ('| constant | value | meaning | origin | tests |\n|---|---|---|---|---|\n',
           '| constant | kind | value | meaning | origin | tests |\n|---|---|---|---|---|---|\n')

HEAD = """# Constants

Written by `make docs` from the comments in the source. Tests are those that name the constant.
Where none does, they bear the name of its module, or are nearest in the chain of imports.
Origins are of four kinds:

- **null**: simulated or counted where nothing is wrong;
- **measured**: seen on simulated arms with a known truth, or on real arms;
- **source**: a formula, a standard or a paper;
- **choice**: a plain choice for the purpose that the meaning states; no experiment set the number.

Constants of a diagnosis are of two kinds, {judgement} of judgement and {numerics} of numerics:

- **judgement**: decides whether something is named or taken back, how sure it is, or what a rest
  follows;
- **numerics**: how that is computed and shown, like widths of filters, numbers of samples,
  rounds of a fit, and how robots move.

Thresholds that effects declare have a [table of their own](#effects).
"""


def judging() -> list[str]:
    """Return the names of the modules that judge, in the order of the table."""
    return [name for name in sorted(PATHS) if name.startswith(PACKAGES[-1])
            and (FOLDERS.intersection(name.split('.')) or name.split('.')[-1] in MODULES)]


def tells_kinds(module: str) -> bool:
    """Return whether the constants of a module state their kind."""
    return bool(TOLD_APART.intersection(module.split('.')))


def constants(text: str) -> Iterator[Constant]:
    """Yield the constants of one module's source."""
    lines = text.split('\n')
    for node in ast.parse(text).body:
        if not isinstance(node, ast.Assign):
            continue
        names = tuple(ast.unparse(part)
                      for part in getattr(node.targets[0], 'elts', node.targets))
        if all(name.isupper() for name in names) and _is_constant(names, node.value):
            constant = constant_of(names, ast.unparse(node.value), comment_of(lines, node),
                                   *stated_by_group(lines, node.lineno))
            if constant.origin != 'layout':
                yield constant


def _is_constant(names: tuple[str, ...], value: ast.expr) -> bool:
    """Return whether a value is one number or several; whole ones for several names are places."""
    if len(names) > 1:
        parts = getattr(value, 'elts', [])
        return any(type(getattr(part, 'value', None)) is float for part in parts)
    return _is_number(value)


def _is_number(value: ast.expr) -> bool:
    """Return whether an expression is a number, a few of them, or worked out of numbers alone."""
    match value:
        case ast.Constant(value=number):
            return type(number) in (int, float)
        case ast.UnaryOp(operand=number):
            return _is_number(number)
        case ast.BinOp(left=left, right=right):
            return _is_number(left) and _is_number(right)
        case ast.Tuple(elts=parts):
            return bool(parts) and all(map(_is_number, parts))
        case ast.Call(func=function, args=parts):
            return ast.unparse(function) in {*NUMPY, 'math.log'} and all(map(_is_number, parts))
    return ast.unparse(value) in {'math.pi', 'np.pi'}


def uses(path: Path) -> dict[str, set[str]]:
    """Return the modules that a test imports, and what it takes or names of each."""
    tree, used = ast.parse(path.read_text()), dict[str, set[str]]()
    named = {node.attr for node in ast.walk(tree) if isinstance(node, ast.Attribute)}
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            for alias in node.names:
                used.setdefault(node.module or '', set()).add(alias.name)
                used.setdefault(f'{node.module}.{alias.name}', set()).update(named)
    return used


def tests_near(module: str, tests: dict[str, dict[str, set[str]]]) -> list[str]:
    """Return the tests that bear a module's name, or import it, or are nearest to it."""
    near, seen = {module}, {module}
    while near:
        found = [test for test, used in tests.items() if near.intersection(used)]
        if found:
            own = [test for test in found if module.rpartition('.')[2] in test]
            return own or found
        near = {name for name, used in IMPORTS.items() if near.intersection(used)} - seen
        if any('.commands.' in name for name in near):
            near.add(COMMAND_LINE)
        seen |= near
    return []


def rows() -> Iterator[tuple[str, Constant, list[str]]]:
    """Yield each module that judges with each of its constants and the tests of that."""
    tests = {path.stem: uses(path) for path in files('test_*.py', ROOT / 'test')}
    for module in judging():
        nearest = tests_near(module, tests)
        for constant in constants(PATHS[module].read_text()):
            naming = [test for test, used in tests.items()
                      if used.get(module, set()).intersection(constant.names)]
            yield module, constant, naming or nearest


def page() -> str:
    """Return docs/constants.md."""
    found, last = list(rows()), ''
    kinds = Counter(constant.kind for _, constant, _ in found)
    parts = [HEAD.format(judgement=kinds['judgement'], numerics=kinds['numerics'])]
    for module, constant, tests in found:
        told = tells_kinds(module)
        if module != last:
            parts.append(f'\n## `{module.partition(".")[2]}`\n\n{COLUMNS[told]}')
            last = module
        more = ' and more' if len(tests) > MOST_TESTS else ''
        cells = (', '.join(f'`{name}`' for name in constant.names),
                 *([constant.kind] if told else []), f'{constant.value} {constant.unit}'.strip(),
                 constant.meaning, constant.origin,
                 ', '.join(f'`{test}`' for test in tests[:MOST_TESTS]) + more)
        parts.append('| ' + ' | '.join(cell.replace('|', r'\|') for cell in cells) + ' |\n')
    return ''.join([*parts, hypothesis_table.section()])


if __name__ == '__main__':
    PAGE.write_text(page())

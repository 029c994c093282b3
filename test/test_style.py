"""The house style that no linter knows, and the linters of ROS."""

import ast
from collections.abc import Iterator
from pathlib import Path
import re
import subprocess
import sys
import tokenize

from project_files import files, PACKAGES, python_roots, ROOT
import pytest

MODULE_LINES = 400
BODY_LINES = 45
ARGUMENTS = 7           # beside self
UNFINISHED = re.compile(r'\b(noqa|TODO|FIXME|XXX)\b|type: ignore(?!\[)')
SAYS_NOTHING = {'data', 'helper', 'helpers', 'info', 'manager', 'misc', 'util', 'utils'}

# A path of somebody's machine, or the host of a package registry.
OF_ONE_MACHINE = re.compile(r'(?<![\w.])/(?:work|root|home|Users)/\w|\bpypi\.org|\bpythonhosted\.')

# Say named, estimated, distinguished, explained, shown (docs/style.md); few places mean speech.
TELLS = re.compile(r'(?<![a-z])(?:told|tell|tells|telling)(?![a-z])', re.IGNORECASE)
FEW = 100

SOURCES = list(files('*.py'))
TREES = {path: ast.parse(path.read_text()) for path in SOURCES}


def tokens(path: Path, kind: int) -> Iterator[tuple[str, str]]:
    """Yield each token of one kind and where it stands."""
    with path.open('rb') as source:
        for token in tokenize.tokenize(source.readline):
            if token.type == kind:
                yield token.string, f'{path.relative_to(ROOT)}:{token.start[0]}'


def body_lines(function: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """Return the number of lines below the signature's first line and the docstring."""
    first = function.body[0].end_lineno if ast.get_docstring(function) else function.lineno
    return (function.end_lineno or 0) - (first or 0)


def arguments(signature: ast.arguments) -> list[str]:
    """Return the names of the arguments of a function, of a method without the object."""
    found = [*signature.posonlyargs, *signature.args, signature.vararg, *signature.kwonlyargs,
             signature.kwarg]
    return [one.arg for one in found if one and one.arg not in ('self', 'cls')]


def test_sources_are_found():
    assert ROOT / 'setup.py' in SOURCES
    assert {path.relative_to(ROOT).parts[0] for path in SOURCES} >= {*PACKAGES, 'test'}


def test_modules_are_short():
    lines = {str(path.relative_to(ROOT)): path.read_text().count('\n') for path in SOURCES}
    assert {name: n for name, n in lines.items() if n > MODULE_LINES} == {}


def test_functions_are_short():
    lines = {
        f'{path.relative_to(ROOT)}:{node.lineno} {node.name}': body_lines(node)
        for path, tree in TREES.items() for node in ast.walk(tree)
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef))}
    assert {name: n for name, n in lines.items() if n > BODY_LINES} == {}


def test_functions_take_few_arguments():
    taken = {f'{path.relative_to(ROOT)}:{node.lineno}': len(arguments(node.args))
             for path, tree in TREES.items() for node in ast.walk(tree)
             if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda))}
    assert {name: n for name, n in taken.items() if n > ARGUMENTS} == {}


def test_no_comment_silences_a_check_or_defers_work():
    assert [(text, place) for path in SOURCES for text, place in tokens(path, tokenize.COMMENT)
            if UNFINISHED.search(text)] == []


def test_no_type_is_found_by_trying_its_attributes():
    assert [f'{path.relative_to(ROOT)}:{node.lineno}'
            for path, tree in TREES.items() for node in ast.walk(tree)
            if isinstance(node, ast.Name) and node.id == 'hasattr'] == []


def test_a_class_name_stands_for_one_thing():
    homes: dict[str, list[str]] = {}
    for path, tree in TREES.items():
        name = str(path.relative_to(ROOT))
        for node in ast.walk(tree) if name.startswith(PACKAGES) else ():
            if isinstance(node, ast.ClassDef):
                homes.setdefault(node.name, []).append(f'{name}:{node.lineno}')
    assert len(homes) > 300
    assert {name: places for name, places in homes.items() if len(places) > 1} == {}


def test_words_of_the_field_are_used():
    found = {str(path.relative_to(ROOT)): len(TELLS.findall(path.read_text()))
             for path in SOURCES if str(path.relative_to(ROOT)).startswith(PACKAGES)}
    assert sum(found.values()) < FEW, {name: n for name, n in found.items() if n}


def test_names_can_be_typed_on_any_keyboard():
    assert [(text, place) for path in SOURCES for text, place in tokens(path, tokenize.NAME)
            if not text.isascii()] == []


def test_module_names_say_what_is_inside():
    assert [path for path in SOURCES if path.stem.split('_')[-1] in SAYS_NOTHING] == []


def test_tests_that_share_nothing_go_where_there_is_time(request):
    assert request.node.get_closest_marker('xdist_group') is None


def test_nothing_points_at_one_machine():
    texts = {path: path.read_text(errors='ignore') for path in files()}
    assert [(str(path.relative_to(ROOT)), found.group())
            for path, text in texts.items() for found in OF_ONE_MACHINE.finditer(text)] == []


@pytest.mark.linter
@pytest.mark.parametrize('rules', ['ament_flake8', 'ament_pep257'])
def test_rules_of_ros(rules):
    """In a process of its own: flake8 forks, which threads of ROS and numba do not survive."""
    pytest.importorskip(rules)
    checked = subprocess.run([sys.executable, '-m', f'{rules}.main', *python_roots()],
                             cwd=ROOT, capture_output=True, text=True)
    assert checked.returncode == 0, checked.stdout.partition('Checked files')[0] + checked.stderr

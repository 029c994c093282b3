"""docs/model.md says what the code does: same effects, same parameters, same equations."""

import ast
from pathlib import Path
import re

from hda_arm_sim.model.effects import EFFECTS, Scope
from project_files import files, ROOT
import pytest

TEXT = (ROOT / 'docs' / 'model.md').read_text()
SECTIONS = {part.split('`')[0]: part.split('\n## ')[0]
            for part in TEXT.split('\n### `')[1:]}
LABEL = re.compile(r'\\qquad \\text\{\(eq:([a-z0-9-]+)\)\} \$\$')
EQUATIONS = [name for page in files('*.md', ROOT / 'docs')
             for name in LABEL.findall(page.read_text())]
CITED = re.compile(r'\(eq:([^()]*)\)')
PAPER = ROOT / 'hda_torque_estimator' / 'reproduction'      # cites the paper's own numbers


def named(parts):
    """Return the names in code quotes, in order, without repetition."""
    return list(dict.fromkeys(re.findall(r'`(\w+)`', parts)))


def docstrings(path):
    """Yield every docstring of a module."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef)):
            yield ast.get_docstring(node) or ''


def cited(text):
    """Return the names of equations that a text cites."""
    return {name for names in CITED.findall(text) for name in re.split(r', | to ', names)}


def pages_and_sources():
    """Yield every file that may cite an equation."""
    yield from (path for kind in ('*.md', '*.py', '*.rst') for path in files(kind)
                if path != Path(__file__))


def test_every_equation_has_a_name_of_its_own():
    assert len(EQUATIONS) == len(set(EQUATIONS))
    for page in ('model.md', 'estimation.md'):
        text = (ROOT / 'docs' / page).read_text()
        assert text.count('$$') == 2 * len(LABEL.findall(text))


def test_every_equation_that_is_cited_exists():
    unknown = {str(path.relative_to(ROOT)): cited(path.read_text()) - set(EQUATIONS)
               for path in pages_and_sources()}
    assert {name: names for name, names in unknown.items() if names} == {}


def test_a_range_of_equations_is_in_the_order_of_the_document():
    assert [(first, last) for path in pages_and_sources()
            for first, last in re.findall(r'\beq:([a-z0-9-]+) to ([a-z0-9-]+)', path.read_text())
            if EQUATIONS.index(first) >= EQUATIONS.index(last)] == []


def test_no_equation_of_the_model_is_cited_by_its_place():
    assert [(str(path.relative_to(ROOT)), place)
            for package in ('hda_arm_sim', 'hda_torque_estimator')
            for path in files('*.py', ROOT / package) if PAPER not in path.parents
            for text in docstrings(path)
            for place in re.findall(r'(?<![\w)\]}])\([FP]?\d{1,2}(?:-[FP]?\d+)?\)', text)
            if 'paper' not in text] == []


def test_every_section_that_is_cited_exists():
    headings = {(page.name, re.sub(r'[^a-z0-9_ -]', '', line.lower()).strip().replace(' ', '-'))
                for page in files('*.md', ROOT / 'docs')
                for line in re.findall('^#+ (.*)', page.read_text(), re.MULTILINE)}
    cited_sections = {found for path in files('*.py', ROOT) for found in
                      re.findall(r'docs/(\w+\.md)#([a-z_-]+)', path.read_text())}
    assert cited_sections
    assert cited_sections - headings == set()


def test_every_equation_of_an_effect_is_cited_by_its_module():
    equations = {name for effect in EFFECTS for name in LABEL.findall(SECTIONS[effect.name])}
    laws = set().union(*(cited(path.read_text())
                         for path in files('*.py', ROOT / 'hda_arm_sim' / 'model')))
    assert equations <= laws


def test_every_effect_has_a_section_and_every_section_an_effect():
    assert set(SECTIONS) == {effect.name for effect in EFFECTS}


@pytest.mark.parametrize('effect', EFFECTS, ids=lambda effect: effect.name)
def test_a_section_says_all_that_is_asked(effect):
    section = SECTIONS[effect.name]
    assert LABEL.search(section)
    for line in ('Parameters', 'Source, size', 'Shows', 'Alike'):
        assert f'- **{line}**' in section
    line = re.search(r'- \*\*Parameters\*\* \((\w+), (\w+)\): (.*)', section)
    assert line is not None
    assert line[1] == ('arm' if effect.scope is Scope.ARM else 'joint')
    assert line[2] == effect.site.value
    assert {rule.name for rule in effect.declarations()} <= set(named(line[3]))


@pytest.mark.parametrize('effect', EFFECTS, ids=lambda effect: effect.name)
def test_a_section_takes_only_effects_of_the_catalogue_for_alike(effect):
    names = {other.name for other in EFFECTS}
    alike = re.search(r'- \*\*Alike\*\*: (.*)', SECTIONS[effect.name])
    assert alike is not None
    assert set(named(alike[1])) <= names - {effect.name}


def test_units_of_parameters_stand_in_the_sections():
    signs = {'N*m': 'N·m', 'N*m/rad': 'N·m/rad', 'N*m*s/rad': 'N·m·s/rad', '1/kg': '1/kg',
             'rad/(N*m)': 'rad/(N·m)', '1/(N*m)': '1/(N·m)'}
    missing = [(effect.name, rule.unit) for effect in EFFECTS for rule in effect.declarations()
               if rule.unit and not rule.unit.endswith('turn')
               and f'[{signs.get(rule.unit, rule.unit)}' not in SECTIONS[effect.name]]
    assert missing == []

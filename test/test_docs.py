"""docs/model.md says what the code does: same effects, same parameters, same equation numbers."""

import ast
import re

from hda_arm_sim.model.effects import EFFECTS, Scope
from project_files import files, ROOT
import pytest

TEXT = (ROOT / 'docs' / 'model.md').read_text()
SECTIONS = {part.split('`')[0]: part.split('\n## ')[0]
            for part in TEXT.split('\n### `')[1:]}
EQUATIONS = [int(number) for number in re.findall(r'\\qquad \((\d+)\) \$\$', TEXT)]
CITED = re.compile(r'\((\d+)(?:\)?-\(?(\d+))?\)')
CITED_AT_TOP = re.compile(r'docs/model\.md, (\d+)(?:-(\d+))?')


def named(parts):
    """Return the names in code quotes, in order, without repetition."""
    return list(dict.fromkeys(re.findall(r'`(\w+)`', parts)))


def docstrings(path):
    """Yield every docstring of a module."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef)):
            yield ast.get_docstring(node) or ''


def cited(path):
    """Return the equation numbers that a module's docstrings cite."""
    texts = list(docstrings(path))
    pairs = [pair for text in texts for pair in CITED.findall(text)]
    pairs += CITED_AT_TOP.findall(texts[0])
    return {int(number) for pair in pairs for number in pair if number}


def test_equations_are_numbered_in_order():
    assert list(range(1, len(EQUATIONS) + 1)) == EQUATIONS


def test_every_reference_inside_the_document_exists():
    cited_numbers = {int(number) for number in re.findall(r'(?<![\w}])\((\d{1,2})\)', TEXT)}
    assert cited_numbers <= set(EQUATIONS)


@pytest.mark.parametrize('package', ['hda_arm_sim', 'hda_torque_estimator'])
def test_every_equation_that_code_cites_exists(package):
    modules = [path for path in files('*.py', ROOT / package)
               if 'docs/model.md' in path.read_text()]
    assert modules
    unknown = {str(path.relative_to(ROOT)): cited(path) - set(EQUATIONS) for path in modules}
    assert {name: numbers for name, numbers in unknown.items() if numbers} == {}


def test_every_equation_of_an_effect_is_cited_by_its_module():
    equations = {int(number) for effect in EFFECTS
                 for number in re.findall(r'\((\d+)\) \$\$', SECTIONS[effect.name])}
    laws = set().union(*(cited(path) for path in files('*.py', ROOT / 'hda_arm_sim' / 'model')))
    assert equations <= laws


def test_every_effect_has_a_section_and_every_section_an_effect():
    assert set(SECTIONS) == {effect.name for effect in EFFECTS}


@pytest.mark.parametrize('effect', EFFECTS, ids=lambda effect: effect.name)
def test_a_section_says_all_that_is_asked(effect):
    section = SECTIONS[effect.name]
    assert re.search(r'\\qquad \(\d+\) \$\$', section)
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
             'rad/(N*m)': 'rad/(N·m)'}
    missing = [(effect.name, rule.unit) for effect in EFFECTS for rule in effect.declarations()
               if rule.unit and not rule.unit.endswith('turn')
               and f'[{signs.get(rule.unit, rule.unit)}' not in SECTIONS[effect.name]]
    assert missing == []

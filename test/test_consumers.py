"""No consumer names an effect: it reads what effects declare, and loops over their places."""

import ast
from collections.abc import Iterator
from dataclasses import replace
from fnmatch import fnmatch
import re

from hda_arm_sim.foundation.parameter import ParameterError
from hda_arm_sim.model.effects import EFFECTS, Scope
from hda_arm_sim.model.effects.catalogue import known_as, sole_at, unmeasured_at
from hda_arm_sim.model.effects.place import DRAG, PLAY
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.model.parts import Base, Joint, Tolerances
from project_files import PACKAGES
from project_imports import PATHS
import pytest

HOME = 'hda_arm_sim.model.effects'
DECLARING = {'catalogue', 'effect', 'hypothesis', 'place', 'words'}     # modules without effects
NAMES = {effect.name for effect in EFFECTS}
CLASSES = {effect.__name__ for effect in EFFECTS}
# Numbers of a joint in the arm file whose names effects bear too, and tolerances.
OF_THE_ARM = NAMES & {rule.name for part in (Joint, Tolerances) for rule in part.declarations()}

# Who names effects all the same, which ones, and why.
ANY = frozenset(NAMES | CLASSES)
ALLOWED: dict[str, tuple[frozenset[str], str]] = {
    'hda_torque_estimator.diagnosis.readings.*': (
        ANY, 'detectors of raw readings: each looks for one effect, before any balance'),
    'hda_torque_estimator.diagnosis.detectability.excitation': (
        ANY, 'the smallest sizes that those detectors could have shown'),
    'hda_torque_estimator.reproduction.*': (
        ANY, "the paper's rig, built with the imperfections that the paper names"),
    'hda_torque_estimator.commands.diagnose_command': (
        frozenset({'backlash'}), 'an example of the command line'),
    'hda_torque_estimator.commands.effects_command': (
        frozenset({'backlash', 'torsional_hysteresis'}), 'an example of the command line'),
    'hda_torque_estimator.commands.plan_command': (
        frozenset({'backlash', 'cable_spring', 'payload'}), 'examples of the command line'),
    'hda_torque_estimator.commands.calibrate_command': (
        frozenset({'payload'}), 'an option: what the user hung at the tip'),
    'hda_torque_estimator.calibrate.passages.stated_conditions': (
        frozenset({'payload'}), 'that option'),
    'hda_torque_estimator.calibrate.passages.suitability': (
        frozenset({'payload'}), 'a word of a sentence'),
    'hda_torque_estimator.calibrate.run': (frozenset({'payload'}), 'a word of a sentence'),
    'hda_torque_estimator.estimating.*': (
        frozenset({'payload'}), 'an estimate: the mass that seems to hang at the tip'),
    'hda_torque_estimator.live.scene': (frozenset({'payload'}), 'that estimate'),
}
JOINT = read_arm('hda_arm.yaml').joints[0]
LATE = replace(JOINT, link_encoder=replace(JOINT.link_encoder, sampling_time=1e-4))
CONSUMERS = [name for name in PATHS if name.startswith(PACKAGES[1:])
             and not name.startswith(HOME + '.') and name != HOME]


def prose(tree: ast.AST) -> set[int]:
    """Return the docstrings of a module, by their identity: they may speak of effects."""
    bodies = (node.body for node in ast.walk(tree) if isinstance(
        node, (ast.Module, ast.ClassDef, ast.FunctionDef)))
    return {id(body[0].value) for body in bodies if body and isinstance(body[0], ast.Expr)}


def of_the_arm(node: ast.Attribute, inner: set[int]) -> bool:
    """Return whether an attribute is a number of the arm, of which nothing is asked further."""
    return node.attr in OF_THE_ARM and id(node) not in inner


def named(source: str) -> Iterator[tuple[int, str]]:
    """Yield where a module names an effect, and which: by class, text or field of a record."""
    tree = ast.parse(source)
    said = prose(tree)
    inner = {id(node.value) for node in ast.walk(tree)
             if isinstance(node, (ast.Attribute, ast.Subscript))}
    for node in ast.walk(tree):
        match node:
            case ast.ImportFrom(module=str(module), names=names) if 'effects' in module.split('.'):
                within = module.rpartition('effects')[2].strip('.')
                yield from ((node.lineno, one.name) for one in names if one.name in CLASSES
                            or within and within not in DECLARING)
            case ast.Constant(value=str(text)) if id(node) not in said and not (
                    text in OF_THE_ARM and id(node) not in inner):
                yield from ((node.lineno, one) for one in re.findall(r'[a-z_]+', text)
                            if one in NAMES)
            case ast.Attribute(attr=name) if name in NAMES and not of_the_arm(node, inner):
                yield node.lineno, name
            case ast.keyword(arg=str(name)) if name in NAMES:
                yield node.value.lineno, name
            case ast.Subscript(slice=ast.Constant(value=str(name))) if name in NAMES & OF_THE_ARM:
                yield node.lineno, name


FOUND = {module: [*named(PATHS[module].read_text())] for module in CONSUMERS}


def reasons(module: str) -> set[str]:
    """Return the effects that a module may name."""
    return {name for pattern, (names, _) in ALLOWED.items() if fnmatch(module, pattern)
            for name in names}


def test_no_consumer_names_an_effect():
    assert {f'{module}:{line}': name for module in CONSUMERS for line, name in FOUND[module]
            if name not in reasons(module)} == {}


@pytest.mark.parametrize('pattern', ALLOWED)
def test_who_may_name_an_effect_does(pattern):
    found = {name for module in CONSUMERS if fnmatch(module, pattern) for _, name in FOUND[module]}
    names, why = ALLOWED[pattern]
    assert why and found and (names == ANY or found >= names)


@pytest.mark.parametrize('source', [
    "arm.effect('backlash', label)", 'joint.backlash.half_width', "it['backlash']['half_width']",
    "found('payload.mass')", 'from hda_arm_sim.model.effects import Backlash',
    'from .effects.friction import bristle_after', 'joint.viscous_friction.slope',
    "joints['viscous_friction']['slope']", 'thing(backlash=1.0)'])
def test_a_name_is_seen_wherever_it_stands(source):
    assert [*named(source)]


@pytest.mark.parametrize('source', [
    '"""Speak of backlash."""', 'known.kinematic_error', "known_as('viscous_friction')",
    'from hda_arm_sim.model.effects.place import PLAY', 'from .effects import Effect, Scope',
    'from hda_arm_sim.model.effects.catalogue import sole_at'])
def test_what_reads_a_declaration_names_nothing(source):
    assert [*named(source)] == []


@pytest.mark.parametrize('asked, message', [
    (lambda: sole_at(DRAG), 'place for one effect, got viscous'),
    (lambda: unmeasured_at(PLAY), 'looks for one effect at play, got none'),
    (lambda: known_as('rust'), "no effect is known by the tolerance 'rust'")])
def test_a_place_or_tolerance_of_no_single_effect_is_refused(asked, message):
    with pytest.raises(ParameterError, match=message):
        asked()


@pytest.mark.parametrize('effect', EFFECTS, ids=lambda effect: effect.name)
def test_what_an_effect_declares_of_its_numbers_it_has(effect):
    names = {rule.name for rule in effect.declarations()}
    assert names >= {*effect.stated, *(effect.hypothesis.stands if effect.hypothesis else ())}
    part = Base(tilt=0.1) if effect.scope is Scope.ARM else LATE
    assert part.nominal(effect).is_neutral() == (not effect.stated)
    if effect.unmeasured is not None:
        assert {number.partition('_')[0] for number in names} >= {
            number.partition('_')[0] for number in effect.unmeasured.sigma}
        assert names >= {*effect.unmeasured.usual}


def test_every_tolerance_that_an_effect_has_finds_it():
    for effect in EFFECTS:
        if effect.known_by:
            assert known_as(effect.known_by.tolerance) is effect
            assert {rule.name for rule in effect.declarations()} >= {*effect.known_by.numbers}
            assert Tolerances.declaration(effect.known_by.tolerance)

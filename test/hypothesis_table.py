"""
Write the last parts of docs/constants.md: what is forgiven an effect, and how it scatters.

A field of `Hypothesis` that judges has a comment with its origin in parentheses, as a constant
has. An effect that declares other values says why in a comment above its declaration.
"""

import ast
from collections.abc import Iterator
from dataclasses import fields
import inspect
import math
from pathlib import Path

from constant_comments import comment_of, constant_of
from hda_arm_sim.model.effects import EFFECTS
from hda_arm_sim.model.effects import hypothesis as declarations
from hda_arm_sim.model.effects.effect import Effect
from hda_arm_sim.model.effects.hypothesis import Hypothesis

HEAD = """
## Effects

Each effect declares how it is looked for (`hda_arm_sim/model/effects`). These thresholds are part
of the declaration. An effect that is not listed has the usual ones. `test_hidden_effects` and
`test_goodness_of_fit` rest on them.

| threshold | usual value | meaning | origin |
|---|---|---|---|
"""
DEPARTURES = """
| effect | instead of the usual value | origin |
|---|---|---|
"""


UNMEASURED = """
## Joints that nobody has measured

Numbers of effects scatter from joint to joint (`Unmeasured`). A calibration begins there, and so
do the tolerances that `hda new` writes. Each is one sigma: in its own unit, or on the logarithm
about a usual value, or relative to what the arm file states. `test_calibrate_bounds` and
`test_calibrate_real` rest on them.

| effect | one sigma | usual value | origin |
|---|---|---|---|
"""


def thresholds() -> Iterator[tuple[str, str, str]]:
    """Yield the name, meaning and origin of each field that judges."""
    text = Path(inspect.getsourcefile(declarations) or '').read_text()
    lines = [line.strip() for line in text.split('\n')]
    body = next(node.body for node in ast.parse(text).body
                if isinstance(node, ast.ClassDef) and node.name == Hypothesis.__name__)
    for node in body:
        if isinstance(node, ast.AnnAssign):
            name = ast.unparse(node.target)
            reported = constant_of((name,), '', comment_of(lines, node), '')
            if reported.origin:
                meaning = reported.meaning
                yield name, f'{meaning} [{reported.unit}]' if reported.unit else meaning, \
                    reported.origin


def usual(name: str) -> object:
    """Return the value of a threshold that most effects have."""
    return getattr(Hypothesis(), name)


def shown(value: object) -> str:
    """Return a threshold as text."""
    if isinstance(value, dict):
        return ', '.join(f'{number}: {share:g} {"of " * bool(whole)}{whole}'.strip()
                         for number, (share, whole) in value.items()) or 'none'
    return 'any' if value == math.inf else f'{value:g}'


def departures() -> Iterator[tuple[str, str, str]]:
    """Yield the effects that do not have the usual thresholds: name, those, their origin."""
    names = [name for name, _, _ in thresholds()]
    for effect in EFFECTS:
        own = effect.hypothesis
        if own is not None and (other := [
                f'`{name}` {shown(getattr(own, name))}' for name in names
                if getattr(own, name) != usual(name)]):
            yield effect.name, '; '.join(other), origin(effect)


def origin(effect: type[Effect], field: str = 'hypothesis') -> str:
    """Return what the comment on a declaration of an effect says of where it comes from."""
    text = inspect.getsource(effect)
    lines = [line.strip() for line in text.split('\n')]
    node = next(node for node in ast.walk(ast.parse(text))
                if isinstance(node, ast.AnnAssign) and ast.unparse(node.target) == field)
    return constant_of((field,), '', comment_of(lines, node), '').origin or 'choice'


def section() -> str:
    """Return the part of docs/constants.md on effects."""
    rows = [f'| `{name}` | {shown(usual(name))} | {meaning} | {whence} |\n'
            for name, meaning, whence in thresholds()]
    others = [f'| `{name}` | {other} | {whence} |\n' for name, other, whence in departures()]
    return ''.join([HEAD, *rows, DEPARTURES, *others, UNMEASURED, *scatters()])


def scatters() -> Iterator[str]:
    """Yield how each effect that a calibration looks for scatters, a row of a table each."""
    for effect in EFFECTS:
        if effect.unmeasured is not None:
            sigma, usual = ('; '.join(f'`{name}` {size:g}' for name, size in sizes.items())
                            for sizes in (effect.unmeasured.sigma, effect.unmeasured.usual))
            yield f'| `{effect.name}` | {sigma} | {usual} | {origin(effect, "unmeasured")} |\n'


def numeric_fields() -> set[str]:
    """Return the fields of a hypothesis that are numbers, all of which judge."""
    return {field.name for field in fields(Hypothesis) if isinstance(field.default, float)}

"""What can be hidden: an effect, its parameters, and how their sizes are drawn."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

Draw = Callable[[np.random.Generator, Mapping[str, float]], float]

Law = tuple[float, float, float]        # code of a form, and its two numbers

JOINTS = ('joint1', 'joint2')


class TruthError(ValueError):
    """Something that the truth cannot hide or record."""


@dataclass(frozen=True)
class Parameter:
    """
    A number of an effect: its unit, its value where nothing is hidden, and how it is drawn.

    Sizes at that value make an effect do nothing, whatever its shape.
    """

    name: str
    unit: str
    neutral: float
    draw: Draw
    is_size: bool


@dataclass(frozen=True)
class Effect:
    """
    Something a real arm has and the nominal one lacks.

    `site` is the balance it breaks, `coordinate` what the discrepancy depends on, `joints` where
    it can be hidden: empty for the arm as a whole.
    """

    name: str
    site: str
    coordinate: str
    parameters: tuple[Parameter, ...]
    joints: tuple[str, ...] = JOINTS


@dataclass(frozen=True)
class Hidden:
    """
    One effect with its sizes, on one joint or, where `joint` is None, on the arm.

    `form` names which of its laws it follows, `law` says so to compiled code (`forms.py`).
    """

    effect: str
    joint: str | None
    parameters: dict[str, float]
    site: str
    coordinate: str
    form: str = ''                  # of its law, '' for the one in README.md
    law: Law = (0.0, 0.0, 0.0)


def size(name: str, unit: str, neutral: float, draw: Draw) -> Parameter:
    """Return a parameter that says how strong an effect is."""
    return Parameter(name, unit, neutral, draw, is_size=True)


def shape(name: str, unit: str, default: float, draw: Draw) -> Parameter:
    """Return a parameter that says where, when or how an effect acts."""
    return Parameter(name, unit, default, draw, is_size=False)


def between(*ranges: tuple[float, float]) -> Draw:
    """Return a draw that is uniform in one of the ranges, all equally likely."""
    def draw(rng: np.random.Generator, drawn: Mapping[str, float]) -> float:
        low, high = ranges[rng.integers(len(ranges))]
        return float(rng.uniform(low, high))
    return draw


def either_sign(low: float, high: float) -> Draw:
    """Return a draw of a size between low and high, of either sign."""
    return between((low, high), (-high, -low))


def angle() -> Draw:
    """Return a draw of an angle or phase [rad]."""
    return between((-np.pi, np.pi))


def one_of(*values: float) -> Draw:
    """Return a draw of one of the values."""
    def draw(rng: np.random.Generator, drawn: Mapping[str, float]) -> float:
        return float(rng.choice(values))
    return draw

"""The numbers of links: how well those of a chain are known, and how one differs."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, ClassVar

import numpy as np

from .parts import Links
from ..foundation.arrays import Array
from ..foundation.chain import CONSTANTS, INERTIA, MASS, MOMENT
from ..foundation.parameter import Declared, parameter

_AXIS_INERTIA = INERTIA + 2     # of a link about its joint
_HALFWAY = 2.0          # lengths of a link per distance of its centre (choice: as of a rod)
_LINKS_KEPT = 1024      # links whose check is remembered: a fit makes thousands of arms of few


@dataclass(frozen=True)
class LinkTolerance(Declared):
    """How well the numbers of one link of a chain are known, one sigma."""

    name: ClassVar[str] = 'links.tolerances'
    mass: float = parameter(0.01, '', 0.0, 1.0, 'mass, moment and inertia together, relative')
    centre: float = parameter(0.0, 'm', 0.0, 1.0, 'each coordinate of the centre of mass')
    inertia: float = parameter(0.01, '', 0.0, 1.0, 'inertia about the own joint, relative')


def gyration(row: Array) -> float:
    """Return the radius of gyration of a link about its centre, 0 without mass [m]."""
    if row[MASS] <= 0.0:
        return 0.0
    spread = row[INERTIA:INERTIA + 3].sum() / 2.0 - (row[MOMENT:MOMENT + 3] ** 2).sum() / row[MASS]
    return float(np.sqrt(max(spread, 0.0) / row[MASS]))


def differ(row: Array, error: Any) -> None:
    """
    Change a link of a chain by its `link_inertia_error`, (eq:link-mass).

    Its mass grows with moment and inertia, its centre moves, the inertia about the joint grows.
    """
    row[:] = _differing(row.tobytes(), error)


def differing_pair(links: Links, errors: Sequence[Any]) -> Links:
    """
    Return two links in a plane, or one, with their errors, (eq:link-inertia, link-mass-plane).

    Where they do not feel each other joint 1 does not turn more with the second.
    """
    first, *others = errors
    p1 = first(nominal=links.p1 * (1.0 + first.mass))
    moment = links.first * (1.0 + first.mass)
    for second in others:
        before, p2 = links.p2, second(nominal=links.p2 * (1.0 + second.mass))
        more = second.mass * (_HALFWAY * links.p3 / links.length2 if links.p3 else 0.0)
        links = replace(links, p2=p2, p3=links.p3 * (1.0 + second.mass),
                        second=links.second * (1.0 + second.mass))
        p1 += links.coupled * (p2 - before + more * links.length1)
        moment += more
    return replace(links, p1=p1, first=moment)


@lru_cache(_LINKS_KEPT)
def _differing(constants: bytes, error: Any) -> Array:
    """Return a link of a chain with an error, from the bytes of its row."""
    row = np.frombuffer(constants).copy()
    row[MASS:CONSTANTS] *= 1.0 + error.mass
    moved = np.array([error.centre_x, error.centre_y, error.centre_z])
    if moved.any():
        before = row[MOMENT:MOMENT + 3].copy()
        row[MOMENT:MOMENT + 3] += row[MASS] * moved
        twice = np.outer(before, moved)
        far = twice + twice.T + row[MASS] * np.outer(moved, moved)
        more = np.trace(far) * np.eye(3) - far
        row[INERTIA:INERTIA + 6] += more[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
    row[_AXIS_INERTIA] = error(nominal=row[_AXIS_INERTIA])
    row.setflags(write=False)
    return row


@lru_cache(_LINKS_KEPT)
def is_definite(constants: bytes) -> bool:
    """Return whether every motion of a link takes energy, from the bytes of its row of a chain."""
    row = np.frombuffer(constants)
    (xx, yy, zz, xy, xz, yz), (x, y, z) = row[INERTIA:INERTIA + 6], row[MOMENT:MOMENT + 3]
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turning = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    whole = np.block([[turning, cross], [cross.T, row[MASS] * np.eye(3)]])
    return bool(np.linalg.eigvalsh(whole).min() > 0.0)

"""
Derivatives of balances without their noise: a fit that shrinks a balance gains nothing by it.

A balance of a softer spring and lighter links is the same balance, smaller, and its noise with it.
Plain least squares takes that for a better fit, and numbers run to the ends of their tolerances.
What of the columns of such numbers is noise (`column_noise`) changes no residual (eq:noiseless).
So it is with what the links carry, which is more of the same. A heavier link had an advantage of
its noise over a payload else.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
import numpy as np

from .nuisance import AnyTerm
from .steps import columns_of, Sized, sized
from ...least_squares.term import Term


class Slopes(NamedTuple):
    """Derivatives of a fit, without noise, and the noise of those of tolerated numbers."""

    columns: Array                      # (m, c, p) of all its terms
    noise: Mapping[Sized, Array]        # (m, c, p) of known numbers, and of what is carried

    def with_columns(self, columns: Array) -> 'Slopes':
        """Return other columns, whose noise is the same."""
        return self._replace(columns=columns)


def without(terms: Sequence[AnyTerm], columns: Array, noise: Mapping[Sized, Array]) -> Array:
    """Return the columns (m, c, p) of terms without what of them is noise."""
    if not any(has_noise(term, noise) for term in terms):
        return columns
    quiet = columns.copy('K')
    take_noise(terms, quiet, noise)
    return quiet


def take_noise(terms: Sequence[AnyTerm], columns: Array, noise: Mapping[Sized, Array]) -> None:
    """Take out of the columns (m, c, p) of terms what is noise: they change."""
    for term, own in columns_of(terms):
        if has_noise(term, noise):
            columns[:, :, own] -= noise[sized(term)]


def of_noise(term: AnyTerm, given: Arm, noise: Mapping[Sized, Array]) -> Array | float:
    """Return what of a term's step from the arm as `given` is noise (m, c) [N*m]."""
    if not has_noise(term, noise):
        return 0.0
    own = (replace(term, effect=given.effect(*term.place)) if isinstance(term, Term)
           else term.at(np.zeros(term.size)))
    loud = noise[sized(term)]
    return np.asarray((loud.reshape(-1, term.size) @ (term.vector() - own.vector())).reshape(
        loud.shape[:2]))


def has_noise(term: AnyTerm, noise: Mapping[Sized, Array]) -> bool:
    """Return whether the noise of a term's numbers is known."""
    return sized(term) in noise

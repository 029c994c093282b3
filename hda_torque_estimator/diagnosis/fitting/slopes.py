"""
Derivatives of balances without their noise: a fit that shrinks a balance gains nothing by it.

A balance of a softer spring and lighter links is the same balance, smaller, and its noise with it.
Plain least squares takes that for a better fit, and numbers run to the ends of their tolerances.
What of the columns of such numbers is noise (`column_noise`) changes no residual (eq:noiseless).
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
import numpy as np

from .nuisance import AnyTerm
from .steps import columns_of
from ...least_squares.term import Place, Term


class Slopes(NamedTuple):
    """Derivatives of a fit, without noise, and the noise of those of tolerated numbers."""

    columns: Array                      # (m, c, p) of all its terms
    noise: Mapping[Place, Array]        # (m, c, p) by the places of numbers with a tolerance

    def with_columns(self, columns: Array) -> 'Slopes':
        """Return other columns, whose noise is the same."""
        return self._replace(columns=columns)


def without(terms: Sequence[AnyTerm], columns: Array, noise: Mapping[Place, Array]) -> Array:
    """Return the columns (m, c, p) of terms without what of them is noise."""
    quiet = columns.copy('K')
    for term, own in columns_of(terms):
        if has_noise(term, noise):
            quiet[:, :, own] -= noise[term.place]
    return quiet


def of_noise(term: AnyTerm, given: Arm, noise: Mapping[Place, Array]) -> Array | float:
    """Return what of a term's step from the arm as `given` is noise (m, c) [N*m]."""
    if not has_noise(term, noise):
        return 0.0
    own = (replace(term, effect=given.effect(*term.place)) if isinstance(term, Term)
           else term.at(np.zeros(term.size)))
    return np.asarray(noise[term.place] @ (term.vector() - own.vector()))


def has_noise(term: AnyTerm, noise: Mapping[Place, Array]) -> bool:
    """Return whether the noise of a term's numbers is known, all of which have a tolerance."""
    return term.place in noise and noise[term.place].shape[2] == term.size

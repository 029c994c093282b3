"""
Whether the causes that were found are backed: nothing is named on a rest that none explains.

A wrong cause takes the place of the right one and leaves a part of what it cannot describe. So a
channel in which much more is left than noise, and more than the accepted laws may leave as one
form of several (`Hypothesis.form_error`), takes back every cause that rests on it.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .fit import Fit, Fitter
from .hypotheses import HYPOTHESES
from .search import Found
from .term import Term

Array = NDArray[np.float64]
REST = 2.5              # rms left beside noise, in rms of noise, that asks for an explanation


class Backing(NamedTuple):
    """What was found, judged by what it leaves."""

    backed: tuple[Term, ...]            # accepted causes that may be named
    unexplained: NDArray[np.bool_]      # (c,) channels in which something has no name


def backing(fitter: Fitter, found: Found, misplaced: Sequence[Term] = ()) -> Backing:
    """
    Return which accepted causes are backed, and where something is unexplained.

    Causes that are `misplaced` are not: what they explain has another site. Causes may cancel
    each other, so each counts with no more power than was wrong at first.
    """
    fitter = Fitter(fitter.balancer, fitter.arm, fitter.noise, fitter.effective,
                    np.ones_like(fitter.rows))                      # held-out stretches as well
    noise = fitter.noise ** 2
    fit = fitter.at(found.last.terms, len(found.last.accepted), found.last.columns)
    powers = [_explained(fitter, fit, term) for term in fit.accepted]
    allowed = sum((HYPOTHESES[term.name].form_error * np.minimum(power, found.first.variance)
                   for term, power in zip(fit.accepted, powers)), np.zeros_like(noise))
    unexplained = fit.variance - noise > REST ** 2 * noise + allowed
    for term in misplaced:
        unexplained[fitter.own_channels(term.joint)] = True
    backed = tuple(term for term, power in zip(fit.accepted, powers)
                   if not (unexplained & (power > REST ** 2 * noise)).any())
    return Backing(backed, unexplained)


def _explained(fitter: Fitter, fit: Fit, term: Term) -> Array:
    """Return the power (c,) that is in the channels when one cause is taken away [N^2*m^2]."""
    without = fitter.at([other for other in fit.terms if other is not term],
                        len(fit.accepted) - 1, fit.columns)
    return np.maximum(without.variance - fit.variance, 0.0)

"""
The best other cause, and by how much it explains less.

Fits are compared as if all made as much noise (`equal_noise`), and in the forms of their laws
that fit best (`law_forms`). A form is a product of curves and not quite exact, so a part of what
it improves says nothing. Where the laws as they are speak for the other cause, a lead that forms
have is the less by that. Effects of the command act on the noise of the encoders that it repeats,
and the balances have the same noise. At high frequency it speaks for one of two such effects
whatever the truth. They are compared where a motion has more.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .equal_noise import equal_noise_score, noise_in
from .law_forms import evidence, formed_gain
from .low_frequency import gain_below
from .screening import Prospect
from .selection_criteria import freedom
from ..fitting.fit import Fit, Fitter
from ..fitting.hypotheses import HYPOTHESES
from ...least_squares.term import Term
from ...significance import HARDLY


class Lead(NamedTuple):
    """The leading fit, and the best other cause in the place of its last one."""

    fit: Fit
    other: Term | None
    gap: float              # score that the other lacks
    more: float = 0.0       # score by which it costs less, where both laws are as they are


def leading(fitter: Fitter, fit: Fit, exact: Sequence[Fit],
            prospects: Sequence[Prospect]) -> Lead:
    """
    Return the leading of `exact` fits beyond `fit`, the best other cause, and what that lacks.

    The score is that of an equal noise and of the best forms of the laws. Of two effects of the
    command it is what distinguishes them. Where one fit is left, its runner-up is the best
    prospect.
    """
    if len(exact) > 1:
        plain = _plain_costs(fitter, fit, exact)
        costs = _in_best_forms(fitter, plain, exact)
        first, second = np.argsort(costs)[:2]
        best, other, lack = exact[first], exact[second], costs[second] - costs[first]
        # (measured: the harmonic of a disc as a form lacked 6 % of what the exact one explained)
        unsure = HARDLY * max(_own_forms(fitter, each) for each in (best, other))
        lack = max(lack - unsure - max(plain[first] - plain[second], 0.0), 0.0)
        below = min(HYPOTHESES[each.accepted[-1].name].below for each in (best, other))
        if np.isfinite(below):
            lack = gain_below(fitter, other, best, below)
        if lack < 0.0:
            best, other, lack = other, best, -lack
        return Lead(best, other.accepted[-1], lack, cost(fitter, best) - cost(fitter, other))
    best = exact[0]
    others = [prospect for prospect in prospects
              if prospect.term.place != best.accepted[-1].place]
    if not others:
        return Lead(best, None, np.inf)
    return Lead(best, others[0].term, others[0].score - best.score)


def cost(fitter: Fitter, fit: Fit) -> float:
    """Return the score of a fit with what the freedom of its causes costs."""
    return fit.score + _freedoms(fitter, fit)


def _freedoms(fitter: Fitter, fit: Fit) -> float:
    """Return what the freedom of all causes of a fit costs."""
    return sum(freedom(fitter, term) for term in fit.accepted)


def fair_costs(fitter: Fitter, fit: Fit, exact: Sequence[Fit]) -> list[float]:
    """Return what fits with one more cause cost at the noise of `fit`, in their best forms."""
    return _in_best_forms(fitter, _plain_costs(fitter, fit, exact), exact)


def _plain_costs(fitter: Fitter, fit: Fit, exact: Sequence[Fit]) -> list[float]:
    """Return what fits with one more cause cost at the noise of `fit`, with laws as they are."""
    usual = noise_in(fitter, fit)
    return [equal_noise_score(fitter, each, usual) + _freedoms(fitter, each) for each in exact]


def _in_best_forms(fitter: Fitter, costs: Sequence[float], fits: Sequence[Fit]) -> list[float]:
    """Return such costs of fits if their laws have their best forms."""
    return [cost - formed_gain(fitter, each) for cost, each in zip(costs, fits)]


def _own_forms(fitter: Fitter, fit: Fit) -> float:
    """Return what forms of the last cause improve beside those of all others."""
    return (evidence(fitter, fit, fit.causes_beside(fit.accepted[-1]))
            - evidence(fitter, fit))

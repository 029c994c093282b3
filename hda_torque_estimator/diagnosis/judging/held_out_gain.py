"""
What one cause gains on stretches that no fit has seen.

It is first asked of predictions: simulations from measured states, with and without the cause.
They hold what all other causes leave as well, and the noise of the states that they start from. A
small cause, or one behind a coarse encoder, may not show in them either way. Nor does any where
they are all below their noise floor. Then the balances of the same stretches are asked, beside
which all else is fitted (eq:held-out).
"""

from .placebo import placebo_shares
from ..balances.balance import Balancer
from ..findings.gains import gains, METRIC
from ..findings.report import Gain, OwnGain
from ..fitting.fit import Fit, Fitter
from ...least_squares.term import Term
from ...measurements.running_clock import Spans
from ...significance import MOSTLY

IN_BALANCES = ('power of the balances on held-out stretches, over that of noise, beside all other '
               'causes')


def held_out_gain(fitter: Fitter, fit: Fit, term: Term, twin: Balancer,
                  spans: Spans) -> OwnGain | None:
    """
    Return what a cause of a fit gains on held-out stretches, None if that is nothing for certain.

    `twin` shows the floor of predictions. A cause gains nothing where its placebo gains as much.
    """
    shares = placebo_shares(fitter, fit, term)
    if not shares.cause > shares.placebo:
        return None
    predicted = gains(fitter.balancer, twin, fitter.on(fitter.terms_without(fit, term)),
                      fitter.on(fit.terms), spans).gain()
    asked = predicted.before != predicted.after     # no event may lie in any of their windows
    if asked and predicted.before > predicted.floor and not predicted.low < 0.0:
        return predicted.beside(shares.placebo, METRIC)
    if (not asked or _may_be_better(predicted)) and shares.low > max(shares.placebo, 0.0):
        return OwnGain(shares.before, shares.after, 1.0, shares.cause, shares.low, shares.high,
                       shares.placebo, IN_BALANCES)
    return None


def _may_be_better(predicted: Gain) -> bool:
    """Return whether predictions do not lean to the worse, by most of their reach."""
    reach = 0.5 * (predicted.high - predicted.low)
    return predicted.high > 0.0 and predicted.removed > -MOSTLY * reach

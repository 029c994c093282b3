"""
The best other cause, and by how much it explains less.

Effects of the command act on the noise of the encoders that it repeats, and the balances have the
same noise: at high frequency it speaks for one of two such effects whatever the truth. So they are
compared where a motion has more.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.signal import filtfilt, firwin

from .balance import RATE
from .fit import Fit, Fitter
from .hypotheses import HYPOTHESES
from .screen import Prospect
from .term import Term

Array = NDArray[np.float64]
_TAPS = 101             # of the low-pass, at the balances' rate


def leading(fitter: Fitter, exact: Sequence[Fit],
            prospects: Sequence[Prospect]) -> tuple[Fit, Term | None, float]:
    """
    Return the leading of `exact` fits, the best other cause, and the score that it lacks.

    The fits come in the order of their scores; the first two change places where what tells them
    apart says so. Where one fit is left, its rival is the best of the prospects.
    """
    best = exact[0]
    if len(exact) > 1:
        other, lack = exact[1], _lack(fitter, best, exact[1])
        if lack < 0.0:
            best, other, lack = other, best, -lack
        return best, other.accepted[-1], lack
    others = [prospect for prospect in prospects
              if prospect.term.place != best.accepted[-1].place]
    return (best, others[0].term, others[0].score - best.score) if others else (best, None, np.inf)


def _lack(fitter: Fitter, best: Fit, other: Fit) -> float:
    """Return the score that another fit lacks, of two of the command below their frequency."""
    below = min(HYPOTHESES[fit.accepted[-1].name].below for fit in (best, other))
    if not np.isfinite(below):
        return other.score - best.score
    independent = fitter.effective * fitter.valid(best.balance).sum(axis=0) * 2.0 * below / RATE
    return float(independent @ np.log(_power(fitter, other, below) / _power(fitter, best, below)))


def _power(fitter: Fitter, fit: Fit, below: float) -> Array:
    """Return the power (c,) of what a fit leaves below a frequency [N^2*m^2]."""
    valid = fitter.valid(fit.balance)
    slow = filtfilt(firwin(_TAPS, below, fs=RATE), [1.0],
                    np.where(valid, fit.balance.residual, 0.0), axis=0)
    return np.maximum((slow ** 2).sum(axis=0, where=valid), 1e-300)

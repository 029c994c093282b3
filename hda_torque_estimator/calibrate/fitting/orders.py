"""Choose the waves that a joint's torsion has, by what each gains where the fit has not seen."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .laws import FURTHER, is_named, is_of_disc, WAVE, wave_columns, waves
from .torsion_fits import BESIDE, TorsionFits
from ...least_squares.descent import beginning, Minimum, places
from ...least_squares.rows import held_out
from ...least_squares.term import Term

Floats = NDArray[np.float64]
# Choices unless stated otherwise.
GAIN = 0.004            # least relative gain of the held-out error that makes a wave worth it
OF_MOTOR = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0)  # orders per motor turn that are tried
OF_LINK = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0)  # orders per link turn that are tried
BEATS = ((1, 1), (2, 1), (2, 2), (2, -2), (2, -1), (4, 2), (4, 4))     # motor and link turns


class Fitted(NamedTuple):
    """A fit whose last terms are the waves of these orders."""

    found: Minimum
    orders: tuple[float, ...]

    def known(self) -> dict[object, Floats]:
        """Return what was found of every term, and of every wave by its order."""
        terms = self.found.terms
        keys = [*map(id, terms[:len(terms) - len(self.orders)]), *self.orders]
        return {key: self.found.scaled[place] for key, place in zip(keys, places(terms))}


def fitted_waves(fits: TorsionFits, terms: Sequence[Term], orders: tuple[float, ...],
                 before: Fitted | None = None) -> Fitted:
    """Return the fit of terms and waves, which begins where a fit before it has come."""
    waved = [*terms, *waves(fits.arm, orders)]
    start = beginning(waved, BESIDE)
    if before is not None:
        known = before.known()
        for key, place in zip([*map(id, terms), *orders], places(waved)):
            start[place] = known.get(key, start[place])
        start[-BESIDE:] = before.found.scaled[-BESIDE:]
    return Fitted(fits.fit(waved, start), orders)


def worthwhile(fitted: Fitted) -> tuple[tuple[float, ...], Minimum]:
    """Return the orders that gain where the fit has not seen, and the fit with these alone."""
    found, orders = fitted.found, list(fitted.orders)
    own = dict(zip(orders, found.terms[len(found.terms) - len(orders):]))
    for order in reversed(fitted.orders):
        less = found.without(own[order])
        if error_held_out(less) < error_held_out(found) / (1.0 - GAIN):
            found = less
            orders.remove(order)
    return tuple(orders), found


def error_held_out(found: Minimum) -> float:
    """Return the error of a fit where it has not seen [N*m rms]."""
    return held_out(found.rows, found.noise, found.scaled, found.prior)


def candidates(ratio: float) -> tuple[float, ...]:
    """Return all orders that are tried, per motor turn."""
    return (*(order / ratio for order in OF_LINK), *OF_MOTOR,
            *(motor + link / ratio for motor, link in BEATS))


def chosen(fits: TorsionFits, found: Minimum, orders: Sequence[float]) -> tuple[float, ...]:
    """
    Return orders with those more whose waves lower the held-out error, the best first.

    `orders` are in the fit already. It stops where no other gains, or all places are taken.
    """
    ratio = fits.arm.joints[0].ratio
    picked = list(orders)
    best = error_held_out(found)
    stiffness = found.rows.slopes[:, found.unknowns]     # torque per turn of the link's zero
    columns = {order: WAVE * stiffness[:, None] * fits.thinned(
        [wave_columns(passage, (order,)) for passage in fits.passages])
        for order in candidates(ratio) if order not in picked}
    while columns:
        trials = {order: error_held_out(_with(found, wave))
                  for order, wave in columns.items() if _has_place(order, picked, ratio)}
        if not trials:
            break
        order = min(trials, key=lambda one: trials[one])
        if trials[order] > (1.0 - GAIN) * best:
            break
        found = _with(found, columns.pop(order))
        best = trials[order]
        picked.append(order)
    return tuple(picked)


def _with(found: Minimum, wave: Floats) -> Minimum:
    """Return a fit with the columns of one more wave (m, 2)."""
    rows = replace(found.rows, slopes=np.concatenate([found.rows.slopes, wave], axis=1))
    return replace(found, rows=rows, scaled=np.concatenate([found.scaled, np.zeros(2)]),
                   prior=np.concatenate([found.prior, np.ones(2)]))


def _has_place(order: float, picked: Sequence[float], ratio: float) -> bool:
    """Return whether the arm file has a place for one more wave of this order."""
    if is_named(order) or is_of_disc(order, ratio):
        return True
    taken = sum(not is_named(one) and not is_of_disc(one, ratio) for one in picked)
    return taken < len(FURTHER)

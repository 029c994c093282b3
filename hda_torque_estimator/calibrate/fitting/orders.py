"""Choose the waves that a joint's torsion has, by what each gains where the fit has not seen."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .descent import beginning, Descent, Found, held_out, Rows
from .laws import FURTHER, is_named, is_of_disc, WAVE, wave_columns, waves
from .terms import Term

Floats = NDArray[np.float64]
# Choices unless told otherwise.
GAIN = 0.004            # least relative gain of the held-out error that makes a wave worth it
OF_MOTOR = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0)  # orders per motor turn that are tried
OF_LINK = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0)  # orders per link turn that are tried
BEATS = ((1, 1), (2, 1), (2, 2), (2, -2), (2, -1), (4, 2), (4, 4))     # motor and link turns


class Fitted(NamedTuple):
    """A fit whose last term are waves of these orders."""

    found: Found
    orders: tuple[float, ...]


def fitted_waves(descent: Descent, terms: Sequence[Term], orders: tuple[float, ...],
                 before: Fitted | None = None) -> Fitted:
    """Return the fit of terms and waves, which begins where a fit before it has come."""
    waved = [*terms, waves(descent.arm, orders)]
    start = beginning(waved)
    if before is not None:
        places = {id(term): place for term, place in zip(before.found.terms, _places(before))}
        at = 0
        for term in terms:
            if id(term) in places:
                start[at:at + len(term.unknowns)] = before.found.scaled[places[id(term)]]
            at += len(term.unknowns)
        old = before.found.scaled[_places(before)[-1]].reshape(-1, 2)
        for order, parts in zip(before.orders, old):
            if order in orders:
                place = at + 2 * orders.index(order)
                start[place:place + 2] = parts
        start[at + 2 * len(orders):] = before.found.scaled[before.found.unknowns:]
    return Fitted(descent.fit(waved, start), orders)


def _places(fitted: Fitted) -> list[slice]:
    """Return where the unknowns of each term stand."""
    ends = np.cumsum([len(term.unknowns) for term in fitted.found.terms])
    return [slice(int(end) - len(term.unknowns), int(end))
            for term, end in zip(fitted.found.terms, ends)]


def worthwhile(fitted: Fitted) -> tuple[tuple[float, ...], Found]:
    """Return the orders that gain where the fit has not seen, and the fit with these alone."""
    found, orders = fitted.found, list(fitted.orders)
    first = found.unknowns - 2 * len(orders)
    for order in reversed(fitted.orders):
        place = first + 2 * orders.index(order)
        best = held_out(found.rows, found.noise, found.scaled)
        less = _without(found, place)
        if held_out(less.rows, less.noise, less.scaled) < best / (1.0 - GAIN):
            found = less
            orders.remove(order)
    return tuple(orders), found


def _without(found: Found, place: int) -> Found:
    """Return a fit without the wave at a place, as far as slopes stay as they are."""
    gone = [place, place + 1]
    rows = found.rows
    error = rows.error - rows.slopes[:, gone] @ found.scaled[gone]
    slopes = np.delete(rows.slopes, gone, axis=1)
    *terms, last = found.terms
    less = replace(last, unknowns=last.unknowns[2:])    # all waves are known alike
    return replace(found, terms=(*terms, less), scaled=np.delete(found.scaled, gone),
                   rows=replace(rows, error=error, slopes=slopes))


def candidates(ratio: float) -> tuple[float, ...]:
    """Return all orders that are tried, per motor turn."""
    return (*(order / ratio for order in OF_LINK), *OF_MOTOR,
            *(motor + link / ratio for motor, link in BEATS))


def chosen(descent: Descent, found: Found, orders: Sequence[float]) -> tuple[float, ...]:
    """
    Return orders with those more whose waves lower the held-out error, the best first.

    `orders` are in the fit already. It stops where no other gains, or all places are taken.
    """
    ratio = descent.arm.joints[0].ratio
    picked = list(orders)
    rows, best = found.rows, held_out(found.rows, found.noise, found.scaled)
    scaled = found.scaled
    stiffness = found.rows.slopes[:, found.unknowns]     # torque per turn of the link's zero
    columns = {order: WAVE * stiffness[:, None] * descent.thinned(
        [wave_columns(passage, (order,)) for passage in descent.passages])
        for order in candidates(ratio) if order not in picked}
    while columns:
        trials = {order: held_out(*_with(rows, wave, found.noise, scaled))
                  for order, wave in columns.items() if _has_place(order, picked, ratio)}
        if not trials:
            break
        order = min(trials, key=lambda one: trials[one])
        if trials[order] > (1.0 - GAIN) * best:
            break
        rows, _, scaled = _with(rows, columns.pop(order), found.noise, scaled)
        best = trials[order]
        picked.append(order)
    return tuple(picked)


def _with(rows: Rows, wave: Floats, noise: float, scaled: Floats) -> tuple[Rows, float, Floats]:
    """Return rows with the columns of one more wave (m, 2)."""
    return (replace(rows, slopes=np.concatenate([rows.slopes, wave], axis=1)), noise,
            np.concatenate([scaled, np.zeros(2)]))


def _has_place(order: float, picked: Sequence[float], ratio: float) -> bool:
    """Tell whether the arm file has a place for one more wave of this order."""
    if is_named(order) or is_of_disc(order, ratio):
        return True
    taken = sum(not is_named(one) and not is_of_disc(one, ratio) for one in picked)
    return taken < len(FURTHER)

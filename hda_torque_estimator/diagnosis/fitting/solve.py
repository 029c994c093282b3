"""
Weigh terms against residuals: a bounded least squares with priors and one variance per channel.

The variance of a channel is what is left in it, but never less than its noise. So a channel with
an unexplained rest counts little, and a prior is worth the more the less the model fits.
Where much is left, that alone could hold a cause at nothing: what could explain all is tried too.
"""

from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
import numpy as np
from numpy.typing import NDArray

from ...least_squares.normal import raised, RIDGE, TINY, within

# Judgement.
# (source: normal distribution; of twenty numbers of an arm, one is farther off in 1 of 107 arms)
REACH = 3.5             # standard deviations that a nuisance may go from its nominal value

# Numerics; choices unless stated otherwise.
_SAME = 1e-3            # by which variances differ at one and the same end,
_LEAST = 1e-8           # and besides by so much at most [N^2*m^2]
_PASSES = 12            # of weights and bounds, at most
_AT_END = 1.0 - 1e-6    # of its reach, from which a number is held there (choice: rounding)
ANYWHERE = np.array(np.inf)     # room of a step that may go on for ever
_APART = 4.0            # times noise: with less left there is one best step (eq:two-ends)


class Columns(NamedTuple):
    """Residuals and the columns of their derivatives, condensed by channel."""

    products: Array     # (c, p, p) column by column
    against: Array      # (c, p) column by residual
    power: Array        # (c,) residual by residual
    samples: Array      # (c,)


class Solution(NamedTuple):
    """A step of the free numbers and what it leaves."""

    step: Array         # (p,)
    score: float        # twice the negative log posterior: smaller is better
    scores: Array       # (c,) share of each channel in it, the rest is that of the priors
    variance: Array     # (c,) left per channel, not below noise [N^2*m^2]


def condense(residual: Array, columns: Array, valid: NDArray[np.bool_]) -> Columns:
    """
    Condense residuals (m, c) and derivative columns (m, c, p) where they are valid (m, c).

    Of an arm with many joints most terms show in some channels alone: nothing else is multiplied.
    """
    rest = np.where(valid, residual, 0.0)
    channels, size = columns.shape[1:]
    products, against = np.zeros((channels, size, size)), np.zeros((channels, size))
    for channel in range(channels):
        own = columns[:, channel].T                                          # (p, m)
        shown = np.flatnonzero(own.any(axis=1))
        flat = np.where(valid[:, channel], own[shown], 0.0)
        products[channel, shown[:, None], shown] = flat @ flat.T
        against[channel, shown] = flat @ rest[:, channel]
    return Columns(products, against, (rest ** 2).sum(axis=0), valid.sum(axis=0).astype(float))


def condense_more(known: Columns, residual: Array, columns: Array, more: Array,
                  valid: NDArray[np.bool_]) -> Columns:
    """Return `known`, the condensed `columns`, with `more` columns (m, c, q) before them."""
    channels, first = more.shape[1:]
    size = first + columns.shape[2]
    products, against = np.zeros((channels, size, size)), np.zeros((channels, size))
    products[:, first:, first:], against[:, first:] = known.products, known.against
    shown = (more != 0.0).any(axis=0).any(axis=1)                  # most are of one joint of many
    for channel in np.flatnonzero(shown):
        added = np.where(valid[:, channel], more[:, channel].T, 0.0)        # (q, m)
        across = added @ columns[:, channel]
        products[channel, :first, :first] = added @ added.T
        products[channel, :first, first:], products[channel, first:, :first] = across, across.T
        against[channel, :first] = added @ residual[:, channel]
    return Columns(products, against, known.power, known.samples)


def solve(columns: Columns, noise: Array, effective: float, now: Array, deviations: Array,
          room: tuple[Array, Array] = (ANYWHERE, ANYWHERE)) -> Solution:
    """
    Return the best step from `now` (p,), the distance to the nominal values in free numbers.

    `noise` (c,) is the standard deviation that a healthy arm leaves, `effective` the share of
    samples that are independent, `deviations` (p,) the priors. A number with a prior stays within
    REACH of them. Steps stay within their `room` (p,), down and up.
    """
    return ends(columns, noise, effective, now, deviations, room)[0]


def ends(columns: Columns, noise: Array, effective: float, now: Array, deviations: Array,
         room: tuple[Array, Array] = (ANYWHERE, ANYWHERE)) -> list[Solution]:
    """
    Return the best steps as `solve` does, the better one first: channels may pull apart.

    Weights begin with the rest, and with the noise as well where there may be two (eq:two-ends).
    What would leave its `room` (p,), down or up, ends there, and the others step again. If it
    were cut off afterwards, they would make room for what is not done (eq:room).
    """
    bounds = (np.maximum(-REACH * deviations, now - room[0]),
              np.minimum(REACH * deviations, now + room[1]))
    rest = np.maximum(_left(columns, np.zeros_like(now)), noise ** 2)
    found = _descended(columns, noise, effective, now, deviations, bounds, rest)
    if not (rest > _APART * noise ** 2).any():
        return [found]
    other = _descended(columns, noise, effective, now, deviations, bounds, noise ** 2)
    if _are_same(other.variance, found.variance):
        return [found]
    return sorted((found, other), key=lambda end: end.score)


def _descended(columns: Columns, noise: Array, effective: float, now: Array, deviations: Array,
               bounds: tuple[Array, Array], variance: Array) -> Solution:
    """Return where steps, and the variances (c,) that they leave, lead to in turn."""
    prior = prior_weights(deviations)
    for _ in range(_PASSES):
        step = step_of(columns, effective / variance, prior, now, bounds)
        left = _left(columns, step)
        renewed = np.maximum(left, noise ** 2)
        if _are_same(renewed, variance):
            break
        variance = renewed
    shares = _scores(left, columns.samples, noise, effective)
    return Solution(step, float(shares.sum() + prior @ (now + step) ** 2), shares, variance)


def _are_same(variance: Array, other: Array) -> bool:
    """Return whether variances (c,) are those of one end."""
    return bool((np.abs(variance - other) <= _LEAST + _SAME * other).all())


def at_end(away: Array, deviations: Array) -> NDArray[np.bool_]:
    """Return which numbers (p,) are held at the end of what priors let them be away."""
    return np.asarray(np.isfinite(deviations) & (np.abs(away) >= _AT_END * REACH * deviations))


def prior_weights(deviations: Array) -> Array:
    """Return one over the squares of priors (p,), nothing where there is none."""
    known = np.isfinite(deviations)
    return np.where(known, 1.0 / np.where(known, deviations, 1.0) ** 2, 0.0)


def step_of(columns: Columns, weight: Array, prior: Array, now: Array,
            bounds: tuple[Array, Array]) -> Array:
    """
    Return the best step (p,) for known weights (c,) of the channels, and (p,) of the priors.

    `now` and the step stay between both `bounds` (p,), which may be infinite.
    """
    normal = raised(np.einsum('c,cpq->pq', weight, columns.products), prior)
    return within(normal, -weight @ columns.against - prior * now, now, bounds, RIDGE)


def covariance(columns: Columns, variance: Array, effective: float, deviations: Array) -> Array:
    """Return how uncertain the free numbers are, their covariances (p, p), 0 at a bound."""
    prior = 1.0 / deviations ** 2                                   # of infinite ones, zero
    normal = np.einsum('c,cpq->pq', effective / variance, columns.products) + np.diag(prior)
    known = np.diag(normal)
    scale = np.where(known > 0.0, 1.0 / np.sqrt(np.maximum(known, TINY)), 0.0)
    return np.linalg.pinv(normal * np.outer(scale, scale), hermitian=True) * np.outer(scale, scale)


def _left(columns: Columns, step: Array) -> Array:
    power = columns.power + 2.0 * columns.against @ step + (columns.products @ step) @ step
    return np.maximum(power, 0.0) / np.maximum(columns.samples, 1.0)


def score(left: Array, count: Array, noise: Array, effective: float) -> float:
    """Return twice the negative log likelihood of what is left per channel (c,) [N^2*m^2]."""
    return float(_scores(left, count, noise, effective).sum())


def _scores(left: Array, count: Array, noise: Array, effective: float) -> Array:
    """
    Return the share of each channel (c,) in the score.

    Above the noise the variance is taken from the rest itself, below it from the noise.
    """
    ratio = left / noise ** 2
    return effective * count * np.where(
        ratio > 1.0, 1.0 + np.log(np.maximum(ratio, 1.0)), ratio)

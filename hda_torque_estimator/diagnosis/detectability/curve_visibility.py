"""
How much curves without a name would improve an imagined effect: what makes a search look.

What is less than noise is looked into only where such a curve explains it for certain
(`selection_criteria.open_rest`). Improvements are to first order, by the weights of the last fit.
"""

from collections.abc import Collection, Sequence
from typing import NamedTuple, TypeAlias

from hda_arm_sim.foundation.arrays import Array
import numpy as np
from numpy.typing import NDArray

from ..fitting.fit import Fit, Fitter
from ..fitting.solve import Columns, condense_more, prior_weights
from ..judging.discrepancy_curves import curves_at_sites

# Numerics; choices unless stated otherwise.
_OWN = 1e-6             # share of a curve that the terms do not have, below which it is theirs


class _Curves(NamedTuple):
    """The curves at one site of a joint, without what the terms of a fit have of them."""

    joint: str
    channels: Sequence[int]         # in which they show
    taken: Array                    # (q, p) shares of the terms in each
    own: Array                      # (q,) information on each that the terms leave, or infinite


Followed: TypeAlias = tuple[_Curves, Array]     # curves, and how far each (q,) is followed


class CurveVisibility:
    """Curves without a name at some joints, beside the terms of a fit."""

    def __init__(self, fitter: Fitter, fit: Fit, known: Columns, joints: Collection[str]) -> None:
        """Prepare the curves at `joints`; `known` are the terms of the fit, condensed."""
        self._weight, valid = fitter.effective / fit.variance, fitter.valid(fit.balance)
        self._prior = prior_weights(fit.deviations)
        normal = np.einsum('c,cpq->pq', self._weight, known.products) + np.diag(self._prior)
        self._sites: list[_Curves] = []
        self._shapes: dict[int, NDArray[np.float32]] = {}   # (q, m) by channel, alike at all sites
        for site in curves_at_sites(fitter, fit, joints, quick=True):
            wide = condense_more(known, fit.balance.residual, fit.columns, site.columns, valid)
            count = len(site.forms)
            across = np.einsum('c,cqp->qp', self._weight, wide.products[:, :count, count:])
            power = np.einsum('c,cqq->q', self._weight, wide.products[:, :count, :count])
            taken = np.linalg.lstsq(normal, across.T, rcond=None)[0].T
            own = power - (taken * across).sum(axis=1)
            channels = np.flatnonzero(site.columns.any(axis=(0, 2))).tolist()
            self._sites.append(_Curves(site.joint, channels, taken,
                                       np.where(own > _OWN * power, own, np.inf)))
            for channel in set(channels) - self._shapes.keys():
                shapes = np.where(valid[:, channel], site.columns[:, channel].T, 0.0)
                self._shapes[channel] = np.ascontiguousarray(shapes, np.float32)

    def along(self, shift: Array, across: Array, joint: str | None) -> list[Followed]:
        """
        Return how far curves follow a shift (m, c) of the residuals: those at a joint, or all.

        `across` (c, p) is the shift times the terms, condensed.
        """
        terms, sites = self._weight @ across, [
            site for site in self._sites if joint is None or site.joint == joint]
        follows = {channel: self._weight[channel] * (
            self._shapes[channel] @ shift[:, channel].astype(np.float32))
            for channel in {channel for site in sites for channel in site.channels}
            if shift[:, channel].any()}
        return [(site, sum(follows.get(channel, 0.0) for channel in site.channels)
                 - site.taken @ terms) for site in sites]

    def improvement(self, along: Sequence[Followed], share: float, step: Array) -> float:
        """Return what the best curve improves of a share of a shift, after a step (p,)."""
        pulled = self._prior * step
        return max((float(np.max((share * follows + site.taken @ pulled) ** 2 / site.own))
                    for site, follows in along), default=0.0)

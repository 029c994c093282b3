"""Fit terms to the balances of one measurement: Gauss-Newton with the exact model."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import cast

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import Site
import numpy as np
from numpy.typing import NDArray

from .derivatives import Derivatives, IMPOSSIBLE, same
from .nuisance import AnyTerm
from .slopes import has_noise, of_noise, Slopes, take_noise, without
from .solve import condense, covariance, ends, score
from .steps import columns_of, places_of, Sized
from ..balances.balance import Balance, Balancer, RATE
from ..balances.channels import channels_of
from ..balances.recent_cache import RecentCache
from ...least_squares.descent import damped, improved
from ...least_squares.sandwich import sandwich
from ...least_squares.term import Place, Term

# Numerics; choices unless stated otherwise.
PASSES = 4              # of a fit of all numbers, at most
_REFINEMENTS = 6        # further passes of a fit that still gains
_TWINS = 2              # of other rows, for which what fits them is kept
_BALANCES = 4           # of which derivatives are kept: of twins, and beside what has no name
_SHARES = (1.0, 0.4, 0.1)       # of a step that are tried, the longest first
_BLOCK = 1.0            # within which residuals may go together [s]
REFERENCE = 'reference'  # what a gear is held against in the place of its link
CLOSE = 0.5             # improvement of the score that is not worth another pass
FAR = 100.0             # improvement by a step after which no derivative is as it was


@dataclass(frozen=True, eq=False)
class Fit:
    """Terms at their best: what was accepted, what only may differ, and what is left."""

    accepted: tuple[Term, ...]
    nuisance: tuple[AnyTerm, ...]
    balance: Balance
    slopes: Slopes              # derivatives of the residual, accepted terms first
    score: float                # smaller is better
    variance: Array             # (c,) of what is left [N^2*m^2]

    @property
    def columns(self) -> Array:
        """Return the derivatives of the residual (m, c, p)."""
        return self.slopes.columns

    @cached_property
    def terms(self) -> tuple[AnyTerm, ...]:
        """Return all terms, the accepted ones first."""
        return self.accepted + self.nuisance

    @cached_property
    def deviations(self) -> Array:
        """Return the tolerances of all free numbers (p,)."""
        return deviations(self.terms)

    def terms_beside(self, term: AnyTerm) -> list[AnyTerm]:
        """Return all terms but one."""
        return [other for other in self.terms if other is not term]

    def causes_beside(self, term: Term) -> list[Term]:
        """Return the accepted terms but one."""
        return [other for other in self.accepted if other is not term]

    def own(self, term: AnyTerm) -> NDArray[np.bool_]:
        """Return which columns are those of a term (p,)."""
        return np.concatenate([np.full(other.size, other is term) for other in self.terms])


@dataclass(frozen=True, eq=False)
class Fitter:
    """Fits on some rows of the balances of one measurement, for one arm as given."""

    balancer: Balancer
    arm: Arm
    noise: Array                # (c,) standard deviation that a healthy arm leaves [N*m]
    effective: float            # share of samples that are independent
    rows: NDArray[np.bool_]     # (m,) those to be used
    twin: Balancer | None = None    # of a healthy arm, recorded with as much noise
    instruments: Balancer | None = None     # of the same motion with other noise, if not the twin
    # What fits the twin does not depend on the noise, and is handed on to a fitter with less.
    _healthy: RecentCache['Fitter'] = field(default_factory=lambda: RecentCache(_TWINS),
                                            repr=False)
    _known: RecentCache[Derivatives] = field(default_factory=lambda: RecentCache(_BALANCES),
                                             repr=False)

    def is_unloaded(self, joint: str | None) -> bool:
        """Return whether nobody knows the load of a joint: its motor balance alone counts then."""
        return bool(self.balancer.measurement.unloaded[self.arm.labels.index(str(joint))])

    def beyond_gear(self, joint: str) -> str:
        """Return what a torsion is held against: the link of a joint, or its reference torque."""
        sensed = self.balancer.measurement.held_against[self.arm.labels.index(joint)]
        return REFERENCE if sensed else Site.LINK.value

    @property
    def healthy(self) -> 'Fitter | None':
        """Return what fits the twin, None without one: what that finds, it finds by chance."""
        twin = self.twin
        if twin is None:
            return None
        key = id(twin), id(self.arm), self.effective, self.rows.tobytes()
        return self._healthy.of(key, lambda: self.of_twin(twin, self.arm))

    def of_twin(self, twin: Balancer, arm: Arm) -> 'Fitter':
        """Return what fits a simulated recording of an arm, beside its own noise."""
        balance = twin(arm)
        power = np.where(balance.valid, balance.residual ** 2, 0.0).sum(axis=0)
        noise = np.sqrt(power / np.maximum(balance.valid.sum(axis=0), 1))
        return Fitter(twin, self.arm, np.where(noise > 0.0, noise, self.noise), self.effective,
                      self.rows, instruments=self.balancer, _known=self._known)

    @cached_property
    def _derivatives(self) -> Derivatives:
        return self._derivatives_of(self.balancer)

    def _derivatives_of(self, balancer: Balancer) -> Derivatives:
        """Return the derivatives of balances, which may be known."""
        return self._known.of((id(balancer), id(self.arm)),
                              lambda: Derivatives(balancer, self.arm))

    @property
    def _tolerated(self) -> tuple[AnyTerm, ...]:
        return self._derivatives.tolerated

    @cached_property
    def _nominal(self) -> dict[Place, Array]:
        return {term.place: term.vector() for term in self._tolerated}

    @cached_property
    def first(self) -> Fit:
        """Return the fit without any cause."""
        return self.fit(())

    def everywhere(self) -> 'Fitter':
        """Return the fitter that looks at all rows, at held-out stretches as well."""
        return replace(self, rows=np.ones_like(self.rows))

    def on(self, terms: Sequence[AnyTerm]) -> Arm:
        """Return the arm as given with these terms, which may have been asked for before."""
        return self._derivatives.on(terms)

    def valid(self, balance: Balance) -> NDArray[np.bool_]:
        """Return what counts of a balance (m, c)."""
        return balance.valid & self.rows[:, None]

    def fit(self, accepted: Sequence[Term], start: Sequence[AnyTerm] = ()) -> Fit:
        """Fit accepted terms and all nuisances together, the latter from `start` where given."""
        terms = self._start([*accepted, *self._others(accepted, start)])
        return improved(self.at(terms, len(accepted), self._slopes(terms)),
                        lambda fit: self._descend(fit, len(accepted)),
                        lambda fit, _: self._renewed(fit, fit.terms, 0), PASSES, CLOSE)

    def _start(self, terms: list[AnyTerm]) -> list[AnyTerm]:
        """Return terms that an arm can have together: as they are, or closer to the arm's own."""
        if self._possible(terms):
            return terms
        own = [replace(term, effect=self.arm.effect(*term.place))
               if isinstance(term, Term) else term for term in terms]
        for share in (0.5, 0.25):
            closer = [term.at(near.vector() + share * (term.vector() - near.vector()))
                      for near, term in zip(own, terms)]
            if self._possible(closer):
                return closer
        return list(own)

    def _possible(self, terms: Sequence[AnyTerm]) -> bool:
        """Return if an arm can have these terms together."""
        try:
            self.on(terms)
        except IMPOSSIBLE:
            return False
        return True

    def refit(self, fit: Fit, term: Term) -> Fit:
        """Return a fit with one more term, after two steps with the others' columns as given."""
        kept = [other for other in fit.nuisance if other.place != term.place]
        terms: list[AnyTerm] = [*fit.accepted, term, *kept]
        first, count = sum(other.size for other in fit.accepted), len(fit.accepted) + 1
        known = fit.columns                             # nearly always all, which takes no copy
        if len(kept) < len(fit.nuisance):
            known = known[:, :, places_of(fit.terms, [*fit.accepted, *kept])]
        own = self._quiet_derivatives([term], terms, fit.slopes)
        begun = self.at(terms, count, fit.slopes.with_columns(np.concatenate(
            [known[:, :, :first], own, known[:, :, first:]], axis=2)))
        starts = [self._descend(begun, count)]
        if len(term.sought) > 1:        # a small size says little of a shape: size alone may gain
            starts.append(self._descend(begun, count, slice(first + 1, first + term.size)))
        return min((self._descend(self._renewed(start, start.accepted[-1:], first), count)
                    for start in starts), key=lambda found: found.score)

    def refined(self, fit: Fit) -> Fit:
        """Return a fit to the end; after far steps no derivative is as it was."""
        first = sum(other.size for other in fit.accepted[:-1])

        def renewed(best: Fit, gained: float) -> Fit:
            if gained >= FAR:
                return self._renewed(best, best.terms, 0)
            return self._renewed(best, best.accepted[-1:], first)

        return improved(renewed(fit, FAR), lambda best: self._descend(best, len(fit.accepted)),
                        renewed, _REFINEMENTS, CLOSE)

    def without(self, fit: Fit, term: Term) -> Fit:
        """Return a fit without one of its causes, refitted with the others' columns as given."""
        if any(tolerated.place == term.place for tolerated in self._tolerated):
            return self.fit(fit.causes_beside(term), fit.nuisance)     # it may still differ
        return improved(self.lacking(fit, term),
                        lambda best: self._descend(best, len(best.accepted)),
                        lambda best, _: best, PASSES, CLOSE)

    def lacking(self, fit: Fit, term: Term) -> Fit:
        """Return a fit as it is without one of its causes."""
        return self.at(self.terms_without(fit, term), len(fit.accepted) - 1,
                       fit.slopes.with_columns(fit.columns[:, :, ~fit.own(term)]))

    def terms_without(self, fit: Fit, term: Term) -> Sequence[AnyTerm]:
        """Return the terms beside a cause, closer to the arm's own if no arm has them so."""
        return self._start(fit.terms_beside(term))

    def can_lack_each(self, fit: Fit) -> bool:
        """Return if an arm can be without each cause: none only makes others possible."""
        return all(self._possible(fit.terms_beside(term)) for term in fit.accepted)

    def settled(self, fit: Fit) -> Fit:
        """Return a fit after one step more, for a fitter of other rows."""
        return self._descend(self.at(fit.terms, len(fit.accepted), fit.slopes),
                             len(fit.accepted))

    def _renewed(self, fit: Fit, terms: Sequence[AnyTerm], place: int) -> Fit:
        """Return a fit with the columns of some neighbouring terms made again."""
        fresh = self._quiet_derivatives(terms, fit.terms, fit.slopes)
        if terms is fit.terms:                          # nothing of the others is left to keep
            return replace(fit, slopes=fit.slopes.with_columns(fresh))
        columns = fit.columns.copy('K')
        columns[:, :, place:place + fresh.shape[2]] = fresh
        return replace(fit, slopes=fit.slopes.with_columns(columns))

    def _quiet_derivatives(self, terms: Sequence[AnyTerm], among: Sequence[AnyTerm],
                           slopes: Slopes) -> Array:
        """Return derivatives (m, c, p) of terms `among` others without the noise of slopes."""
        made = self.derivatives(terms, among)           # nobody else has them
        take_noise(terms, made, slopes.noise)
        return made

    def _slopes(self, terms: Sequence[AnyTerm]) -> Slopes:
        """Return the derivatives of terms, those of numbers with a tolerance without noise."""
        derivatives, other = self._derivatives, self.instruments or self.twin
        columns = (derivatives.as_given if same(terms, self._tolerated)
                   else derivatives.of(terms, terms))
        if other is None:
            return Slopes(columns, {})
        balance, twin = self.balancer(self.on(terms)), self._derivatives_of(other)
        weight = np.where(self.valid(balance), 1.0 / self.noise, 0.0)
        noise = (derivatives.noise_beside(twin).noise_in(
            terms, columns, balance.residual, balance.valid, weight)
            | derivatives.noise_carried(twin, balance, weight))
        return Slopes(without(terms, columns, noise), noise)

    def balance(self, terms: Sequence[AnyTerm], noise: Mapping[Sized, Array]) -> Balance:
        """Return what terms leave, as noisy as the arm as given (eq:noiseless)."""
        exact = self.balancer(self.on(terms))
        return Balance(exact.residual - sum(of_noise(term, self.arm, noise) for term in terms),
                       exact.valid)

    def residual(self, terms: Sequence[AnyTerm], noise: Mapping[Sized, Array]) -> Array:
        """Return what terms leave (m, c), as noisy as the arm as given [N*m] (eq:noiseless)."""
        return self.balance(terms, noise).residual

    def as_noisy(self, fit: Fit) -> Arm:
        """Return an arm that leaves as much noise as a fit does."""
        try:
            return self.on([term for term in fit.terms if not has_noise(term, fit.slopes.noise)])
        except IMPOSSIBLE:
            return self.on(fit.terms)

    def _descend(self, fit: Fit, accepted: int, held: slice = slice(0)) -> Fit:
        """Return the fit after one step that improves it, or itself; some numbers are `held`."""
        down, up = room(fit.terms)
        down[held] = up[held] = 0.0
        condensed = condense(fit.balance.residual, fit.columns, self.valid(fit.balance))

        def trial(step: Array) -> Fit | None:
            try:
                return self.at(moved(fit.terms, step), accepted, fit.slopes)
            except IMPOSSIBLE:
                return None

        steps = [share * end.step for end in ends(condensed, self.noise, self.effective,
                                                  self.away(fit.terms), fit.deviations,
                                                  (down, up))
                 for share in _SHARES]
        return damped(trial, steps, lambda found: found.score < fit.score) or fit

    def at(self, terms: Sequence[AnyTerm], accepted: int, slopes: Slopes) -> Fit:
        """Return the fit with these terms as they are, exactly evaluated."""
        balance = self.balance(terms, slopes.noise)
        valid = self.valid(balance)
        count = np.maximum(valid.sum(axis=0), 1)
        left = np.where(valid, balance.residual ** 2, 0.0).sum(axis=0) / count
        prior = float(np.sum((self.away(terms) / deviations(terms)) ** 2))
        causes = cast(Sequence[Term], terms[:accepted])     # a zero is never one
        return Fit(tuple(causes), tuple(terms[accepted:]), balance, slopes,
                   score(left, valid.sum(axis=0), self.noise, self.effective) + prior,
                   np.maximum(left, self.noise ** 2))

    def covariance(self, fit: Fit) -> Array:
        """
        Return how uncertain a fit is: covariances (p, p), those of accepted terms first.

        They are those of noise, widened where blocks of the recording pull more apart than
        noise would (Huber's sandwich, by blocks of a second).
        """
        valid, tolerances = self.valid(fit.balance), fit.deviations
        condensed = condense(fit.balance.residual, fit.columns, valid)
        plain = covariance(condensed, fit.variance, self.effective, tolerances)
        pull = np.where(valid[:, :, None], fit.columns * (fit.balance.residual
                                                          / fit.variance)[:, :, None], 0.0)
        starts = np.arange(0, len(pull), round(_BLOCK * RATE))
        blocks = self.effective * np.add.reduceat(pull.sum(axis=1), starts)
        apart = sandwich(plain, blocks.T @ blocks, 1.0 / tolerances ** 2)
        wide = np.sqrt(np.maximum(np.diag(apart)
                                  / np.maximum(np.diag(plain), 1e-300), 1.0))
        return plain * np.outer(wide, wide)

    def derivatives(self, terms: Sequence[AnyTerm], among: Sequence[AnyTerm]) -> Array:
        """Return the derivative columns (m, c, p) of terms, all of which are `among` others."""
        return self._derivatives.of(terms, among)

    def change(self, terms: Sequence[AnyTerm], arm: Arm) -> Array:
        """Return what the residual (m, c) of an arm has more than that of the terms [N*m]."""
        return self._derivatives.change(terms, arm)

    def own_channels(self, joint: str | None) -> list[int]:
        """Return the channels of a joint: its A, its B, and its C if a sensor is beside links."""
        return channels_of(self.balancer.measurement, self.arm.labels.index(str(joint)))

    def channels_of(self, term: Term) -> list[int]:
        """Return the channels in which a term may show: those of its joint, or all."""
        return (self.own_channels(term.joint) if term.joint is not None
                else list(range(len(self.noise))))

    def _others(self, accepted: Sequence[Term], start: Sequence[AnyTerm]) -> list[AnyTerm]:
        """Return the nuisances that are not accepted effects, as far as they have come."""
        taken = {term.place for term in accepted}
        known = {term.place: term for term in start}
        return [known.get(term.place, term) for term in self._tolerated
                if term.place not in taken]

    def away(self, terms: Sequence[AnyTerm]) -> Array:
        """Return how far the free numbers are from nominal, 0 for those without a tolerance."""
        return np.concatenate([
            term.vector() - self._nominal.get(term.place, 0.0)
            if np.isfinite(term.deviations()).all() else self._away_of_cause(term)
            for term in terms])

    def _away_of_cause(self, term: AnyTerm) -> Array:
        """Return how far a cause's numbers with a tolerance are from the arm's own."""
        known = np.isfinite(term.deviations())
        if not known.any() or not isinstance(term, Term):
            return np.zeros(term.size)
        own = replace(term, effect=self.arm.effect(*term.place))
        return np.where(known, term.vector() - own.vector(), 0.0)


def moved(terms: Sequence[AnyTerm], step: Array) -> list[AnyTerm]:
    """Return terms with their free numbers moved."""
    return [term.moved(step[own]) if isinstance(term, Term) else term.at(term.vector() + step[own])
            for term, own in columns_of(terms)]


def room(terms: Sequence[AnyTerm]) -> tuple[Array, Array]:
    """Return how far each free number (p,) may go down and up until no arm has it."""
    down, up = zip(*map(_ways_to_bounds, terms))
    return np.concatenate(down), np.concatenate(up)


def _ways_to_bounds(term: AnyTerm) -> tuple[Array, Array]:
    """Return how far the free numbers (p,) of a term are from their lower and upper bounds."""
    if not isinstance(term, Term):
        return np.full(term.size, np.inf), np.full(term.size, np.inf)
    low, high = term.declared()
    now = term.vector()
    return np.abs(low - now), np.abs(high - now)


def deviations(terms: Sequence[AnyTerm]) -> Array:
    """Return the tolerances of all free numbers."""
    return np.concatenate([term.deviations() for term in terms])

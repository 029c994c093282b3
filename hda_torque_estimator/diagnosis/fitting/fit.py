"""Fit terms to the balances of one measurement: Gauss-Newton with the exact model."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from operator import is_
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.parameter import ParameterError
from hda_arm_sim.model.arm import Arm, ArmError
import numpy as np
from numpy.typing import NDArray

from .column_noise import ColumnNoise
from .nuisance import AnyTerm, nuisances
from .slopes import has_noise, of_noise, Slopes, without
from .solve import condense, covariance, score, solve
from .steps import groups_at_once, places_of, stepped
from ..balances.balance import Balance, Balancer, RATE
from ..balances.known import Known
from ...least_squares.descent import damped, improved
from ...least_squares.sandwich import sandwich
from ...least_squares.term import Place, Term, with_terms

IMPOSSIBLE = (ArmError, ParameterError)     # no arm can have such numbers
# Choices unless told otherwise.
PASSES = 4              # of a fit of all numbers, at most
_REFINEMENTS = 6        # further passes of a fit that still gains
_TWINS = 2              # of other rows, for which what fits them is kept
_ARMS = 4               # that were asked for last and are known
_UNMOVED = 6            # balances whose columns for the arm as given are: two fits and their noise
_SHARES = (1.0, 0.4, 0.1)       # of a step that are tried, the longest first
_BLOCK = 1.0            # within which residuals may go together [s]
CLOSE = 0.5             # improvement of the score that is not worth another pass
FAR = 100.0             # improvement by a step after which no derivative is as it was


class _Base(NamedTuple):
    """Terms that were changed last, and the arm with them."""

    terms: tuple[AnyTerm, ...]
    arm: Arm


class _Unmoved(NamedTuple):
    """Balances and their columns (m, c, p) of all tolerated numbers, for an arm as given."""

    balancer: Balancer
    arm: Arm
    columns: Array


class _Step(NamedTuple):
    """A step of one free number, which shows in some channels of its column."""

    column: int
    channels: slice | list[int]
    size: float


class _Trial(NamedTuple):
    """An arm that is some steps on, which do not meet."""

    arm: Arm
    steps: list[_Step]


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
    _healthy: Known['Fitter'] = field(default_factory=lambda: Known(_TWINS), repr=False)
    _loud: Known[ColumnNoise] = field(default_factory=lambda: Known(_TWINS), repr=False)
    _unmoved: Known['_Unmoved'] = field(default_factory=lambda: Known(_UNMOVED), repr=False)
    _base: list['_Base'] = field(default_factory=list, init=False, repr=False)  # the last, if any
    _arms: list['_Base'] = field(default_factory=list, init=False, repr=False)

    @property
    def led(self) -> bool:
        """Tell whether links are led: then motor balances alone tell, of motor and torsion."""
        return self.balancer.measurement.led

    @property
    def healthy(self) -> 'Fitter | None':
        """Return what fits the twin, None without one: what that finds, it finds by chance."""
        twin = self.twin
        if twin is None:
            return None
        key = id(twin), id(self.arm), self.effective, self.rows.tobytes()
        return self._healthy.of(key, lambda: self._fitting(twin))

    def _fitting(self, twin: Balancer) -> 'Fitter':
        """Return what fits a twin beside the noise that it has itself."""
        balance = twin(self.arm)
        power = np.where(balance.valid, balance.residual ** 2, 0.0).sum(axis=0)
        noise = np.sqrt(power / np.maximum(balance.valid.sum(axis=0), 1))
        return Fitter(twin, self.arm, np.where(noise > 0.0, noise, self.noise), self.effective,
                      self.rows, instruments=self.balancer, _unmoved=self._unmoved)

    @cached_property
    def _tolerated(self) -> tuple[AnyTerm, ...]:
        return nuisances(self.arm)

    @cached_property
    def _nominal(self) -> dict[Place, Array]:
        return {term.place: term.vector() for term in self._tolerated}

    @cached_property
    def first(self) -> Fit:
        """Return the fit without any cause."""
        return self.fit(())

    def on(self, terms: Sequence[AnyTerm]) -> Arm:
        """Return the arm as given with these terms, which may have been asked for before."""
        for known in (*self._base, *self._arms):
            if _same(known.terms, terms):
                return known.arm
        arm = with_terms(self.arm, terms)
        self._arms[:] = [_Base(tuple(terms), arm), *self._arms[:_ARMS - 1]]
        return arm

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
        own = [replace(term, effect=self.arm.effect(*term.place))
               if isinstance(term, Term) else term for term in terms]
        for share in (1.0, 0.5, 0.25):
            closer = [term.at(near.vector() + share * (term.vector() - near.vector()))
                      for near, term in zip(own, terms)]
            try:
                self.on(closer)
            except IMPOSSIBLE:
                continue
            return closer if share < 1.0 else terms
        return list(own)

    def refit(self, fit: Fit, term: Term) -> Fit:
        """Return a fit with one more term, after two steps with the others' columns as given."""
        kept = [other for other in fit.nuisance if other.place != term.place]
        terms: list[AnyTerm] = [*fit.accepted, term, *kept]
        first, count = sum(other.size for other in fit.accepted), len(fit.accepted) + 1
        known = fit.columns[:, :, places_of(fit.terms, [*fit.accepted, *kept])]
        own = without([term], self.derivatives([term], terms), fit.slopes.noise)
        start = self._descend(self.at(terms, count, fit.slopes.with_columns(np.concatenate(
            [known[:, :, :first], own, known[:, :, first:]], axis=2))), count)
        return self._descend(self._renewed(start, start.accepted[-1:], first), count)

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
        return self.at(fit.terms_beside(term), len(fit.accepted) - 1,
                       fit.slopes.with_columns(fit.columns[:, :, ~fit.own(term)]))

    def settled(self, fit: Fit) -> Fit:
        """Return a fit after one step more, for a fitter of other rows."""
        return self._descend(self.at(fit.terms, len(fit.accepted), fit.slopes),
                             len(fit.accepted))

    def _renewed(self, fit: Fit, terms: Sequence[AnyTerm], place: int) -> Fit:
        """Return a fit with the columns of some neighbouring terms made again."""
        columns = fit.columns.copy('K')
        fresh = without(terms, self.derivatives(terms, fit.terms), fit.slopes.noise)
        columns[:, :, place:place + fresh.shape[2]] = fresh
        return replace(fit, slopes=fit.slopes.with_columns(columns))

    def _slopes(self, terms: Sequence[AnyTerm]) -> Slopes:
        """Return the derivatives of terms, those of numbers with a tolerance without noise."""
        columns = (self._columns_as_given(self.balancer) if _same(terms, self._tolerated)
                   else self.derivatives(terms, terms))
        other = self.instruments or self.twin
        if other is None:
            return Slopes(columns, {})
        balance = self.balancer(self.on(terms))
        noise = self._column_noise(other).told(
            terms, columns, balance.residual, balance.valid,
            np.where(self.valid(balance), 1.0 / self.noise, 0.0))
        return Slopes(without(terms, columns, noise), noise)

    def _columns_as_given(self, balancer: Balancer) -> Array:
        """Return the columns (m, c, p) of tolerated numbers in balances, which may be known."""
        known = self._tolerated
        return self._unmoved.of((id(balancer), id(self.arm)), lambda: _Unmoved(
            balancer, self.arm,
            replace(self, balancer=balancer).derivatives(known, known))).columns

    def _column_noise(self, twin: Balancer) -> ColumnNoise:
        """Return how loud the columns of tolerated numbers are, those of a `twin` beside them."""
        own = self.balancer

        def made() -> ColumnNoise:
            balance = own(self.arm)
            return ColumnNoise.made(
                self._tolerated, self._columns_as_given(twin),
                self._columns_as_given(own.noisier) - self._columns_as_given(own),
                own.noisier(self.arm).residual - balance.residual, balance.valid,
                (own, twin, self.arm))

        return self._loud.of((id(own), id(twin), id(self.arm)), made)

    def residual(self, terms: Sequence[AnyTerm], noise: Mapping[Place, Array]) -> Array:
        """Return what terms leave (m, c), as noisy as the arm as given [N*m] (eq:noiseless)."""
        return self.balancer(self.on(terms)).residual - sum(
            of_noise(term, self.arm, noise) for term in terms)

    def as_noisy(self, fit: Fit) -> Arm:
        """Return an arm that leaves as much noise as a fit does."""
        try:
            return self.on([term for term in fit.terms if not has_noise(term, fit.slopes.noise)])
        except IMPOSSIBLE:
            return self.on(fit.terms)

    def _descend(self, fit: Fit, accepted: int) -> Fit:
        """Return the fit after one step that improves it, shortened if need be, or itself."""
        condensed = condense(fit.balance.residual, fit.columns, self.valid(fit.balance))
        step = solve(condensed, self.noise, self.effective, self.away(fit.terms),
                     fit.deviations).step

        def trial(share: float) -> Fit | None:
            try:
                return self.at(moved(fit.terms, share * step), accepted, fit.slopes)
            except IMPOSSIBLE:
                return None

        return damped(trial, _SHARES, lambda found: found.score < fit.score) or fit

    def at(self, terms: Sequence[AnyTerm], accepted: int, slopes: Slopes) -> Fit:
        """Return the fit with these terms as they are, exactly evaluated."""
        balance = Balance(self.residual(terms, slopes.noise),
                          self.balancer(self.on(terms)).valid)
        valid = self.valid(balance)
        count = np.maximum(valid.sum(axis=0), 1)
        left = np.where(valid, balance.residual ** 2, 0.0).sum(axis=0) / count
        prior = float(np.sum((self.away(terms) / deviations(terms)) ** 2))
        return Fit(tuple(terms[:accepted]), tuple(terms[accepted:]),   # type: ignore[arg-type]
                   balance, slopes, score(left, valid.sum(axis=0), self.noise, self.effective)
                   + prior, np.maximum(left, self.noise ** 2))

    def covariance(self, fit: Fit) -> Array:
        """
        Return how uncertain a fit is: covariances (p, p), those of accepted terms first.

        They are those of noise, widened where blocks of the recording pull more apart than
        noise would (Huber's sandwich, by blocks of a second).
        """
        valid, tolerances = self.valid(fit.balance), deviations(fit.terms)
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
        shape = 2 * len(self.arm.joints), sum(term.size for term in terms)
        columns = np.zeros((*shape, len(self.balancer.time))).transpose(2, 0, 1)   # each in a row
        trials = list(self._trials(terms, among))
        self.balancer.thinned.run_ahead(self._known(among), [trial.arm for trial in trials])
        for trial in trials:
            shift = self.change(among, trial.arm)
            for step in trial.steps:
                columns[:, step.channels, step.column] = shift[:, step.channels] / step.size
        return columns

    def change(self, terms: Sequence[AnyTerm], arm: Arm) -> Array:
        """
        Return what the residual (m, c) of an arm has more than that of the terms [N*m].

        Noise is the same in both, so fewer samples tell as much.
        """
        return self.balancer.thinned.change(arm, self._known(terms))

    def _known(self, terms: Sequence[AnyTerm]) -> Arm:
        """Return the arm with terms, which is asked for many times."""
        if not self._base or not _same(self._base[0].terms, terms):
            self._base[:] = [_Base(tuple(terms), self.on(terms))]
        return self._base[0].arm

    def _trials(self, terms: Sequence[AnyTerm], among: Sequence[AnyTerm]) -> Iterator[_Trial]:
        """Yield arms that are steps on from terms, one for all that a simulation can vary."""
        for group in groups_at_once(terms):
            changed, steps = {id(term): term for term in among}, []
            for place, number, column in group:
                term = terms[place]
                moved_on = changed[id(term)] = stepped(term, number)
                size = float((moved_on.vector() - term.vector())[number])
                channels = slice(None) if len(group) == 1 else self.own_channels(term.joint)
                if size:
                    steps.append(_Step(column, channels, size))
            try:
                yield _Trial(self.on(list(changed.values())), steps)
            except IMPOSSIBLE:
                continue                            # no way to go: the column stays zero

    def own_channels(self, joint: str | None) -> list[int]:
        """Return the channels of a joint: its A and its B."""
        place = self.arm.labels.index(str(joint))
        return [place, len(self.arm.labels) + place]

    def channels_of(self, term: Term) -> list[int]:
        """Return the channels in which a term may show: those of its joint, or all."""
        return (self.own_channels(term.joint) if term.joint is not None
                else list(range(2 * len(self.arm.labels))))

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
            if np.isfinite(term.deviations()).all() else np.zeros(term.size) for term in terms])


def _same(terms: Sequence[AnyTerm], others: Sequence[AnyTerm]) -> bool:
    """Tell whether terms are the very same."""
    return len(terms) == len(others) and all(map(is_, terms, others))


def moved(terms: Sequence[AnyTerm], step: Array) -> list[AnyTerm]:
    """Return terms with their free numbers moved."""
    ends = np.cumsum([term.size for term in terms])
    parts = [step[end - term.size:end] for term, end in zip(terms, ends)]
    return [term.moved(part) if isinstance(term, Term) else term.at(term.vector() + part)
            for term, part in zip(terms, parts)]


def deviations(terms: Sequence[AnyTerm]) -> Array:
    """Return the tolerances of all free numbers."""
    return np.concatenate([term.deviations() for term in terms])

"""Derivatives of the balances of one measurement, and their noise, about one arm as given."""

from collections.abc import Callable, Iterator, Mapping, MutableMapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from operator import is_
from typing import NamedTuple
from weakref import WeakKeyDictionary

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.parameter import ParameterError
from hda_arm_sim.model.arm import Arm, ArmError
import numpy as np

from .column_noise import ColumnNoise
from .hypotheses import carried_by, terms_of
from .nuisance import AnyTerm, nuisances
from .steps import groups_at_once, Sized, sized, stepped
from ..balances.balance import Balance, Balancer
from ..balances.channels import channels_of, noisy_by_torques, sides
from ...least_squares.term import Term, with_terms

IMPOSSIBLE = (ArmError, ParameterError)     # no arm can have such numbers
# Numerics; choices unless stated otherwise.
_ARMS = 4               # that were asked for last and are known


class _With(NamedTuple):
    """Terms that were asked for, and the arm with them."""

    terms: tuple[AnyTerm, ...]
    arm: Arm


class _Step(NamedTuple):
    """A step of one free number, which shows in some channels of its column."""

    column: int
    channels: slice | list[int]
    size: float


class _SteppedArm(NamedTuple):
    """An arm that is some steps on, which do not meet."""

    arm: Arm
    steps: list[_Step]


class TermColumns(NamedTuple):
    """Terms, and the derivative columns (m, c, p) along their numbers."""

    terms: tuple[AnyTerm, ...]
    columns: Array


@dataclass(frozen=True, eq=False)
class Derivatives:
    """Derivative columns of balances, along the numbers of terms of an arm."""

    balancer: Balancer
    arm: Arm
    _base: list[_With] = field(default_factory=list, init=False, repr=False)  # the last, if any
    _arms: list[_With] = field(default_factory=list, init=False, repr=False)
    # By the twin, and as long as it lives: two may know each other.
    _noise: MutableMapping['Derivatives', ColumnNoise] = field(
        default_factory=WeakKeyDictionary, init=False, repr=False)
    _carried: MutableMapping['Derivatives', ColumnNoise] = field(
        default_factory=WeakKeyDictionary, init=False, repr=False)

    def on(self, terms: Sequence[AnyTerm]) -> Arm:
        """Return the arm as given with these terms, which may have been asked for before."""
        for known in (*self._base, *self._arms):
            if same(known.terms, terms):
                return known.arm
        arm = with_terms(self.arm, terms)
        arm.record()                                    # some numbers are impossible together
        self._arms[:] = [_With(tuple(terms), arm), *self._arms[:_ARMS - 1]]
        return arm

    def of(self, terms: Sequence[AnyTerm], among: Sequence[AnyTerm]) -> Array:
        """Return the derivative columns (m, c, p) of terms, all of which are `among` others."""
        shape = (sides(self.balancer.measurement) * len(self.arm.joints),
                 sum(term.size for term in terms))
        columns = np.zeros((*shape, len(self.balancer.time))).transpose(2, 0, 1)   # each in a row
        trials = list(self._trials(terms, among))
        self.balancer.thinned.run_ahead(self._about(among), [trial.arm for trial in trials])
        for trial in trials:
            shift = self.change(among, trial.arm)
            for step in trial.steps:
                columns[:, step.channels, step.column] = shift[:, step.channels] / step.size
        return columns

    def change(self, terms: Sequence[AnyTerm], arm: Arm) -> Array:
        """
        Return what the residual (m, c) of an arm has more than that of the terms [N*m].

        Noise is the same in both, so fewer samples show as much.
        """
        return self.balancer.thinned.change(arm, self._about(terms))

    @cached_property
    def tolerated(self) -> tuple[AnyTerm, ...]:
        """Return what may differ from the arm as given without being wrong."""
        measurement = self.balancer.measurement
        return nuisances(self.arm, measurement.untold, measurement.reference_spread(),
                         measurement.unscaled)

    @cached_property
    def as_given(self) -> Array:
        """Return the columns (m, c, q) of what is tolerated, for the arm as given."""
        return self.of(self.tolerated, self.tolerated)

    def noise_beside(self, twin: 'Derivatives') -> ColumnNoise:
        """Return what is known of the noise of `as_given` beside a twin of the same motion."""
        if twin not in self._noise:
            self._noise[twin] = self._beside(
                twin, lambda some: TermColumns(some.tolerated, some.as_given))
        return self._noise[twin]

    def noise_carried(self, twin: 'Derivatives', balance: Balance,
                      weight: Array) -> dict[Sized, Array]:
        """
        Return what of the columns of what the links may carry is noise, by each of its laws.

        An arm is linear in these numbers, so they are those of any size. Where it is stated what
        they carry that is a tolerance.
        """
        if not self.carried.terms:
            return {}
        if twin not in self._carried:
            self._carried[twin] = self._beside(twin, lambda some: some.carried)
        found: dict[Sized, Array] = {}
        noises = self._carried[twin].noise_in(self.carried.terms, self.carried.columns,
                                              balance.residual, balance.valid, weight)
        for body in carried_by(self.arm):       # which contains all other laws of the effect
            for law in terms_of(self.arm, body.name):
                own = [body.free.index(number) for number in law.free]
                found[sized(law)] = np.ascontiguousarray(noises[sized(body)][:, :, own])
        return found

    @cached_property
    def carried(self) -> TermColumns:
        """Return columns of what the links may carry, as bodies of their usual masses."""
        terms = tuple(carried_by(self.arm)) if self.arm.links is not None else ()
        return TermColumns(terms, self.of(terms, [*self.tolerated, *terms]))

    def _beside(self, twin: 'Derivatives',
                columns: Callable[['Derivatives'], TermColumns]) -> ColumnNoise:
        """Return what noisier readings make of columns, beside a twin."""
        noisier, balance = Derivatives(self.balancer.noisier, self.arm), self.balancer(self.arm)
        ours = columns(self)
        return ColumnNoise.made(
            ours.terms, twin.as_given, columns(noisier).columns - ours.columns,
            noisier.balancer(self.arm).residual - balance.residual, balance.valid,
            noisy_by_torques(self.balancer.measurement))

    def _about(self, terms: Sequence[AnyTerm]) -> Arm:
        """Return the arm with terms, which is asked for many times."""
        if not self._base or not same(self._base[0].terms, terms):
            self._base[:] = [_With(tuple(terms), self.on(terms))]
        return self._base[0].arm

    def _trials(self, terms: Sequence[AnyTerm], among: Sequence[AnyTerm]) -> Iterator[_SteppedArm]:
        """Yield arms that are steps on from terms, one for all that a simulation can vary."""
        for group in groups_at_once(terms):
            changed, steps = {}, []
            for place, number, column in group:
                term = terms[place]
                moved_on = changed[id(term)] = stepped(term, number)
                size = float((moved_on.vector() - term.vector())[number])
                channels = (slice(None) if len(group) == 1
                            else channels_of(self.balancer.measurement,
                                             self.arm.labels.index(str(term.joint))))
                if size:
                    steps.append(_Step(column, channels, size))
            try:
                yield _SteppedArm(self._with(changed, among), steps)
            except IMPOSSIBLE:
                continue                            # no way to go: the column stays zero

    def _with(self, changed: Mapping[int, AnyTerm], among: Sequence[AnyTerm]) -> Arm:
        """Return the arm with terms `among` which some have `changed`, by their identity."""
        if not all(isinstance(term, Term) and term.is_whole for term in changed.values()):
            return self.on([changed.get(id(term), term) for term in among])
        arm = with_terms(self._about(among), changed.values())      # effects replace each other
        arm.record()
        return arm


def same(terms: Sequence[AnyTerm], others: Sequence[AnyTerm]) -> bool:
    """Return whether terms are the very same."""
    return len(terms) == len(others) and all(map(is_, terms, others))

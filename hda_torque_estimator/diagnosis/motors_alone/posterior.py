"""
How probable each set of causes is, given what a fit of columns leaves (eq:set-evidence).

A cause has columns, and a prior of how much it usually does. Its law may have another form: smooth
changes of its columns, with a prior of their own. Causes without a name are smooth curves along
one coordinate. The evidence of a set has all numbers integrated out, so more freedom costs what it
is worth. A beam of sets grows by adding, dropping and swapping causes.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
import numpy as np

from ...significance import SCORE_BAR

# Numerics; choices unless stated otherwise.
_BEAM = 12              # sets of different causes that are extended in every round,
_ROUNDS = 10            # of which there are at most so many
_NONE = 1e-9            # prior of a form of a law that does nothing: it has none
_DIGITS = 9             # of a probability: the last ones depend on how a machine sums


class Law(NamedTuple):
    """
    One law of a cause: columns (k, p), their priors (p,), and other forms of it (k, f).

    A form does as much as the law per unit of its first number; `spread` of that is its prior.
    """

    columns: Array
    deviations: Array
    forms: Array
    spread: float = 0.0
    least: float = -np.inf      # of the first number
    weight: float = 1.0         # how likely it is beside the other laws of its cause


@dataclass(frozen=True)
class PossibleCause:
    """What may be at work: its laws, and how likely one of the usual ones is at all."""

    name: str
    laws: tuple[Law, ...]
    prior: float
    named: bool = True

    def odds(self, number: int) -> float:
        """
        Return the log odds, before anything is seen, that one of its laws acts.

        The usual laws share those of the cause, and other laws come on top of them.
        """
        share = self.laws[number].weight / sum(law.weight for law in self.usual())
        return float(np.log(share * self.prior / (1.0 - self.prior)))

    def usual(self) -> list[Law]:
        """Return the laws of which none is likelier."""
        most = max(law.weight for law in self.laws)
        return [law for law in self.laws if law.weight == most]


Set = tuple[tuple[int, int], ...]       # causes, and which law of each


class WeighedSet(NamedTuple):
    """One set of causes: its log evidence with the prior, and the numbers of its columns."""

    chosen: Set
    evidence: float
    numbers: Array
    covariance: Array


class Posterior(NamedTuple):
    """The sets that were looked at, the most probable first, and their probabilities."""

    causes: tuple[PossibleCause, ...]
    sets: tuple[WeighedSet, ...]
    probability: Array

    def of(self, name: str) -> float:
        """Return the probability of a cause: that of all sets that hold it."""
        return round(float(sum(share for share, one in zip(self.probability, self.sets)
                               if name in self.names(one))), _DIGITS)

    def nameless(self) -> float:
        """Return the probability that something without a name is at work."""
        return float(sum(share for share, one in zip(self.probability, self.sets)
                         if any(not self.causes[place].named for place, _ in one.chosen)))

    def either(self, name: str, other: str) -> float:
        """Return the probability of the sets that hold one of two causes, or both."""
        return float(sum(share for share, one in zip(self.probability, self.sets)
                         if {name, other} & set(self.names(one))))

    def names(self, one: WeighedSet) -> list[str]:
        """Return the causes of a set."""
        return [self.causes[place].name for place, _ in one.chosen]


class Weigher:
    """The evidence of sets of causes for one residual (k,) with white noise of a variance."""

    def __init__(self, residual: Array, known: Array, deviations: Array,
                 causes: Sequence[PossibleCause], variance: float) -> None:
        """Condense all columns; `known` ones (k, q) of these priors (q,) are in every set."""
        self._precision = 1.0 / deviations ** 2         # of infinite ones, zero
        self.causes = tuple(causes)
        self._places: dict[tuple[int, int], slice] = {}
        parts, end = [known], known.shape[1]
        for place, cause in enumerate(self.causes):
            for number, law in enumerate(cause.laws):
                size = law.columns.shape[1] + law.forms.shape[1]
                self._places[place, number] = slice(end, end + size)
                parts += [law.columns, law.forms]
                end += size
        self._known = known.shape[1]
        together = np.concatenate(parts, axis=1)
        self._gram = together.T @ together / variance
        self._against = together.T @ residual / variance

    def weigh(self, chosen: Set) -> WeighedSet | None:
        """Return what a set of causes is worth, None where a number is beyond its bounds."""
        laws = [self.causes[place].laws[number] for place, number in chosen]
        plain = self._solved(chosen, [np.r_[law.deviations, np.full(law.forms.shape[1], _NONE)]
                                      for law in laws])
        sizes = [abs(plain.numbers[first]) for first in self._firsts(laws)]
        found = self._solved(chosen, [
            np.r_[law.deviations, np.full(law.forms.shape[1], max(law.spread * size, _NONE))]
            for law, size in zip(laws, sizes)])
        if any(found.numbers[first] < law.least
               for law, first in zip(laws, self._firsts(laws))):
            return None
        odds = sum(self.causes[place].odds(number) for place, number in chosen)
        return found._replace(evidence=found.evidence + odds)

    def _firsts(self, laws: Sequence[Law]) -> list[int]:
        """Return the place of the first number of each law."""
        sizes = [law.columns.shape[1] + law.forms.shape[1] for law in laws]
        return [self._known + sum(sizes[:place]) for place in range(len(laws))]

    def _solved(self, chosen: Set, deviations: Sequence[Array]) -> WeighedSet:
        """Return the numbers of a set and its log evidence, for these priors."""
        rows = np.concatenate([np.arange(self._known), *(
            np.arange(self._places[each].start, self._places[each].stop) for each in chosen)])
        precision = np.concatenate([self._precision, *(each ** -2.0 for each in deviations)])
        normal = self._gram[np.ix_(rows, rows)] + np.diag(precision)
        scale = 1.0 / np.sqrt(np.maximum(np.diag(normal), 1e-300))
        scaled = normal * np.outer(scale, scale) + 1e-10 * np.eye(len(rows))
        inverse = np.linalg.inv(scaled) * np.outer(scale, scale)
        numbers = inverse @ self._against[rows]
        freedom = (float(np.linalg.slogdet(scaled)[1]) - 2.0 * float(np.log(scale).sum())
                   - float(np.log(precision[self._known:]).sum()))
        return WeighedSet(chosen, 0.5 * float(self._against[rows] @ numbers) - 0.5 * freedom,
                          numbers, inverse)


def posterior(weigher: Weigher) -> Posterior:
    """Return how probable sets of causes are, by a beam from the empty one."""
    empty = weigher.weigh(())
    assert empty is not None
    known: dict[Set, WeighedSet | None] = {(): empty}
    extended: set[Set] = set()
    for _ in range(_ROUNDS):
        best = _apart(_best(known))
        ahead = [one.chosen for one in best[:_BEAM] if one.chosen not in extended
                 and one.evidence > best[0].evidence - 0.5 * SCORE_BAR]
        if not ahead:
            break
        for chosen in ahead:
            extended.add(chosen)
            for near in _neighbours(weigher.causes, chosen):
                if near not in known:
                    known[near] = weigher.weigh(near)
    best = _best(known)
    odds = np.exp(np.array([one.evidence for one in best]) - best[0].evidence)
    return Posterior(weigher.causes, tuple(best), odds / odds.sum())


def _best(known: Mapping[Set, WeighedSet | None]) -> list[WeighedSet]:
    """Return the sets that an arm can have, the most probable first."""
    return sorted((one for one in known.values() if one is not None),
                  key=lambda one: -one.evidence)


def _apart(best: Sequence[WeighedSet]) -> list[WeighedSet]:
    """Return the first set of each choice of causes: other laws of them are near it anyway."""
    first: dict[tuple[int, ...], WeighedSet] = {}
    for one in best:
        first.setdefault(tuple(place for place, _ in one.chosen), one)
    return list(first.values())


def _neighbours(causes: Sequence[PossibleCause], chosen: Set) -> Iterator[Set]:
    """Yield a set with one cause more, one less, another one, or another law of one."""
    taken = {place for place, _ in chosen}
    others = [(place, number) for place, cause in enumerate(causes) if place not in taken
              for number in range(len(cause.laws))]
    for each in others:
        yield tuple(sorted((*chosen, each)))
    for gone in chosen:
        rest = tuple(each for each in chosen if each != gone)
        yield rest
        laws = [(gone[0], number) for number in range(len(causes[gone[0]].laws))]
        for each in (*others, *laws):
            yield tuple(sorted((*rest, each)))

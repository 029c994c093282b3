"""Numbers of terms that derivatives step along: how far, and which of them at once."""

from collections.abc import Iterator, Sequence
from typing import TypeAlias

from hda_arm_sim.model.effects import effect_named, Scope, Site

from .nuisance import AnyTerm, OneNumber
from ...least_squares.term import Place

# Numerics; choices unless stated otherwise.
_FINE = 0.01            # share of the usual step in a derivative: noise is the same at both ends

# A place and how many numbers are free there: another law of a cause has others.
Sized: TypeAlias = tuple[Place, int]


def sized(term: AnyTerm) -> Sized:
    """Return the place of a term, and how many numbers it has."""
    return term.place, term.size


def stepped(term: AnyTerm, number: int) -> AnyTerm:
    """Return a term with one number a fine step on, or back from its bound."""
    for step in (_FINE, -_FINE):
        vector = term.vector()
        vector[number] += step * term.all_steps()[number]
        moved_on = term.at(vector)
        if (moved_on.vector() != term.vector()).any():
            break
    return moved_on


def places_of(terms: Sequence[AnyTerm], chosen: Sequence[AnyTerm]) -> list[int]:
    """Return the columns of chosen terms among those of all terms."""
    picked = {id(term) for term in chosen}
    return [column for term, own in columns_of(terms) if id(term) in picked
            for column in range(own.start, own.stop)]


def columns_of(terms: Sequence[AnyTerm]) -> Iterator[tuple[AnyTerm, slice]]:
    """Yield each term with the place of its columns among those of all."""
    end = 0
    for term in terms:
        end += term.size
        yield term, slice(end - term.size, end)


def groups_at_once(terms: Sequence[AnyTerm]) -> list[list[tuple[int, int, int]]]:
    """
    Return numbers (term, number, column) that one simulation can vary at once.

    Motor and torsion effects of different joints do not meet: each shows in its own joint only.
    """
    groups: dict[object, list[tuple[int, int, int]]] = {}
    column = 0
    for place, term in enumerate(terms):
        for number in range(term.size):
            key = (term.name, number) if acts_apart(term) else (place, number)
            member = groups.setdefault(key, [])
            if any(terms[other].joint == term.joint for other, _, _ in member):
                member = groups.setdefault((place, number), [])
            member.append((place, number, column))
            column += 1
    return list(groups.values())


def acts_apart(term: AnyTerm) -> bool:
    """Return whether a term shows in its own joint only."""
    if isinstance(term, OneNumber):
        return term.joint is not None
    kind = effect_named(term.name)
    return kind.scope is Scope.JOINT and kind.site is not Site.LINK

"""
Loops over all effects of one place, unrolled into compiled code.

Compiled code cannot loop over effects, for each has a record and a law of its own. So the loop is
unrolled here, when the module of a place is imported. Every effect of the place becomes one more
step around those before it, in the order of the catalogue.
"""

from typing import Any, TypeAlias

import numba

from .effects.catalogue import effects_at, sole_at
from .effects.effect import Effect
from .effects.place import Place
from ..foundation.compiled import Record

Compiled: TypeAlias = Any

# Part of whoever calls it, and cached with the caller.
_unrolled = numba.njit(error_model='numpy', forceinline=True, nogil=True)


def added(place: Place, law: str = 'law') -> Compiled:
    """Return `f(owner, signals, value)`: the value and what every law of the place adds to it."""
    return _unrolled_effects(place, law, _as_they_are, _sum)


def pair_added(place: Place) -> Compiled:
    """Return the same for laws and values that are pairs."""
    return _unrolled_effects(place, 'law', _as_they_are, _sum_of_pairs)


def triple_added(place: Place) -> Compiled:
    """Return the same for laws on chains and values that are triples."""
    return _unrolled_effects(place, 'law_chain', _as_they_are, _sum_of_triples)


def grown(place: Place, renewed: Compiled) -> Compiled:
    """Return the same for laws that read the value so far: `renewed(signals, value)`."""
    return _unrolled_effects(place, 'law', renewed, _sum)


def passed(place: Place, renewed: Compiled, law: str = 'law') -> Compiled:
    """Return `f(owner, signals, value)`: the value after every law has changed it in turn."""
    return _unrolled_effects(place, law, renewed, _latter)


def record_at(place: Place) -> Compiled:
    """Return `f(owner)`: the numbers of the only effect of a place, which keeps a state there."""
    return record_of(sole_at(place))


def record_of(effect: type[Effect]) -> Compiled:
    """Return `f(owner)`: the numbers of an effect."""
    name = effect.name

    @_unrolled
    def found(owner: Record) -> Record:
        return owner[name]
    return found


def acting_at(place: Place) -> Compiled:
    """Return `f(owner)`: whether the only effect of a place does anything."""
    name, acts = sole_at(place).name, _condition(sole_at(place).acts)

    @_unrolled
    def found(owner: Record) -> bool:
        return acts(owner[name])
    return found


def numbers_at(owner: Any, place: Place) -> Any:
    """Return what compiled code has of `record_at`, outside of it: of one owner or of many."""
    return owner[sole_at(place).name]


def any_acts(owner: Any, *places: Place) -> bool:
    """Return whether, in one owner or many, an effect does anything at one of these places."""
    return any(owner[effect.name][number].any() for place in places
               for effect in effects_at(place) for number in effect.acts)


def where_acts(owners: Any, *places: Place) -> tuple[int, ...]:
    """Return which of many owners an effect does anything to at one of these places."""
    return tuple(number for number, owner in enumerate(owners) if any_acts(owner, *places))


def total_at(place: Place, law: str, owner: Any, at: Any) -> float:
    """Return what `added` returns from zero on, of one owner and outside of compiled code."""
    return float(sum(getattr(effect, law)(owner[effect.name], at) for effect in effects_at(place)
                     if getattr(effect, law) is not None))


def _unrolled_effects(place: Place, law: str, renewed: Compiled, joined: Compiled) -> Compiled:
    """
    Return all effects of a place that have such a law, one step around the other.

    `renewed(signals, value)` are the signals that a law reads, `joined(value, result)` is the
    value after it.
    """
    total: Compiled = _nothing
    for effect in effects_at(place):
        if (one := getattr(effect, law)) is not None:
            total = _step(total, effect.name, one, _condition(effect.acts), renewed, joined)
    return total


def _step(before: Compiled, name: str, law: Compiled, acts: Compiled, renewed: Compiled,
          joined: Compiled) -> Compiled:
    @_unrolled
    def total(owner: Record, at: Any, value: Any) -> Any:
        value = before(owner, at, value)
        own = owner[name]
        if acts(own):
            value = joined(value, law(own, renewed(at, value)))
        return value
    return total


@_unrolled
def _nothing(owner: Record, at: Any, value: Any) -> Any:
    """Return the value as it is."""
    return value


@_unrolled
def _as_they_are(at: Any, value: Any) -> Any:
    return at


@_unrolled
def _sum(value: Any, more: Any) -> Any:
    return value + more


@_unrolled
def _sum_of_pairs(value: Any, more: Any) -> Any:
    return value[0] + more[0], value[1] + more[1]


@_unrolled
def _sum_of_triples(value: Any, more: Any) -> Any:
    return value[0] + more[0], value[1] + more[1], value[2] + more[2]


@_unrolled
def _latter(value: Any, changed: Any) -> Any:
    return changed


def _condition(numbers: tuple[str, ...]) -> Compiled:
    """Return a test of whether one of a record's numbers is not zero; true without any."""
    always = not numbers

    @_unrolled
    def found(own: Record) -> bool:         # a function for each effect: each has its record
        return always
    total: Compiled = found
    for number in numbers:
        total = _or(total, number)
    return total


def _or(before: Compiled, number: str) -> Compiled:
    @_unrolled
    def acts(own: Record) -> bool:
        return before(own) or own[number] != 0.0
    return acts

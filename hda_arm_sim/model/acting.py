"""
Let all effects of one place act, whichever the catalogue has there.

Compiled code cannot loop over effects, for each has a record and a law of its own. So the loop is
unrolled here, when the module of a place is imported. Every effect of the place becomes one more
step around those before it, in the order of the catalogue.
"""

from collections.abc import Callable
from typing import Any, TypeAlias

import numba

from .compiled import Record
from .effects.catalogue import effects_at
from .effects.place import Place

Compiled: TypeAlias = Any
Step: TypeAlias = Callable[[Compiled, str, Compiled, Compiled], Compiled]

# Part of whoever calls it, and cached with the caller.
_unrolled = numba.njit(error_model='numpy', forceinline=True, nogil=True)


def added(place: Place, law: str = 'law') -> Compiled:
    """Return `f(owner, signals, value)`: the value and what every law of the place adds to it."""
    return _unroll(place, law, _adding)


def pair_added(place: Place) -> Compiled:
    """Return the same for laws and values that are pairs."""
    return _unroll(place, 'law', _adding_pairs)


def grown(place: Place, renewed: Compiled) -> Compiled:
    """Return the same for laws that read the value so far: `renewed(signals, value)`."""
    return _unroll(place, 'law', _growing(renewed))


def passed(place: Place, renewed: Compiled, law: str = 'law') -> Compiled:
    """Return `f(owner, signals, value)`: the value after every law has changed it in turn."""
    return _unroll(place, law, _passing(renewed))


def _unroll(place: Place, law: str, step: Step) -> Compiled:
    """Return all effects of a place that have such a law, one step around the other."""
    total: Compiled = _nothing
    for effect in effects_at(place):
        if (one := getattr(effect, law)) is not None:
            total = step(total, effect.name, one, _condition(effect.acts))
    return total


@_unrolled
def _nothing(owner: Record, at: Any, value: Any) -> Any:
    """Return the value as it is."""
    return value


def _adding(before: Compiled, name: str, law: Compiled, acts: Compiled) -> Compiled:
    @_unrolled
    def total(owner: Record, at: Any, value: Any) -> Any:
        value = before(owner, at, value)
        own = owner[name]
        if acts(own):
            value = value + law(own, at)
        return value
    return total


def _adding_pairs(before: Compiled, name: str, law: Compiled, acts: Compiled) -> Compiled:
    @_unrolled
    def total(owner: Record, at: Any, value: Any) -> Any:
        first, second = before(owner, at, value)
        own = owner[name]
        if acts(own):
            more = law(own, at)
            first, second = first + more[0], second + more[1]
        return first, second
    return total


def _growing(renewed: Compiled) -> Step:
    def step(before: Compiled, name: str, law: Compiled, acts: Compiled) -> Compiled:
        @_unrolled
        def total(owner: Record, at: Any, value: Any) -> Any:
            value = before(owner, at, value)
            own = owner[name]
            if acts(own):
                value = value + law(own, renewed(at, value))
            return value
        return total
    return step


def _passing(renewed: Compiled) -> Step:
    def step(before: Compiled, name: str, law: Compiled, acts: Compiled) -> Compiled:
        @_unrolled
        def total(owner: Record, at: Any, value: Any) -> Any:
            value = before(owner, at, value)
            own = owner[name]
            if acts(own):
                value = law(own, renewed(at, value))
            return value
        return total
    return step


def _condition(numbers: tuple[str, ...]) -> Compiled:
    """Return what tells of a record whether one of its numbers is not zero; true without any."""
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

"""
Whether causes at a joint stand in for the gain of the sensor that it is held against.

A gain beyond its tolerance is in both balances of a joint. A torque constant and a stiffness that
are both off together do the same, and so nearly do others under one kind of load. So a gain of
any size competes with what was found. Where it alone explains as much as some causes of that
joint, these are not told.
"""

from collections.abc import Iterator
from itertools import combinations

from .equal_noise import equal_noise_score, noise_in
from .search import SearchResult
from ..fitting.fit import Fit, Fitter
from ..fitting.nuisance import any_gains
from ...least_squares.term import Term
from ...significance import SCORE_BAR

# Numerics; choices unless stated otherwise.
_MOST = 3               # causes at a joint that may stand in for a gain together


def in_place_of_gain(fitter: Fitter, found: SearchResult) -> tuple[Term, ...]:
    """Return the accepted causes in whose place a gain of their sensor explains as much."""
    sensed = fitter.balancer.measurement.held_against
    return tuple(term for place, label in enumerate(fitter.arm.labels) if sensed[place]
                 for term in _of_joint(fitter, found.last, label))


def _of_joint(fitter: Fitter, fit: Fit, label: str) -> tuple[Term, ...]:
    """Return the most causes of a joint that a gain replaces, none if it replaces none."""
    usual = noise_in(fitter, fit)
    least = equal_noise_score(fitter, fit, usual) + SCORE_BAR
    for some in _sets([term for term in fit.accepted if term.joint == label]):
        others = [term for term in fit.accepted if term not in some]
        scaled = fitter.fit(others, any_gains(fit.nuisance, [label]))
        if equal_noise_score(fitter, scaled, usual) < least:
            return some
    return ()


def _sets(here: list[Term]) -> Iterator[tuple[Term, ...]]:
    for count in range(min(len(here), _MOST), 0, -1):
        yield from combinations(here, count)

"""
Which causes a rest takes back: those that act where it is, or may leave it across the gear.

What is wrong at a joint may be any of it. A cause that stands for another one across the gear
leaves there, where it does nothing itself, about as much as it explains. Much less than that is a
rest of something else, and says nothing against the cause.
"""

from collections.abc import Mapping, Sequence

from hda_arm_sim.foundation.arrays import Array
import numpy as np
from numpy.typing import NDArray

from ..fitting.fit import Fitter
from ...least_squares.term import Place, Term
from ...significance import HARDLY, MATERIAL, MOSTLY


def acts_in(power: Array) -> NDArray[np.bool_]:
    """Return in which channels (c,) a cause acts by its power over noise: most, or much."""
    return (power > MATERIAL ** 2) | (power >= MOSTLY * power.max())


def may_leave_across(rest: float, power: Array) -> bool:
    """Return whether a cause of a `power` (c,) may leave such a rest where it does nothing."""
    return bool(rest > HARDLY * power.max())


def shown_by(fitter: Fitter, terms: Sequence[Term]) -> NDArray[np.bool_]:
    """Return the channels (c,) in which some terms may show."""
    shown = np.zeros(len(fitter.noise), bool)
    for term in terms:
        shown[fitter.channels_of(term)] = True
    return shown


def of_joints(fitter: Fitter, seen: NDArray[np.bool_], doubtful: NDArray[np.bool_],
              is_nameless: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """
    Return in which channels (c,) something is unexplained, of those in which it is `seen` (c,).

    What is wrong at a joint may be any of it, so both of its channels are where one is `doubtful`
    (c,). But of what has no name the site is known: what it leaves itself stays there.
    """
    unexplained = seen.copy()
    for label in fitter.arm.labels:
        own = fitter.own_channels(label)
        unexplained[own] |= (doubtful | seen & ~is_nameless)[own].any()
    return unexplained


def blamed_by(seen: NDArray[np.bool_], unexplained: NDArray[np.bool_], left: Array,
              powers: Mapping[Place, Array]) -> set[Place]:
    """
    Return the causes of these powers (c,) that a rest takes back.

    It is `seen` (c,) where more is `left` (c,) than laws and noise may leave, and `unexplained`
    (c,) at their joints.
    """
    across = float(left[seen].max(initial=0.0))
    return {place for place, power in powers.items() if (seen & acts_in(power)).any()
            or may_leave_across(across, power) and (unexplained & acts_in(power)).any()}

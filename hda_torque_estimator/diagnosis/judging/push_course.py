"""
Pushes of any course: what a force on the tip does that changes while something touches the arm.

Nothing says how a hand or a wall pushes, nor how often. A contact of the catalogue has one course,
so any other is a form of it, as are further ones of its kind (eq:pushed). The course is a broken
line along each direction.
"""

from collections.abc import Iterator, Sequence
from typing import Any

from hda_arm_sim.foundation.arrays import Array
import numpy as np

from ..balances.balance import RATE
from ..fitting.fit import Fit, Fitter
from ..fitting.starting_points import contacts_in, ContactStart, leverage, span_of

PUSH = 'push'           # declares that a force may have any course, while a contact lasts
# Numerics; choices unless stated otherwise.
_RESOLVED = 2.0 / RATE      # shortest piece of a line that balances resolve [s]
_MOST = 64                  # pieces of a line


def courses(fitter: Fitter, fit: Fit, contact: Any,
            lacking: Array) -> Iterator[tuple[Array, float]]:
    """
    Yield what a force of another course than a contact's does (m, c), in units of noise.

    Residuals `lacking` (m, c) are those without it: other pushes stand out of them as well. Beside
    each is how much more a force does then than at the contact: the arm may be stretched out.
    """
    balancer, arm, valid = fitter.balancer, fitter.on(fit.terms), fitter.valid(fit.balance)
    levers, strengths = leverage(balancer, arm), list[float]()
    for span in _spans(contact, contacts_in(balancer, arm, lacking, valid, fitter.noise)):
        hats = _hats(balancer.time, *span)
        shapes = np.concatenate([_in_balances(fitter, lever[:, :, None] * hats[:, None])
                                 for lever in levers.transpose(2, 0, 1)], axis=2)
        strengths.append(float(np.sqrt((shapes ** 2).sum(where=valid[:, :, None]))))
        for shape in shapes.transpose(2, 0, 1):
            yield shape, strengths[-1] / (strengths[0] or 1.0)


def _in_balances(fitter: Fitter, torques: Array) -> Array:
    """Return what torques (m, n, k) on the joints do in all balances (m, c, k), over noise."""
    joints = torques.shape[1]
    return np.stack([share * fitter.balancer.in_balance(torques[:, channel % joints], channel)
                     / fitter.noise[channel] for channel, share in enumerate(
                         fitter.balancer.of_link_torque)], axis=1)


def _spans(contact: Any, pushes: Sequence[ContactStart]) -> Iterator[tuple[float, float]]:
    """Yield begin and end of a contact, and of pushes that are not near it."""
    own = span_of(contact.onset, contact.duration)
    yield own
    for push in pushes:
        begin, end = span_of(push.onset, push.duration)
        if begin > own[1] or end < own[0]:
            yield begin, end


def _hats(time: Array, begin: float, end: float) -> Array:
    """Return the pieces (m, k) of which broken lines from begin to end are made."""
    count = int(np.clip(round((end - begin) / _RESOLVED), 2, _MOST)) + 1
    knots = np.linspace(begin, end, count)
    return np.stack([np.interp(time, knots, peak, 0.0, 0.0) for peak in np.eye(count)], axis=1)

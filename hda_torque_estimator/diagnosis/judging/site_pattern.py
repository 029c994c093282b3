"""
The pattern that a rest makes in the balances of a joint identifies its site.

What acts on the motor shows in A alone, what acts on the torsion in B alone, what acts on the link
in both alike. Each of the three says that something must vanish (B, A, or A - B); the one of which
the least is left is right. Beside a third balance C, what acts on the torsion is in B and C alike.
What a sensor has wrong is in C alone (eq:balance-third).
"""

from collections.abc import Sequence
from typing import NamedTuple

from hda_arm_sim.model.effects import effect_named, Site
import numpy as np
from numpy.typing import NDArray

from .search import SearchResult
from ..findings.rest import SENSOR
from ..fitting.fit import Fit, Fitter
from ..fitting.solve import condense, solve
from ...least_squares.term import Term
from ...significance import LOUD, MATERIAL, UNLIKE

Array = NDArray[np.float64]


class BalancePair(NamedTuple):
    """Residuals of one joint where all of its balances hold (k,) [N*m], and their noise."""

    motor: Array
    torsion: Array
    motor_noise: float
    torsion_noise: float
    sensor: Array | None = None     # of a third balance, whole: reference less torsion
    sensor_noise: float = 0.0

    def site(self) -> str:
        """Return the site whose own pattern the residuals break least."""
        var_a, var_b = self.motor_noise ** 2, self.torsion_noise ** 2
        left = {'motor': power(self.torsion) - var_b, 'torsion': power(self.motor) - var_a,
                'link': power(self.motor - self.torsion) - var_a - var_b}
        if self.sensor is not None:
            var_c = self.sensor_noise ** 2
            alone = power(self.sensor) - var_c
            left[SENSOR] = left['motor'] + left['torsion']
            left['motor'] += alone
            left['link'] += alone
            left['torsion'] += power(self.torsion - self.sensor) - var_b - var_c
        return min(left, key=lambda site: left[site])


def pair_of(residual: Array, valid: NDArray[np.bool_], noise: Array, channels: Sequence[int],
            shared: float = 0.0) -> BalancePair:
    """
    Return the residuals of one joint from those of all (m, c), in its own `channels`.

    Of the third as much of the second was taken out as was `shared`.
    """
    motor, torsion, *third = channels
    both = valid[:, channels].all(axis=1)
    pair = BalancePair(residual[both, motor], residual[both, torsion], float(noise[motor]),
                       float(noise[torsion]))
    return pair if not third else pair._replace(
        sensor=residual[both, third[0]] + shared * pair.torsion,
        sensor_noise=float(np.hypot(noise[third[0]], shared * pair.torsion_noise)))


def misplaced(fitter: Fitter, found: SearchResult) -> tuple[Term, ...]:
    """
    Return the accepted causes that take one link torque for something else.

    They sit at the motor and the torsion of a joint. But what both of its balances show without
    them is the same torque, and no such causes do that.
    """
    wrong: list[Term] = []
    for label in fitter.arm.labels:
        here = not_of_link(found.last, label)
        if _doubtful(fitter, found.last, here):
            least, apart, _ = _powers(fitter, found, label)
            if apart < UNLIKE * least:
                wrong += here
    return tuple(wrong)


def is_one_link_torque(fitter: Fitter, found: SearchResult, label: str) -> bool:
    """Return whether both balances of a joint show the same torque, and nothing else but noise."""
    least, apart, noise = _powers(fitter, found, label)
    return least > 0.0 and apart <= MATERIAL ** 2 * noise


def _powers(fitter: Fitter, found: SearchResult, label: str) -> tuple[float, float, float]:
    """
    Return the power that both balances of a joint show, that of their difference, and of noise.

    They are without causes that are none of its link. The first is 0 if it is not far above noise.
    Numbers within their tolerance may make up for a difference: each balance has moved them as
    suits its own rest (eq:one-link-torque).
    """
    here = not_of_link(found.last, label)
    fit = found.with_only(fitter, [term for term in found.last.accepted if term not in here])
    own = fitter.own_channels(label)[:2]
    rests, moved, noise = fit.balance.residual[:, own], fit.columns[:, own], fitter.noise[own]
    both = np.logical_and.reduce(fitter.valid(fit.balance)[:, own], axis=1)
    least = min(power(values) for values in rests[both].T)
    if least <= (LOUD * float(noise.max())) ** 2:
        return 0.0, 0.0, float(noise @ noise)
    first = sum(term.size for term in fit.accepted)             # whose numbers stay as they are
    apart = condense(-np.diff(rests), -np.diff(moved[:, :, first:], axis=1), both[:, None])
    left = solve(apart, np.array([np.hypot(*noise)]), fitter.effective,
                 fitter.away(fit.terms)[first:], fit.deviations[first:]).variance
    return least, float(left[0] - noise @ noise), float(noise @ noise)


def not_of_link(fit: Fit, label: str) -> list[Term]:
    """Return the accepted causes at a joint that are none of its link."""
    return [term for term in fit.accepted
            if term.joint == label and effect_named(term.name).site is not Site.LINK]


def _doubtful(fitter: Fitter, fit: Fit, here: list[Term]) -> bool:
    """Return whether causes at one joint leave much there, or sit at both of its sides."""
    if not here:
        return False
    own = fitter.own_channels(here[0].joint)
    loud = fit.variance[own] > (LOUD * fitter.noise[own]) ** 2
    return bool(loud.any()) or len({effect_named(term.name).site for term in here}) > 1


def power(values: Array) -> float:
    """Return the mean square of values (k,), 0 if there are none."""
    return float(np.mean(values ** 2)) if len(values) else 0.0

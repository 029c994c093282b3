"""
What no effect of the catalogue explains: where it sits, and what it follows.

The site is identified by the pattern of both balances (`site_pattern`), the coordinate by how much
of the power a curve along it explains (`following`).
"""

from collections.abc import Mapping
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
import numpy as np
from numpy.typing import NDArray

from .following import follow, Following, VELOCITIES
from ..balances.coordinates import coordinates_of
from ..findings.rest import GEAR, NOTHING, SENSOR, Unexplained
from ..fitting.fit import Fit, Fitter
from ..judging.site_pattern import pair_of, power
from ...significance import HARDLY, LOUD, MOSTLY


class Rest(NamedTuple):
    """What a fit leaves: columns (m, c) A of every joint, then B, then C if any [N*m]."""

    time: Array                         # (m,) [s]
    labels: tuple[str, ...]
    residual: Array
    valid: NDArray[np.bool_]            # (m, c)
    noise: Array                        # (c,) standard deviation
    coordinates: Mapping[str, Array]    # (m, n) each
    # What each gear is held against (n,): its link, unless it is another.
    beyond: tuple[str, ...] = ()
    # How much of each second balance was taken out of the third (n,), if any.
    shared: Array | None = None

    def is_of_gear(self, place: int) -> bool:
        """Return whether nothing is known of a joint's load: only its motor balance holds."""
        return not self.valid[:, len(self.labels) + place].any()

    def column(self, place: int, site: str) -> int:
        """Return the column in which a rest at a site shows best."""
        side = {'motor': 0, GEAR: 0, SENSOR: 2}.get(site, 1)
        return side * len(self.labels) + place

    def channels(self, place: int) -> list[int]:
        """Return the columns of a joint that hold somewhere, its motor and torsion at least."""
        joints = len(self.labels)
        return [channel for channel in range(place, len(self.noise), joints)
                if channel < 2 * joints or self.valid[:, channel].any()]

    def along(self, place: int) -> dict[str, Array]:
        """Return the coordinates (m,) of a joint."""
        return {name: values[:, place] for name, values in self.coordinates.items()}

    def followed(self, column: int) -> list[Following]:
        """Return what a column follows, the most first."""
        side, place = divmod(column, len(self.labels))
        return follow(self.time, self.residual[:, column], self.valid[:, column],
                      self.along(place), VELOCITIES[min(side, 1)])

    def excess(self, least: float = LOUD) -> Array:
        """Return the power (c,) beyond that of noise, 0 where its rms is not `least` times."""
        powers = np.array([power(column[valid]) for column, valid in
                           zip(self.residual.T, self.valid.T)])
        return np.where(powers > (least * self.noise) ** 2, powers - self.noise ** 2, 0.0)

    def powers(self, least: float = LOUD) -> Array:
        """Return the largest excess of the balances of each joint (n,)."""
        return np.asarray(self.excess(least).reshape(-1, len(self.labels)).max(axis=0))


def unexplained(fitter: Fitter, fit: Fit, is_sure: bool = False) -> Unexplained | None:
    """
    Return where the rest of a fit sits and what it follows, None if it is at the noise.

    Where there is a rest for certain, it is that of most power, even if it hardly is above noise.
    """
    rest = rest_of(fitter, fit)
    return described(rest) or (described(rest, 1.0) if is_sure else None)


def rest_of(fitter: Fitter, fit: Fit) -> Rest:
    """Return what a fit leaves, with the coordinates of the arm that it found."""
    balancer = fitter.balancer
    return Rest(balancer.time, fitter.arm.labels, fit.balance.residual, fit.balance.valid,
                fitter.noise, coordinates_of(balancer, fitter.on(fit.terms)),
                tuple(map(fitter.beyond_gear, fitter.arm.labels)), balancer.shared)


def described(rest: Rest, least: float = LOUD) -> Unexplained | None:
    """Return where a rest sits and what it follows, None if it is not `least` times noise."""
    joints, powers = len(rest.labels), rest.powers(least)
    if not powers.any():
        return None
    place = int(np.argmax(powers))
    site = site_of(rest, place)
    following = rest.followed(rest.column(place, site))[0]
    whole = site == 'link' and joints > 1 and all(
        found > HARDLY * powers[place] and site_of(rest, other) == 'link'
        for other, found in enumerate(powers))
    return Unexplained(
        _timed(site, following), None if whole else rest.labels[place],
        following.coordinate if following.share > HARDLY else NOTHING,
        following.line if following.share > HARDLY else None,
        min(following.share, 1.0) * (1.0 if whole else float(powers[place] / powers.sum())))


def site_of(rest: Rest, place: int) -> str:
    """Return the site of a rest at a joint: the one whose own pattern it breaks least."""
    if rest.is_of_gear(place):
        return GEAR
    site = pair_of(rest.residual, rest.valid, rest.noise, rest.channels(place),
                   0.0 if rest.shared is None else float(rest.shared[place])).site()
    return rest.beyond[place] if rest.beyond and site == 'link' else site


def _timed(site: str, following: Following) -> str:
    """Return `timing` for a torsion that is off as the speed is: the angles are of two times."""
    late = following.coordinate in VELOCITIES and following.share > MOSTLY
    return 'timing' if site == 'torsion' and late else site

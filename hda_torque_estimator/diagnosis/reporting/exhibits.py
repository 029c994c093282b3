"""What a diagnosis shows beside its findings: residuals, what they follow, and predictions."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
import math

from hda_arm_sim.foundation.arrays import Array, Mask
import numpy as np

from .unexplained import Rest


@dataclass(frozen=True, eq=False)
class Exhibits:
    """
    Residuals, coordinates and predictions of the arm as given and of the extended arm.

    Columns (m, c) are balance A of every joint, then balance B, then C of every joint if there are
    any [N*m at the output]. Coordinates (m, n) are `motor_velocity`, `link_velocity` [rad/s],
    `motor_angle` [rad at the shaft], `link_angle` [rad], `joint_torque` [N*m at the output] and
    `motor_torque` [N*m at the shaft]. Predictions are rms errors (h,) [rad at the output].
    """

    time: Array                     # (m,) [s]
    labels: tuple[str, ...]
    before: Array
    after: Array
    valid: Mask                     # (m, c)
    noise: Array                    # (c,) standard deviation
    coordinates: Mapping[str, Array]
    horizons: Array                 # (h,) [s]
    predicted_before: Array
    predicted_after: Array
    predicted_floor: Array
    # Residuals (m, c) of the extended arm without one cause (effect, joint).
    lacking: Mapping[tuple[str, str | None], Array] = field(default_factory=dict)
    # Torque commanded to the motors (m, n), filtered as the balances are [N*m at the output].
    commanded: Array | None = None
    # What each gear is held against (n,): its link, unless it is another.
    beyond: tuple[str, ...] = ()
    # How much of each second balance was taken out of the third (n,), if any.
    shared: Array | None = None

    def of(self, effect: str, joint: str | None) -> 'Exhibits':
        """Return the exhibits of one cause: before is then the extended arm without it."""
        return replace(self, before=self.lacking.get((effect, joint), self.before))

    def missed(self) -> Rest:
        """Return what the simulation misses before."""
        return Rest(self.time, self.labels, self.before, self.valid, self.noise, self.coordinates,
                    self.beyond, self.shared)

    def rest(self) -> Rest:
        """Return what backed causes leave."""
        return replace(self, before=self.after).missed()

    def column(self, site: str, joint: str | None) -> int:
        """Return the column at a site and joint in which the extension removes the most."""
        joints = len(self.labels)
        sides = {'motor': (0,), 'torsion': (1,), 'link': (1,)}.get(site, (0, 1))
        missed = self.missed()
        columns = [side * joints + place for place, label in enumerate(self.labels)
                   if joint in (None, label)
                   for side in ((0,) if missed.is_of_gear(place) else sides)]
        return max(columns, key=self._removed)

    def _removed(self, column: int) -> float:
        valid = self.valid[:, column]
        if not valid.any():
            return -math.inf
        return float(np.mean(self.before[valid, column] ** 2 - self.after[valid, column] ** 2))

"""
What another arm changes in the balances of one, as cheaply as can be.

Balances are made of what motors miss, what gears carry, and what links need (eq:balance-parts).
Of another arm only that is found anew which differs: gears of some joints, or the links.
"""

from collections.abc import Sequence
from functools import cached_property

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm, ArmRecord
import numpy as np

from .balance import Balancer, sensing


class Changes:
    """The changes of balances by other arms, beside one."""

    def __init__(self, balancer: Balancer, arm: Arm) -> None:
        """Change this arm, along the motion of a balancer."""
        self._balancer, self._arm = balancer, arm
        self._all = range(len(arm.joints))

    @cached_property
    def _residual(self) -> Array:
        return self._balancer(self._arm).residual

    @cached_property
    def _gears(self) -> Array:
        """Return what all motors miss, and what all gears carry (2, k, n) [N*m]."""
        return self._balancer.gears(self._arm, self._all)

    @cached_property
    def _needed(self) -> Array:
        """Return what the links need (k, n) [N*m]."""
        return self._balancer.needed(self._arm)

    def by(self, arm: Arm) -> Array:
        """Return what the residual (m, 2 n) of an arm has more [N*m]."""
        ours, others = self._arm.record(), arm.record()
        if _hands_on(ours) or _hands_on(others):
            return self._balancer(arm).residual - self._residual
        moved = sensing(self._arm) != sensing(arm)
        joints = list(self._all) if moved else [
            place for place, (one, other) in enumerate(zip(ours.joints, others.joints))
            if one.tobytes() != other.tobytes()]
        is_loaded = moved or ours.body.tobytes() != others.body.tobytes()
        return self._by_parts(arm, joints, is_loaded=is_loaded)

    def _by_parts(self, arm: Arm, joints: Sequence[int], *, is_loaded: bool) -> Array:
        """Return the change by gears of some joints, and by links if they need other torques."""
        balancer, count = self._balancer, len(self._all)
        change = np.zeros((len(balancer.time), 2 * count))
        shown = list(self._all) if is_loaded else list(joints)
        if not shown:
            return change
        motor, link = (np.zeros((len(balancer.measurement.command), count)) for _ in range(2))
        if joints:
            motor[:, joints], carried = balancer.gears(arm, joints) - self._gears[:, :, joints]
            link[:, joints] = -carried
        if is_loaded:
            link += balancer.needed(arm) - self._needed
        if not balancer.measurement.led:
            motor += link
        filtered = balancer.filtered(np.concatenate([motor[:, shown], link[:, shown]], axis=1))
        for place, channel in enumerate([*shown, *(count + joint for joint in shown)]):
            change[:, [channel]] = balancer.in_balance(filtered[:, [place]], channel)
        return change


def _hands_on(record: ArmRecord) -> bool:
    """Tell whether a bearing may hold its link, or a base give way: there links answer gears."""
    return bool(record.joints['link_bearing_friction']['level'].any()
                or record.body['base_vibration']['amplitude'])

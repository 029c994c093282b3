"""What an estimator found in a recording, by joint and at the tip."""

from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.chain_links import ChainLinks
import numpy as np
from numpy.typing import NDArray

from .laws import layout


class Estimates(NamedTuple):
    """Estimates over time: stamps (k,) ns, joints (k, n, RESULTS), tip (k, TIP_RESULTS)."""

    stamps: NDArray[np.int64]
    joints: Array
    tip: Array
    refused: NDArray[np.int64]          # indices of the samples that were not used
    taring: bool = False                # of a part: a tare is under way after each sample

    @property
    def torque(self) -> Array:
        """Return the torques through the gears (k, n) [N*m, output side]."""
        return self.joints[:, :, layout.TORQUE]

    @property
    def torque_deviation(self) -> Array:
        """Return the standard deviations of the torques (k, n) [N*m]."""
        return self.joints[:, :, layout.TORQUE_DEVIATION]

    @property
    def external_torque(self) -> Array:
        """Return the joint torques of the environment (k, n) [N*m], NaN without links."""
        return self.joints[:, :, layout.EXTERNAL_TORQUE]

    @property
    def external_torque_deviation(self) -> Array:
        """Return the standard deviations of the external torques (k, n) [N*m]."""
        return self.joints[:, :, layout.EXTERNAL_DEVIATION]

    @property
    def base_wrench(self) -> Array:
        """Return the wrench on the tip in the base frame (k, 6) [N, N*m]; of a chain alone."""
        return self.tip[:, layout.BASE_WRENCH:layout.BASE_WRENCH + 6]

    @property
    def tool_wrench(self) -> Array:
        """Return the wrench on the tip in the tool frame (k, 6) [N, N*m]; of a chain alone."""
        return self.tip[:, layout.TOOL_WRENCH:layout.TOOL_WRENCH + 6]

    @property
    def base_force(self) -> Array:
        """Return the force on the tip in the base frame (k, 2) [N]."""
        return self.tip[:, layout.BASE_X:layout.BASE_X + 2]

    @property
    def tip_force(self) -> Array:
        """Return the force on the tip along the axes there are (k, 2 or 3) [N, base frame]."""
        return self.base_wrench[:, :3] if self.in_space else self.base_force

    @property
    def tip_force_deviation(self) -> Array:
        """Return the standard deviations of the force on the tip (k, 2 or 3) [N]."""
        variances = [layout.WRENCH_COVARIANCE + 7 * axis for axis in range(3)] if (
            self.in_space) else [layout.BASE_COVARIANCE, layout.BASE_COVARIANCE + 3]
        return np.sqrt(self.tip[:, variances])

    @property
    def in_space(self) -> bool:
        """Return whether the wrench on the tip has all six components, as that of a chain."""
        return self.tip.shape[1] > layout.TIP_RESULTS

    @property
    def tool_force(self) -> Array:
        """Return the force on the tip in the tool frame, axial first (k, 2) [N]."""
        return self.tip[:, layout.TOOL_X:layout.TOOL_X + 2]


def tip_results(arm: Arm) -> int:
    """Return how many numbers describe the tip: a chain's has a wrench in space."""
    return (layout.CHAIN_TIP_RESULTS if isinstance(arm.links, ChainLinks)
            else layout.TIP_RESULTS)

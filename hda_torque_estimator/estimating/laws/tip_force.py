"""Tip force from external joint torques, where it can be observed (docs/model.md#estimator)."""

from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.compiled import compiled, Record
from hda_arm_sim.foundation.rigid import tool_jacobian
import numpy as np

# Choices unless stated otherwise.
_ALIGNED = 0.01         # share of an unobserved force that may leak into an observed component


class Posture(NamedTuple):
    """How the links stand, and from where on that hides a force."""

    links: Record               # their lengths
    joints: int
    elbow: float                # [rad]
    singular_sine: float        # |sin(theta2)| below which the axial force is not observed


@compiled
def tool_force(at: Posture, torque: Array, deviation: Array, force: Array,
               covariance: Array) -> tuple[bool, float]:
    """
    Fill the force on the tip in the tool frame (2,) [N] and its covariance (2, 2) [N^2].

    Solves tau = J^T F. The axial component is NaN for a single link and where
    |sin(theta2)| < `singular_sine`; the perpendicular one is then the weighted mean of what both
    joints say. Returns whether that is so, and the conditioning: 0 to 1.
    """
    if at.joints == 1:
        force[0], force[1] = np.nan, torque[0] / at.links.length1
        _only_perpendicular(covariance, (deviation[0] / at.links.length1) ** 2)
        return True, 0.0
    j11, _, j21, j22 = tool_jacobian(at.links.length1, at.links.length2, at.elbow)
    ratio = singular_ratio(j11, j21, j22)
    if abs(np.sin(at.elbow)) < at.singular_sine:
        weight1, weight2 = 1.0 / deviation[0] ** 2, 1.0 / deviation[1] ** 2
        certainty = j21 * j21 * weight1 + j22 * j22 * weight2
        force[0] = np.nan
        force[1] = (j21 * weight1 * torque[0] + j22 * weight2 * torque[1]) / certainty
        _only_perpendicular(covariance, 1.0 / certainty)
        return True, ratio
    force[1] = torque[1] / j22
    force[0] = (torque[0] - j21 * force[1]) / j11
    variance1, variance2 = deviation[0] ** 2, deviation[1] ** 2
    covariance[1, 1] = variance2 / j22 ** 2
    covariance[0, 0] = (variance1 + (j21 / j22) ** 2 * variance2) / j11 ** 2
    covariance[0, 1] = covariance[1, 0] = -j21 * variance2 / (j11 * j22 ** 2)
    return False, ratio


@compiled
def singular_ratio(j11: float, j21: float, j22: float) -> float:
    """Return smallest over largest singular value of a triangular matrix, by rows."""
    product = abs(j11 * j22)
    squares = j11 ** 2 + j21 ** 2 + j22 ** 2
    return 2.0 * product / (squares + np.sqrt(max(squares ** 2 - 4.0 * product ** 2, 0.0)))


@compiled
def _only_perpendicular(covariance: Array, variance: float) -> None:
    covariance[0, 0] = covariance[0, 1] = covariance[1, 0] = np.nan
    covariance[1, 1] = variance


@compiled
def base_force(direction: float, tool: Array, tool_covariance: Array, force: Array,
               covariance: Array) -> None:
    """
    Fill the same force in the base frame; `direction` is that of the tool's x axis [rad].

    Without an axial component a base component is still known where its axis is perpendicular
    to the last link; every other one is NaN.
    """
    c, s = np.cos(direction), np.sin(direction)
    axial = tool[0] == tool[0]
    if axial:
        a, b, d = tool_covariance[0, 0], tool_covariance[0, 1], tool_covariance[1, 1]
        force[0], force[1] = c * tool[0] - s * tool[1], s * tool[0] + c * tool[1]
        covariance[0, 0] = c * c * a - 2.0 * c * s * b + s * s * d
        covariance[1, 1] = s * s * a + 2.0 * c * s * b + c * c * d
        covariance[0, 1] = covariance[1, 0] = c * s * (a - d) + (c * c - s * s) * b
        return
    force[:] = np.nan
    covariance[:] = np.nan
    if abs(c) < _ALIGNED:
        force[0], covariance[0, 0] = -s * tool[1], s * s * tool_covariance[1, 1]
    if abs(s) < _ALIGNED:
        force[1], covariance[1, 1] = c * tool[1], c * c * tool_covariance[1, 1]

"""
Read a swinging base from what is left: it answers the links' own acceleration at one frequency.

Along a measured motion the push of the links on the base is known. So the torque of a mode of
given frequency and damping is linear in its amplitude, and quadratic in the components of its
direction. The wider a mode is, the fewer frequencies show it.
"""

from collections.abc import Iterator
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects.catalogue import sole_at
from hda_arm_sim.model.effects.place import BASE
import numpy as np
from numpy.typing import NDArray

from .balance import Balancer, RATE
from .base_motion import stirring
from ...significance import HARDLY

# Numerics; choices unless stated otherwise.
_LOWEST, _HIGHEST = 3.0, 30.0   # frequencies, below the balances' bandwidth [Hz]
_DAMPINGS = (0.04, 0.3, 1.0)    # of steel, of a base on rubber, and of one that creeps back
_DIRECTIONS = np.linspace(0.0, np.pi, 36, endpoint=False)  # of the base that are tried [rad]


class Mode(NamedTuple):
    """One mode of a base, by the names of its effect's numbers."""

    frequency: float            # [Hz]
    damping: float
    amplitude: float            # [1/kg]
    direction: float            # [rad]


def swing_in(balancer: Balancer, arm: Arm, residual: Array, valid: NDArray[np.bool_],
             noise: Array) -> Mode | None:
    """Return the mode that explains most of a residual (m, c), None if it explains little."""
    joints = len(arm.labels)
    if arm.links is None or joints < 2:
        return None
    push, coupling = _stirred(balancer, arm)
    most = sole_at(BASE).declaration('amplitude').high
    of_links = slice(joints, 2 * joints)
    scale = (np.sqrt(valid) / noise)[:, of_links]
    rest = (scale * residual[:, of_links]).ravel()
    best, power = None, HARDLY * float(rest @ rest - np.count_nonzero(scale))
    for frequency, damping in _modes():
        columns = np.stack([
            scale[:, [joint]] * balancer.in_balance(torques, joints + joint) for joint, torques
            in enumerate(_torques(push, coupling, frequency, damping).swapaxes(0, 1))], axis=1)
        amplitude, direction, explained = _strongest(columns.reshape(-1, 3), rest)
        if explained > power and amplitude < most:
            power = explained
            best = Mode(frequency, damping, amplitude, direction)
    return best


def _modes() -> Iterator[tuple[float, float]]:
    """Yield frequencies [Hz] and dampings that are tried: two within half the width of a mode."""
    for damping in _DAMPINGS:
        count = round(np.log(_HIGHEST / _LOWEST) / np.log1p(0.5 * damping))
        for frequency in np.geomspace(_LOWEST, _HIGHEST, count):
            yield float(frequency), damping


def _stirred(balancer: Balancer, arm: Arm) -> tuple[Array, Array]:
    """Return the push on the base (m, 2) and its coupling (m, n, 2), along x and along y."""
    links = balancer.motion(arm).links
    sides = [stirring(arm, links, direction) for direction in (0.0, 0.5 * np.pi)]
    push = np.stack([side for side, _ in sides], axis=1)
    return balancer.filtered(push), np.stack([side[::balancer.every] for _, side in sides], axis=2)


def _torques(push: Array, coupling: Array, frequency: float, damping: float) -> Array:
    """Return the torques (m, n, 3) of a mode of 1/kg, by products of cosine and sine."""
    line = np.fft.rfftfreq(len(push), 1.0 / RATE)
    answer = -line ** 2 / (frequency ** 2 - line ** 2 + 2j * damping * frequency * line)
    swing = np.fft.irfft(np.fft.rfft(push, axis=0) * answer[:, None], len(push), axis=0)
    x, y = swing[:, 0, None], swing[:, 1, None]
    along, across = coupling[:, :, 0], coupling[:, :, 1]
    return -np.stack([along * x, along * y + across * x, across * y], axis=2)


def _strongest(columns: Array, rest: Array) -> tuple[float, float, float]:
    """Return amplitude [1/kg] and direction that explain most, and the power explained."""
    cosine, sine = np.cos(_DIRECTIONS), np.sin(_DIRECTIONS)
    mixed = np.stack([cosine ** 2, cosine * sine, sine ** 2], axis=1)
    right = mixed @ (columns.T @ rest)
    own = ((mixed @ (columns.T @ columns)) * mixed).sum(axis=1)
    power = np.where(right > 0.0, right ** 2 / own, 0.0)
    at = int(np.argmax(power))
    return float(right[at] / own[at]), float(_DIRECTIONS[at]), float(power[at])

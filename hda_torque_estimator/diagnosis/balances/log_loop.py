"""
The loop of a log: the PD law on the shafts that its commands follow (eq:log-loop).

A loop answers the noise of readings and drives. So noise of the balances goes with the motion and
the commands, the more the higher the gains are. A twin with other gains does not show it.
"""

from collections.abc import MutableMapping, Sequence
import math
from weakref import WeakKeyDictionary

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
import numpy as np
from scipy.optimize import minimize_scalar
from scipy.signal import lfilter

from ...controlling.controller import usual_gains
from ...measurements.even_grid import as_taken
from ...measurements.measurement import Measurement
from ...measurements.upsampling import answered, FAST, is_held, usually_explained
from ...significance import IMMATERIAL, MOSTLY
from ...simulating.closed_loop import MotorLoop

# Numerics; choices unless stated otherwise.
_DIFFERENCES = 5        # of samples, in which noise is more than any motion
_SLOWEST, _FASTEST = 1e-3, 4.0  # low-pass of a speed, over the rate of the log
_NEAR = 1e-4            # logarithm of a bandwidth, to which it is known
_ENOUGH = 20_000        # samples of a recording that show its loop

# Of joints, by recording; nothing of one whose loop does not show.
_KNOWN: MutableMapping[Measurement, list[Sequence[float] | None]] = WeakKeyDictionary()


def loop_of(measurement: Measurement, arm: Arm) -> MotorLoop | None:
    """
    Return the loop that made the commands of a recording, None where it does not show.

    A joint whose commands follow no such law has the usual gains of its rotor.
    """
    if measurement not in _KNOWN:
        recorded = measurement.as_recorded()
        _KNOWN[measurement] = [_gains(recorded, joint) for joint in range(len(recorded.labels))
                               ] if is_held(recorded) else []
    if not any(_KNOWN[measurement]):
        return None
    gains = usual_gains(arm)
    for joint, found in enumerate(_KNOWN[measurement]):
        for known, gain in zip(gains, found or ()):
            known[joint] = gain
    return MotorLoop(gains, measurement.parts)


def is_twin(made: Measurement, measured: Measurement) -> bool:
    """Return whether what is quick in the commands of a simulated loop is as in the log."""
    twin, ours = (np.std(np.diff(each.as_recorded().command, FAST, axis=0), axis=0)
                  for each in (made, measured))
    return bool((MOSTLY * twin <= ours).all())


def _gains(recorded: Measurement, joint: int) -> Sequence[float] | None:
    """Return K_P, K_D and the bandwidth that explain all quick commands, None without."""
    shown = [recorded.reading[:, joint, 0]]
    if len(recorded.past):          # a loop answers readings as they were taken, at no even ticks
        shown.append(as_taken(recorded)[:, joint, 0])
    found = [_fitted(pieces) for angle in shown
             if (pieces := [piece for part in recorded.pieces()
                            if (piece := _Piece(recorded, part, joint, angle)).rows.any()])]
    gains, left = min(found, key=lambda one: one[1], default=(np.zeros(1), math.inf))
    return gains.tolist() if left <= IMMATERIAL and (gains > 0.0).all() else None


def _fitted(pieces: Sequence['_Piece']) -> tuple[Array, float]:
    """Return K_P, K_D and the bandwidth (3,) that explain most, and the share that they leave."""
    quick = np.concatenate([piece.quick for piece in pieces])

    def gains_at(bandwidth: float) -> tuple[Array, float]:
        return usually_explained(
            quick, np.concatenate([piece.columns(bandwidth) for piece in pieces]))

    rate = 1.0 / pieces[0].dt
    found = minimize_scalar(
        lambda size: gains_at(math.exp(size))[1], options={'xatol': _NEAR}, method='bounded',
        bounds=(math.log(_SLOWEST * rate), math.log(_FASTEST * rate)))
    gains, left = gains_at(math.exp(found.x))
    return np.append(gains, math.exp(found.x)), left


class _Piece:
    """What is quick in the commands and readings of a joint in one recording."""

    def __init__(self, recorded: Measurement, part: slice, joint: int, angle: Array) -> None:
        """Take what is needed of samples in a part, where the shaft showed an `angle` (k,)."""
        command = recorded.command[part, joint, None][:_ENOUGH]
        self._angle, self.dt = angle[part][:_ENOUGH], recorded.dt
        past = recorded.past[part] if len(recorded.past) else np.zeros(len(command))
        self._since = self.dt + np.diff(past[:_ENOUGH], prepend=past[:1])
        self.rows = answered(command, 1 + _DIFFERENCES - FAST)[:, 0]
        self.quick = np.diff(command[:, 0], _DIFFERENCES)[1:][self.rows]

    def columns(self, bandwidth: float) -> Array:
        """Return by what K_P and K_D make commands quick (k, 2), each a sample late."""
        left = math.exp(-2.0 * math.pi * bandwidth * self.dt)
        rate = np.diff(self._angle, prepend=self._angle[:1]) / self._since
        speed = lfilter([1.0 - left], [1.0, -left], rate)
        shown = np.stack([self._angle, speed], axis=1)
        return -np.diff(shown, _DIFFERENCES, axis=0)[:-1][self.rows]

"""
Joints whose controller oscillates: most of their command is one line that no motion asks for.

Motions of robots are slow, and what a healthy loop answers besides is spread or small. A loop that
oscillates makes a quick line. It is more than all else in a command, and no small part of what the
motor can do. Where it swings an arm against the limits of its motors, most causes look alike.
"""

from collections.abc import Iterator, Sequence

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
import numpy as np
from scipy.signal import welch

from ..findings.origin import OscillatingLoop
from ..judging.selection_criteria import SLOW
from ...measurements.measurement import Measurement
from ...significance import HARDLY, MOSTLY

# Numerics; choices unless stated otherwise.
_SEGMENT = 2.0          # of a spectrum [s]
_WIDTH = 0.1            # share of its frequency that a line reaches to both sides: it may drift


def oscillating_loops(measurement: Measurement, arm: Arm) -> tuple[OscillatingLoop, ...]:
    """Return the joints whose controller oscillates in a recording of its own rate."""
    return tuple(_oscillating(measurement, arm))


def _oscillating(measurement: Measurement, arm: Arm) -> Iterator[OscillatingLoop]:
    frequency, power = _spectrum([measurement.command[piece] for piece in measurement.pieces()],
                                 measurement.dt)
    for joint, column in zip(arm.joints, power.T):
        quick = np.where(frequency >= SLOW, column, 0.0)
        line = float(frequency[np.argmax(quick)])
        of_line = float(quick[np.abs(frequency - line) <= _WIDTH * line].sum())
        amplitude = float(np.sqrt(2.0 * of_line)) / joint.torque_limit
        if of_line > MOSTLY * column.sum() and amplitude > HARDLY:
            yield OscillatingLoop(joint.label, line, of_line / float(column.sum()), amplitude)


def _spectrum(pieces: Sequence[Array], period: float) -> tuple[Array, Array]:
    """
    Return frequencies (f,) [Hz] and the power of commands in each (f, n) [N^2*m^2, shaft].

    Recordings `pieces` [(k, n)] count by their lengths. What takes longer than a segment, as the
    weight of links does, has hardly a part.
    """
    size = min(round(_SEGMENT / period), *map(len, pieces))
    spectra = [welch(piece, 1.0 / period, nperseg=size, axis=0) for piece in pieces]
    frequency = spectra[0][0]
    power = np.average([power for _, power in spectra], axis=0, weights=list(map(len, pieces)))
    return frequency, power * frequency[1]

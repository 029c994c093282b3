"""The fits of a few lines that people make by hand, beside which a calibration must stand."""

from collections.abc import Sequence
from dataclasses import replace

from hda_arm_sim.model.parts import Joint
import numpy as np
from numpy.typing import NDArray

from .motor_witness import STANDS
from ..passages.joint_recording import Measured
from ...least_squares.rows import FOLDS, rms
from ...samples.readings import LINK_READING, MOTOR_READING

Floats = NDArray[np.float64]


def line_left_out(joint: Joint, recordings: Sequence[Measured], lag: float = 0.0) -> float:
    """
    Return the error of a straight line on recordings left out, or fifths of the only [N*m rms].

    It goes through the motor torque, speed and its sign; without a motor torque through the
    torsion. An offset is common to all recordings. References lag by so much [s]. It is 0 where
    there is neither.
    """
    recordings = [replace(one, reference=one.later(lag)) for one in recordings]
    witnesses = [[one for one in recordings if one.has_command],
                 [one for one in recordings if one.has_link]]
    used = next((some for some in witnesses if some), [])
    return _left_out([_rows(joint, one, by_motor=used is witnesses[0]) for one in used])


def mean_left_out(recordings: Sequence[Measured]) -> float:
    """Return the error of the mean torque of the others, without any sensor [N*m rms]."""
    return _left_out([one.thinned(np.stack([np.ones_like(one.reference), one.reference], axis=1))
                      for one in recordings])


def _left_out(rows: Sequence[Floats]) -> float:
    """Return the error of a line through each recording's rows (m, p), which it has not seen."""
    if not rows:
        return 0.0
    fold = np.concatenate([np.full(len(one), place) for place, one in enumerate(rows)])
    every = np.concatenate(rows)
    if len(rows) == 1:
        fold = np.arange(len(every)) * FOLDS // len(every)
    errors = [every[fold == one] @ _line(every[fold != one]) for one in np.unique(fold)]
    return rms(np.concatenate(errors))


def _rows(joint: Joint, one: Measured, *, by_motor: bool) -> Floats:
    """Return what a line goes through, and the reference behind it (m, 5)."""
    motor, link = one.readings[:, 0, (MOTOR_READING, LINK_READING)].T
    rate = one.turning().rate
    witness = one.command if by_motor else motor / joint.ratio - link
    sense = np.where(np.abs(rate) > STANDS, np.sign(rate), 0.0)
    rows = np.stack([witness, rate, sense, np.ones_like(rate), one.reference], axis=1)
    rows = one.thinned(rows)
    return rows[np.isfinite(rows).all(axis=1)]


def _line(rows: Floats) -> Floats:
    """Return the factors (p,) with which rows (m, p) give the error of their line."""
    factors = np.linalg.lstsq(rows[:, :-1], rows[:, -1], rcond=None)[0]
    return np.append(factors, -1.0)

"""A residual over what it follows, and its spectrum: the same data for pages and for figures."""

from collections.abc import Sequence
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array, Mask
import numpy as np
from numpy.typing import NDArray

from .axes import BALANCES, COORDINATES, RESIDUAL
from .following import BINS, Following, TURN_BINS, WRAPPED
from .unexplained import Rest
from ..balances.balance import BANDWIDTH
from ..balances.strongest_wave import TURN
from ..findings.rest import Unexplained
from ...pages.plot import Plot, PlotLine
from ...pages.wording import spoken

# Numerics; choices unless stated otherwise.
_FEWEST = 20            # samples of a bin, on average: fewer draw noise
_LINES = 1500           # of a spectrum: as many as can be seen
_SHAPE = 12             # bins of a wave: fewer hardly show it, so all of its periods are laid over
_SPEEDS = {'motor_angle': 'motor_velocity', 'link_angle': 'link_velocity'}
_CARRIERS = {'direction': 'motor_velocity', 'torque': 'joint_torque'}


class Dependence(NamedTuple):
    """The column in which a rest shows best, what it follows there, and which of that is shown."""

    column: int
    found: list[Following]          # the most first
    following: Following


class _Part(NamedTuple):
    """Samples of a residual (k,), and what distinguishes them from the others."""

    name: str
    rows: Mask


def dependence_of(unexplained: Unexplained, rest: Rest) -> Dependence:
    """Return where an unexplained rest shows best and what it follows there."""
    place = (int(np.argmax(rest.powers())) if unexplained.joint is None
             else rest.labels.index(unexplained.joint))
    column = rest.column(place, unexplained.site)
    found = rest.followed(column)
    return Dependence(column, found, next(
        (each for each in found if each.coordinate == unexplained.depends_on), found[0]))


def against(following: Following, column: int, shown: Sequence[tuple[str, Rest, str]]) -> Plot:
    """
    Return residuals in bins of what they follow: medians and quartiles, apart for both signs.

    `shown` are names, residuals on one motion and looks of lines. Bins hold equally many samples.
    Of a wave that is too fine for bins, all periods are laid over each other, where it is slow
    enough for the balances.
    """
    first = shown[0][1]
    valid, period = first.valid[:, column], _period(first, following, column)
    if period is not None:
        valid = _followed(first, following, column, valid)
    coordinate = _along(first, following, column)[valid]
    if period is not None:
        coordinate = np.mod(coordinate, period)
    whole = following.coordinate == WRAPPED and period is None
    count = max(1, min(TURN_BINS if whole else BINS, len(coordinate) // _FEWEST))
    bins = np.minimum(np.argsort(np.argsort(coordinate, kind='stable'), kind='stable') * count
                      // max(len(coordinate), 1), count - 1)
    centre = np.array([np.median(coordinate[bins == k]) for k in range(count)])
    lines = [_binned(f'{name}{part.name}', rest.residual[valid, column], bins, count,
                     _Part(look + ('' if place == 0 else '_other'), part.rows))
             for name, rest, look in shown
             for place, part in enumerate(_parts(first, following, column, valid))]
    return Plot(_axis(following, period), RESIDUAL, centre, lines, 'turn' if whole else 'linear')


def _period(rest: Rest, following: Following, column: int) -> float | None:
    """Return the period [rad] of a wave over an angle that bins are too wide for, else None."""
    if following.line is None or following.coordinate == 'time':
        return None
    reach = TURN if following.coordinate == WRAPPED else float(np.ptp(
        _along(rest, following, column)[rest.valid[:, column]]))
    bins, period = TURN_BINS if following.coordinate == WRAPPED else BINS, TURN / following.line
    return period if bins * period < _SHAPE * reach else None


def _followed(rest: Rest, following: Following, column: int, valid: Mask) -> Mask:
    """Return where (m,) a wave is in the lower half of the balances, all if it hardly ever is."""
    if following.coordinate not in _SPEEDS or following.line is None:
        return valid
    speed = rest.coordinates[_SPEEDS[following.coordinate]][:, column % len(rest.labels)]
    slow = valid & (following.line * np.abs(speed) < 0.5 * TURN * BANDWIDTH)
    return slow if slow.sum() >= _SHAPE * _FEWEST else valid


def _along(rest: Rest, following: Following, column: int) -> Array:
    """Return the coordinate (m,) that a column follows, within its period if it has one."""
    if following.coordinate == 'time':
        return rest.time if following.line is None else np.mod(rest.time, 1.0 / following.line)
    values = rest.along(column % len(rest.labels))[following.coordinate]
    return np.mod(values, TURN) if following.coordinate == WRAPPED else values


def _parts(rest: Rest, following: Following, column: int, valid: Mask) -> list[_Part]:
    """Return all samples, or those of both signs of what a curve multiplies."""
    if not following.carrier:
        return [_Part('', np.ones(int(valid.sum()), bool))]
    carrier = rest.coordinates[_CARRIERS[following.carrier]]
    sign = carrier[valid, column % len(rest.labels)] > 0.0
    return [_Part(f', {following.carrier} positive', sign),
            _Part(f', {following.carrier} negative', ~sign)]


def _binned(name: str, values: Array, bins: NDArray[np.int64], count: int,
            part: _Part) -> PlotLine:
    """Return the median of values in bins, and the quartiles around it."""
    spread = np.full((3, count), np.nan)
    for k in range(count):
        if (rows := part.rows & (bins == k)).any():
            spread[:, k] = np.quantile(values[rows], (0.25, 0.5, 0.75))
    return PlotLine(name, spread[1], part.name, spread[0], spread[2])


def spectrum(rest: Rest, column: int) -> Plot:
    """Return the amplitude of each line of a residual, as far as the balances reach."""
    values = np.where(rest.valid[:, column], rest.residual[:, column], 0.0)
    size = np.abs(np.fft.rfft(values * np.hanning(len(values)))) * 4.0 / len(values)
    frequency = np.fft.rfftfreq(len(values), float(rest.time[1] - rest.time[0]))
    rows = np.flatnonzero((frequency > 0.0) & (frequency <= BANDWIDTH))
    cuts = np.unique(np.geomspace(1, len(rows), _LINES).astype(int)) - 1
    return Plot('frequency [Hz]', 'amplitude, output [N·m]', frequency[rows[cuts]],
                [PlotLine('amplitude', np.maximum.reduceat(size[rows], cuts), 'after')], 'log_x')


def where(labels: tuple[str, ...], column: int) -> str:
    """Return the joint and the balance of a column."""
    return f'{spoken(labels[column % len(labels)])}, balance {BALANCES[column // len(labels)]}'


def _axis(following: Following, period: float | None) -> str:
    """Return what stands at the axis of what a residual follows."""
    if period is not None:
        return f'{spoken(following.coordinate)} in its wave, {following.line:.4g} per turn [rad]'
    if following.coordinate == 'time' and following.line is not None:
        return f'time in the period of {following.line:.4g} Hz [s]'
    return COORDINATES[following.coordinate]

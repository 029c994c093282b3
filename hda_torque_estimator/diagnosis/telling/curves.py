"""The plots of a diagnosis as data: torques over time, and what gives causes away."""

from collections.abc import Sequence
import math
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.effects import effect_named
import numpy as np
from numpy.typing import NDArray

from .axes import BALANCES, COORDINATES
from .exhibits import along, Exhibits
from .following import BINS, Following, TURN_BINS, WRAPPED
from .unexplained import Rest
from ..balances.balance import BANDWIDTH
from ..findings.report import Diagnosis
from ...pages.plot import Chart, Line, Plot
from ...pages.wording import spoken

RESIDUAL = 'residual, output [N·m]'
# Choices unless told otherwise.
_FEWEST = 20            # samples of a bin, on average: fewer draw noise
_STRETCH = 3.0          # of a recording that is shown at first [s]
_LINES = 1500           # of a spectrum: as many as can be seen


class Cause(NamedTuple):
    """An effect, its joint or None for the arm, and the site that it breaks."""

    effect: str
    joint: str | None
    site: str


class _Part(NamedTuple):
    """Samples of a residual (k,), and what tells them from the others."""

    name: str
    rows: NDArray[np.bool_]


def overview(diagnosis: Diagnosis, exhibits: Exhibits) -> Chart:
    """Return the residual of every balance over time, before and after."""
    joints = len(exhibits.labels)
    floors = {(row.site, row.joint): row.floor for row in diagnosis.residuals}
    plots = {}
    for column in _worst_first(exhibits):
        label, side = exhibits.labels[column % joints], column // joints
        floor = floors.get((('motor', 'torsion')[side], label), math.nan)
        plots[_where(exhibits.labels, column)] = Plot(
            COORDINATES['time'], RESIDUAL, exhibits.time, [
                Line('arm as given', _shown(exhibits, column, exhibits.before), 'before'),
                Line('extended arm', _shown(exhibits, column, exhibits.after), 'after'),
                *_floor(floor, len(exhibits.time))], 'time')
    return Chart('What each balance misses over time', (
        'The arm as given leaves the wide trace. The extended arm should stay mostly between the '
        'dashed lines, as noise and encoder resolution alone do. Gaps are standstill, where '
        'friction is not known.'), plots)


def _floor(floor: float, count: int) -> list[Line]:
    """Return twice the rms of noise on both sides of zero."""
    if not math.isfinite(floor):
        return []
    return [Line(name, np.full(count, sign * floor), 'floor')
            for name, sign in (('twice the noise', 2.0), ('', -2.0))]


def _shown(exhibits: Exhibits, column: int, residual: Array) -> Array:
    return np.where(exhibits.valid[:, column], residual[:, column], np.nan)


def giveaway(cause: Cause, exhibits: Exhibits) -> Chart:
    """Return the residual against what gives a cause away, without it and with it."""
    own = exhibits.of(cause.effect, cause.joint)
    column = own.column(cause.site, cause.joint)
    missed, rest = own.missed(), own.rest()
    told = missed.followed(column)[0]
    plot = against(told, column, (('without this cause', missed, 'before'),
                                  ('with it', rest, 'after')))
    return Chart(f'What gives it away: {_where(own.labels, column)}', (
        'The line is the median of the residual, the band its middle half. Without the cause it '
        'follows the coordinate; with it, it should be flat at zero.'),
        {_where(own.labels, column): plot})


def against(told: Following, column: int,
            shown: Sequence[tuple[str, Rest, str]]) -> Plot:
    """Return residuals in bins of what the first of them follows, apart for both signs."""
    first = shown[0][1]
    valid = first.valid[:, column]
    coordinate = along(first, told, column)[valid]
    count = max(1, min(TURN_BINS if told.coordinate == WRAPPED else BINS,
                       len(coordinate) // _FEWEST))
    bins = np.minimum(np.argsort(np.argsort(coordinate, kind='stable'), kind='stable') * count
                      // max(len(coordinate), 1), count - 1)
    centre = np.array([np.median(coordinate[bins == k]) for k in range(count)])
    lines = [_binned(f'{name}{part.name}', rest.residual[valid, column], bins, count,
                     _Part(look + ('' if place == 0 else '_other'), part.rows))
             for name, rest, look in shown
             for place, part in enumerate(_parts(first, told, column, valid))]
    return Plot(_name_of(told), RESIDUAL, centre, lines,
                'turn' if told.coordinate == WRAPPED else 'linear')


def _parts(rest: Rest, told: Following, column: int, valid: NDArray[np.bool_]) -> list[_Part]:
    """Return all samples, or those of both signs of what a curve multiplies."""
    if not told.carrier:
        return [_Part('', np.ones(int(valid.sum()), bool))]
    name = {'direction': 'motor_velocity', 'torque': 'joint_torque'}[told.carrier]
    sign = rest.coordinates[name][valid, column % len(rest.labels)] > 0.0
    return [_Part(f', {told.carrier} positive', sign), _Part(f', {told.carrier} negative', ~sign)]


def _binned(name: str, values: Array, bins: NDArray[np.int64], count: int, part: _Part) -> Line:
    """Return the median of values in bins, and the quartiles around it."""
    spread = np.full((3, count), np.nan)
    for k in range(count):
        if (rows := part.rows & (bins == k)).any():
            spread[:, k] = np.quantile(values[rows], (0.25, 0.5, 0.75))
    return Line(name, spread[1], part.name, spread[0], spread[2])


def through_time(exhibits: Exhibits, columns: Sequence[int], names: tuple[str, str],
                 site: str = 'link') -> Chart | None:
    """
    Return torques over time in columns of balances: one measured, and what two arms make of it.

    Of a motor, the torque commanded stands beside what the model needs to move as measured. Of a
    joint, the torque of its gear by the torsion stands beside what the links need. Where the
    `site` is the torsion, the links are right and the simulated gear is not. All at the output
    [N*m]. None where no command is known.
    """
    if exhibits.commanded is None:
        return None
    sides = {column // len(exhibits.labels) for column in columns}
    said = [*([_MOTOR] if 0 in sides else []),
            *([_GEAR if site in _IN_TORSION else _LINKS] if 1 in sides else []), _SHOWN]
    return Chart('Torque, measured and simulated', ' '.join(said), {
        _timed_name(exhibits.labels, column): _timed(exhibits, column, names, site)
        for column in columns})


_IN_TORSION = ('torsion', 'timing', 'sensing')
_MOTOR = ('Of a motor, measured is the torque that it was commanded, times the gear ratio; '
          'simulated is what the model needs there to move as measured.')
_LINKS = ('Of a joint, measured is the torque of the gear, as the torsion tells it; simulated is '
          'what the links of the model need to move as measured.')
_GEAR = ('Of a joint, measured is the torque that the motion of the links asked for; simulated '
         'is what the gear of the model gives at the measured torsion.')
_SHOWN = 'The plot begins with the seconds in which the two part most.'


def _timed_name(labels: tuple[str, ...], column: int) -> str:
    part = ('motor', 'gear')[column // len(labels)]
    return f'{part} of {spoken(labels[column % len(labels)])}'


def _timed(own: Exhibits, column: int, names: tuple[str, str], site: str) -> Plot:
    side, place = divmod(column, len(own.labels))
    before, after = (_shown(own, column, residual) for residual in (own.before, own.after))
    measured = (own.commanded if side == 0 and own.commanded is not None
                else own.coordinates['joint_torque'])[:, place]
    if side == 1 and site in _IN_TORSION:
        measured, before, after = measured + own.after[:, column], -before, -after
    return Plot(COORDINATES['time'], 'torque, output [N·m]', own.time, [
        Line('measured', measured, 'measured'), Line(names[0], measured + before, 'before'),
        Line(names[1], measured + after, 'after')], 'time', _telling(own.time, measured, before))


def _telling(time: Array, measured: Array, missed: Array) -> tuple[float, float] | None:
    """Return the stretch in which a trace misses most, over how far the measured one goes."""
    count = round(_STRETCH / float(time[1] - time[0])) if len(time) > 1 else 0
    if count < 1 or len(time) <= count:
        return None
    parted = np.nan_to_num(missed) ** 2
    begins = range(0, len(time) - count, max(1, count // 4))
    share = [parted[k:k + count].mean() / (np.ptp(measured[k:k + count]) ** 2 + parted.mean())
             if parted.any() else 0.0 for k in begins]
    best = begins[int(np.argmax(share))]
    return float(time[best]), float(time[best + count])


def rest_charts(diagnosis: Diagnosis, exhibits: Exhibits) -> tuple[list[Following],
                                                                   dict[str, Chart]]:
    """Return what an unexplained rest follows, and its curve and spectrum."""
    told, rest = diagnosis.unexplained, exhibits.rest()
    if told is None:
        return [], {}
    place = (int(np.argmax(rest.powers())) if told.joint is None
             else rest.labels.index(told.joint))
    column = rest.column(place, told.site)
    found = rest.followed(column)
    best = next((each for each in found if each.coordinate == told.depends_on), found[0])
    name = _where(rest.labels, column)
    return found, {
        'rest_curve': Chart(f'Along what it follows: {name}', 'The line is the median of what no '
                            'backed cause explains, the band its middle half.',
                            {name: against(best, column, (('rest', rest, 'after'),))}),
        'rest_spectrum': Chart(f'Its spectrum: {name}', 'Amplitude of each frequency in it.',
                               {name: _spectrum(rest, column)})}


def _spectrum(rest: Rest, column: int) -> Plot:
    """Return the amplitude of each line of a residual, as far as the balances reach."""
    values = np.where(rest.valid[:, column], rest.residual[:, column], 0.0)
    size = np.abs(np.fft.rfft(values * np.hanning(len(values)))) * 4.0 / len(values)
    frequency = np.fft.rfftfreq(len(values), float(rest.time[1] - rest.time[0]))
    rows = np.flatnonzero((frequency > 0.0) & (frequency <= BANDWIDTH))
    cuts = np.unique(np.geomspace(1, len(rows), _LINES).astype(int)) - 1
    return Plot('frequency [Hz]', 'amplitude, output [N·m]', frequency[rows[cuts]],
                [Line('amplitude', np.maximum.reduceat(size[rows], cuts), 'after')], 'log_x')


def prediction(exhibits: Exhibits) -> Chart:
    """Return the error of predictions from measured states over how far ahead they look."""
    told = (exhibits.predicted_before, exhibits.predicted_after, exhibits.predicted_floor)
    before, after, floor = (1e3 * error for error in told)
    return Chart('Error of the simulation, by how far it looks ahead', (
        'From measured states, held out. The extended arm should lie on the noise; the gap '
        'between the two is what is still missed.'), {'all joints': Plot(
            'time ahead of the measured state [s]', 'rms error, output [mrad]',
            exhibits.horizons, [
                Line('arm as given', before, 'before'), Line('extended arm', after, 'after'),
                Line('noise alone', floor, 'floor')], 'log')})


def charts(diagnosis: Diagnosis, exhibits: Exhibits) -> dict[str, Chart]:
    """Return all charts of a diagnosis by the names under which its page places them."""
    found = {'overview': overview(diagnosis, exhibits), 'prediction': prediction(exhibits)}
    columns = _worst_first(exhibits)
    named, rest = causes(diagnosis), diagnosis.unexplained
    site = next((cause.site for cause in named.values()), rest.site if rest else 'link')
    timed = {'through_time': through_time(exhibits, columns, ('arm as given', 'extended arm'),
                                          site)}
    for name, cause in named.items():
        own = exhibits.of(cause.effect, cause.joint)
        found[f'giveaway_{name}'] = giveaway(cause, exhibits)
        timed[f'through_time_{name}'] = through_time(
            own, _columns_of(own, cause), ('simulated without it', 'simulated with it'),
            cause.site)
    found |= {name: chart for name, chart in timed.items() if chart is not None}
    return found | rest_charts(diagnosis, exhibits)[1]


def _worst_first(exhibits: Exhibits) -> list[int]:
    """Return the columns of all balances, what misses most over its noise first."""
    power = np.where(exhibits.valid, exhibits.before, 0.0).std(axis=0)
    missed = power / np.maximum(exhibits.noise, np.finfo(float).tiny)
    return [int(column) for column in np.argsort(-missed, kind='stable')]


def causes(diagnosis: Diagnosis) -> dict[str, Cause]:
    """Return all causes that the extended arm holds, by where the page shows them."""
    named = {str(number): Cause(one.effect, one.joint, one.site)
             for number, one in enumerate(diagnosis.findings, 1)}
    held = [one for alike in diagnosis.ambiguous for one in alike.candidates if one.in_model]
    return named | {f'alike_{one.effect}_{one.joint}': Cause(
        one.effect, one.joint, effect_named(one.effect).site.value) for one in held}


def _columns_of(own: Exhibits, cause: Cause) -> list[int]:
    """Return where a cause shows best: of a joint its own, of the arm every joint."""
    side, place = divmod(own.column(cause.site, cause.joint), len(own.labels))
    rest = [] if cause.joint else [one for one in range(len(own.labels)) if one != place]
    return [side * len(own.labels) + one for one in (place, *rest)]


def _where(labels: tuple[str, ...], column: int) -> str:
    """Return the joint and the balance of a column."""
    return f'{spoken(labels[column % len(labels)])}, balance {BALANCES[column // len(labels)]}'


def _name_of(told: Following) -> str:
    """Return what stands at the axis of what a residual follows."""
    if told.coordinate == 'time' and told.line is not None:
        return f'time in the period of {told.line:.4g} Hz [s]'
    return COORDINATES[told.coordinate]

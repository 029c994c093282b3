"""The plots of a diagnosis as data: torques over time, and what gives causes away."""

from collections.abc import Sequence
import math
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.effects import effect_named
import numpy as np

from .axes import ADJUSTED, COORDINATES, EXTENDED, GIVEN, RESIDUAL, SIDES
from .dependence import against, dependence_of, spectrum, where
from .exhibits import Exhibits
from .following import Following
from ..findings.report import Diagnosis
from ..findings.rest import SENSOR
from ..fitting.fit import REFERENCE
from ...pages.plot import Plot, PlotGroup, PlotLine
from ...pages.wording import spoken

# Numerics; choices unless stated otherwise.
_STRETCH = 3.0          # of a recording that is shown at first [s]


class CauseSite(NamedTuple):
    """An effect, its joint or None for the arm, and the site that it breaks."""

    effect: str
    joint: str | None
    site: str


def made_of(diagnosis: Diagnosis) -> str:
    """Return what a diagnosis makes of an arm: without a cause its numbers alone may differ."""
    return EXTENDED if diagnosis.extends else ADJUSTED


def _spelt(diagnosis: Diagnosis) -> str:
    return EXTENDED if diagnosis.extends else f'arm {ADJUSTED}'


def overview(diagnosis: Diagnosis, exhibits: Exhibits) -> PlotGroup:
    """Return the residual of every balance over time, before and after."""
    joints = len(exhibits.labels)
    floors = {(row.site, row.joint): row.floor for row in diagnosis.residuals}
    plots = {}
    for column in _worst_first(exhibits):
        label, side = exhibits.labels[column % joints], column // joints
        floor = floors.get((SIDES[side], label), math.nan)
        plots[where(exhibits.labels, column)] = Plot(
            COORDINATES['time'], RESIDUAL, exhibits.time, [
                PlotLine(GIVEN, _shown(exhibits, column, exhibits.before), 'before'),
                PlotLine(made_of(diagnosis), _shown(exhibits, column, exhibits.after), 'after'),
                *_floor(floor, len(exhibits.time))], 'time')
    return PlotGroup('What each balance misses over time', (
        f'The arm as given leaves the wide trace. The {_spelt(diagnosis)} should stay mostly '
        'between the dashed lines, as noise and encoder resolution alone do. Gaps are standstill, '
        'where friction is not known.'), plots)


def _floor(floor: float, count: int) -> list[PlotLine]:
    """Return twice the rms of noise on both sides of zero."""
    if not math.isfinite(floor):
        return []
    return [PlotLine(name, np.full(count, sign * floor), 'floor')
            for name, sign in (('twice the noise', 2.0), ('', -2.0))]


def _shown(exhibits: Exhibits, column: int, residual: Array) -> Array:
    return np.where(exhibits.valid[:, column], residual[:, column], np.nan)


def giveaway(cause: CauseSite, exhibits: Exhibits) -> PlotGroup:
    """Return the residual against what gives a cause away, without it and with it."""
    own = exhibits.of(cause.effect, cause.joint)
    column = own.column(cause.site, cause.joint)
    missed, rest = own.missed(), own.rest()
    following = missed.followed(column)[0]
    plot = against(following, column, (('without this cause', missed, 'before'),
                                       ('with it', rest, 'after')))
    return PlotGroup(f'What gives it away: {where(own.labels, column)}', (
        'The line is the median of the residual, the band its middle half. Without the cause it '
        'follows the coordinate; with it, it should be flat at zero.'),
        {where(own.labels, column): plot})


def through_time(exhibits: Exhibits, columns: Sequence[int], names: tuple[str, str],
                 site: str = 'link') -> PlotGroup | None:
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
            *([_gear_said(exhibits, columns, site)] if 1 in sides else []),
            *([_SENSED] if 2 in sides else []), _SHOWN]
    return PlotGroup('Torque, measured and simulated', ' '.join(said), {
        _timed_name(exhibits.labels, column): _timed(exhibits, column, names, site)
        for column in columns})


def _gear_said(exhibits: Exhibits, columns: Sequence[int], site: str) -> str:
    """Return what the torques of gears are, held against links or against a reference."""
    joints = len(exhibits.labels)
    if any(exhibits.beyond[column % joints] == REFERENCE for column in columns
           if column >= joints and exhibits.beyond):
        return _SENSED
    return _GEAR if site in _IN_TORSION else _LINKS


_IN_TORSION = ('torsion', 'timing', 'sensing')
_MOTOR = ('Of a motor, measured is the torque that it was commanded, times the gear ratio; '
          'simulated is what the model needs there to move as measured.')
_LINKS = ('Of a joint, measured is the torque of the gear, as the torsion gives it; simulated is '
          'what the links of the model need to move as measured.')
_GEAR = ('Of a joint, measured is the torque that the motion of the links asked for; simulated '
         'is what the gear of the model gives at the measured torsion.')
_SENSED = ('Of a joint, the torque of the gear by the torsion stands beside its reference torque, '
           'as what is simulated and what is measured.')
_SHOWN = 'The plot begins with the seconds in which the two part most.'


def _timed_name(labels: tuple[str, ...], column: int) -> str:
    part = ('motor', 'gear', SENSOR)[column // len(labels)]
    return f'{part} of {spoken(labels[column % len(labels)])}'


def _timed(own: Exhibits, column: int, names: tuple[str, str], site: str) -> Plot:
    side, place = divmod(column, len(own.labels))
    before, after = (_shown(own, column, residual) for residual in (own.before, own.after))
    measured = (own.commanded if side == 0 and own.commanded is not None
                else own.coordinates['joint_torque'])[:, place]
    if side == 1 and site in _IN_TORSION:
        measured, before, after = measured + own.after[:, column], -before, -after
    return Plot(COORDINATES['time'], 'torque, output [N·m]', own.time, [
        PlotLine('measured', measured, 'measured'),
        PlotLine(names[0], measured + before, 'before'),
        PlotLine(names[1], measured + after, 'after')], 'time',
                _clearest_stretch(own.time, measured, before))


def _clearest_stretch(time: Array, measured: Array, missed: Array) -> tuple[float, float] | None:
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
                                                                   dict[str, PlotGroup]]:
    """Return what an unexplained rest follows, and its curve and spectrum."""
    unexplained, rest = diagnosis.unexplained, exhibits.rest()
    if unexplained is None:
        return [], {}
    found = dependence_of(unexplained, rest)
    name = where(rest.labels, found.column)
    return found.found, {
        'rest_curve': PlotGroup(f'Along what it follows: {name}',
                                'The line is the median of what no '
                                'backed cause explains, the band its middle half.',
                                {name: against(found.following, found.column,
                                               (('rest', rest, 'after'),))}),
        'rest_spectrum': PlotGroup(f'Its spectrum: {name}', 'Amplitude of each frequency in it.',
                                   {name: spectrum(rest, found.column)})}


def prediction(diagnosis: Diagnosis, exhibits: Exhibits) -> PlotGroup:
    """Return the error of predictions from measured states over how far ahead they look."""
    errors = (exhibits.predicted_before, exhibits.predicted_after, exhibits.predicted_floor)
    before, after, floor = (1e3 * error for error in errors)
    return PlotGroup('Error of the simulation, by how far it looks ahead', (
        f'From measured states, held out. The {_spelt(diagnosis)} should lie on the noise; the '
        'gap between the two is what is still missed.'), {'all joints': Plot(
            'time ahead of the measured state [s]', 'rms error, output [mrad]',
            exhibits.horizons, [
                PlotLine(GIVEN, before, 'before'), PlotLine(made_of(diagnosis), after, 'after'),
                PlotLine('noise alone', floor, 'floor')], 'log')})


def charts(diagnosis: Diagnosis, exhibits: Exhibits) -> dict[str, PlotGroup]:
    """Return all charts of a diagnosis by the names under which its page places them."""
    found = {'overview': overview(diagnosis, exhibits),
             'prediction': prediction(diagnosis, exhibits)}
    columns = _worst_first(exhibits)
    named, rest = causes(diagnosis), diagnosis.unexplained
    site = next((cause.site for cause in named.values()), rest.site if rest else 'link')
    timed = {'through_time': through_time(exhibits, columns, (GIVEN, made_of(diagnosis)),
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
    """Return the columns of balances that hold somewhere, what misses most over noise first."""
    power = np.where(exhibits.valid, exhibits.before, 0.0).std(axis=0)
    missed = power / np.maximum(exhibits.noise, np.finfo(float).tiny)
    return [int(column) for column in np.argsort(-missed, kind='stable')
            if exhibits.valid[:, column].any()]


def causes(diagnosis: Diagnosis) -> dict[str, CauseSite]:
    """Return all causes that the extended arm holds, by where the page shows them."""
    named = {str(number): CauseSite(one.effect, one.joint, one.site)
             for number, one in enumerate(diagnosis.findings, 1)}
    held = [one for alike in diagnosis.ambiguous for one in alike.candidates if one.in_model]
    return named | {f'alike_{one.effect}_{one.joint}': CauseSite(
        one.effect, one.joint, effect_named(one.effect).site.value) for one in held}


def _columns_of(own: Exhibits, cause: CauseSite) -> list[int]:
    """Return where a cause shows best: of a joint its own, of the arm every joint."""
    side, place = divmod(own.column(cause.site, cause.joint), len(own.labels))
    rest = [] if cause.joint else [one for one in range(len(own.labels)) if one != place]
    return [side * len(own.labels) + one for one in (place, *rest)]

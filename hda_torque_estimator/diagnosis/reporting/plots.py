"""The figures of a diagnosis: what the simulation misses, what it follows, and what is gained."""

from collections.abc import Mapping
import math

import matplotlib
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter
import numpy as np

from .axes import BALANCES, COORDINATES, GIVEN, RESIDUAL, SIDES
from .curves import made_of
from .dependence import against, dependence_of, spectrum, where
from .exhibits import Exhibits
from .following import Following
from .unexplained import Rest
from ..balances.strongest_wave import TURN
from ..findings.report import Diagnosis, Finding
from ..findings.rest import Unexplained
from ...pages.drawing import AFTER, band, BEFORE, FLOOR, INK, plain, STYLE
from ...pages.plot import Plot


def figures(diagnosis: Diagnosis, exhibits: Exhibits) -> dict[str, Figure]:
    """Return all figures of a diagnosis by name, in the order in which they are shown."""
    drawn = {'residuals': residual_figure(diagnosis, exhibits)}
    for number, finding in enumerate(diagnosis.findings, 1):
        drawn[f'finding_{number}'] = finding_figure(finding, exhibits)
    if diagnosis.unexplained is not None:
        drawn['unexplained'] = rest_figure(diagnosis.unexplained, exhibits.rest())
    drawn['prediction'] = prediction_figure(diagnosis, exhibits)
    return drawn


def residual_figure(diagnosis: Diagnosis, exhibits: Exhibits) -> Figure:
    """Draw the residual of every balance over time, before and after, and its noise floor."""
    joints = len(exhibits.labels)
    floors = {(row.site, row.joint): row.floor for row in diagnosis.residuals}
    with matplotlib.rc_context(STYLE):
        columns = sorted(column for place in range(joints)
                         for column in exhibits.missed().channels(place))
        figure = Figure(figsize=(7.6, 1.0 + 1.45 * len(columns)), layout='constrained')
        rows = figure.subplots(len(columns), 1, sharex=True, squeeze=False)[:, 0]
        for column, axes in zip(columns, rows):
            label, side = exhibits.labels[column % joints], column // joints
            axes.set_title(f'{plain(label)}: balance {BALANCES[side]}')
            axes.set_ylabel('residual,\noutput [N·m]')
            for residual, colour, name in ((exhibits.before, BEFORE, GIVEN),
                                           (exhibits.after, AFTER, made_of(diagnosis))):
                shown = np.where(exhibits.valid[:, column], residual[:, column], np.nan)
                band(axes, exhibits.time, shown, colour, name,
                     alpha=0.55 if colour == BEFORE else 1.0)
            _floor(axes, floors.get((SIDES[side], label), math.nan))
        rows[-1].set_xlabel(COORDINATES['time'])
        _legend(figure, rows[0])
        figure.align_ylabels()
    return figure


def finding_figure(finding: Finding, exhibits: Exhibits) -> Figure:
    """Draw the residual that one cause leaves against what gives it away, before and after."""
    own = exhibits.of(finding.effect, finding.joint)
    column = own.column(finding.site, finding.joint)
    return _against(own, column, finding.effect, ('without this cause', 'with it'))


def rest_figure(unexplained: Unexplained, rest: Rest) -> Figure:
    """Draw the map of a rest: what it follows, how, and its spectrum."""
    found = dependence_of(unexplained, rest)
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(7.6, 3.3))
        bars, curve, lines = figure.subplots(1, 3, width_ratios=(0.8, 1.2, 1.0))
        figure.subplots_adjust(0.16, 0.25, 0.99, 0.88, 0.45)
        _bars(bars, found.found)
        _curve(curve, against(found.following, found.column, (('median', rest, 'after'),)), AFTER)
        curve.set_ylabel(RESIDUAL)
        _spectrum(lines, spectrum(rest, found.column))
        figure.suptitle(plain(f'unexplained: {where(rest.labels, found.column)}'), x=0.01,
                        ha='left', fontsize=9.5)
        handles, names = curve.get_legend_handles_labels()
        figure.legend(handles, names, ncols=len(names), loc='lower left')
    return figure


def _bars(axes: Axes, found: list[Following]) -> None:
    """Draw what each coordinate explains, the most on top."""
    names = [one.coordinate.replace('_', ' ') + (f'\nby {one.carrier}' if one.carrier else '')
             for one in found]
    axes.barh(names, [100.0 * one.share for one in found], color=AFTER)
    axes.invert_yaxis()
    axes.set_xlim(0.0, 100.0)
    axes.grid(visible=False, axis='y')
    axes.set_xlabel('power explained [%]')


def _curve(axes: Axes, plot: Plot, colour: str) -> None:
    """Draw medians over what a residual follows, and the quartiles around them."""
    for line, style in zip(plot.lines, ('-', '--')):
        if line.low is not None and line.high is not None:
            axes.fill_between(plot.x, line.low, line.high, color=colour, alpha=0.3, linewidth=0.0,
                              label='middle half' if style == '-' else None)
        axes.plot(plot.x, line.values, style, color=colour, linewidth=1.6, label=line.name)
    axes.axhline(0.0, color=INK, linewidth=0.6)
    axes.set_xlabel(plot.x_label)
    if plot.scale == 'turn':
        _turn_ticks(axes)


def _spectrum(axes: Axes, plot: Plot) -> None:
    """Draw the amplitude of each line of a residual."""
    axes.semilogx(plot.x, plot.lines[0].values, color=AFTER, linewidth=0.8)
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel(plot.x_label)
    axes.set_ylabel('amplitude [N·m]')


def _against(exhibits: Exhibits, column: int, title: str, names: tuple[str, ...]) -> Figure:
    """Draw one panel for each name: the residual before, and after, over what it follows."""
    missed = exhibits.missed()
    following = missed.followed(column)[0]
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(7.6 if len(names) > 1 else 4.8, 3.3), layout='constrained')
        panels = figure.subplots(1, len(names), sharey=True, sharex=True, squeeze=False)[0]
        for axes, name, rest, colour in zip(panels, names, (missed, exhibits.rest()),
                                            (BEFORE, AFTER)):
            _curve(axes, against(following, column, (('median', rest, 'after'),)), colour)
            axes.set_title(name)
        figure.suptitle(plain(f'{title}: {where(exhibits.labels, column)}'), x=0.01, ha='left',
                        fontsize=9.5)
        panels[0].set_ylabel(RESIDUAL)
        _legend(figure, panels[0], below=True)
    return figure


def prediction_figure(diagnosis: Diagnosis, exhibits: Exhibits) -> Figure:
    """Draw the error of predictions from measured states over how far ahead they look."""
    count = len(exhibits.horizons)
    marks = np.unique(np.geomspace(1, max(count, 1), min(count, 9)).astype(int) - 1).tolist()
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(4.8, 3.4), layout='constrained')
        axes = figure.subplots()
        for name, error, colour, style in (
                (GIVEN, exhibits.predicted_before, BEFORE, 'o-'),
                (made_of(diagnosis), exhibits.predicted_after, AFTER, 's--'),
                ('noise alone', exhibits.predicted_floor, FLOOR, '^:')):
            axes.loglog(exhibits.horizons, error, style, color=colour, label=name, markersize=4.5,
                        markevery=marks, linewidth=1.4)
        axes.set_xlabel('time ahead of the measured state [s]')
        axes.set_ylabel('rms prediction error, output [rad]')
        axes.grid(which='minor', alpha=0.12)
        _legend(figure, axes)
    return figure


def _floor(axes: Axes, floor: float) -> None:
    """Draw twice the rms of noise on both sides of zero."""
    if math.isfinite(floor):
        axes.axhline(2.0 * floor, color=INK, linestyle=(0, (4, 3)), linewidth=0.8,
                     label='noise floor, two standard deviations')
        axes.axhline(-2.0 * floor, color=INK, linestyle=(0, (4, 3)), linewidth=0.8)


def _turn_ticks(axes: Axes) -> None:
    axes.set_xlim(0.0, TURN)
    axes.xaxis.set_major_locator(FixedLocator([0.25 * TURN * place for place in range(5)]))
    names: Mapping[int, str] = {0: '0', 1: 'π/2', 2: 'π', 3: '3π/2', 4: '2π'}
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: names[round(4 * value / TURN)]))


def _legend(figure: Figure, axes: Axes, *, below: bool = False) -> None:
    handles, names = axes.get_legend_handles_labels()
    figure.legend(handles, names, ncols=len(names), borderpad=0.0,
                  loc='outside lower left' if below else 'outside upper left')

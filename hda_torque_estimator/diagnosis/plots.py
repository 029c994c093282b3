"""The figures of a diagnosis: what the simulation misses, what it follows, and what is gained."""

from collections.abc import Mapping
import io
import math
import re
from typing import Any

import matplotlib
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, NullFormatter
import numpy as np
from numpy.typing import NDArray

from .exhibits import along, binned, dependences, Example, Exhibits, TURN, WRAPPED
from .report import Diagnosis, Finding

Array = NDArray[np.float64]
INK = '#1a1a1e'                     # becomes the colour of the text around an inline figure
BEFORE, AFTER, FLOOR = '#e08214', '#2b6cb0', '#7f7f85'
COORDINATES = {
    'time': 'time [s]',
    'motor_velocity': 'motor velocity, shaft [rad/s]',
    'link_velocity': 'link velocity [rad/s]',
    'motor_angle': 'motor angle in its turn, shaft [rad]',
    'link_angle': 'link angle [rad]',
    'joint_torque': 'joint torque, output [N m]',
    'motor_torque': 'motor torque, shaft [N m]',
}
BALANCES = ('A, motor', 'B, torsion')
_BUCKETS = 600                      # of a trace over time: as many as can be seen
_BINS, _TURN_BINS = 30, 60
_STYLE: dict[Any, Any] = {
    'font.size': 8.5, 'axes.titlesize': 9.0, 'axes.titlelocation': 'left',
    'axes.spines.top': False, 'axes.spines.right': False, 'axes.grid': True, 'grid.alpha': 0.25,
    'grid.color': FLOOR, 'grid.linewidth': 0.5, 'axes.linewidth': 0.6, 'axes.xmargin': 0.01,
    'legend.frameon': False, 'text.color': INK, 'axes.labelcolor': INK, 'axes.edgecolor': INK,
    'xtick.color': INK, 'ytick.color': INK, 'axes.formatter.useoffset': False,
    'svg.hashsalt': 'hda', 'svg.fonttype': 'path',
}


def figures(diagnosis: Diagnosis, exhibits: Exhibits) -> dict[str, Figure]:
    """Return all figures of a diagnosis by name, in the order in which they are shown."""
    drawn = {'residuals': residual_figure(diagnosis, exhibits)}
    for number, finding in enumerate(diagnosis.findings, 1):
        drawn[f'finding_{number}'] = finding_figure(finding, exhibits)
    if diagnosis.unexplained is not None:
        rest = diagnosis.unexplained
        drawn['unexplained'] = rest_figure(exhibits, exhibits.column(rest.site, rest.joint))
    drawn['prediction'] = prediction_figure(exhibits)
    if exhibits.example is not None:
        drawn['example'] = example_figure(exhibits.labels, exhibits.example)
    return drawn


def residual_figure(diagnosis: Diagnosis, exhibits: Exhibits) -> Figure:
    """Draw the residual of every balance over time, before and after, and its noise floor."""
    joints = len(exhibits.labels)
    floors = {(row.site, row.joint): row.floor for row in diagnosis.residuals}
    with matplotlib.rc_context(_STYLE):
        figure = Figure(figsize=(7.6, 1.0 + 1.45 * 2 * joints), layout='constrained')
        rows = figure.subplots(2 * joints, 1, sharex=True, squeeze=False)[:, 0]
        for column, axes in enumerate(rows):
            label, side = exhibits.labels[column % joints], column // joints
            axes.set_title(f'{_text(label)}: balance {BALANCES[side]}')
            axes.set_ylabel('residual,\noutput [N m]')
            for residual, colour, name in ((exhibits.before, BEFORE, 'arm as given'),
                                           (exhibits.after, AFTER, 'extended arm')):
                shown = np.where(exhibits.valid[:, column], residual[:, column], np.nan)
                _trace(axes, exhibits.time, shown, colour, name)
            _floor(axes, floors.get((('motor', 'torsion')[side], label), math.nan))
        rows[-1].set_xlabel(COORDINATES['time'])
        _legend(figure, rows[0])
        figure.align_ylabels()
    return figure


def finding_figure(finding: Finding, exhibits: Exhibits) -> Figure:
    """Draw the residual that one cause leaves against what gives it away, before and after."""
    own = exhibits.of(finding.effect, finding.joint)
    column = own.column(finding.site, finding.joint)
    title = f'{finding.effect} at {finding.joint or "the arm"}'
    return _against(own, column, title, ('without this cause', 'with it'))


def rest_figure(exhibits: Exhibits, column: int) -> Figure:
    """Draw what the extended arm leaves in a column against what it follows."""
    return _against(exhibits.rest(), column, 'unexplained', ('extended arm',))


def _against(exhibits: Exhibits, column: int, title: str, names: tuple[str, ...]) -> Figure:
    """Draw one panel for each name: the residual before, and after, over what it follows."""
    told, joints = dependences(exhibits, column)[0], len(exhibits.labels)
    valid = exhibits.valid[:, column]
    coordinate = along(exhibits, told.coordinate, column)[valid]
    ahead = exhibits.coordinates['motor_velocity'][valid, column % joints] > 0.0
    with matplotlib.rc_context(_STYLE):
        figure = Figure(figsize=(7.6 if len(names) > 1 else 4.6, 3.0), layout='constrained')
        panels = figure.subplots(1, len(names), sharey=True, sharex=True, squeeze=False)[0]
        for axes, name, residual, colour in zip(
                panels, names, (exhibits.before, exhibits.after), (BEFORE, AFTER)):
            directions = {'forward': ahead, 'backward': ~ahead} if told.by_direction else \
                {'median': np.ones(len(ahead), bool)}
            for (direction, rows), line in zip(directions.items(), ('-', '--')):
                _spread(axes, coordinate[rows], residual[valid, column][rows], colour, line,
                        direction, _TURN_BINS if told.coordinate == WRAPPED else _BINS)
            axes.set_title(_text(name))
            axes.set_xlabel(COORDINATES[told.coordinate])
            axes.axhline(0.0, color=INK, linewidth=0.6)
            if told.coordinate == WRAPPED:
                _turn_ticks(axes)
        where = f'{exhibits.labels[column % joints]}, balance {BALANCES[column // joints]}'
        figure.suptitle(_text(f'{title}: {where}'), x=0.01, ha='left', fontsize=9.5)
        panels[0].set_ylabel('residual, output [N m]')
        panels[0].legend(loc='best')
    return figure


def prediction_figure(exhibits: Exhibits) -> Figure:
    """Draw the error of predictions from measured states over how far ahead they look."""
    with matplotlib.rc_context(_STYLE):
        figure = Figure(figsize=(4.8, 3.4), layout='constrained')
        axes = figure.subplots()
        for name, error, colour, style in (
                ('arm as given', exhibits.predicted_before, BEFORE, 'o-'),
                ('extended arm', exhibits.predicted_after, AFTER, 's--'),
                ('noise alone', exhibits.predicted_floor, FLOOR, '^:')):
            axes.loglog(exhibits.horizons, error, style, color=colour, label=name, markersize=4.5,
                        markevery=max(1, len(error) // 8), linewidth=1.4)
        axes.set_xlabel('time ahead of the measured state [s]')
        axes.set_ylabel('rms prediction error, output [rad]')
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.legend(loc='upper left')
        axes.grid(which='minor', alpha=0.12)
    return figure


def example_figure(labels: tuple[str, ...], example: Example) -> Figure:
    """Draw one window: the error of every simulated angle against the measured one."""
    joints = len(labels)
    with matplotlib.rc_context(_STYLE):
        figure = Figure(figsize=(7.6, 0.6 + 2.0 * joints), layout='constrained')
        panels = figure.subplots(joints, 2, sharex=True, squeeze=False)
        for column, axes in enumerate(panels.T.flat):
            label, side = labels[column % joints], ('motor over ratio', 'link')[column // joints]
            start = example.measured[0, column]
            for name, angle, colour, line in (
                    ('measured', example.measured, INK, '-'),
                    ('arm as given', example.before, BEFORE, '--'),
                    ('extended arm', example.after, AFTER, ':')):
                axes.plot(example.time, 1e3 * (angle[:, column] - start), line, color=colour,
                          linewidth=1.8 if line == ':' else 1.2, label=name)
            axes.set_title(_text(f'{label}, {side}'))
            axes.set_ylabel('angle moved,\noutput [mrad]')
        for axes in panels[-1]:
            axes.set_xlabel(COORDINATES['time'])
        _legend(figure, panels[0, 0])
    return figure


def inline_svg(figure: Figure, name: str) -> str:
    """
    Return a figure as an SVG element to stand in a page with others.

    Its names are made its own by `name`, its ink is the colour of the text around it.
    """
    stream = io.StringIO()
    with matplotlib.rc_context(_STYLE):
        figure.savefig(stream, format='svg', transparent=True, metadata={'Date': None})
    text = stream.getvalue()
    text = text[text.index('<svg'):].replace(INK, 'currentColor')
    text = re.sub(r'<metadata>.*?</metadata>', '', text, flags=re.DOTALL)
    return re.sub(r'(\bid="|xlink:href="#|url\(#)', rf'\g<1>{name}-', text)


def _trace(axes: Axes, time: Array, values: Array, colour: str, name: str) -> None:
    """Draw the band in which dense values lie: vector graphics stay small."""
    cuts = np.unique(np.linspace(0, len(time), min(_BUCKETS, len(time)) + 1).astype(int))[:-1]
    low = np.fmin.reduceat(values, cuts)
    high = np.fmax.reduceat(values, cuts)
    axes.fill_between(time[cuts], low, high, color=colour, linewidth=0.7,
                      alpha=0.55 if colour == BEFORE else 1.0, label=name)


def _floor(axes: Axes, floor: float) -> None:
    """Draw twice the rms of noise on both sides of zero."""
    if math.isfinite(floor):
        axes.axhline(2.0 * floor, color=INK, linestyle=(0, (4, 3)), linewidth=0.8,
                     label='noise floor, two standard deviations')
        axes.axhline(-2.0 * floor, color=INK, linestyle=(0, (4, 3)), linewidth=0.8)


def _spread(axes: Axes, coordinate: Array, values: Array, colour: str, line: str, name: str,
            bins: int) -> None:
    """Draw the binned median of values, and the quartiles around it."""
    if not len(values):
        return
    told = binned(coordinate, values, max(1, min(bins, len(values) // 20)))
    axes.fill_between(told.centre, told.low, told.high, color=colour, alpha=0.3, linewidth=0.0,
                      label='quartiles' if line == '-' else None)
    axes.plot(told.centre, told.median, line, color=colour, linewidth=1.6, label=name)


def _turn_ticks(axes: Axes) -> None:
    axes.set_xlim(0.0, TURN)
    axes.xaxis.set_major_locator(FixedLocator([0.25 * TURN * place for place in range(5)]))
    names: Mapping[int, str] = {0: '0', 1: 'π/2', 2: 'π', 3: '3π/2', 4: '2π'}
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: names[round(4 * value / TURN)]))


def _legend(figure: Figure, axes: Axes) -> None:
    handles, names = axes.get_legend_handles_labels()
    figure.legend(handles, names, loc='outside upper left', ncols=len(names), borderpad=0.0)


def _text(plain: str) -> str:
    """Return text in which a dollar sign starts no formula."""
    return plain.replace('$', r'\$')

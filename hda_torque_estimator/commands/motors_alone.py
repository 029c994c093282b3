"""Recordings with one encoder for each joint: how `hda diagnose` draws them."""

from collections.abc import Sequence

import matplotlib
from matplotlib.axes import Axes
from matplotlib.figure import Figure
import numpy as np

from ..diagnosis.motors_alone.motor_fit import Explained
from ..diagnosis.motors_alone.ripple import spectrum
from ..pages.drawing import AFTER, BEFORE, FLOOR, plain, STYLE

_SHOWN = 0.15           # of a sweep, in the figure of its torque [s]


def motor_figures(parts: Sequence[Explained]) -> dict[str, Figure]:
    """Return a figure for each motor: its torque, and the spectrum over its turn."""
    return {f'motor_{part.sweep.joint.label}': _motor_figure(part) for part in parts}


def _motor_figure(part: Explained) -> Figure:
    """Draw the torque of a motor and the lines in it."""
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(7.6, 2.9), layout='constrained')
        torque, lines = figure.subplots(1, 2, width_ratios=(1.0, 1.25))
        _torque(torque, part)
        _lines(lines, part)
        figure.suptitle(plain(part.sweep.joint.label), x=0.01, ha='left', fontsize=9.5)
        figure.legend(*lines.get_legend_handles_labels(), loc='outside lower left', ncols=3)
    return figure


def _torque(axes: Axes, part: Explained) -> None:
    """Draw a part of a held-out stretch: measured, without and with what was found."""
    sweep = part.sweep
    held = np.flatnonzero(sweep.moving & sweep.held_out)
    middle = sweep.block[held[len(held) // 2]]
    rows = held[sweep.block[held] == middle][:round(_SHOWN / sweep.dt)]
    first = part.columns.shape[1] - 2 * len(part.lines)
    for values, colour, width in (
            (sweep.torque, FLOOR, 0.6),
            (sweep.torque - part.without(range(first, part.columns.shape[1])), BEFORE, 1.2),
            (sweep.torque - part.without(()), AFTER, 0.9)):
        axes.plot(sweep.time[rows], sweep.joint.ratio * values[rows], color=colour, lw=width)
    axes.set_title('a held-out stretch')
    axes.set_xlabel('time [s]')
    axes.set_ylabel('motor torque, output [N\N{MIDDLE DOT}m]')


def _lines(axes: Axes, part: Explained) -> None:
    """Draw the amplitude of the rest over orders of the motor's turn, without and with lines."""
    sweep = part.sweep
    first = part.columns.shape[1] - 2 * len(part.lines)
    axes.plot([], [], color=FLOOR, lw=0.8, label='measured')
    for taken, colour, name in ((range(first, part.columns.shape[1]), BEFORE, 'without lines'),
                                ((), AFTER, 'with the lines found')):
        orders, size = spectrum(sweep.angle[sweep.moving],
                                part.without(tuple(taken))[sweep.moving])
        axes.plot(orders, sweep.joint.ratio * size, color=colour, lw=0.8, label=name)
    for line in part.lines:
        axes.axvline(line.order, color=FLOOR, lw=0.5, ls=':')
    axes.set_title('rest over the turn of the motor')
    axes.set_xlabel('waves per motor turn')
    axes.set_ylabel('amplitude, output [N\N{MIDDLE DOT}m]')
    axes.set_ylim(bottom=0.0)

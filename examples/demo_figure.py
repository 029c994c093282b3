"""The figure of the demo: what was true, and what was estimated from the encoders."""

from pathlib import Path
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.files import arm_from_text
from hda_msgs_json.bag import open_recording
from hda_msgs_json.topics import (
    JOINT_TORQUES, MOTOR_COMMAND, TIP_WRENCH, truth_joint_torque, TRUTH_TIP_WRENCH)
import matplotlib
from matplotlib.axes import Axes
import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray

TRUE, ESTIMATED, ERROR = '#222222', '#d95f02', '#7570b3'


class Panel(NamedTuple):
    """One quantity over time."""

    name: str
    unit: str
    true: Array         # (k,)
    estimated: Array    # (k,)


class Shown(NamedTuple):
    """What the figure shows, at the stamps of the estimates while the controller was enabled."""

    labels: tuple[str, ...]
    stamps: NDArray[np.int64]       # (k,) [ns]
    lost: int                       # samples that the recording lacks
    panels: list[Panel]

    @staticmethod
    def read(recording: Path, estimates: Path) -> 'Shown':
        """Read what was true and what `hda estimate` made of it."""
        live, made = open_recording(recording), open_recording(estimates)
        labels = arm_from_text(live.metadata['arm'], str(recording)).labels
        torques = made.joint_states(JOINT_TORQUES.name)
        commanded = live.joint_states(MOTOR_COMMAND.name).stamps
        moving = torques.stamps >= commanded[0]
        stamps = torques.stamps[moving]
        panels = []
        for label, column in zip(labels, torques.effort[moving].T):
            truth = live.wrenches(truth_joint_torque(label).name)
            panels.append(Panel(f'torque, {label}', 'N m',
                                _at(stamps, truth.stamps, truth.torque[:, 2]), column))
        force, truth = made.wrenches(TIP_WRENCH.name), live.wrenches(TRUTH_TIP_WRENCH.name)
        for axis, letter in enumerate('xy'):
            panels.append(Panel(f'tip force, {letter}', 'N',
                                _at(stamps, truth.stamps, truth.force[:, axis]),
                                force.force[moving, axis]))
        periods = np.diff(live.joint_states().stamps)
        lost = int((np.round(periods / np.median(periods)) - 1).sum())
        return Shown(labels, stamps, lost, panels)


def _at(stamps: NDArray[np.int64], known: NDArray[np.int64], values: Array) -> Array:
    return np.interp(stamps - stamps[0], known - stamps[0], values)


def draw(shown: Shown, path: Path) -> None:
    """Write the figure."""
    matplotlib.use('Agg')
    with plt.rc_context(STYLE):
        figure, rows = plt.subplots(
            len(shown.panels), 2, figsize=(7.2, 6.4), sharex=True, layout='constrained',
            gridspec_kw={'width_ratios': (3, 2)})
        time = (shown.stamps - shown.stamps[0]) * 1e-9
        for row, panel in zip(rows, shown.panels):
            _values(row[0], time, panel)
            _errors(row[1], time, panel)
        rows[0, 0].legend(loc='lower left', bbox_to_anchor=(0.0, 1.0), ncols=2, borderpad=0.0)
        rows[0, 1].set_title('estimated minus true', loc='left')
        for axes in rows[-1]:
            axes.set_xlabel('time [s]')
        figure.align_ylabels(rows[:, 0])
        figure.savefig(path, dpi=200)
        plt.close(figure)


def _values(axes: Axes, time: Array, panel: Panel) -> None:
    axes.plot(time, panel.true, color=TRUE, linewidth=1.8, label='true')
    axes.plot(time, panel.estimated, color=ESTIMATED, linewidth=0.8, label='estimated')
    axes.set_ylabel(f'{panel.name} [{panel.unit}]')


def _errors(axes: Axes, time: Array, panel: Panel) -> None:
    error = panel.estimated - panel.true
    axes.plot(time, error, color=ERROR, linewidth=0.6)
    axes.margins(y=0.2)
    axes.text(0.02, 0.96, f'rms {np.sqrt(np.nanmean(error ** 2)):.2g} {panel.unit}',
              transform=axes.transAxes, va='top')


STYLE = {
    'font.size': 8.0, 'axes.titlesize': 9.0, 'axes.spines.top': False,
    'axes.spines.right': False, 'axes.grid': True, 'grid.alpha': 0.25, 'grid.linewidth': 0.5,
    'axes.linewidth': 0.6, 'legend.frameon': False, 'axes.xmargin': 0.01,
}

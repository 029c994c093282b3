"""Fig. 14: the two-axis arm pushed by hand, with and without a motor torque."""

import math
from typing import NamedTuple

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import CoarseQuantisation, DriveOffset, StribeckFriction
from hda_arm_sim.motions import HOME, Motion
import numpy as np

from ..rig import bench
from ..rig.exhibit import Arms, Drawing, Exhibit, Look, Panel, PaperNumber, Trace
from ..rig.printed import PRINTED
from ..rig.shapes import hand
from ...controlling.controller import ControllerSettings
from ...simulating import closed_loop

_SECONDS = 100.0
_PUSHES = ((20.0, 40.0), (40.0, 60.0), (80.0, 100.0))
_MOTOR = 2.66e-2                    # of joint 2 in the second scenario [N*m, shaft]
_FORCE = 42.0                       # of the hand [N]
_BREAKAWAY = StribeckFriction(excess=0.008, speed=3.0)
_STEP = 2.0 * np.pi / 4096.0        # of the motor encoders [rad]
_STANDING = 200                     # samples for which a motor has to stand before a slip
_IDLE = ControllerSettings(position_gain=0.0, velocity_gain=0.0)


class _Slips(NamedTuple):
    """How a motor stands and slips: shares, and the torque at which it gives way [N*m]."""

    standing: float                 # share of the time of the pushes
    onsets: int
    one_sided: float                # share of slips in the direction of the torque that drives
    torque: float                   # median size at the onset
    spread: float                   # deviation of the torque while the motor stands


def back_driving(arms: Arms) -> Exhibit:
    """Return angle and torque of an arm that a hand moves, and why its peaks are one-sided."""
    free, driven = _pushed(arms.two_axis, 0.0), _pushed(arms.two_axis, _MOTOR)
    slips = [_slips(free, joint) for joint in range(2)]
    stick = PRINTED.ratio * PRINTED.starting_torque
    counts = 1e4 * _STEP / PRINTED.ratio
    numbers = (
        PaperNumber('torque that back-drives a joint without current', 'N*m', None, None, stick,
                    'N T_fs; breaking away takes more'),
        *(PaperNumber(f'share of the pushes in which motor {joint + 1} stands', '%', None, None,
                      100.0 * found.standing) for joint, found in enumerate(slips)),
        *(PaperNumber(f'slips of motor {joint + 1}', '1', None, None, float(found.onsets))
          for joint, found in enumerate(slips)),
        *(PaperNumber(f'slips of motor {joint + 1} with a peak of the sign of the motion', '%',
                      100.0,
                      None, 100.0 * found.one_sided) for joint, found in enumerate(slips)),
        *(PaperNumber(f'torque at which motor {joint + 1} gives way, median', 'N*m', None, None,
                      found.torque) for joint, found in enumerate(slips)),
        *(PaperNumber(f'torque of joint {joint + 1} while its motor stands, deviation', 'N*m',
                      None,
                      None, found.spread) for joint, found in enumerate(slips)),
        PaperNumber('one count of the motor encoder', 'N*m', None, None, counts,
                    '4096 counts, at K_f'),
        PaperNumber('torque of 2.66e-2 N*m at joint 2', 'N*m', None, None, PRINTED.ratio * _MOTOR,
                    f'below the {stick:g} N*m that move it'))
    return Exhibit(numbers, (
        'Where the displacement is flat the motor stands: friction at the shaft holds '
        f'{stick:.1f} N*m at the joint, within which only the gear twists, by less than half a '
        'milliradian. The torque goes on changing there; a flat curve is stick, not a want of '
        'resolution.',
        'A motor gives way only with a torque that pushes it, so every peak has the sign of the '
        f'motion that it starts ({100.0 * min(found.one_sided for found in slips):.0f} % of the '
        'slips). Breaking away takes more than sliding: the torque drops as the motor moves, '
        'which leaves a peak, one-sided by nature.',
        f'Counts of the motor encoder are {counts:.2f} N*m, those of the scale a tenth of it: the '
        'fine scale is not what limits the torque.',
        f'The motor torque of the second scenario is {PRINTED.ratio * _MOTOR:.2f} N*m at the '
        'joint and does not move it alone; it lowers the push that joint 2 needs one way to '
        f'{stick - PRINTED.ratio * _MOTOR:.1f} N*m and raises it the other way to '
        f'{stick + PRINTED.ratio * _MOTOR:.1f} N*m.'),
        (_drawing('free', 'without current', free),
         _drawing('driven', '2.66e-2 N·m at motor 2', driven), _peaks(free)),
        ('The pushes were those of a hand; here they are random, of the same order.',))


def _pushed(arm: Arm, current: float) -> closed_loop.ClosedLoopRun:
    """Return an arm without control whose tip is pushed by a hand in the three stretches."""
    for label in arm.labels:
        arm = arm.with_effect(CoarseQuantisation(motor_step=_STEP, link_step=2.0 * np.pi / 4e6),
                              label)
    true = arm.with_effect(DriveOffset(offset=current), arm.labels[1])
    for label in arm.labels:
        true = true.with_effect(_BREAKAWAY, label)
    time = bench.quiet(2, _SECONDS).time
    force = sum(np.stack([hand(time, 2 * seed + axis, *span, _FORCE) for axis in range(2)], axis=1)
                for seed, span in enumerate(_PUSHES))
    still = np.tile(np.array(HOME), (len(time), 1))
    return closed_loop.run(true, arm, Motion(time, still, np.zeros_like(still),
                                             np.asarray(force)), 0, controller=_IDLE,
                           estimator=bench.TORSION_ALONE)


def _slips(made: closed_loop.ClosedLoopRun, joint: int) -> _Slips:
    """Return how a motor stands and slips during the pushes."""
    pushed = np.any([(made.time > begin) & (made.time < end) for begin, end in _PUSHES], axis=0)
    speed = made.state[:, joint, 1]
    standing = speed == 0.0
    onsets = np.array([k for k in np.flatnonzero(standing[:-1] & ~standing[1:])
                       if standing[max(k - _STANDING, 0):k + 1].all()], int)
    drive = -made.estimated_torque[onsets, joint]
    along = np.sign(drive) == np.sign(speed[onsets + 1])
    return _Slips(float(standing[pushed].mean()), len(onsets),
                  float(along.mean()) if len(onsets) else math.nan,
                  float(np.median(np.abs(drive))) if len(onsets) else math.nan,
                  float(made.estimated_torque[pushed & standing, joint].std()))


def _drawing(name: str, title: str, made: closed_loop.ClosedLoopRun) -> Drawing:
    thin = slice(None, None, 50)
    angle = made.state[thin, :, 2] - made.state[0, :, 2]
    return Drawing(name, f'Displacement and torque of the environment, {title}; the pushes are '
                   'shaded.', (tuple(
                       Panel(f'{title}, {what}', 'time [s]', label, tuple(
                           Trace(made.time[thin], values[:, joint], f'joint {joint + 1}', look)
                           for joint, look in enumerate((Look.CONSISTENT, Look.PRINTED))),
                           shaded=_PUSHES)
                       for what, label, values in (
                           ('displacement', 'link angle moved [rad]', angle),
                           ('torque', 'torque [N·m]', -made.estimated_torque[thin]))),))


def _peaks(made: closed_loop.ClosedLoopRun) -> Drawing:
    """Draw displacement and torque of joint 1 over a few seconds, and where the motor stands."""
    part = (made.time > 22.0) & (made.time < 32.0)
    time, standing = made.time[part], (made.state[part, 0, 1] == 0.0)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], standing, [0]])))
    stands = tuple((float(time[a]), float(time[min(b, len(time) - 1)]))
                   for a, b in zip(edges[::2], edges[1::2]) if b - a > 20)
    thin = np.flatnonzero(part)[::4]
    moved = 1e3 * (made.state[thin, 0, 0] - made.state[0, 0, 0]) / PRINTED.ratio
    displacement = Panel(
        'joint 1, displacement', 'time [s]', 'shaft angle moved / N [mrad]',
        (Trace(made.time[thin], moved, 'shaft', Look.CONSISTENT),), shaded=stands)
    torque = Panel('joint 1, torque', 'time [s]', 'torque [N·m]', (
        Trace(made.time[thin], -made.joint_torque[thin, 0], 'true', Look.TRUTH),
        Trace(made.time[thin], -made.estimated_torque[thin, 0], 'estimated', Look.PRINTED)),
        shaded=stands)
    return Drawing('peaks', 'Ten seconds without current; the motor stands while shaded. The '
                   'torque climbs while it stands and drops as it slips.',
                   ((displacement, torque),))

"""Fig. 12: the two experiments with torque feedback, on the imperfect but calibrated rig."""

import math

from hda_arm_sim.model.arm import Arm
import numpy as np

from ..rig import bench
from ..rig.exhibit import Arms, Drawing, Exhibit, Look, Panel, PaperNumber, Trace
from ..rig.imperfections import imperfect, TOGETHER
from ..rig.printed import PRINTED
from ..rig.rig_calibration import calibrated
from ..rig.shapes import hand, step
from ...controlling.controller import ControllerSettings

_CURRENT, _PUSH = 0.01, 2.5         # constant motor torque, shaft, and pushes of a hand [N*m]
_FOLLOW_SECONDS, _HOLD_SECONDS = 20.0, 26.0
_HARD_PUSH, _PUSHED = 6.0, (8.0, 24.0)      # in position mode [N*m], [s]
_GAINS = (0.0, 0.1, 0.9)
_STICK = PRINTED.ratio * PRINTED.starting_torque
_LOOKS = {0.0: Look.PLAIN, 0.1: Look.CONSISTENT, 0.9: Look.THIRD}


def feedback_experiments(arms: Arms) -> Exhibit:
    """Return following with a constant motor torque, and holding 90 deg against a hand."""
    true = imperfect(arms.rig, TOGETHER)
    known = calibrated(true, arms.rig)
    followed = {gain: _followed((true, known), gain) for gain in (0.0, -1.0)}
    held = {gain: _held((true, known), gain) for gain in _GAINS}
    numbers = (
        *(PaperNumber(f'first experiment, travel of the link, K_J = {gain:g}', 'deg', None, None,
                      math.degrees(float(np.ptp(made.link_angle)))) for gain,
          made in followed.items()),
        PaperNumber('push at which the motor gives way, no feedback', 'N*m', None, None, _STICK,
                    'without a motor torque'),
        PaperNumber('push at which the motor gives way, K_J = -1', 'N*m', None, None, 0.5 * _STICK,
                    'without a motor torque'),
        *(PaperNumber(f'second experiment, largest departure from where it stood, K_J = {gain:g}',
                      'deg', None, None, _departure(made)) for gain, made in held.items()),
        PaperNumber('second experiment, distance from 90 deg before the push', 'deg', None, None,
                    abs(90.0 - math.degrees(_before(held[0.0]))),
                    'the stick band of K_P: up to 7.1 deg'))
    departures = [_departure(made) for made in held.values()]
    return Exhibit(numbers, (
        f'First experiment: pushes of {_PUSH:g} N*m do not overcome the friction of the gear '
        f'({_STICK:.1f} N*m at the joint), so without feedback the link only springs. K_J = -1 '
        'doubles what the motor feels, the arm gives way at half the push and follows.',
        f'Second experiment: the hand takes the arm {departures[0]:.2f} deg off without feedback, '
        f'{departures[1]:.2f} deg with K_J = 0.1 and {departures[2]:.2f} deg with K_J = 0.9. The '
        'effect of Fig. 12(d) needs a K_J near 1, or pushes just above the friction.'),
        (_follow_drawing(followed), _hold_drawing(held)),
        ('The torques of the hand: random, and no scale in the text.',))


def _followed(arms: tuple[Arm, Arm], gain: float) -> bench.BenchRun:
    """Return the rig under a constant motor torque and pushes either way."""
    inputs = bench.quiet(1, _FOLLOW_SECONDS)
    inputs.current[:] = _CURRENT
    inputs.load[:, 0] = _PUSH * (step(inputs.time, 4.0, 8.0, 0.5)
                                 - step(inputs.time, 12.0, 16.0, 0.5))
    settings = ControllerSettings(position_gain=0.0, velocity_gain=0.0, torque_feedback=gain)
    return bench.run(*arms, inputs, (0.0,), controller=settings)


def _held(arms: tuple[Arm, Arm], gain: float) -> bench.BenchRun:
    """Return the rig moved to 90 deg and held there against a hand."""
    time = bench.quiet(1, _HOLD_SECONDS).time
    rate = 0.25 * math.pi * step(time, 1.0, 4.0, 1.0)
    settings = ControllerSettings(position_gain=0.003, velocity_gain=0.01, torque_feedback=gain)
    return bench.follow(*arms, rate, hand(time, 4, *_PUSHED, _HARD_PUSH), controller=settings)


def _before(made: bench.BenchRun) -> float:
    """Return the link angle just before the hand begins [rad]."""
    return float(made.link_angle[round(_PUSHED[0] / bench.STEP), 0])


def _departure(made: bench.BenchRun) -> float:
    """Return how far the hand takes the link from where it stood [deg]."""
    pushed = (made.time > _PUSHED[0]) & (made.time < _PUSHED[1])
    return math.degrees(float(np.abs(made.link_angle[pushed, 0] - _before(made)).max()))


def _follow_drawing(followed: dict[float, bench.BenchRun]) -> Drawing:
    looks = {0.0: Look.PLAIN, -1.0: Look.CONSISTENT}
    traces = [(made, _name(gain), looks[gain]) for gain, made in followed.items()]
    torque, angle = _panels(traces, 0.0)
    return Drawing('follow', 'First experiment: a constant motor torque, and pushes of 2.5 N·m '
                   'either way. With feedback the motor turns the way it is pushed; it shakes '
                   'where its kinematic error meets the resonance of the arm.',
                   ((torque._replace(bottom=-8.0, top=8.0), angle),))


def _hold_drawing(held: dict[float, bench.BenchRun]) -> Drawing:
    traces = [(made, _name(gain), _LOOKS[gain]) for gain, made in held.items()]
    row = tuple(panel._replace(shaded=(_PUSHED,)) for panel in _panels(traces, _PUSHED[0] - 2.0))
    return Drawing('hold', 'Second experiment: 90 deg are commanded, a hand pushes while shaded.',
                   (row,))


def _panels(traces: list[tuple[bench.BenchRun, str, Look]], begin: float) -> tuple[Panel, Panel]:
    """Return torque and angle of some runs from a time on [s]."""
    shown = slice(round(begin / bench.STEP), None, 20)
    torque = tuple(Trace(made.time[shown], -made.torque[shown, 0], name, look)
                   for made, name, look in traces)
    angle = tuple(Trace(made.time[shown], np.degrees(made.link_angle[shown, 0]), name, look)
                  for made, name, look in traces)
    return (Panel('estimated torque', 'time [s]', 'torque of the push [N·m]', torque),
            Panel('position', 'time [s]', 'link angle [deg]', angle))


def _name(gain: float) -> str:
    return f'K_J = {gain:g}' if gain else 'without feedback'

"""Fig. 7: joint torque feedback that follows a push or rejects it."""

import math
from typing import NamedTuple

from hda_arm_sim.model.arm import Arm
import numpy as np

from .responses import AMPERE, printed_plant
from ..rig import bench
from ..rig.exhibit import Arms, Drawing, Exhibit, Look, Panel, PaperNumber, Trace
from ..rig.loop_margins import frequencies, limits, loop_response
from ..rig.printed import PRINTED
from ...controlling.controller import ControllerSettings

PUSH = (10.0, 15.0)                 # when the environment pushes [s]
_SWITCHED_ON, _SECONDS = 9.0, 20.0      # the current, the whole [s]
_WEAK, _STRONG = (1.0, 8.5), (3.0, 12.0)    # current [A] and push against it [N*m]
_HELD_PUSH = 6.0                    # in position mode [N*m]
_STICK = PRINTED.ratio * PRINTED.starting_torque


class Case(NamedTuple):
    """One run: its name and look, the arm, current [A], push [N*m] and settings."""

    name: str
    look: Look
    arm: Arm
    current: float
    push: float
    settings: ControllerSettings


def feedback(arms: Arms) -> Exhibit:
    """Return torque mode and position mode with and without feedback, and the loop's limits."""
    follow, reject = _torque_mode(arms), _position_mode(arms)
    runs = {case.name: _run(case) for case in (*follow, *reject)}
    drawings = (_drawing('torque', 'Torque mode: a step of current at 9 s, and a push against it '
                         'while shaded. Left and middle 1 A and 8.5 N·m, right 3 A and 12 N·m.',
                         [follow[:2], follow[2:5], follow[5:]], runs, 'link angle [rad]'),
                _drawing('position', 'Position mode: the motor holds its angle by the gains of '
                         'the paper, the environment pushes with 6 N·m while shaded. By the '
                         'printed equations T_fs drives the arm off to begin with.',
                         [reject[:2], reject[2:]], runs, 'link angle [rad]'),
                _loop(arms.rig))
    return Exhibit((*_following(runs), *_rejecting(runs), *_limits(arms.rig)),
                   _findings(arms.rig), drawings,
                   ('The size of the external torque and of the current: no scale in the text.',
                    'The units of K_P = 0.003 and K_D = 0.01: taken as N*m/rad and N*m*s/rad at '
                    'the shaft. Per degree, the stick band would be '
                    f'{math.degrees(PRINTED.starting_torque / 0.172) / 100.0:.2f} deg instead.'))


def _gains(torque_feedback: float, *, position: bool = False) -> ControllerSettings:
    return ControllerSettings(position_gain=0.003 if position else 0.0,
                              velocity_gain=0.01 if position else 0.0,
                              torque_feedback=torque_feedback)


def _torque_mode(arms: Arms) -> list[Case]:
    printed = printed_plant(arms.rig)
    return [Case('printed, without', Look.MARK, printed, *_WEAK, _gains(0.0)),
            Case('printed, K_J = -1', Look.PRINTED, printed, *_WEAK, _gains(-1.0)),
            Case('consistent, without', Look.PLAIN, arms.rig, *_WEAK, _gains(0.0)),
            Case('consistent, K_J = -1', Look.CONSISTENT, arms.rig, *_WEAK, _gains(-1.0)),
            Case('consistent, K_J = 0.9', Look.THIRD, arms.rig, *_WEAK, _gains(0.9)),
            Case('3 A, without', Look.PLAIN, arms.rig, *_STRONG, _gains(0.0)),
            Case('3 A, K_J = -1', Look.CONSISTENT, arms.rig, *_STRONG, _gains(-1.0))]


def _position_mode(arms: Arms) -> list[Case]:
    printed = printed_plant(arms.rig)
    cases = [Case(f'printed, K_J = {gain:g}, held', look, printed, 0.0, _HELD_PUSH,
                  _gains(gain, position=True))
             for gain, look in ((0.0, Look.MARK), (0.1, Look.PRINTED))]
    return cases + [Case(f'consistent, K_J = {gain:g}, held', look, arms.rig, 0.0, _HELD_PUSH,
                         _gains(gain, position=True))
                    for gain, look in ((0.0, Look.PLAIN), (0.1, Look.CONSISTENT),
                                       (0.9, Look.THIRD), (-1.0, Look.FOURTH))]


def _run(case: Case) -> bench.BenchRun:
    inputs = bench.quiet(1, _SECONDS)
    inputs.current[inputs.time >= _SWITCHED_ON] = case.current * AMPERE
    during = (inputs.time >= PUSH[0]) & (inputs.time < PUSH[1])
    inputs.load[during] = -case.push
    return bench.run(case.arm, case.arm, inputs, (0.0,), controller=case.settings)


def moved(made: bench.BenchRun) -> float:
    """Return how far the link goes while it is pushed [rad]."""
    begin, end = (round(time / bench.STEP) for time in PUSH)
    return float(made.link_angle[end - 1, 0] - made.link_angle[begin, 0])


def _furthest(made: bench.BenchRun) -> float:
    """Return how far the push takes the link from where it began [rad]."""
    begin, end = (round(time / bench.STEP) for time in PUSH)
    return float(np.abs(made.link_angle[begin:end, 0] - made.link_angle[begin, 0]).max())


def _following(runs: dict[str, bench.BenchRun]) -> tuple[PaperNumber, ...]:
    rows = (('1 A, push of 8.5 N*m, without feedback', 'printed, without', 'consistent, without'),
            ('1 A, push of 8.5 N*m, K_J = -1', 'printed, K_J = -1', 'consistent, K_J = -1'),
            ('1 A, push of 8.5 N*m, K_J = 0.9', None, 'consistent, K_J = 0.9'),
            ('3 A, push of 12 N*m, without feedback', None, '3 A, without'),
            ('3 A, push of 12 N*m, K_J = -1', None, '3 A, K_J = -1'))
    return tuple(PaperNumber(f'link during the push: {name}', 'rad', None,
                             None if printed is None else moved(runs[printed]),
                             moved(runs[consistent])) for name, printed, consistent in rows)


def _rejecting(runs: dict[str, bench.BenchRun]) -> tuple[PaperNumber, ...]:
    found = []
    for gain in ('0', '0.1', '0.9', '-1'):
        printed = runs.get(f'printed, K_J = {gain}, held')
        found.append(PaperNumber(
            f'position mode, link pushed off by 6 N*m, K_J = {gain}', 'rad', None,
            None if printed is None else _furthest(printed),
            _furthest(runs[f'consistent, K_J = {gain}, held'])))
    push, share = _HELD_PUSH, 0.1
    return (*found,
            PaperNumber('position mode, lasting offset left with K_J = 0.1', '%', None,
                        100.0 * (1.0 - share),
                        100.0 * (push * (1.0 - share) - _STICK) / (push - _STICK),
                        'of that without; dry friction takes its share first'),
            PaperNumber('stick band T_fs/K_P, at the link', 'deg', None, None,
                        math.degrees(PRINTED.starting_torque / 0.003 / PRINTED.ratio)),
            PaperNumber('largest push that the motor does not feel at all, K_J = 0', 'N*m', None,
                        0.0,
                        _STICK),
            PaperNumber('largest push that the motor does not feel at all, K_J = 0.1', 'N*m', None,
                        0.0, _STICK / (1.0 - share)))


def _limits(rig: Arm) -> tuple[PaperNumber, ...]:
    free, held = limits(rig, held=False), limits(rig, held=True)
    return (PaperNumber('largest K_J, link free', '1', None, None, free.rejecting),
            PaperNumber('largest K_J, link held', '1', None, None, held.rejecting,
                        'from there on positive feedback'),
            PaperNumber('smallest K_J, link free', '1', None, None, free.following,
                        f'swings at {free.at:.0f} Hz'),
            PaperNumber('smallest K_J, link held', '1', None, None, held.following,
                        f'swings at {held.at:.0f} Hz'),
            PaperNumber('K_J = 0.1 without 1/N, as (17) has it, in units of the scaled K_J', '1',
                        0.1,
                        0.1 * PRINTED.ratio, None, 'beyond the largest: it runs off'))


def _findings(rig: Arm) -> tuple[str, ...]:
    held = limits(rig, held=True)
    low, high = 0.5 * PRINTED.ratio, PRINTED.ratio
    drive, stick = AMPERE, PRINTED.starting_torque
    return (
        'The sign: the gear takes tau/N from the motor; +K_J tau/N gives it back (rejects), '
        '-K_J tau/N takes it once more (follows). So K_J = 1 of the first simulation and -1 two '
        'lines later cannot both follow; -1 does.',
        'The scale: with 1/N, K_J = 0.1 relieves the motor of a tenth of the load. Without it, '
        'as (17) has it, the loop gain is 10 where '
        f'{held.rejecting:.2f} is the most that it bears.',
        'By the printed equations T_fs drives, and a step of 1 A goes on without feedback and '
        f'turns back with K_J = -1 for pushes between {low * (drive + stick):.1f} and '
        f'{high * (drive + stick):.1f} N*m, as in Fig. 7(b), though T_fs has driven it to such a '
        'speed by then that 5 s only stop it. With friction that opposes, no push does both at '
        '1 A (it would have to be below '
        f'{high * (drive - stick):.1f} and above {low * (drive + stick):.1f} N*m); from 2.1 A on '
        'there is one, as at 3 A and 12 N*m.',
        'A tenth of the load is no "much smaller" displacement by itself. Dry friction makes it '
        f'one: it holds {_STICK:.1f} N*m, so between {_STICK:.1f} and {_STICK / 0.9:.2f} N*m '
        'K_J = 0.1 is the difference between an arm that yields and one that stands.')


def _drawing(name: str, caption: str, cases: list[list[Case]], runs: dict[str, bench.BenchRun],
             label: str) -> Drawing:
    row = tuple(Panel(('printed', 'consistent', 'consistent, 3 A')[place], 'time [s]', label,
                      tuple(_trace(case, runs[case.name]) for case in part), shaded=(PUSH,))
                for place, part in enumerate(cases))
    return Drawing(name, caption, (row,))


def _trace(case: Case, made: bench.BenchRun) -> Trace:
    gain = case.settings.torque_feedback
    name = f'K_J = {gain:g}' if gain else 'without feedback'
    return Trace(made.time[::20], made.link_angle[::20, 0], f'{case.name.split(",")[0]}, {name}',
                 case.look)


def _loop(rig: Arm) -> Drawing:
    """Draw the loop at K_J = 1 over frequency, with the link free and held."""
    parts = (('link free', Look.CONSISTENT, loop_response(rig, held=False)),
             ('link held', Look.THIRD, loop_response(rig, held=True)))
    thin = slice(None, None, 40)
    frequency = frequencies()[thin]
    size = Panel('loop at K_J = 1', 'frequency [Hz]', 'gain', tuple(
        Trace(frequency, np.abs(loop[thin]), name, look) for name, look, loop in parts),
        log_x=True, log_y=True, bottom=1e-2)
    phase = Panel('its phase', 'frequency [Hz]', 'phase [deg]', tuple(
        Trace(frequency, np.degrees(np.unwrap(np.angle(loop)))[thin], name, look)
        for name, look, loop in parts), log_x=True)
    return Drawing('loop', 'Motor torque to gear torque and back, with the delay of the samples '
                   'and the motor sliding.', ((size, phase),))

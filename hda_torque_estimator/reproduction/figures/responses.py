"""Fig. 5: what steps and sines of current do to both joints, and how the arm resonates."""

from collections.abc import Callable
from dataclasses import replace
import math

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import DriveOffset
from hda_arm_sim.model.torsion import TorsionLaw
import numpy as np

from ..rig import bench
from ..rig.exhibit import Arms, Drawing, Exhibit, Look, Panel, PaperNumber, Trace
from ..rig.linear import free_resonances, Linear, linearised, locked_resonances
from ..rig.printed import PRINTED

AMPERE = 0.0534                     # torque of one ampere, EC 60 flat [N*m/A]
_SECONDS, _SINE = 4.0, 1.0          # duration [s] and frequency [Hz]
_START = (0.3, 1.2)
_ELBOWS = {'stretched': 0.0, 'at 90 deg': 0.5 * math.pi, 'folded': math.pi}
LINEAR = TorsionLaw(
    flexspline_stiffness=PRINTED.linear_stiffness, flexspline_curvature=0.0,
    wave_generator_stiffness=math.inf, wave_generator_curvature=0.0, damping=0.0,
    valid_torque=1e4)


def printed_plant(arm: Arm) -> Arm:
    """
    Return an arm by (1)-(5) as printed, but for the sign of the gear's torque in (4).

    Linear stiffness, J_m without J_w, and a starting torque that drives: an offset of the drive.
    """
    joints = tuple(replace(joint, torsion=LINEAR, dry_friction=0.0,
                           motor_inertia=PRINTED.motor_inertia) for joint in arm.joints)
    arm = replace(arm, joints=joints)
    for label in arm.labels:
        arm = arm.with_effect(DriveOffset(offset=PRINTED.starting_torque), label)
    return arm


def responses(arms: Arms) -> Exhibit:
    """Return the responses to step and sine, and the frequency response of the linear arm."""
    plants = (('printed', Look.PRINTED, printed_plant(arms.table1)),
              ('consistent', Look.CONSISTENT, arms.two_axis))
    step, sine = (tuple(_moved(plant, wave) for _, _, plant in plants)
                  for wave in (_step, _sine))
    idle = _moved(plants[0][2], lambda time: 0.0 * time)
    linear = [linearised(plant, (0.3, 0.5 * math.pi)) for _, _, plant in plants]
    drawings = (_over_time(step, sine), _frequency(linear))
    return Exhibit((*_time_numbers(step, sine, idle), *_resonances(arms, linear[0])),
                   _findings(idle, sine[0]), drawings,
                   ('The size and the frequency of the sine are not given; the paper names a '
                    'unit step and shows no scale that the text would hold.',
                    'The links of the Simscape model are a CAD file; its inertia is not printed '
                    'but for J_l.'))


def _findings(idle: bench.BenchRun, sine: bench.BenchRun) -> tuple[str, ...]:
    growth = _printed_pole()
    return (
        'With the signs of (3) and (4) as printed the link runs away from the motor: a real pole '
        f'at +{growth:.1f} rad/s, a factor of {math.exp(0.1 * growth):,.0f} within 0.1 s. No '
        'figure of the paper could come from that; below, only this sign is mended.',
        'By (1) the starting torque drives: the arm starts without current and heads for '
        f'{_idle_speed():.0f} rad/s at the shaft. That is how "the sinusoid '
        f'input current increases the positions": {_turned(idle, 0):.1f} of the '
        f'{_turned(sine, 0):.1f} rad after 4 s come without any current. Where friction opposes, '
        'a step still runs on, slower, and a sine swings about where it began.',
        'Damping is not printed: by (1)-(5) every step rings for ever.')


def _printed_pole() -> float:
    return math.sqrt(PRINTED.linear_stiffness / PRINTED.link_inertia)


def _idle_speed() -> float:
    """Return the speed of the shaft to which (1) drives without current [rad/s]."""
    return PRINTED.starting_torque / PRINTED.viscous_friction


def _step(time: Array) -> Array:
    return np.full_like(time, AMPERE)


def _sine(time: Array) -> Array:
    return AMPERE * np.sin(2.0 * np.pi * _SINE * time)


def _moved(plant: Arm, wave: Callable[[Array], Array]) -> bench.BenchRun:
    """Return an arm from rest under the same current in both motors [N*m, shaft]."""
    inputs = bench.quiet(2, _SECONDS)
    inputs.current[:] = wave(inputs.time)[:, None]
    return bench.run(plant, plant, inputs, _START)


def _turned(made: bench.BenchRun, joint: int) -> float:
    """Return how far a link is from its start at the end [rad]."""
    return float(made.link_angle[-1, joint] - made.link_angle[0, joint])


def _over_time(step: tuple[bench.BenchRun, ...], sine: tuple[bench.BenchRun, ...]) -> Drawing:
    """Draw the link angles: after a step, after a sine, and the sine's small motion alone."""
    looks = (('printed', Look.PRINTED), ('consistent', Look.CONSISTENT))
    panels = [_panel(f'step, joint {joint + 1}', step, joint, looks)
              for joint in range(2)]
    both = _panel('sine, joint 1', sine, 0, looks)
    small = _panel('sine, consistent alone', (sine[1], sine[1]), 0, looks[1:])
    second = _panel('', (sine[1],), 1, (('consistent, joint 2', Look.THIRD),))
    return Drawing(
        'time', 'Link angles after a step of 1 A and a sine of 1 A and 1 Hz. By (1) the starting '
        'torque drives both.',
        (tuple(panels), (both, small._replace(traces=small.traces + second.traces))))


def _panel(title: str, runs: tuple[bench.BenchRun, ...], joint: int,
           looks: tuple[tuple[str, Look], ...]) -> Panel:
    return Panel(title, 'time [s]', 'link angle moved [rad]', tuple(
        Trace(made.time[::10], made.link_angle[::10, joint] - made.link_angle[0, joint], name,
              look) for made, (name, look) in zip(runs, looks)))


def _time_numbers(step: tuple[bench.BenchRun, ...], sine: tuple[bench.BenchRun, ...],
                  idle: bench.BenchRun) -> tuple[PaperNumber, ...]:
    """Return how far the links get."""
    return (
        PaperNumber('acceleration of an idle motor by (1)', 'rad/s^2', None,
                    PRINTED.starting_torque / PRINTED.motor_inertia, 0.0, 'gear let go'),
        PaperNumber('speed it heads for', 'rad/s', None, _idle_speed(), 0.0),
        PaperNumber('link angle of joint 1 after 4 s without current', 'rad', None,
                    _turned(idle, 0),
                    0.0),
        *(PaperNumber(f'link angle of joint {joint + 1} after 4 s of {name}', 'rad', None,
                      _turned(runs[0], joint), _turned(runs[1], joint))
          for name, runs in (('a step of 1 A', step), ('a sine of 1 A', sine))
          for joint in range(2)))


def _resonances(arms: Arms, printed: Linear) -> tuple[PaperNumber, ...]:
    """Return the resonances: one joint by Table I, then the coupled arm over its elbow."""
    unstable = PaperNumber('real pole by (3) and (4) as printed', 'rad/s', None, _printed_pole())
    single = linearised(arms.rig, (0.3,))
    found = [unstable,
             PaperNumber('resonance, motor held, one axis', 'Hz', None,
                         float(locked_resonances(printed)[0]), float(locked_resonances(single)[0]),
                         'small torque'),
             PaperNumber('resonance, motor free, one axis', 'Hz', None,
                         float(free_resonances(printed)[0]), float(free_resonances(single)[0]),
                         'small torque')]
    for name, elbow in _ELBOWS.items():
        linear = linearised(arms.two_axis, (0.3, elbow))
        for kind, values in (('held', locked_resonances(linear)),
                             ('free', free_resonances(linear))):
            found += [PaperNumber(f'two axes {name}, motors {kind}, mode {mode}', 'Hz', None, None,
                                  float(value)) for mode, value in enumerate(values, 1)]
    return tuple(found)


def _frequency(linear: list[Linear]) -> Drawing:
    """Draw torque of motor 1 to both angles of joint 1 and to the link of joint 2."""
    frequency = np.geomspace(1.0, 100.0, 800)
    outputs = (('shaft angle of joint 1', 0), ('link angle of joint 1', 2),
               ('link angle of joint 2', 6))
    panels = []
    for title, place in outputs:
        traces = []
        for name, look, each in zip(('printed', 'consistent, elbow at 90 deg'),
                                    (Look.PRINTED, Look.CONSISTENT), linear):
            size = np.abs(each.response(np.eye(8)[place], 0, frequency))
            if size.max() > 1e-9:
                traces.append(Trace(frequency, size, name, look))
        traces += _marks(linear[1]) if place == 0 else []
        panels.append(Panel(title, 'frequency [Hz]', 'angle per torque [rad/(N·m)]',
                            tuple(traces), log_x=True, log_y=True))
    return Drawing('frequency', 'Torque of motor 1 to the angles, near zero torque. Zeros of the '
                   'shaft are the resonances with motors held, peaks those with motors free. By '
                   '(4) and (5) joint 2 does not feel joint 1 at all.', (tuple(panels),))


def _marks(linear: Linear) -> list[Trace]:
    """Return lines at the resonances of an arm, motors held and motors free."""
    return [Trace(np.full(2, frequency), np.array([1e-2, 1e2]), name, look)
            for name, look, found in (('motors held', Look.MARK, locked_resonances(linear)),
                                      ('motors free', Look.PLAIN, free_resonances(linear)))
            for frequency in found]

"""Fig. 6: link-side torque, real and estimated, with printed and with consistent equations."""

from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.torsion import torsion_of_torque
import numpy as np

from .responses import AMPERE, printed_plant
from ..rig import bench
from ..rig.exhibit import Arms, Drawing, Exhibit, Look, Panel, PaperNumber, Trace
from ..rig.printed import estimated_torque, flexspline_torque, PRINTED
from ..rig.shapes import sine, step
from ...controlling.controller import ControllerSettings

_SECONDS, _SIZE = 4.0, 8.0          # [s], [N*m]
_START = (0.3, 1.2)
_LEVELS = (2.0, 5.0, 8.0, 12.0, 15.0, 20.0)
_AGREES = 0.05                      # relative error up to which two curves look alike


class _Pair(NamedTuple):
    """A torque through a gear and its estimate over time, (k, n) [N*m]."""

    time: Array
    true: Array
    estimated: Array


def torque_check(arms: Arms) -> Exhibit:
    """Return real against estimated torque for a step and a sine, and the error over torque."""
    shapes = {'step': lambda time: step(time, 1.0, 3.0, 0.2),
              'sine': lambda time: sine(time, 0.5, 0.5)}
    pairs = {(name, kind): pair for name, shape in shapes.items()
             for kind, pair in (('printed', _printed(arms, _SIZE * shape(_time()))),
                                ('consistent', _consistent(arms, _SIZE * shape(_time()))))}
    agreed = float(np.interp(_AGREES, _relative(np.linspace(0.1, 12.0, 2000)),
                             np.linspace(0.1, 12.0, 2000)))
    findings = (
        'The printed plant is linear (K_f), the printed estimator bends (tangent law with K_f0). '
        f'They agree within {100.0 * _AGREES:.0f} % up to {agreed:.1f} N*m, so the "close '
        'agreement" of Fig. 6 shows that its torques are small, or that plant and estimator are '
        'not those of the text. At 12 N*m the estimate is half as large again, at 19.4 N*m it '
        'changes its sign.',
        'A step of 1 A, the input of Fig. 5, loads the gear with a mean of '
        f'{_of_one_ampere():.2f} N*m by (1): there nothing of this can be seen.',
        'With one law for arm and estimator the error is the counts of the encoders.',
        'If (13) is fed with tau_w of the sign that (1) gives it, the compliance of the wave '
        'generator is taken off twice in the wrong direction.')
    return Exhibit((*_errors(pairs), *_levels(), *_doubled(arms)), findings,
                   (_over_time(pairs), _over_torque(arms)),
                   ('The size of the torques in Fig. 6: its axes are not in the text.',))


def _time() -> Array:
    return bench.quiet(2, _SECONDS).time


def _loaded(plant: Arm, load: Array) -> bench.BenchRun:
    """Run an arm that is held by its controller under a load on both joints (k,) [N*m]."""
    inputs = bench.quiet(2, _SECONDS)
    inputs.load[:] = -load[:, None]
    return bench.run(plant, plant, inputs, _START, controller=ControllerSettings())


def _printed(arms: Arms, load: Array) -> _Pair:
    """Return the linear plant with the estimator (13), its wave generator without wind-up."""
    plant = printed_plant(arms.table1)
    for label in plant.labels:
        plant = plant.without('drive_offset', label)
    made = _loaded(plant, load)
    return _Pair(made.time, made.joint_torque, flexspline_torque(made.torsion))


def _consistent(arms: Arms, load: Array) -> _Pair:
    made = _loaded(arms.two_axis, load)
    return _Pair(made.time, made.joint_torque, made.torque)


def _relative(torque: Array) -> Array:
    """Return the relative error of (B.2) on a linear flexspline."""
    return flexspline_torque(torque / PRINTED.linear_stiffness) / torque - 1.0


def _of_one_ampere() -> float:
    """Return the mean torque in the gear while a motor with 1 A and T_fs speeds up [N*m]."""
    drive = PRINTED.ratio * (AMPERE + PRINTED.starting_torque)
    motor = PRINTED.ratio ** 2 * PRINTED.motor_inertia
    return drive * PRINTED.link_inertia / (PRINTED.link_inertia + motor)


def _errors(pairs: dict[tuple[str, str], _Pair]) -> tuple[PaperNumber, ...]:
    """Return mean and largest error of every curve."""
    found: list[PaperNumber] = []
    for joint in range(2):
        for shape in ('step', 'sine'):
            printed, consistent = (
                np.abs(pairs[shape, kind].estimated - pairs[shape, kind].true)[:, joint]
                for kind in ('printed', 'consistent'))
            where = f'error, arm {joint + 1}, {shape} of {_SIZE:g} N*m'
            found += [PaperNumber(f'mean {where}', 'N*m', None, float(printed.mean()),
                                  float(consistent.mean())),
                      PaperNumber(f'largest {where}', 'N*m', None, float(printed.max()),
                                  float(consistent.max()))]
    return tuple(found)


def _levels() -> tuple[PaperNumber, ...]:
    """Return what the printed estimator says of constant torques in the linear plant."""
    return tuple(PaperNumber(f'estimate of {level:g} N*m', 'N*m', None,
                             float(flexspline_torque(level / PRINTED.linear_stiffness)), level)
                 for level in _LEVELS)


def _doubled(arms: Arms) -> tuple[PaperNumber, ...]:
    """Return what (13) says of the consistent arm when tau_w has the sign of (1)."""
    joint = arms.two_axis.joints[0]
    law = joint.torsion.record(joint.ratio)
    return tuple(PaperNumber(f'(13) with tau_w = +tau/N at {level:g} N*m', 'N*m', None,
                             float(estimated_torque(torsion_of_torque(law, joint.ratio, level),
                                                    level / joint.ratio)), level,
                             'on the consistent arm') for level in (5.0, 12.0))


def _over_time(pairs: dict[tuple[str, str], _Pair]) -> Drawing:
    rows = []
    for joint in range(2):
        row = []
        for shape in ('step', 'sine'):
            printed, consistent = pairs[shape, 'printed'], pairs[shape, 'consistent']
            row.append(Panel(f'arm {joint + 1}, {shape}', 'time [s]', 'joint torque [N·m]', (
                Trace(consistent.time[::5], consistent.true[::5, joint], 'real', Look.TRUTH),
                Trace(printed.time[::5], printed.estimated[::5, joint], 'estimated, printed',
                      Look.PRINTED),
                Trace(consistent.time[::5], consistent.estimated[::5, joint],
                      'estimated, consistent', Look.CONSISTENT))))
        rows.append(tuple(row))
    return Drawing('time', f'{_SIZE:g} N·m at both joints with the motors held. The '
                   'printed estimator overshoots where the torque is large (and shows the '
                   '4096 counts that are assumed for it); the consistent one lies on the truth.',
                   tuple(rows))


def _over_torque(arms: Arms) -> Drawing:
    torque = np.linspace(0.0, 19.0, 300)
    doubled = np.linspace(0.0, 12.0, 200)
    joint = arms.two_axis.joints[0]
    torsion = torsion_of_torque(joint.torsion.record(joint.ratio), joint.ratio, doubled)
    return Drawing('levels', 'What the estimators say of a constant torque. Printed: the tangent '
                   'law on a linear flexspline. Worse, with tau_w of the sign of (1) on the '
                   'consistent arm.', ((Panel(
                       'estimate over torque', 'torque [N·m]', 'estimate [N·m]', (
                           Trace(torque, flexspline_torque(torque / PRINTED.linear_stiffness),
                                 'tangent law on a linear flexspline', Look.PRINTED),
                           Trace(doubled, estimated_torque(torsion, doubled / joint.ratio),
                                 'tau_w with the sign of (1)', Look.FOURTH),
                           Trace(torque, torque, 'one law, consistent', Look.CONSISTENT)),
                       bottom=0.0, top=40.0),),))

"""The motor's viscous friction by (A.1), and what it leaves out."""

import math

import numpy as np

from ..rig.exhibit import Arms, Drawing, Exhibit, Look, Panel, PaperNumber, Trace
from ..rig.printed import PRINTED, viscous_friction

# EC 60 flat, 100 W, 24 V: torque constant [N*m/A] and no-load speed [1/min] of two windings.
_CURRENT = 0.497                    # without load [A]
_WINDINGS = (('torque constant 53.4 mN*m/A, 4250 1/min', 0.0534, 4250.0),
             ('torque constant 52.5 mN*m/A, 4300 1/min', 0.0525, 4300.0))
_SLOW = 10.0                        # [rad/s, shaft]


def motor_friction(arms: Arms) -> Exhibit:
    """Return r_m from the motor's sheet, and how far it is off at small speed."""
    slopes = [viscous_friction(constant, _CURRENT, speed) for _, constant, speed in _WINDINGS]
    idle = _WINDINGS[0][1] * _CURRENT
    numbers = (
        *(PaperNumber(f'r_m, {name}', 'N*m*s/rad', None, slope)
          for (name, _, _), slope in zip(_WINDINGS, slopes)),
        PaperNumber('r_m of the arm files', 'N*m*s/rad', None, None,
                    arms.table1.joints[0].viscous_friction),
        PaperNumber('no-load torque of the motor, at the joint', 'N*m', None,
                    PRINTED.ratio * idle),
        PaperNumber('starting torque T_fs, at the joint', 'N*m', None,
                    PRINTED.ratio * PRINTED.starting_torque),
        PaperNumber('share of the no-load torque that (A.1) knows at 10 rad/s', '%', None,
                    100.0 * slopes[0] * _SLOW / idle, None, 'if that torque is all dry'))
    return Exhibit(numbers, (
        'The text swaps its references: by their units, r_m [N*m*s/rad] is (A.1), the torsion of '
        'the wave generator [rad] is (B.1) and the torque of the flexspline [N*m] is (B.2).',
        '(A.1) books the whole no-load torque as viscous. Where it is dry friction of bearings '
        'and iron, the motor at 10 rad/s is opposed by up to '
        f'{idle / (slopes[0] * _SLOW):.0f} times what (A.1) says. A torque taken from the motor '
        'current is off by that; one taken from the torsion does not notice.',
        "T_fs is that of the gear, so the motor's own no-load torque comes on top of it."),
        (_lines(slopes[0], idle),),
        ('Which winding the paper used is not said; both of the usual ones are given.',))


def _lines(slope: float, idle: float) -> Drawing:
    speed = np.linspace(0.0, 4250.0 * math.pi / 30.0, 100)
    viscous = Trace(speed, 1e3 * slope * speed, '(A.1): all viscous', Look.PRINTED)
    dry = Trace(speed, np.full_like(speed, 1e3 * idle), 'all dry', Look.CONSISTENT)
    half = Trace(speed, 0.5e3 * (idle + slope * speed), 'half and half', Look.THIRD)
    start = Trace(speed, np.full_like(speed, 1e3 * PRINTED.starting_torque),
                  'starting torque of the gear', Look.MARK)
    return Drawing('friction', 'One point of the data sheet, the no-load current, fits any split '
                   'between dry and viscous friction. The lines meet at the no-load speed only.',
                   ((Panel('friction of the motor', 'speed of the shaft [rad/s]',
                           'torque at the shaft [mN·m]', (viscous, dry, half, start),
                           bottom=0.0),),))

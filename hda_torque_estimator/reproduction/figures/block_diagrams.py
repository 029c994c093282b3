"""
Fig. 2 and 3: block diagrams whose arrows are the derivatives of the compiled model.

No arrow is drawn by hand. An arrow is there where the kernel, the estimator or the controller
changes one signal with another, and it carries by how much.
"""

import math

from hda_arm_sim.model.arm import Arm
import numpy as np

from .responses import printed_plant
from ..rig.bench import stamps, STEP
from ..rig.exhibit import Arms, Diagram, DiagramBlock, Drawing, Exhibit, PaperNumber, Wire
from ..rig.linear import Linear, linearised
from ..rig.printed import PRINTED
from ...controlling.controller import Controller, ControllerSettings
from ...controlling.reference import Reference
from ...estimating.estimator import Estimator
from ...estimating.laws.layout import TORQUE
from ...samples.readings import LINK_READING, MOTOR_READING, READINGS

_ELBOW = 0.5 * math.pi
_SETTLING = 3000                    # samples, in which the controller has taken over
_NOTHING = 1e-9                     # of the largest gain of its kind


def arm_diagram(arms: Arms) -> Exhibit:
    """Return the arm as a block diagram, by the printed equations and by the kernel."""
    printed = linearised(printed_plant(arms.table1), (0.3, _ELBOW))
    consistent = linearised(arms.two_axis, (0.3, _ELBOW))
    m11, m12, m22 = (_link_gain(consistent, i, j) for i, j in ((0, 0), (0, 1), (1, 1)))
    numbers = (
        PaperNumber('link 1 from gear torque 1', '1/(kg*m^2)', 1.0 / PRINTED.link_inertia,
                    _link_gain(printed, 0, 0), m11, 'elbow at 90 deg'),
        PaperNumber('link 2 from gear torque 2', '1/(kg*m^2)', 1.0 / PRINTED.link_inertia,
                    _link_gain(printed, 1, 1), m22, 'elbow at 90 deg'),
        PaperNumber('link 1 from gear torque 2', '1/(kg*m^2)', 0.0, _link_gain(printed, 0, 1), m12,
                    'the coupling that (4) and (5) leave out'),
        PaperNumber('shaft from gear torque', '1/(kg*m^2)', None, _load(printed, 0),
                    _load(consistent, 0), '-1/(N J)'))
    return Exhibit(numbers, (
        'The arrows are derivatives of the compiled equation of motion at an elbow of 90 deg. By '
        'the printed equations each joint stands alone; in the arm each gear drives both links, '
        f'and gear 2 moves link 1 by {100.0 * abs(m12 / m11):.0f} % of what gear 1 does, the '
        'other way round.',
        'The printed diagram has no friction arrow but r_m, and no damping.'),
        (Drawing('arm', 'Above by (1)-(5), signs of (3) and (4) mended; below the kernel. Units '
                 'are SI; joint 1 is the upper row of each.',
                 ((_arm('printed', printed),), (_arm('consistent', consistent),))),))


def _link_gain(linear: Linear, link: int, gear: int) -> float:
    """Return the acceleration of a link per torque in a gear [1/(kg*m^2)]."""
    shaft = 4 * gear
    return float(linear.matrix[4 * link + 3, shaft] / linear.gear[gear, shaft])


def _load(linear: Linear, joint: int) -> float:
    """Return the acceleration of a shaft per torque in its gear [1/(kg*m^2)]."""
    link = 4 * joint + 2
    return float(linear.matrix[4 * joint + 1, link] / linear.gear[joint, link])


def _drag(linear: Linear, joint: int) -> float:
    """Return the drag of a shaft per speed, without what the gear does [N*m*s/rad]."""
    speed = 4 * joint + 1
    slowing = linear.matrix[speed, speed] - _load(linear, joint) * linear.gear[joint, speed]
    return float(slowing / linear.motor[speed, joint])


def _arm(title: str, linear: Linear) -> Diagram:
    """Return the diagram of a linear arm, a row for each joint."""
    blocks, wires = [], []
    for j in range(linear.joints):
        row, y = f'{j + 1}', 2.2 * j
        names = ('motor\ntorque', 'shaft\nspeed', 'shaft\nangle', 'gear\ntorque', 'link\nspeed',
                 'link\nangle')
        blocks += [DiagramBlock(f'{name}{row}', f'{name} {row}', 1.6 * x, y)
                   for x, name in enumerate(names)]
        s = 4 * j
        wires += [
            Wire(f'{names[0]}{row}', f'{names[1]}{row}',
                 _gain_label(linear.motor[s + 1, j]) + '/s'),
            Wire(f'{names[1]}{row}', f'{names[2]}{row}', '1/s'),
            Wire(f'{names[2]}{row}', f'{names[3]}{row}', _gain_label(linear.gear[j, s])),
            Wire(f'{names[4]}{row}', f'{names[5]}{row}', '1/s'),
            Wire(f'{names[3]}{row}', f'{names[1]}{row}', _gain_label(_load(linear, j)) + '/s',
                 0.35),
            Wire(f'{names[5]}{row}', f'{names[3]}{row}', _gain_label(linear.gear[j, s + 2]), 0.35),
            Wire(f'{names[1]}{row}', f'{names[0]}{row}', _gain_label(_drag(linear, j)), 0.6)]
        wires += [Wire(f'{names[3]}{j + 1}', f'{names[4]}{i + 1}',
                       _gain_label(_link_gain(linear, i, j)) + '/s')
                  for i in range(linear.joints)
                  if abs(_link_gain(linear, i, j)) > _NOTHING]
        damping = linear.gear[j, s + 3]
        if damping:
            wires.append(Wire(f'{names[4]}{row}', f'{names[3]}{row}', _gain_label(damping), -0.5))
    return Diagram(title, tuple(blocks), tuple(wires))


def _gain_label(gain: float) -> str:
    return f'{gain:.0f}' if abs(gain) >= 1000.0 else f'{gain:.3g}'


def control_diagram(arms: Arms) -> Exhibit:
    """Return the control loop as a block diagram, its gains measured from its functions."""
    paper = ControllerSettings(position_gain=0.003, velocity_gain=0.01, torque_feedback=0.1)
    gains, slope = _law(arms.rig, paper), _stiffness(arms.rig)
    blocks = (DiagramBlock('target', 'target of\nthe link', 0.0, 0.0),
              DiagramBlock('law', 'PD law', 1.8, 0.0),
              DiagramBlock('sum', 'motor\ntorque', 3.5, 0.0),
              DiagramBlock('arm', 'arm, Fig. 2', 5.2, 0.0),
              DiagramBlock('shaft', 'shaft\nangle', 7.0, 0.0),
              DiagramBlock('link', 'link\nangle', 7.0, 1.3),
              DiagramBlock('estimate', 'estimated\ntorque', 4.4, 1.3))
    wires = (Wire('target', 'law', f'{gains["target"]:.3g} + {gains["rate"]:.3g} s'),
             Wire('law', 'sum', '1'), Wire('sum', 'arm', ''), Wire('arm', 'shaft', ''),
             Wire('arm', 'link', ''), Wire('shaft', 'law', f'{gains["shaft"]:.3g}', 0.2),
             Wire('shaft', 'estimate', _gain_label(slope[0])),
             Wire('link', 'estimate', _gain_label(slope[1])),
             Wire('estimate', 'sum', f'{gains["torque"]:.3g} = K_J/N'))
    numbers = (
        PaperNumber('K_P at the shaft', 'N*m/rad', 0.003, None, -gains['shaft'],
                    'unit not printed'),
        PaperNumber('K_D at the shaft', 'N*m*s/rad', 0.01, None, gains['rate'] / PRINTED.ratio),
        PaperNumber('feedback of the estimated torque, K_J = 0.1', 'N*m/(N*m)', 0.1, None,
                    gains['torque'], 'K_J/N; by (17) it would be K_J'),
        PaperNumber('(17) as an equation at K_J = 1', 'N*m/(N*m)', None, math.inf, None,
                    'K_J/(1 - K_J): an algebraic loop'))
    return Exhibit(numbers, (
        'The law of the controller is (16) with the estimated torque on top, '
        'K_P (N q_d - theta_m) + K_D (N dq_d - dtheta_m) + (K_J/N) tau. (17) gives one symbol to '
        'the torque fed back and to the torque of the flexspline; as an equation it is an '
        'algebraic loop that has no solution at K_J = 1, the value that the paper sets.',
        'A motor that carries tau/N is relieved by +K_J and loaded by -K_J: following needs a '
        'negative K_J, rejecting one between 0 and 1.'),
        (Drawing('loop', "The loop with the paper's gains; every number on an arrow is measured "
                 'from the compiled controller and estimator.',
                 ((Diagram('joint torque feedback', blocks, wires),),)),))


def _law(arm: Arm, settings: ControllerSettings) -> dict[str, float]:
    """Return the gains of the settled controller from all that it hears."""
    def settled(target: float, rate: float, shaft: float, torque: float) -> float:
        law = Controller(arm, settings)
        law.enable()
        end = STEP * _SETTLING
        law.follow(Reference(np.array([0.0, 2.0 * end]), np.array(
            [[target - rate * end], [target + rate * end]]), np.full((2, 1), rate)), 0)
        for stamp in stamps(_SETTLING).tolist():
            command = law.update(stamp, np.array([shaft]), np.array([torque]))
        return float(command[0])

    size = 1e-4
    return {name: (settled(*(size * unit)) - settled(*(-size * unit))) / (2.0 * size)
            for name, unit in zip(('target', 'rate', 'shaft', 'torque'), np.eye(4))}


def _stiffness(arm: Arm) -> tuple[float, float]:
    """Return how the estimated torque changes with shaft and link angle [N*m/rad]."""
    def estimated(shaft: float, link: float) -> float:
        reading = np.full((1, READINGS), np.nan)
        reading[0, MOTOR_READING], reading[0, LINK_READING] = shaft, link
        estimator = Estimator(arm)
        estimator.update(1, reading)
        return float(estimator.joints[0, TORQUE])

    return ((estimated(1e-4, 0.0) - estimated(-1e-4, 0.0)) / 2e-4,
            (estimated(0.0, 1e-6) - estimated(0.0, -1e-6)) / 2e-6)

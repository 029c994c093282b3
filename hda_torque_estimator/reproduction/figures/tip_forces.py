"""Equations (14) and (15): the tip force from two joint torques, over the workspace."""

from typing import Any, NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.rigid import tool_jacobian
import numpy as np

from ..rig.exhibit import Arms, Drawing, Exhibit, Look, Map, Panel, PaperNumber, Trace
from ..rig.printed import force_direction, PRINTED, tip_force as printed_force
from ...estimating.laws.tip_force import Posture, tool_force

_FORCE = 20.0                       # on the tip [N]
_SMALLEST_SINE = 1e-6               # of the elbow at which the axial force is still asked for
_EXAMPLE = (1.2, np.radians(30.67))     # elbow and direction of the force in the tool frame [rad]
_ELBOWS = (90.0, 30.0, 10.0, 1.0)       # [deg]


class _TipForce(NamedTuple):
    """A tip force in the tool frame [N] and its direction from link 2 [rad]."""

    axial: float
    across: float
    direction: float


def tip_forces(arms: Arms) -> Exhibit:
    """Return printed and corrected tip forces, their errors over the workspace, and the noise."""
    elbows, directions = np.radians(np.linspace(3.0, 177.0, 88)), np.radians(
        np.linspace(-178.0, 178.0, 90))
    size, turned = _error_maps(elbows, directions)
    links = arms.two_axis.record().body['links']
    corrected = _corrected_error(links, elbows[::8], directions[::9])
    printed, consistent = _printed(*_EXAMPLE), _consistent(links, *_EXAMPLE)
    numbers = (
        PaperNumber('direction of the example, elbow at 69 deg', 'deg', None,
                    np.degrees(printed.direction).item(), np.degrees(consistent.direction).item(),
                    'true: 30.67 deg from link 2'),
        PaperNumber('the same by (15) with 1 + cos', 'deg', None, float(np.degrees(
            _half_corrected(*_EXAMPLE))), None, 'the quadrant is lost: arctan, not atan2'),
        PaperNumber('size of the example', 'N', None,
                    float(np.hypot(printed.axial, printed.across)),
                    float(np.hypot(consistent.axial, consistent.across)), 'true: 20 N'),
        PaperNumber('median error of the size over the workspace', '%', None,
                    100.0 * float(np.median(size)), 100.0 * corrected),
        PaperNumber('share of the workspace with an error above 100 %', '%', None,
                    100.0 * float(np.mean(size > 1.0)), 0.0),
        PaperNumber('median error of the direction over the workspace', 'deg', None,
                    float(np.degrees(np.median(turned)))),
        *(PaperNumber(f'noise of the axial force, elbow at {elbow:g} deg', 'N/(N*m)', None, None,
                      _noise(links, np.radians(elbow)), 'deviation per deviation of a torque')
          for elbow in _ELBOWS))
    return Exhibit(numbers, (
        '(14b) adds 1 to a length: equal links give 1 + cos(theta_2). It also lost its '
        '1/sin(theta_2), which (15) still has, so (14b) is the misprint. Its "x" is across link '
        '2, its "y" against the direction of link 2.',
        '(15) with arctan knows no quadrant; atan2 does, with the sign of sin(theta_2).',
        'Neither says that the axial force cannot be observed where the arm is stretched or '
        'folded. The estimator gives its deviation, and no number where |sin(theta_2)| < 0.1.'),
        (_maps(elbows, directions, size, turned), _noise_curve(links)))


def _torques(elbow: Array | float, direction: Array | float) -> tuple[Array, Array]:
    """Return the joint torques of the force at a direction in the tool frame [N*m]."""
    length = PRINTED.link_length
    j11, _, j21, j22 = tool_jacobian(length, length, np.asarray(elbow, float))
    axial, across = _FORCE * np.cos(direction), _FORCE * np.sin(direction)
    return np.asarray(j11 * axial + j21 * across), np.asarray(j22 * across)


def _printed(elbow: float, direction: float) -> _TipForce:
    """Return (14) and (15); its y is against link 2."""
    torques = _torques(elbow, direction)
    across, against = printed_force(*torques, np.asarray(elbow))
    return _TipForce(-float(against), float(across),
                     float(force_direction(*torques, np.asarray(elbow))))


def _half_corrected(elbow: float, direction: float) -> float:
    """Return (15) with 1 + cos(theta_2), but with arctan and its sign as printed [rad]."""
    first, second = _torques(elbow, direction)
    return float(np.arctan(second * np.sin(elbow) / (second * (1.0 + np.cos(elbow)) - first)))


def _consistent(links: Any, elbow: float, direction: float) -> _TipForce:
    """Return what the estimator makes of the torques."""
    force, _ = _solved(links, elbow, np.array(_torques(elbow, direction)))
    return _TipForce(float(force[0]), float(force[1]), float(np.arctan2(force[1], force[0])))


def _solved(links: Any, elbow: float, torque: Array) -> tuple[Array, Array]:
    """Return the estimator's tip force and its covariance for torques of unit deviation."""
    force, covariance = np.zeros(2), np.zeros((2, 2))
    tool_force(Posture(links, 2, elbow, _SMALLEST_SINE), torque, np.ones(2), force, covariance)
    return force, covariance


def _error_maps(elbows: Array, directions: Array) -> tuple[Array, Array]:
    """Return relative error of the size, and error of the direction [rad], by direction, elbow."""
    elbow, direction = np.meshgrid(elbows, directions)
    torques = _torques(elbow, direction)
    across, against = printed_force(*torques, elbow)
    missed = np.hypot(-against - _FORCE * np.cos(direction), across - _FORCE * np.sin(direction))
    turned = force_direction(*torques, elbow) - direction
    return missed / _FORCE, np.abs(np.angle(np.exp(1j * turned)))


def _corrected_error(links: Any, elbows: Array, directions: Array) -> float:
    """Return the largest relative error of the estimator's tip force over the workspace."""
    errors = []
    for elbow in elbows.tolist():
        for direction in directions.tolist():
            found = _consistent(links, elbow, direction)
            errors.append(np.hypot(found.axial - _FORCE * np.cos(direction),
                                   found.across - _FORCE * np.sin(direction)) / _FORCE)
    return float(max(errors))


def _noise(links: Any, elbow: float) -> float:
    """Return the deviation of the axial force per deviation of both torques [N/(N*m)]."""
    return float(np.sqrt(_solved(links, elbow, np.zeros(2))[1][0, 0]))


def _maps(elbows: Array, directions: Array, size: Array, turned: Array) -> Drawing:
    axes = ('elbow [deg]', 'direction of the force from link 2 [deg]')
    x, y = np.degrees(elbows), np.degrees(directions)
    return Drawing('map', 'Errors of (14) and (15) as printed, for any elbow and any direction of '
                   'the force. The corrected equations have none.', ((
                       Map('(14): error of the force', *axes, 'error [%]', x, y, 100.0 * size,
                           150.0),
                       Map('(15): error of the direction', *axes, 'error [deg]', x, y,
                           np.degrees(turned), 180.0)),))


def _noise_curve(links: Any) -> Drawing:
    elbow = np.radians(np.linspace(1.0, 179.0, 179))
    noise = np.array([_noise(links, each) for each in elbow.tolist()])
    across = np.full_like(noise, 1.0 / PRINTED.link_length)
    return Drawing('noise', 'How the deviation of the joint torques becomes that of the force: '
                   'the axial component is lost where the arm is stretched or folded.', ((Panel(
                       'noise of the tip force', 'elbow [deg]', 'deviation [N/(N·m)]', (
                           Trace(np.degrees(elbow), noise, 'axial', Look.CONSISTENT),
                           Trace(np.degrees(elbow), across, 'across', Look.THIRD)),
                       log_y=True),),))

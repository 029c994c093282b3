"""Each hidden torque or torsion is, over a whole recording, what its row of the table says."""

from collections.abc import Callable
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
import numpy as np
from numpy.typing import NDArray
import pytest
from truth import Hidden, layout, TruthRecord
from truth.torsion import torsion
from truth_cases import DT, exact, hide, times

TAU, MASS_MOMENTS = 2.0 * np.pi, (2.925, 1.2)


class Seen(NamedTuple):
    """A recording by what the equations name (k, 2), time and the mean command at a sample."""

    t: Array
    theta: Array
    v: Array
    q: Array
    dq: Array
    ddq: Array
    tau: Array
    before: Array               # command until the sample
    after: Array                # command from the sample on


def looked_at(seen: TruthRecord) -> Seen:
    """Return a recording by the names of the equations."""
    theta, v, q, dq = np.moveaxis(seen.states, 2, 0)
    return Seen(times(seen), theta, v, q, dq, np.gradient(dq, DT, axis=0), seen.joint_torque,
                np.roll(seen.command, 1, axis=0), seen.command)


def rigid(s: Seen, p1: float, p2: float, p3: float) -> Array:
    """Return the joint torques (k, 2) that links of this inertia need [N*m]."""
    c, sine = p3 * np.cos(s.q[:, 1]), p3 * np.sin(s.q[:, 1])
    return np.stack([
        (p1 + 2.0 * c) * s.ddq[:, 0] + (p2 + c) * s.ddq[:, 1]
        - sine * (2.0 * s.dq[:, 0] * s.dq[:, 1] + s.dq[:, 1] ** 2),
        (p2 + c) * s.ddq[:, 0] + p2 * s.ddq[:, 1] + sine * s.dq[:, 0] ** 2], axis=1)


def motor_balance(s: Seen) -> Array:
    """Return what the nominal motor lacks (k, 2) [N*m]; acceleration feels both commands."""
    return (0.5 * (s.before + s.after) - 1.289e-4 * np.gradient(s.v, DT, axis=0)
            - 5.96e-5 * s.v - 0.037 * np.sign(s.v) - s.tau / 100.0)


def link_balance(s: Seen) -> Array:
    """Return what the nominal links lack (k, 2) [N*m]."""
    return s.tau - rigid(s, 0.876, 0.25, 0.18)


def elastic(s: Seen) -> Array:
    """Return what the spring bears (k, 2) where the damping is nominal [N*m]."""
    return s.tau - 8.0 * (s.v / 100.0 - s.dq)


def compliance(torque: Array) -> Array:
    """Return the nominal torsion at a torque [rad]."""
    return torsion(layout.nominal_joints()[0], torque)


def torsion_balance(s: Seen) -> Array:
    """Return the nominal torsion at the torque less the one seen (k, 2) [rad]."""
    return compliance(elastic(s)) - (s.theta / 100.0 - s.q)


def wavy(s: Seen, order: int, size: float, phase: float) -> Array:
    """Return a transmission error (k, 2), and what its rate adds by way of the damping [rad]."""
    angle = order * s.theta + phase
    return size * (np.sin(angle) + order * s.v * np.cos(angle) * 8.0 / 8000.0)


def gravity(s: Seen, tilt: float, direction: float) -> Array:
    """Return the torques (k, 2) that hold the arm against the slope, joint 1 first [N*m]."""
    a1, a2 = s.q[:, 0] - direction, s.q.sum(axis=1) - direction
    pull = 9.81 * np.sin(tilt)
    second = pull * MASS_MOMENTS[1] * np.sin(a2)
    return np.stack([pull * MASS_MOMENTS[0] * np.sin(a1) + second, second], axis=1)


def loaded(s: Seen, ml2: float, gain: float = 1.0) -> Array:
    """Return the torques that a point mass at the tip, of inertia ml2 about the elbow, takes."""
    return gain * rigid(s, 2.0 * ml2, ml2, ml2)


def clipped(command: Array, limit: float) -> Array:
    """Return what a limit takes of a command."""
    return command - np.clip(command, -limit, limit)


Case = tuple[Hidden, int, Callable[[Seen], Array]]

MOTOR: list[Case] = [
    (hide('coulomb_friction', level=0.02), 0, lambda s: 0.02 * np.sign(s.v)),
    (hide('coulomb_friction', 'joint2', level=-0.015), 1, lambda s: -0.015 * np.sign(s.v)),
    (hide('viscous_friction', slope=3e-4), 0, lambda s: 3e-4 * s.v),
    (hide('nonlinear_viscous_friction', coefficient=4e-3, exponent=0.5), 0,
     lambda s: 4e-3 * np.sqrt(np.abs(s.v)) * np.sign(s.v)),
    (hide('stribeck_friction', excess=0.03, speed=25.0), 0,
     lambda s: 0.03 * np.exp(-(s.v / 25.0) ** 2) * np.sign(s.v)),
    (hide('asymmetric_friction', asymmetry=0.3), 0, lambda s: np.full_like(s.v, 0.3 * 0.037)),
    (hide('load_dependent_friction', coefficient=0.25), 0,
     lambda s: 0.25 * np.abs(s.tau) / 100.0 * np.sign(s.v)),
    (hide('position_dependent_friction', amplitude=0.5, order=3.0, phase=0.4), 0,
     lambda s: 0.5 * 0.037 * np.sin(3.0 * s.q + 0.4) * np.sign(s.v)),
    (hide('crossed_friction', amplitude=0.5, order=3.0, phase=0.4), 0,
     lambda s: 0.5 * 0.037 * np.sin(3.0 * s.q[:, ::-1] + 0.4) * np.sign(s.v)),
    (hide('torque_ripple', amplitude_2=0.01, phase_2=0.5, amplitude_4=0.01, phase_4=-1.0), 0,
     lambda s: -0.01 * (np.sin(2.0 * s.theta + 0.5) + np.sin(4.0 * s.theta - 1.0))),
    (hide('motor_cogging', amplitude=0.01, order=7.0, phase=0.5), 0,
     lambda s: -0.01 * np.sin(7.0 * s.theta + 0.5)),
    (hide('motor_torque_line', amplitude=0.01, frequency=5.0, phase=0.7), 0,
     lambda s: -0.01 * np.sin(TAU * 5.0 * s.t + 0.7)[:, None] * [1.0, 1.0]),
    (hide('torque_constant_error', relative_error=0.1), 0,
     lambda s: -0.05 * (s.before + s.after)),
    (hide('drive_offset', 'joint2', offset=0.01), 1, lambda s: np.full_like(s.v, -0.01)),
    (hide('torque_saturation', limit=0.07), 0,
     lambda s: 0.5 * (clipped(s.before, 0.07) + clipped(s.after, 0.07))),
    (hide('command_delay', delay=0.003), 0, lambda s: 0.5 * (
        s.before + s.after - np.roll(s.before + s.after, 3, axis=0))),
    (hide('motor_inertia_error', relative_error=0.2), 0,
     lambda s: 0.2 * 1.289e-4 * np.gradient(s.v, DT, axis=0)),
]
LINK: list[Case] = [
    (hide('link_bearing_friction', level=1.0), 0, lambda s: np.sign(s.dq)),
    (hide('cable_spring', stiffness=1.2, rest_angle=0.5), 0, lambda s: 1.2 * (s.q - 0.5)),
    (hide('cubic_spring', coefficient=20.0, centre=0.1), 0, lambda s: 20.0 * (s.q - 0.1) ** 3),
    (hide('tooth_torque', 'joint2', amplitude=1.0, order=8.0, phase=0.2), 1,
     lambda s: -np.sin(8.0 * s.q + 0.2)),
    (hide('link_torque_line', 'joint2', amplitude=1.0, frequency=3.0, phase=0.7), 1,
     lambda s: -np.sin(TAU * 3.0 * s.t + 0.7)[:, None] * [1.0, 1.0]),
    (hide('payload', None, mass=3.0), 0, lambda s: loaded(s, 3.0 * 0.15 ** 2)),
    (hide('payload', None, mass=3.0), 1, lambda s: loaded(s, 3.0 * 0.15 ** 2)),
    (hide('link_inertia_error', relative_error=0.2), 0,
     lambda s: 0.2 * rigid(s, 0.876, 0.0, 0.0)),
    (hide('link_inertia_error', 'joint2', relative_error=0.2), 0,
     lambda s: 0.2 * rigid(s, 0.25, 0.25, 0.0)),
    (hide('link_inertia_error', 'joint2', relative_error=0.2), 1,
     lambda s: 0.2 * rigid(s, 0.25, 0.25, 0.0)),
    (hide('inertial_coupling', None, share=1.0), 0,
     lambda s: rigid(s, 0.876, 0.0, 0.0) - rigid(s, 0.876, 0.25, 0.18)),
    (hide('inertial_coupling', None, share=1.0), 1,
     lambda s: rigid(s, 0.0, 0.25, 0.0) - rigid(s, 0.0, 0.25, 0.18)
     - 0.25 * s.ddq[:, ::-1]),
    (hide('base_tilt', None, tilt=0.05, direction=2.0), 0, lambda s: gravity(s, 0.05, 2.0)),
    (hide('base_tilt', None, tilt=0.05, direction=-0.5), 1, lambda s: gravity(s, 0.05, -0.5)),
]
TORSION: list[Case] = [
    (hide('kinematic_error', amplitude_2=1e-4, phase_2=0.4, amplitude_4=5e-5, phase_4=-1.0), 0,
     lambda s: wavy(s, 2, 1e-4, 0.4) + wavy(s, 4, 5e-5, -1.0)),
    (hide('third_order_kinematic_error', 'joint2', amplitude=1e-4, phase=0.4), 1,
     lambda s: wavy(s, 3, 1e-4, 0.4)),
    (hide('loaded_kinematic_error', amplitude=8e-6, phase=0.4), 0,
     lambda s: np.abs(elastic(s)) * wavy(s, 2, 8e-6, 0.4)),
    (hide('backlash', half_width=1e-4), 0, lambda s: -1e-4 * np.sign(s.tau)),
    (hide('structural_damping', coefficient=200.0), 0,
     lambda s: torsion_balance(s) - compliance(s.tau - 208.0 * (s.v / 100.0 - s.dq))
     + s.theta / 100.0 - s.q),
    (hide('stiffness_error', relative_error=0.15), 0,
     lambda s: (1.0 - 1.0 / 1.15) * np.arctan(0.0831 * s.tau) / (0.0831 * 9743.939)),
    (hide('angle_dependent_stiffness', amplitude=0.3, order=4.0, phase=0.3), 0,
     lambda s: compliance(elastic(s)) - compliance(
         elastic(s) / (1.0 + 0.3 * np.sin(4.0 * s.q + 0.3)))),
]


def at_speed(s: Seen, joint: int) -> NDArray[np.bool_]:
    """Return where a joint moves fast and pulls, neither at the beginning nor at the end (k,)."""
    moving = (np.abs(s.v[:, joint]) > 15.0) & (np.abs(s.tau[:, joint]) > 0.3)
    moving[:100] = moving[-5:] = False
    return moving


def compare(balance: Callable[[Seen], Array], case: Case, most: float, share: float) -> None:
    """Require that a balance without the effect lacks what is expected, and little else."""
    hidden, joint, expected = case
    s = looked_at(exact(hidden))
    moving = at_speed(s, joint)
    lacking, wanted = (one[moving, joint] for one in (balance(s), expected(s)))
    left = np.sqrt(np.mean((lacking - wanted) ** 2))
    assert left < most + share * np.sqrt(np.mean(wanted ** 2))
    assert left < 0.25 * np.sqrt(np.mean(lacking ** 2))


def named(value: object) -> str | None:
    """Return the name of a case."""
    return f'{value[0].effect}-{value[1] + 1}' if isinstance(value, tuple) else None


@pytest.mark.parametrize('case', MOTOR, ids=named)
def test_motor_effects_are_what_the_motor_lacks(case):
    compare(motor_balance, case, 4e-4, 0.03)


@pytest.mark.parametrize('case', LINK, ids=named)
def test_link_effects_are_what_the_links_lack(case):
    compare(link_balance, case, 0.02, 0.03)


@pytest.mark.parametrize('case', TORSION, ids=named)
def test_torsion_effects_are_what_the_torsion_lacks(case):
    compare(torsion_balance, case, 1e-6, 0.05)


@pytest.mark.parametrize('case', [MOTOR[0], MOTOR[2], LINK[0], LINK[1], LINK[5], TORSION[0]],
                         ids=named)
def test_effects_break_the_balances_of_their_site_only(case):
    hidden, joint, _ = case
    sites = {'motor': (motor_balance, 2e-3), 'link': (link_balance, 0.1),
             'torsion': (torsion_balance, 1e-5)}
    s = looked_at(exact(hidden))
    for site, (balance, usual) in sites.items():
        lacking = balance(s)[at_speed(s, joint), joint]
        assert (np.sqrt(np.mean(lacking ** 2)) > usual) == (site == hidden.site), site


def test_a_warm_drive_is_less_viscous_as_time_goes_by():
    s = looked_at(exact(hide('thermal_viscosity', amplitude=4e-4, time_constant=3.0),
                        seconds=12.0))
    moving = at_speed(s, 0)
    found, v = motor_balance(s)[moving, 0], s.v[moving, 0]
    expected = 4e-4 * np.exp(-s.t[moving] / 3.0) * v
    assert np.sqrt(np.mean((found - expected) ** 2)) < 0.2 * np.sqrt(np.mean(expected ** 2))
    early, late = s.t[moving] < 1.0, s.t[moving] > 9.0
    slopes = [found[part] @ v[part] / (v[part] @ v[part]) for part in (early, late)]
    assert slopes[0] > 3e-4 and abs(slopes[1]) < 4e-5


@pytest.mark.parametrize('noise', [1.0, 3.0])
def test_noise_of_the_motor_torque_is_as_large_as_stated(noise):
    s = looked_at(exact(noise=noise))
    lacking = motor_balance(s)[at_speed(s, 1), 1]
    # Two samples of noise lie within a central difference.
    assert lacking.std() == pytest.approx(noise * 1e-3 / np.sqrt(2.0), rel=0.15)


def test_a_moving_base_takes_the_links_along():
    hidden = hide('base_vibration', None, frequency=9.0, damping=0.04, amplitude=0.03,
                  direction=0.5)
    for joint in range(2):
        for case, moves in ((hidden, True), (hide('base_vibration', None), False)):
            s = looked_at(exact(case))
            lacking = link_balance(s)[100:-5, joint]
            spectrum = np.abs(np.fft.rfft(lacking * np.hanning(len(lacking))))
            line = np.fft.rfftfreq(len(lacking), DT)[np.argmax(spectrum[10:]) + 10]
            assert (lacking.std() > 0.05) == moves
            assert not moves or 8.0 < line < 14.0

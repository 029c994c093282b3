"""The truth moves as the equations of the arm say, and shares nothing with the library."""

import ast
import json
from pathlib import Path
import sys

from hda_arm_sim.foundation.arrays import Array
import numpy as np
import pytest
from scipy.integrate import trapezoid
from truth import layout, links
from truth.drive import delayed, lagged, Sent
from truth.free import swing
from truth.friction import bent, resistance
from truth.gear import drag_sliders, seat, transmission_error
from truth.plant import at_rest, Plant, plant, State
from truth.torsion import look_up, table, torsion

REFERENCE = Path(__file__).parents[2] / 'shared' / 'reference'
SOURCES = sorted((Path(__file__).parent / 'truth').glob('*.py'))
N, P1, P2, P3 = 100.0, 0.876, 0.25, 0.18
INERTIA = 1.289e-4
STARTS = {                      # motor angles and rates, link angles and rates
    'free': ((0.10, 99.95), (0.0, 0.0), (0.0, 1.0005), (0.0, 0.0)),
    'forced': ((30.0, -80.0), (0.0, 0.0), (0.3, -0.8), (0.0, 0.0)),
    'kinematic': ((0.0, 90.0), (40.0, -30.0), (0.0, 0.9), (0.4, -0.3)),
}


def reference(name: str) -> Path:
    """Return a file of reference values, or skip where there is none."""
    if not (path := REFERENCE / name).exists():
        pytest.skip(f'{name} is not at ../shared/reference')
    return path


def built(**numbers: object) -> Plant:
    """Return the nominal arm without dry friction, with these numbers of joints and arm."""
    joints, arm = layout.nominal_joints(), layout.nominal_arm()
    joints['dry'] = 0.0
    for name, value in numbers.items():
        (joints if name in joints.dtype.names else arm)[name] = value
    return plant(arm, joints)


def started(motor: tuple[float, float], motor_rate: tuple[float, float],
            link: tuple[float, float], link_rate: tuple[float, float]) -> State:
    """Return the state at these angles and rates."""
    state = at_rest(np.array(motor), np.array(link))
    state.rate[:4] = [*motor_rate, link_rate[0], sum(link_rate)]
    return state


def coast(arm: Plant, state: State, seconds: float, h: float = 25e-6, every: int = 40) -> Array:
    """Return the trajectory without any input."""
    nothing = np.zeros((round(seconds / h), 2))
    return swing(arm, state, nothing, nothing, h, every)


def given(name: str, h: float) -> tuple[Array, Array]:
    """Return motor torques and tip forces of a reference trajectory, at the middle of steps."""
    t = (np.arange(round(2.0 / h)) + 0.5) * h
    turn = 2.0 * np.pi * t
    if name == 'forced':
        return (np.stack([0.06 * np.sin(1.3 * turn), -0.03 * np.sin(2.1 * turn + 0.4)], axis=1),
                np.stack([15.0 * np.sin(0.9 * turn), -8.0 * np.cos(1.7 * turn)], axis=1))
    constant = (0.02, -0.01) if name == 'kinematic' else (0.0, 0.0)
    return np.tile(constant, (len(t), 1)), np.zeros((len(t), 2))


def trajectory(name: str, h: float) -> Array:
    """Return a reference trajectory as the truth integrates it (2001, 2, 4)."""
    error = ((1.0e-4, 0.6e-4), (0.5, -1.1)) if name == 'kinematic' else (0.0, 0.0)
    arm = built(kinematic_error_amplitude_2=error[0], kinematic_error_phase_2=error[1])
    return swing(arm, started(*STARTS[name]), *given(name, h), h, round(1e-3 / h))


def energy(arm: Plant, row: Array, base: tuple[float, float] = (0.0, 0.0)) -> float:
    """Return the energy of a state (2, 4) [J]; `base` is displacement and rate of the base."""
    motor, motor_rate, q, dq = row.T
    m12 = P2 + P3 * np.cos(q[1])
    mass = np.array([[P1 + 2.0 * P3 * np.cos(q[1]), m12], [m12, P2]])
    total = 0.5 * INERTIA * motor_rate @ motor_rate + 0.5 * dq @ mass @ dq
    for j, x in enumerate(motor / N - q):
        grid = np.linspace(0.0, x, 4001)
        total += trapezoid([look_up(arm.law[j], one) for one in grid], grid)
    moments, angles, rates = np.array([2.925, 1.2]), np.cumsum(q), np.cumsum(dq)
    if tilt := float(arm.arm['base_tilt_tilt'][0]):
        down = float(arm.arm['base_tilt_direction'][0])
        total -= 9.81 * np.sin(tilt) * moments @ np.cos(angles - down)
    if mobility := float(arm.arm['base_vibration_amplitude'][0]):
        along = float(arm.arm['base_vibration_direction'][0])
        swinging = 2.0 * np.pi * float(arm.arm['base_vibration_frequency'][0])
        total += 0.5 * (base[1] ** 2 + (swinging * base[0]) ** 2) / mobility
        total -= base[1] * moments @ (np.sin(angles - along) * rates)
    return float(total)


def test_it_imports_nothing_of_the_library():
    allowed = {'numba', 'numpy', 'scipy', *sys.stdlib_module_names}
    for path in SOURCES:
        for node in ast.walk(ast.parse(path.read_text())):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else (
                [node.module or ''] if isinstance(node, ast.ImportFrom) and not node.level else [])
            assert {name.partition('.')[0] for name in names} <= allowed, path


@pytest.mark.parametrize('name', STARTS)
def test_trajectories_are_those_of_other_programs(name):
    expected = np.load(reference(f'{name}.npz'))
    found = trajectory(name, 40e-6)
    assert found[:, :, 0] == pytest.approx(expected['motor_angle'], abs=1e-5)
    assert found[:, :, 2] == pytest.approx(expected['link_angle'], abs=1e-6)


def test_rigid_motion_is_that_of_another_program():
    cases = json.loads(reference('rigid.json').read_text())['cases']
    arm, wanted = built(), np.array([1.7, -2.3])
    for case in cases:
        q, dq = np.array(case['q']), np.array(case['dq'])
        t1, t2 = np.array(case['M']) @ wanted + case['bias']
        pose, out = np.zeros(links.POSE), np.zeros(5)
        links.write_pose(arm.arm[0], arm.body, q[0], q.sum(), (0.0, 0.0), pose)
        links.accelerate(arm.arm[0], arm.body, pose, (t1, t2), 0.0,
                         np.array([0.0, 0.0, dq[0], dq.sum(), 0.0]), out)
        assert [out[2], out[3] - out[2]] == pytest.approx(wanted, rel=1e-9)


def test_healthy_torsion_law_is_the_nominal_one():
    law = table(layout.nominal_joints()[0])
    torque = np.concatenate([np.geomspace(1e-9, 20.0, 2000), np.linspace(0.01, 20.0, 2000)])
    known = (np.arctan(0.0831 * torque) / (0.0831 * 9743.939)
             - np.expm1(-27.027 * torque / N) / (N * 27.027 * 2.5517))
    assert [look_up(law, x) for x in known] == pytest.approx(torque, rel=1e-6)
    assert [look_up(law, -x) for x in known] == pytest.approx(-torque, rel=1e-6)


def test_torsion_law_is_that_of_another_program():
    rows = np.loadtxt(reference('torsion_law.csv'), delimiter=',', skiprows=1)
    law = table(layout.nominal_joints()[1])
    assert [look_up(law, x) for x in rows[:, 2]] == pytest.approx(rows[:, 0], rel=1e-5, abs=1e-12)


@pytest.mark.parametrize('name', STARTS)
def test_integration_is_of_second_order(name):
    fine = trajectory(name, 12.5e-6)
    coarse, middle = (np.abs(trajectory(name, h)[:, :, 0] - fine[:, :, 0]).max()
                      for h in (100e-6, 50e-6))
    # Both are compared to a solution that errs itself: (1 - 1/64) / (1/4 - 1/64).
    assert coarse / middle == pytest.approx(4.2, abs=0.3)


def test_friction_leaves_the_integration_of_second_order():
    joints, arm = layout.nominal_joints(), layout.nominal_arm()
    results = []
    for h in (40e-6, 20e-6, 5e-6):
        moved = coast(plant(arm, joints), started((0.0, 0.0), (60.0, -40.0), (0.0, 1.0),
                                                  (0.6, -0.4)), 0.1, h, round(1e-3 / h))
        results.append(moved[:, :, 0])
    coarse, middle = (np.abs(one - results[-1]).max() for one in results[:2])
    assert 3.0 < coarse / middle < 6.0


LOSSLESS = {'damping': 0.0, 'viscous': 0.0}
TILTED = {'base_tilt_tilt': 0.05, 'base_tilt_direction': 0.7}
SHAKEN = {'base_vibration_amplitude': 0.02, 'base_vibration_damping': 0.0,
          'base_vibration_direction': 0.4}


@pytest.mark.parametrize('more', [{}, TILTED, SHAKEN], ids=['level', 'tilted', 'shaken'])
def test_energy_stays_where_nothing_takes_it(more):
    arm, state = built(**LOSSLESS, **more), started(*STARTS['kinematic'])
    state.rate[4] = 0.1 if more is SHAKEN else 0.0
    before = energy(arm, coast(arm, state, 0.0)[0], (0.0, state.rate[4]))
    after = energy(arm, coast(arm, state, 1.03)[-1], (state.position[4], state.rate[4]))
    assert after == pytest.approx(before, rel=1e-5)
    assert (abs(state.rate[4]) > 1e-3) == (more is SHAKEN)


@pytest.mark.parametrize('loss', [
    {'damping': 8.0}, {'viscous': 6e-5}, {'dry': 0.037}, {'link_bearing_friction_level': 1.0},
    {'dry': 0.037, 'presliding_friction_stiffness': 1.0, 'presliding_friction_damping': 0.02},
    {'dry': 0.037, 'stribeck_friction_excess': 0.03}], ids=lambda loss: '+'.join(loss))
def test_every_loss_takes_energy_and_none_gives_any(loss):
    arm = built(**{**LOSSLESS, **loss})
    state = started((0.1, 89.9), (6.0, -4.0), (0.0, 0.9), (0.06, -0.04))
    left = np.array([energy(arm, row) for row in coast(arm, state, 0.5, every=800)])
    assert left[-1] < 0.9 * left[0]
    # What bent bristles hold is not counted: level^2 / 2 stiffness.
    stored = 2.0 * 0.067 ** 2 / 2.0 if 'presliding_friction_stiffness' in loss else 1e-4
    assert np.diff(left).max() < stored


def test_work_of_force_and_motors_is_the_energy_gained():
    arm, state, h = built(**LOSSLESS), started(*STARTS['forced']), 25e-6
    torque, force = given('forced', h)
    path = swing(arm, state, torque, force, h, 1)
    middle = 0.5 * (path[1:] + path[:-1])
    a1, a2 = middle[:, 0, 2], middle[:, :, 2].sum(axis=1)
    r1, r2 = middle[:, 0, 3], middle[:, :, 3].sum(axis=1)
    tip = 0.15 * np.stack([-np.sin(a1) * r1 - np.sin(a2) * r2,
                           np.cos(a1) * r1 + np.cos(a2) * r2], axis=1)
    work = h * ((torque * middle[:, :, 1]).sum() + (force * tip).sum())
    assert energy(arm, path[-1]) - energy(arm, path[0]) == pytest.approx(work, rel=1e-5)


@pytest.mark.parametrize(('torque', 'shake', 'slides'), [
    (0.015, 0.0, False), (0.015, 0.005, False), (0.033, 0.0, False), (0.041, 0.0, True)])
def test_bristles_stick_below_their_level_and_slide_above(torque, shake, slides):
    h, pushed = 40e-6, np.zeros((50000, 2))
    t = h * np.arange(len(pushed))
    pushed[:, 0] = np.minimum(t / 0.5, 1.0) * (torque + shake * np.sin(2.0 * np.pi * 40.0 * t))
    path = swing(built(dry=0.037), at_rest(np.zeros(2), np.zeros(2)), pushed,
                 np.zeros_like(pushed), h, 25)
    if slides:
        assert path[-1, 0, 0] > 1.0
    else:
        assert path[-1, 0, 0] == pytest.approx(path[1500, 0, 0], abs=1e-6)
        assert path[-1, 0, 0] < 1e-3


@pytest.mark.parametrize('rate', [1e-3, 0.5, 80.0])
@pytest.mark.parametrize('way', [1.0, -1.0])
def test_sliding_bristles_push_back_at_their_level(rate, way):
    bristle = bent(-way * 3e-4, way * rate, 123.0, 0.037, 3e-3 / rate)
    assert resistance(bristle, way * rate, 123.0, 0.08, 0.037) == pytest.approx(0.037 * way,
                                                                                rel=1e-4)


@pytest.mark.parametrize('share', [-0.9, -0.3, 0.3, 0.9])
@pytest.mark.parametrize('rate', [0.01, -0.2])
def test_bristles_are_damped_by_the_rate_at_which_they_bend(share, rate):
    bristle, h = share * 3e-4, 1e-9 / abs(rate)
    bending = (bent(bristle, rate, 123.0, 0.037, h) - bristle) / h
    damping = resistance(bristle, rate, 123.0, 0.08, 0.037) - 123.0 * bristle
    assert damping * (1.0 + (0.16 * rate / 0.037) ** 2) == pytest.approx(0.08 * bending, rel=1e-4)


def test_bristles_never_drive_what_slides_steadily():
    for rate in np.geomspace(1e-6, 100.0, 30):
        for share in np.linspace(-1.0, 1.0, 21):
            push = resistance(share * 3e-4, rate, 123.0, 0.08, 0.037)
            assert -0.0371 <= push <= 0.037 * 1.3


def test_sliders_have_initial_slope_saturation_and_a_loop_of_any_speed():
    joint = built(torsional_hysteresis_level=1.2, torsional_hysteresis_width=2e-4).joints[0]
    areas = []
    for count in (200, 2000):
        x = np.concatenate([np.linspace(0.0, 1e-3, count), 1e-3 * np.cos(
            np.linspace(0.0, 2.0 * np.pi, 8 * count))])
        sliders, torque, was = np.zeros(10), np.zeros(len(x)), 0.0
        for i, one in enumerate(x):
            torque[i], was = drag_sliders(joint, one, was, sliders), one
        assert torque[1] / x[1] == pytest.approx(1.2 / 2e-4)
        assert torque.max() == pytest.approx(1.2)
        areas.append(trapezoid(torque[count:], x[count:]))
    # A loop of full height, but for its corners: each branch loses level times width.
    assert areas[0] == pytest.approx(areas[1], rel=1e-2)
    assert 1.2 * (4e-3 - 4 * 2e-4 * 1.9) < areas[1] < 1.2 * 4e-3


def test_nothing_dampens_within_the_play():
    arm = built(backlash_half_width=1e-4)
    for torsion_seen, damping in ((0.0, 0.0), (4e-4, 8.0), (-4e-4, 8.0)):
        state = at_rest(np.array([torsion_seen * N, 0.0]), np.zeros(2))
        coast(arm, state, 1e-9, h=1e-9, every=1)
        assert state.held['damping'][0] == pytest.approx(damping, abs=0.02)


def test_play_is_a_dead_zone_with_free_flanks():
    joint = built(backlash_half_width=1e-4).joints[0]
    assert seat(joint, 0.0) == pytest.approx((0.0, 0.0), abs=1e-3)
    for way in (1.0, -1.0):
        behind, share = seat(joint, way * 5e-4)
        assert behind == pytest.approx(way * 4e-4, rel=1e-3)
        assert share == pytest.approx(1.0, abs=1e-3)
    x = np.linspace(-3e-4, 3e-4, 6001)
    behind, share = np.array([seat(joint, one) for one in x]).T
    assert np.gradient(behind, x)[1:-1] == pytest.approx(share[1:-1], abs=1e-2)


def test_transmission_error_keeps_power():
    joint = built(kinematic_error_amplitude_2=1e-4, kinematic_error_amplitude_4=3e-5,
                  kinematic_error_phase_4=1.0,
                  third_order_kinematic_error_amplitude=5e-5).joints[0]
    theta = np.linspace(-3.0, 3.0, 6001)
    error, slope = np.array([transmission_error(joint, one) for one in theta]).T
    assert np.gradient(error, theta)[1:-1] == pytest.approx(slope[1:-1], abs=1e-8)


def test_delay_moves_the_torque_and_keeps_its_area():
    instant = 1e-3 * np.arange(51)
    torque = np.stack([np.sin(instant), np.cos(instant)], axis=1)
    sent = Sent(torque, np.stack([instant, instant], axis=1), np.zeros(2, np.int64))
    h, delay, out = 4e-5, 2.37e-3, []
    for k in range(50):
        out += [delayed(sent, k, 0, delay, instant[k] + i * h, h) for i in range(25)]
    edges = np.arange(1251) * h
    held = np.concatenate([[0.0], np.cumsum(1e-3 * torque[:-1, 0])])
    area = np.interp(edges - delay, instant, held)
    assert np.array(out) * h == pytest.approx(np.diff(area), abs=1e-12)


def test_lag_is_of_first_order_whatever_the_step():
    joint = built(current_loop_lag_time_constant=4e-3).joints[0]
    for h in (1e-5, 1e-3):
        lag, area = np.zeros(2), 0.0
        for _ in range(round(0.01 / h)):
            area += h * lagged(joint, 0.1, 0, lag, h)
        assert lag[0] == pytest.approx(0.1 * (1.0 - np.exp(-2.5)), rel=1e-9)
        assert area == pytest.approx(0.1 * (0.01 - 4e-3 * (1.0 - np.exp(-2.5))), rel=1e-9)


def test_hidden_torsion_laws_differ_as_their_names_say():
    torque = np.linspace(0.0, 30.0, 301)
    for name, value, stiffer in (
            ('stiffness_error_relative_error', 0.1, True),
            ('stiffness_error_relative_error', -0.1, False),
            ('stiffening_error_curvature', 0.16, True), ('stiffening_error_curvature', 0.0, False),
            ('wave_generator_compliance_psi', 1e-4, True),
            ('wave_generator_compliance_psi', 6e-4, False)):
        joint = layout.nominal_joints()[0]
        usual = torsion(joint, torque)
        joint[name] = value
        changed = torsion(joint, torque)
        assert (np.diff(changed) > 0.0).all(), name
        assert ((changed < usual)[1:] == stiffer).all(), name


def test_hidden_torsion_laws_have_the_sizes_of_the_table():
    knees, joint = np.array([3.9, 12.0, 24.0]), layout.nominal_joints()[0]
    usual = torsion(joint, knees)
    joint['stiffness_error_relative_error'] = 0.1
    assert torsion(joint, knees) - usual == pytest.approx(
        (1.0 / 1.1 - 1.0) * np.arctan(0.0831 * knees) / (0.0831 * 9743.939))
    joint = layout.nominal_joints()[0]
    joint['stiffening_error_curvature'] = 0.16
    assert torsion(joint, knees) - usual == pytest.approx(
        (np.arctan(0.16 * knees) / 0.16 - np.arctan(0.0831 * knees) / 0.0831) / 9743.939)
    joint = layout.nominal_joints()[0]
    far, joint['wave_generator_compliance_psi'] = np.array([5000.0]), 6e-4
    assert torsion(joint, far) - torsion(layout.nominal_joints()[0], far) == pytest.approx(
        0.5 * (6e-4 - 2.9e-4), rel=1e-4)

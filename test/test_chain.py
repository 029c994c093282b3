"""Dynamics of chains in space, against another program and against the laws that must hold."""

from importlib.metadata import distribution
from pathlib import Path

from chains import iiwa, tables
from hda_arm_sim.foundation import chain as of
from hda_arm_sim.foundation.chain_doubts import own_doubts
from hda_arm_sim.model.chain_links import chain_to, ChainLinks, kept
from hda_arm_sim.model.effects import LinkInertiaError
from hda_arm_sim.model.link_numbers import differ
from hypothesis import given, settings, strategies as st
import numpy as np
import pinocchio
from project_files import ROOT
import pytest

STEP = 1e-6
GRAVITY = np.array([1.0, 2.0, -9.0])
ROBOTS = {
    'panda_description/urdf/panda.urdf': 'panda_hand_tcp',
    'ur_description/urdf/ur5_robot.urdf': 'ee_link',
    'kinova_description/robots/kinova.urdf': 'j2s6s200_end_effector',
    'z1_description/urdf/z1.urdf': 'gripperStator'}
OWN = ROOT / 'config' / 'cobot7.urdf'


def matrix(table):
    """Return the mass matrix of a table that was placed."""
    of.mass_matrix(table)
    return table[1:-1, of.MATRIX:of.MATRIX + len(table) - 2].copy()


def placed(table, angle):
    """Return a copy of a table at other angles."""
    made = table.copy()
    made[1:-1, of.ANGLE] = angle
    of.place(made)
    return made


def robots():
    """Yield descriptions of real arms and of ours, with the tip of each."""
    folder = Path(str(distribution('example-robot-data').locate_file(
        'cmeel.prefix/share/example-robot-data/robots')))
    for name, tip in ROBOTS.items():
        yield pytest.param((folder / name).read_text(), tip, id=Path(name).stem)
    yield pytest.param(iiwa(), 'ee', id='iiwa')
    yield pytest.param(OWN.read_text(), 'tool_tip', id='cobot7')


@pytest.mark.parametrize(('text', 'tip'), robots())
def test_equals_another_program(text, tip):
    names = chain_to(text, tip)
    parts = ChainLinks(kept(text), tip, names).parts.copy()
    parts[0, of.DOWN:of.DOWN + 3] = GRAVITY
    c, n = of.chain(parts).table, len(names)
    whole = pinocchio.buildModelFromXML(text)
    other = pinocchio.buildReducedModel(
        whole, [whole.getJointId(name) for name in whole.names[1:] if name not in names],
        pinocchio.neutral(whole))
    work, other.gravity.linear = other.createData(), GRAVITY
    q, dq, ddq = np.random.default_rng(0).normal(size=(3, n))
    given_q = pinocchio.neutral(other)
    for name, angle in zip(names, q):
        there = other.joints[other.getJointId(name)]
        given_q[there.idx_q:there.idx_q + there.nq] = (
            (np.cos(angle), np.sin(angle)) if there.nq == 2 else angle)
    c[1:-1, of.ANGLE:of.SPEEDING + 1] = np.stack([q, dq, ddq], axis=1)
    of.place(c)
    of.inverse_dynamics(c)
    torque, jacobian, speeding = c[1:-1, of.TORQUE].copy(), np.zeros((6, n)), np.zeros(n)
    of.tip_jacobian(c, jacobian)
    close = {'rtol': 0.0, 'atol': 1e-10}
    np.testing.assert_allclose(torque, pinocchio.rnea(other, work, given_q, dq, ddq), **close)
    full = pinocchio.crba(other, work, given_q)
    mass = np.triu(full) + np.triu(full, 1).T
    np.testing.assert_allclose(matrix(c), mass, **close)
    np.testing.assert_allclose(jacobian, pinocchio.computeFrameJacobian(
        other, work, given_q, other.getFrameId(tip, pinocchio.FrameType.BODY),
        pinocchio.LOCAL_WORLD_ALIGNED), **close)
    of.momenta(c)
    np.testing.assert_allclose(c[1:-1, of.TORQUE], mass @ dq, **close)
    coriolis = pinocchio.computeCoriolisMatrix(other, work, given_q, dq)
    np.testing.assert_allclose(c[1:-1, of.COUPLING], coriolis.T @ dq, **close)
    of.weights(c)
    np.testing.assert_allclose(
        c[1:-1, of.TORQUE], -pinocchio.computeGeneralizedGravity(other, work, given_q), **close)
    of.forward_dynamics(c, torque, speeding)
    np.testing.assert_allclose(speeding, ddq, **close)


@given(tables())
def test_mass_matrix_is_symmetric_and_positive_definite(table):
    of.place(table)
    mass = matrix(table)
    np.testing.assert_array_equal(mass, mass.T)
    assert np.linalg.eigvalsh(mass).min() > 0.0


@given(tables())
def test_inverse_dynamics_is_linear_in_the_acceleration(table):
    of.place(table)
    speeding = table[1:-1, of.SPEEDING].copy()
    of.inverse_dynamics(table)
    whole = table[1:-1, of.TORQUE].copy()
    table[1:-1, of.SPEEDING] = 0.0
    of.inverse_dynamics(table)
    scale = 1.0 + np.abs(whole).max()
    np.testing.assert_allclose(whole - table[1:-1, of.TORQUE], matrix(table) @ speeding,
                               atol=1e-11 * scale)


@given(tables())
def test_forward_dynamics_undoes_inverse_dynamics(table):
    of.place(table)
    speeding, found = table[1:-1, of.SPEEDING].copy(), np.zeros(len(table) - 2)
    of.inverse_dynamics(table)
    worst = np.linalg.cond(matrix(table))
    of.forward_dynamics(table, table[1:-1, of.TORQUE].copy(), found)
    np.testing.assert_allclose(found, speeding, atol=1e-13 * worst * (1.0 + np.abs(speeding).max())
                               * (1.0 + np.abs(table[1:-1, of.TORQUE]).max()))


@given(tables())
def test_the_torques_of_a_wrench_do_its_work(table):
    of.place(table)
    jacobian = np.zeros((6, len(table) - 2))
    of.tip_jacobian(table, jacobian)
    with_wrench, without = table.copy(), table.copy()
    without[-1, of.WRENCH:of.WRENCH + 6] = 0.0
    of.inverse_dynamics(with_wrench)
    of.inverse_dynamics(without)
    np.testing.assert_allclose(
        without[1:-1, of.TORQUE] - with_wrench[1:-1, of.TORQUE],
        jacobian.T @ table[-1, of.WRENCH:of.WRENCH + 6],
        atol=1e-11 * (1.0 + np.abs(without[1:-1, of.TORQUE]).max()))


@given(tables())
def test_the_jacobian_is_the_slope_of_the_tip(table):
    of.place(table)
    jacobian, angle = np.zeros((6, len(table) - 2)), table[1:-1, of.ANGLE].copy()
    of.tip_jacobian(table, jacobian)
    for k in range(len(angle)):
        moved = STEP * (np.arange(len(angle)) == k)
        ahead, behind = placed(table, angle + moved), placed(table, angle - moved)
        slope = (ahead[-1, of.PLACE:of.PLACE + 3] - behind[-1, of.PLACE:of.PLACE + 3]) / 2 / STEP
        np.testing.assert_allclose(jacobian[:3, k], slope, atol=1e-8)


@given(tables())
def test_rate_of_mass_matrix_minus_twice_coriolis_is_skew(table):
    """M' dq is C dq and C^T dq together, and both do the same work."""
    angle, speed = table[1:-1, of.ANGLE].copy(), table[1:-1, of.SPEED].copy()
    rate = (matrix(placed(table, angle + STEP * speed))
            - matrix(placed(table, angle - STEP * speed))) / (2.0 * STEP)
    table[0, of.DOWN:of.DOWN + 3], table[-1, of.WRENCH:of.WRENCH + 6] = 0.0, 0.0
    table[1:-1, of.SPEEDING] = 0.0
    of.place(table)
    of.inverse_dynamics(table)
    forth = table[1:-1, of.TORQUE].copy()
    of.momenta(table)
    back = table[1:-1, of.COUPLING]
    scale = 1.0 + np.abs(rate).max() * np.abs(speed).max()
    np.testing.assert_allclose(forth + back, rate @ speed, atol=1e-7 * scale)
    assert abs(speed @ (forth - back)) < 1e-11 * scale * (1.0 + np.abs(speed).max()) ** 2


@given(tables())
def test_gravity_is_the_slope_of_its_potential(table):
    def potential(angle):
        made = placed(table, angle)
        return -(made[1:-1, of.MOMENT_HERE:of.MOMENT_HERE + 3]
                 @ made[0, of.DOWN:of.DOWN + 3]).sum()
    angle = table[1:-1, of.ANGLE].copy()
    of.place(table)
    of.weights(table)
    moves = STEP * np.eye(len(angle))
    slopes = [(potential(angle + move) - potential(angle - move)) / (2.0 * STEP)
              for move in moves]
    np.testing.assert_allclose(table[1:-1, of.TORQUE], np.negative(slopes), atol=1e-6)


@given(tables(), st.integers(0, 2 ** 32 - 1))
def test_nothing_depends_on_the_frame_of_the_base(table, seed):
    turn = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    other = table.copy()
    for column in (of.DOWN, of.WRENCH, of.WRENCH + 3):
        row = 0 if column == of.DOWN else -1
        other[row, column:column + 3] = turn @ table[row, column:column + 3]
    first = table[1, of.ROTATION:of.ROTATION + 9].reshape(3, 3)
    other[1, of.ROTATION:of.ROTATION + 9] = (turn @ first).ravel()
    other[1, of.OFFSET:of.OFFSET + 3] = turn @ table[1, of.OFFSET:of.OFFSET + 3]
    for each in (table, other):
        of.place(each)
        of.inverse_dynamics(each)
    scale = 1.0 + np.abs(table[1:-1, of.TORQUE]).max()
    np.testing.assert_allclose(other[1:-1, of.TORQUE], table[1:-1, of.TORQUE], atol=1e-11 * scale)
    np.testing.assert_allclose(matrix(other), matrix(table), atol=1e-11 * scale)


@settings(max_examples=20)
@given(tables())
def test_the_base_feels_what_the_links_throw_at_it(table):
    """The torque per acceleration of the base is that of gravity the other way round."""
    along = (0.6, 0.0, -0.8)
    of.place(table)
    of.base_couplings(table, along)
    pulled = table.copy()
    pulled[0, of.DOWN:of.DOWN + 3] = along
    of.weights(pulled)
    np.testing.assert_allclose(table[1:-1, of.COUPLING], pulled[1:-1, of.TORQUE], atol=1e-12)


def whole_energy(table):
    """Return kinetic energy and that of gravity, at the frames placed [J]."""
    speed = table[1:-1, of.SPEED]
    moments = table[1:-1, of.MOMENT_HERE:of.MOMENT_HERE + 3]
    return 0.5 * speed @ matrix(table) @ speed - (moments @ table[0, of.DOWN:of.DOWN + 3]).sum()


def along(table, speeding, time):
    """Return a table some time on along a motion of constant acceleration, placed."""
    made = table.copy()
    angle, speed = table[1:-1, of.ANGLE], table[1:-1, of.SPEED]
    made[1:-1, of.ANGLE] = angle + time * speed + 0.5 * time ** 2 * speeding
    made[1:-1, of.SPEED] = speed + time * speeding
    of.place(made)
    return made


@given(tables(), st.integers(0, 2 ** 32 - 1))
def test_energy_grows_by_the_work_of_torques_and_wrench(table, seed):
    """dE/dt = tau dq + F v, with the acceleration that forward dynamics gives them."""
    n = len(table) - 2
    torque, speeding = np.random.default_rng(seed).uniform(-20.0, 20.0, n), np.zeros(n)
    speed, jacobian = table[1:-1, of.SPEED].copy(), np.zeros((6, n))
    of.forward_dynamics(table, torque, speeding)
    of.tip_jacobian(table, jacobian)
    work = (torque + jacobian.T @ table[-1, of.WRENCH:of.WRENCH + 6]) @ speed
    step = STEP / (1.0 + np.abs(speeding).max() ** 0.5)
    ends = [whole_energy(along(table, speeding, sign * step)) for sign in (1.0, -1.0)]
    scale = np.abs(work) + np.abs(speeding).max() * np.abs(matrix(table)).max() * n * 3.0
    assert abs((ends[0] - ends[1]) / (2.0 * step) - work) < 1e-6 * scale + 1e-5 + (
        1e-15 * max(map(abs, ends)) / step)


@given(tables(), st.integers(0, 2 ** 32 - 1))
def test_momentum_grows_by_torques_weight_drift_and_wrench(table, seed):
    """dp/dt = tau + g + C^T dq + J^T F: what the momentum observer expects."""
    n = len(table) - 2
    torque, speeding = np.random.default_rng(seed).uniform(-20.0, 20.0, n), np.zeros(n)
    jacobian = np.zeros((6, n))
    of.forward_dynamics(table, torque, speeding)
    of.tip_jacobian(table, jacobian)
    of.momenta(table)
    expected = torque + table[1:-1, of.COUPLING] + jacobian.T @ (
        table[-1, of.WRENCH:of.WRENCH + 6])
    of.weights(table)
    expected += table[1:-1, of.TORQUE]
    step, ends = STEP / (1.0 + np.abs(speeding).max() ** 0.5), []
    for sign in (1.0, -1.0):
        end = along(table, speeding, sign * step)
        of.momenta(end)
        ends.append(end[1:-1, of.TORQUE].copy())
    scale = 1.0 + np.abs(expected).max() + n * np.abs(speeding).max() * np.abs(
        matrix(table)).max()
    np.testing.assert_allclose((ends[0] - ends[1]) / (2.0 * step), expected, atol=1e-6 * scale)


@given(tables())
def test_links_that_a_tip_carries_are_felt_as_their_weight_and_inertia(table):
    """The torques of each link alone, in `own_doubts`, are those of a chain without the others."""
    of.place(table)
    n = len(table) - 2
    found, sums = np.zeros((n, n)), np.zeros((n, n))
    table[-1, of.WRENCH:of.WRENCH + 6] = 0.0
    own_doubts(table, np.outer(np.ones(n), (1.0, 0.0, 0.0)), found)
    for link in range(1, n + 1):
        alone = table.copy()
        others = [row for row in range(1, n + 1) if row != link]
        alone[others, of.MASS:of.CONSTANTS] = 0.0
        of.place(alone)
        of.inverse_dynamics(alone)
        sums += np.outer(alone[1:-1, of.TORQUE], alone[1:-1, of.TORQUE])
    np.testing.assert_allclose(found, sums, rtol=1e-9, atol=1e-9)


@settings(max_examples=30)
@given(tables(), st.integers(0, 2 ** 32 - 1))
def test_doubts_of_links_are_what_other_links_would_need(table, seed):
    """Covariances of torques are products of what a step of each number changes."""
    n = len(table) - 2
    known = np.random.default_rng(seed).uniform(0.0, 0.1, (n, 3))
    known[:, 1] *= 0.1
    table[-1, of.WRENCH:of.WRENCH + 6] = 0.0
    of.place(table)
    found, sums = np.zeros((n, n)), np.zeros((n, n))
    own_doubts(table, known, found)
    steps = [(link, name, size) for link in range(n)
             for name, size in zip(('mass', 'centre', 'error'), known[link])]
    for link, name, size in steps:
        for axis in 'xyz' if name == 'centre' else ('',):
            torques = []
            for sign in (1.0, -1.0):
                other = table.copy()
                differ(other[link + 1], LinkInertiaError(
                    **{f'centre_{axis}' if axis else name: sign * STEP}))
                of.place(other)
                of.inverse_dynamics(other)
                torques.append(other[1:-1, of.TORQUE].copy())
            change = size * (torques[0] - torques[1]) / (2.0 * STEP)
            sums += np.outer(change, change)
    np.testing.assert_allclose(found, sums, rtol=1e-5, atol=1e-6 * (1.0 + sums.max()))

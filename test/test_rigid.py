"""Dynamics of the links, against another program and against the laws that must hold."""

import json

from hda_arm_sim.foundation.rigid import (coriolis, gravity_torque, Inertia, mass_matrix,
                                          momentum_drift, tip_position, tip_torque, tool_jacobian)
from hda_arm_sim.model.arm import Arm, ArmError
from hda_arm_sim.model.parts import Joint, Links
from hypothesis import given, strategies as st
import numpy as np
import pytest
from reference_values import reference

INERTIA = Inertia(0.876, 0.25, 0.18, 2.925, 1.2, 1.0)
LENGTH = 0.15
JOINTS = (Joint(label='joint1'), Joint(label='joint2'))

angles = st.floats(-7.0, 7.0)
speeds = st.floats(-10.0, 10.0)


@st.composite
def inertias(draw):
    """Return the inertia of two random links made of masses, so one that can be."""
    m1, m2 = draw(st.floats(0.1, 30.0)), draw(st.floats(0.1, 30.0))
    c1, c2, length = (draw(st.floats(0.01, 1.0)) for _ in range(3))
    i1, i2 = draw(st.floats(1e-3, 1.0)), draw(st.floats(1e-3, 1.0))
    return Inertia(i1 + i2 + m1 * c1 ** 2 + m2 * (length ** 2 + c2 ** 2), i2 + m2 * c2 ** 2,
                   m2 * length * c2, m1 * c1 + m2 * length, m2 * c2, draw(st.floats(0.0, 1.0)))


def matrix(inertia, elbow):
    """Return M as an array."""
    m11, m12, m22 = mass_matrix(inertia, elbow)
    return np.array([[m11, m12], [m12, m22]])


def test_equals_another_program():
    cases = json.loads(reference('rigid.json').read_text())['cases']
    assert len(cases) == 40
    for case in cases:
        (q1, q2), dq, force = case['q'], case['dq'], case['tip_force']
        close = {'rtol': 1e-12, 'atol': 1e-12}
        np.testing.assert_allclose(matrix(INERTIA, q2), case['M'], **close)
        np.testing.assert_allclose(coriolis(INERTIA, q2, *dq), case['bias'], **close)
        np.testing.assert_allclose(tip_position(LENGTH, LENGTH, q1, q2), case['tip'], **close)
        np.testing.assert_allclose(tip_torque(LENGTH, LENGTH, q1, q2, *force),
                                   case['joint_torque'], **close)


@given(inertias(), angles)
def test_mass_matrix_is_positive_definite(inertia, elbow):
    assert np.linalg.eigvalsh(matrix(inertia, elbow)).min() > 0.0


@pytest.mark.parametrize('links', [
    Links(length2=0.15, p1=0.876, p2=0.0), Links(length2=0.15, p1=0.5, p2=0.25, p3=0.25),
    Links(length2=0.15, p1=0.2, p2=0.25), Links(length2=0.15, p2=0.0, coupled=0.0)])
def test_arms_that_could_gain_energy_from_nothing_are_refused(links):
    with pytest.raises(ArmError, match='p2'):
        Arm(JOINTS, links)


@given(inertias(), angles, speeds, speeds)
def test_rate_of_mass_matrix_minus_twice_coriolis_is_skew(inertia, elbow, dq1, dq2):
    step = 1e-6
    rate = (matrix(inertia, elbow + step) - matrix(inertia, elbow - step)) / (2.0 * step) * dq2
    dq = np.array([dq1, dq2])
    forth = np.array(coriolis(inertia, elbow, dq1, dq2))
    back = np.array([0.0, momentum_drift(inertia, elbow, dq1, dq2)])
    scale = inertia.p1 * (dq @ dq + 1.0)
    np.testing.assert_allclose(forth + back, rate @ dq, atol=1e-8 * scale)
    assert abs(dq @ (rate @ dq - 2.0 * forth)) < 1e-7 * scale * (1.0 + np.abs(dq).max())


@given(inertias(), st.floats(0.0, 5.0), angles, angles, angles)
def test_gravity_is_the_slope_of_its_potential(inertia, pull, direction, q1, q2):
    def potential(a, b):
        return -pull * (inertia.first * np.cos(direction - a)
                        + inertia.second * np.cos(direction - a - b))
    step = 1e-6
    slopes = ((potential(q1 + step, q2) - potential(q1 - step, q2)) / (2.0 * step),
              (potential(q1, q2 + step) - potential(q1, q2 - step)) / (2.0 * step))
    np.testing.assert_allclose(gravity_torque(inertia, pull, direction, q1, q2),
                               np.negative(slopes), atol=1e-6 * (1.0 + pull * inertia.first))


@given(angles, angles, speeds, speeds)
def test_a_tip_force_does_the_work_of_its_joint_torques(q1, q2, force_x, force_y):
    step = 1e-6
    moves = [(np.array(tip_position(0.3, 0.2, q1 + step * (j == 0), q2 + step * (j == 1)))
              - tip_position(0.3, 0.2, q1 - step * (j == 0), q2 - step * (j == 1))) / (2.0 * step)
             for j in range(2)]
    work = [move @ (force_x, force_y) for move in moves]
    np.testing.assert_allclose(tip_torque(0.3, 0.2, q1, q2, force_x, force_y), work, atol=1e-7)


@given(angles, angles, speeds, speeds)
def test_tool_frame_turns_with_the_last_link(q1, q2, axial, across):
    c, s = np.cos(q1 + q2), np.sin(q1 + q2)
    j11, j12, j21, j22 = tool_jacobian(0.3, 0.2, q2)
    np.testing.assert_allclose(
        (j11 * axial + j21 * across, j12 * axial + j22 * across),
        tip_torque(0.3, 0.2, q1, q2, c * axial - s * across, s * axial + c * across), atol=1e-12)


def test_decoupled_links_do_not_feel_each_other():
    loose = INERTIA._replace(coupled=0.0)
    np.testing.assert_array_equal(matrix(loose, 1.0), np.diag([INERTIA.p1, INERTIA.p2]))
    assert coriolis(loose, 1.0, 2.0, 3.0) == (0.0, 0.0)


def test_one_link_is_an_inertia():
    one = Inertia(0.876, 0.0, 0.0, 2.0, 0.0, 1.0)
    assert mass_matrix(one, 0.4)[0] == 0.876
    assert tip_torque(0.15, 0.0, 0.5 * np.pi, 0.0, -2.0, 1.0)[0] == pytest.approx(0.3)
    assert gravity_torque(one, 9.81, 0.5 * np.pi, 0.0, 0.0)[0] == pytest.approx(2.0 * 9.81)


def test_scalars_equal_arrays():
    elbow, dq1, dq2 = np.linspace((-3.0, 1.0, -1.0), (3.0, 2.0, 1.0), 7).T
    one_by_one = [(*mass_matrix(INERTIA, e), *coriolis(INERTIA, e, a, b),
                   momentum_drift(INERTIA, e, a, b)) for e, a, b in zip(elbow, dq1, dq2)]
    at_once = (*mass_matrix(INERTIA, elbow), *coriolis(INERTIA, elbow, dq1, dq2),
               momentum_drift(INERTIA, elbow, dq1, dq2))
    np.testing.assert_array_equal(np.stack(at_once, axis=1), one_by_one)

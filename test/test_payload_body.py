"""A payload that is a body: as other programs have it, and named with its centre and inertia."""

from dataclasses import replace

from hda_arm_sim.foundation import chain as of
from hda_arm_sim.foundation.rigid import mass_matrix
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.chain_links import ChainLinks, kept
from hda_arm_sim.model.effects import Payload
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.model.link_side import loaded_inertia
from hda_arm_sim.model.parts import Joint, Tolerances
from hda_torque_estimator.diagnosis.findings.report import FittedNumber
from hda_torque_estimator.diagnosis.fitting.hypotheses import terms_of
from hda_torque_estimator.diagnosis.fitting.nuisance import nuisances
from hda_torque_estimator.diagnosis.reporting.summary import cause_sentence
from hda_torque_estimator.estimating.estimator import compiled_settings, EstimatorSettings
from hda_torque_estimator.least_squares.charts import CarriedMoments
from hypothesis import given, strategies as st
import numpy as np
import pinocchio
import pytest
from test_chain import chain_to, GRAVITY, robots
from truth import worlds
from world_fits import diagnosed

ARM, COBOT = read_arm('hda_arm.yaml'), read_arm('cobot7.yaml')
BODY_IN_PLANE = Payload(mass=1.7, x=0.03, radius=0.05)
BODY = Payload(mass=1.7, x=0.03, y=-0.06, z=0.11, radius=0.05)
CLOSE = {'rtol': 0.0, 'atol': 1e-10}


@pytest.mark.parametrize(('text', 'tip'), robots())
def test_a_body_at_the_tip_equals_another_program(text, tip):
    names = chain_to(text, tip)
    arm = Arm(tuple(Joint(label=name) for name in names), ChainLinks(kept(text), tip, names))
    parts = loaded_inertia(arm.with_effect(BODY).record().body).table
    parts[0, of.DOWN:of.DOWN + 3] = GRAVITY
    whole = pinocchio.buildModelFromXML(text)
    other = pinocchio.buildReducedModel(
        whole, [whole.getJointId(name) for name in whole.names[1:] if name not in names],
        pinocchio.neutral(whole))
    frame = other.frames[other.getFrameId(tip, pinocchio.FrameType.BODY)]
    other.appendBodyToJoint(frame.parentJoint, pinocchio.Inertia(
        BODY.mass, np.array([BODY.x, BODY.y, BODY.z]),
        BODY.mass * BODY.radius ** 2 * np.eye(3)), frame.placement)
    work, other.gravity.linear = other.createData(), GRAVITY
    q, dq, ddq = np.random.default_rng(1).normal(size=(3, len(names)))
    given_q = pinocchio.neutral(other)
    for name, angle in zip(names, q):
        there = other.joints[other.getJointId(name)]
        given_q[there.idx_q:there.idx_q + there.nq] = (
            (np.cos(angle), np.sin(angle)) if there.nq == 2 else angle)
    c = parts.copy()
    c[1:-1, of.ANGLE:of.SPEEDING + 1] = np.stack([q, dq, ddq], axis=1)
    of.place(c)
    of.inverse_dynamics(c)
    torque, speeding = c[1:-1, of.TORQUE].copy(), np.zeros(len(names))
    np.testing.assert_allclose(torque, pinocchio.rnea(other, work, given_q, dq, ddq), **CLOSE)
    of.mass_matrix(c)
    full = pinocchio.crba(other, work, given_q)
    np.testing.assert_allclose(c[1:-1, of.MATRIX:of.MATRIX + len(names)],
                               np.triu(full) + np.triu(full, 1).T, **CLOSE)
    of.forward_dynamics(c, torque, speeding)
    np.testing.assert_allclose(speeding, ddq, **CLOSE)
    of.weights(c)
    np.testing.assert_allclose(
        c[1:-1, of.TORQUE], -pinocchio.computeGeneralizedGravity(other, work, given_q), **CLOSE)


@given(st.floats(0.1, 5.0), st.floats(-0.1, 0.1), st.floats(0.0, 0.2), st.floats(-3.0, 3.0))
def test_a_body_of_two_links_has_the_energy_of_its_centre_and_its_turn(mass, x, radius, elbow):
    """Half of v M v grows by the energy of the centre, and of the turn about it."""
    rate = np.array([0.7, -1.3])
    far, links = ARM.links.length2 + x, ARM.links
    energy = []
    for arm in (ARM, ARM.with_effect(Payload(mass=mass, x=x, radius=radius))):
        m11, m12, m22 = mass_matrix(loaded_inertia(arm.record().body), elbow)
        energy.append(0.5 * rate @ np.array([[m11, m12], [m12, m22]]) @ rate)
    turn = rate.sum()
    centre = np.array([-far * np.sin(elbow) * turn,
                       links.length1 * rate[0] + far * np.cos(elbow) * turn])
    assert energy[1] - energy[0] == pytest.approx(
        0.5 * mass * (centre @ centre + radius ** 2 * turn ** 2), abs=1e-12)


@pytest.mark.parametrize('arm', [ARM, COBOT])
def test_a_point_is_looked_for_first_and_then_a_body_that_costs_more(arm):
    point, centred, body = terms_of(arm, 'payload')
    assert point.free == ('mass',)
    assert centred.free == ('mass', 'radius')
    spatial = ('y', 'z') if isinstance(arm.links, ChainLinks) else ()
    assert body.free == ('mass', 'x', *spatial, 'radius')
    assert all(0.0 < within(arm.links) < 1.0 for within in Payload.hypothesis.within.values())


def test_a_body_is_looked_for_by_its_moments():
    chart = CarriedMoments(('mass', 'x', 'radius'), 0.5)
    body = Payload(mass=2.0, x=-0.1, radius=0.3)
    assert chart.unknowns(body) == pytest.approx((2.0, -0.2, 0.2))
    assert chart.numbers(chart.unknowns(body)) == pytest.approx(
        {'mass': 2.0, 'x': -0.1, 'radius': 0.3})
    assert chart.numbers([2.0, 0.2, -1.0]) == {'mass': 2.0, 'x': 0.1, 'radius': 0.0}
    assert chart.numbers([2.0, 0.2, 0.01]) == {'mass': 2.0, 'x': 0.1, 'radius': 0.0}
    assert chart.numbers([0.0, 0.2, 0.1]) == {'mass': 0.0, 'x': 0.0, 'radius': 0.0}


@given(st.floats(0.3, 3.0), st.floats(-0.2, 0.2), st.floats(0.02, 0.3), st.integers(0, 99))
def test_how_unsure_a_body_is_follows_from_its_moments(mass, x, radius, seed):
    """The linear propagation of differences, which the chart has in closed form."""
    body = Payload(mass=mass, x=x, radius=radius)
    chart = CarriedMoments(('mass', 'x', 'radius'), 0.5)
    half = 1e-3 * np.random.default_rng(seed).standard_normal((3, 3))
    covariance, moments = half @ half.T, np.array(chart.unknowns(body))
    slopes = np.zeros((3, 3))
    for place, step in enumerate(1e-6 * np.eye(3)):
        near, far = (chart.numbers(moments + way * step) for way in (-1.0, 1.0))
        slopes[:, place] = [(far['mass'] - near['mass']), (far['x'] - near['x']),
                            (far['radius'] ** 2 - near['radius'] ** 2)]
    slopes /= 2e-6
    np.testing.assert_allclose(chart.deviations(body, covariance), np.sqrt(np.diag(
        slopes @ covariance @ slopes.T)), rtol=1e-3, atol=1e-12)
    low, high = chart.ends(body, 'radius', 0.5 * radius ** 2)
    assert (low, high) == pytest.approx((np.sqrt(0.5) * radius, np.sqrt(1.5) * radius))


@pytest.mark.parametrize('arm', [ARM, COBOT])
def test_a_stated_payload_is_known_to_its_tolerance(arm):
    carrying = replace(arm.with_effect(Payload(mass=2.0, x=0.1)),
                       tolerances=Tolerances(carried_load=0.05))
    term = nuisances(carrying)[-1]
    assert (term.place, term.free) == (('payload', None), ('mass', 'x'))
    np.testing.assert_allclose(term.deviations(), [0.1, 0.005])
    assert ('payload', None) not in {each.place for each in nuisances(arm)}


def test_the_estimator_knows_the_links_no_better_than_what_they_carry():
    known = [compiled_settings(replace(arm, tolerances=Tolerances(carried_load=0.2)),
                               EstimatorSettings())
             for arm in (ARM, ARM.with_effect(BODY_IN_PLANE), COBOT, COBOT.with_effect(BODY))]
    assert known[1].inertia_tolerance == 0.2 > known[0].inertia_tolerance
    changed = known[3].links_known != known[2].links_known
    assert changed[-1].tolist() == [True, False, True]
    assert not changed[:-1].any()


def test_a_body_is_told_in_words():
    def number(value, unit):
        return FittedNumber(value, unit, 0.9 * value, 1.1 * value)

    said = cause_sentence('payload', None, {
        'mass': number(0.8, 'kg'), 'x': number(0.03, 'm'), 'radius': number(0.05, 'm')})
    assert said == ('the arm carries 0.8 kg more at its tip, its centre 30 mm along x, '
                    'a radius of gyration of 50 mm')
    assert cause_sentence('payload', None, {'mass': number(0.8, 'kg')}) == (
        'the arm carries 0.8 kg more at its tip')


def test_a_payload_that_is_no_point_is_named_with_its_inertia():
    world = worlds.draw(630172, ('payload',), motion='trapezoid', rate=1000)
    hidden, = world.hidden
    assert hidden.form == 'own_inertia'
    said = diagnosed(world)
    assert said.verdict == 'explained'
    found, = said.findings
    assert found.effect == 'payload'
    assert found.parameters['mass'].value == pytest.approx(hidden.parameters['mass'], rel=0.1)
    assert found.parameters['radius'].low > 0.0

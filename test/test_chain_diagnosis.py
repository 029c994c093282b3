"""Arms of many joints are diagnosed: the balances of a chain, and what seven joints show."""

from dataclasses import replace

from chains import planar
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.chain_links import ChainLinks, kept
from hda_arm_sim.model.effects import (Backlash, BaseTilt, BaseVibration, CoulombFriction, Effect,
                                       ExternalContact, LinkInertiaError, Payload)
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.model.link_numbers import LinkTolerance
from hda_arm_sim.model.parts import Encoder, Joint, Links
from hda_arm_sim.model.typical_sizes import typical
from hda_arm_sim.motions import motion, motion_of
from hda_torque_estimator.diagnosis.balances.balance import Balancer
from hda_torque_estimator.diagnosis.balances.healthy_twin import noise_of
from hda_torque_estimator.diagnosis.balances.predict import prediction_errors
from hda_torque_estimator.diagnosis.balances.reversals import turning_round
from hda_torque_estimator.diagnosis.diagnose import diagnose
from hda_torque_estimator.diagnosis.fitting.fit import Fitter
from hda_torque_estimator.diagnosis.fitting.hypotheses import terms_of
from hda_torque_estimator.diagnosis.fitting.nuisance import nuisances
from hda_torque_estimator.diagnosis.fitting.starting_points import contact_in
from hda_torque_estimator.measurements.measurement import Measurement
from hda_torque_estimator.simulating.closed_loop import run
import numpy as np
import pytest

PAIR = Links(length1=0.3, length2=0.2, p1=2.0, p2=0.35, p3=0.3, first=4.0, second=1.0)
JOINTS = tuple(Joint(label=f'joint{j}', dry_friction=0.03, motor_encoder=Encoder(65536.0),
                     link_encoder=Encoder(8e6)) for j in (1, 2))
FLAT = Arm(JOINTS, PAIR)
SPACE = replace(FLAT, links=ChainLinks(kept(planar(PAIR)), 'tip', ('joint1', 'joint2')))
COBOT = read_arm('cobot7.yaml')
ON_BOTH = {
    'nothing': (), 'tilt': (BaseTilt(tilt=0.4, direction=0.7),), 'payload': (Payload(mass=2.0),),
    'base': (BaseVibration(frequency=9.0, amplitude=0.02, direction=0.5, damping=0.05),)}


def recorded(true: Arm, known: Arm, duration: float, seed: int, dt: float = 1e-3) -> Measurement:
    """Return a recording of an arm, moved by who knows another."""
    asked = (motion_of(known, 'rich', duration, dt, seed) if len(known.joints) > 2 else
             motion('rich', 2, duration, dt, seed))
    made = run(true, known, asked, seed, estimator=None)
    return Measurement(known.labels, dt, np.ascontiguousarray(made.reading[:, :, :2]),
                       made.command)


def on_both(effects: tuple[Effect, ...]) -> tuple[Arm, Arm]:
    """Return two links in a plane and as a chain, with effects."""
    flat, space = FLAT, SPACE
    for effect in effects:
        flat, space = flat.with_effect(effect), space.with_effect(effect)
    return flat, space


@pytest.mark.parametrize('name', ON_BOTH)
def test_the_balances_of_a_chain_in_a_plane_are_those_of_two_links(name):
    flat, space = on_both(ON_BOTH[name])
    balancer = Balancer(recorded(FLAT, FLAT, 6.0, 3))
    of_flat, of_space = balancer(flat), balancer(space)
    np.testing.assert_allclose(of_space.residual, of_flat.residual, atol=1e-7)
    assert (of_flat.valid == of_space.valid).all()
    spans = ((1.0, 3.0),)
    np.testing.assert_allclose(prediction_errors(balancer, space, spans),
                               prediction_errors(balancer, flat, spans), rtol=1e-4, atol=1e-16)


def test_a_wrong_load_shows_in_both_balances_alike_and_a_right_one_in_none():
    heavy = COBOT.with_effect(Payload(mass=1.0))
    balancer = Balancer(recorded(heavy, COBOT, 10.0, 4))
    noise, known, missed = noise_of(balancer, heavy)[0], balancer(heavy), balancer(COBOT)
    for joint in range(5):
        good = known.valid[:, joint]
        assert known.residual[good, joint].std() < 2.0 * noise[joint]
        assert missed.residual[good, joint].std() > 10.0 * noise[joint]
        np.testing.assert_allclose(missed.residual[good, joint], missed.residual[good, 7 + joint],
                                   atol=8.0 * (noise[joint] + noise[7 + joint]))


def test_what_is_not_known_of_links_is_no_cause():
    """Mass and centre of each link may differ as their tolerances say, stated or not."""
    links = replace(COBOT.links, tolerances=(
        None, LinkTolerance(mass=0.05, centre=0.004, inertia=0.1), *5 * [None]))
    found = {term.place: term for term in nuisances(replace(COBOT, links=links))
             if term.name == 'link_inertia_error'}
    assert [place[1] for place in found] == list(COBOT.labels)
    reported = found['link_inertia_error', 'joint2']
    assert dict(zip(reported.free, reported.deviations())) == {
        'error': 0.1, 'mass': 0.05, 'centre_x': 0.004, 'centre_y': 0.004, 'centre_z': 0.004}
    usual = COBOT.links.known(0.01)[2].centre
    assert 0.0003 < usual < 0.003               # a hundredth of 3 to 30 cm
    assert dict(zip(found['link_inertia_error', 'joint3'].free,
                    found['link_inertia_error', 'joint3'].deviations())) == {
        'error': 0.01, 'mass': 0.01, 'centre_x': usual, 'centre_y': usual, 'centre_z': usual}
    starts = [term.free for term in terms_of(COBOT, 'link_inertia_error')
              if term.joint == 'joint3']
    assert starts == [('error',), ('mass',)]


def test_links_within_their_tolerance_leave_no_rest():
    """Masses off by 1 % leave many times the noise, until they are fitted."""
    true = COBOT
    for label, size in zip(COBOT.labels, (1.0, -1.2, 0.8, 1.3, -0.7, 1.1, -0.9)):
        true = true.with_effect(LinkInertiaError(mass=0.01 * size), label)
    balancer = Balancer(recorded(true, COBOT, 12.0, 5))
    noise = noise_of(balancer, COBOT)[0]
    rows = np.ones(len(balancer.time), bool)
    fit = Fitter(balancer, COBOT, noise, 0.5, rows).first
    before, after = balancer(COBOT), fit.balance
    joint = 1                                                   # that bears the weight
    good = before.valid[:, joint] & after.valid[:, joint]
    left, found = (float((each.residual[good, joint] ** 2).mean()) for each in (after, before))
    assert found > 25.0 * left
    reported = {term.joint: term.effect.mass for term in fit.nuisance
                if term.name == 'link_inertia_error'}
    assert reported['joint4'] == pytest.approx(0.013, abs=0.008)


def test_short_stops_of_light_wrists_are_not_friction_that_builds_up():
    for seed, presliding in ((8, False), (11, True)):
        true = COBOT
        if presliding:
            true = COBOT.with_effect(typical(COBOT, 'presliding_friction', 'joint6'), 'joint6')
        balancer = Balancer(recorded(true, COBOT, 60.0, seed))
        found = turning_round(balancer, COBOT, noise_of(balancer, COBOT)[0])
        assert found == ((5,) if presliding else ())


@pytest.mark.parametrize(('effect', 'joint'), [
    (None, None), pytest.param('kinematic_error', 'joint5', marks=pytest.mark.study),
    pytest.param('payload', None, marks=pytest.mark.study)])
def test_what_is_wrong_with_seven_joints_is_reported_with_its_joint(effect, joint):
    true = COBOT if effect is None else COBOT.with_effect(typical(COBOT, effect, joint), joint)
    said = diagnose(recorded(true, COBOT, 30.0, 102), COBOT).diagnosis
    assert [(one.effect, one.joint) for one in said.findings] == (
        [] if effect is None else [(effect, joint)])
    assert any('inertial_coupling' in remark for remark in said.remarks)
    assert said.verdict == ('no_discrepancy' if effect is None else 'explained')


@pytest.mark.study
def test_what_an_elbow_with_play_makes_the_shoulder_leave_is_no_rest():
    true = COBOT.with_effect(Backlash(half_width=3e-4), 'joint4')
    said = diagnose(recorded(true, COBOT, 30.0, 5), COBOT, names=['backlash']).diagnosis
    assert [(one.effect, one.joint) for one in said.findings] == [('backlash', 'joint4')]
    assert said.verdict == 'explained'


def test_weight_and_friction_within_tolerances_build_up_at_no_turn():
    """By the arm as stated joints seem to, by the one that its tolerances allow none does."""
    true = COBOT
    for label, size in zip(COBOT.labels, (1.0, -1.2, 0.8, 1.3, -0.7, 1.1, -0.9)):
        friction = (1.0 + 0.005 * size) * COBOT.joint(label).dry_friction
        true = true.with_effect(LinkInertiaError(mass=0.01 * size), label).with_effect(
            CoulombFriction(level=friction), label)
    balancer = Balancer(recorded(true, COBOT, 20.0, 900))
    noise = noise_of(balancer, COBOT)[0]
    assert turning_round(balancer, COBOT, noise)
    fitter = Fitter(balancer, COBOT, noise, 0.5, np.ones(len(balancer.time), bool))
    assert not turning_round(balancer, fitter.on(fitter.first.terms), noise)


def test_weight_that_is_off_hides_no_friction_that_builds_up():
    """By the arm as stated, what is left elsewhere is too loud to identify it."""
    true = COBOT.with_effect(typical(COBOT, 'presliding_friction', 'joint4'), 'joint4')
    for label, size in zip(COBOT.labels, (1.0, -1.2, 0.8, 1.3, -0.7, 1.1, -0.9)):
        true = true.with_effect(LinkInertiaError(mass=0.01 * size), label)
    balancer = Balancer(recorded(true, COBOT, 20.0, 900))
    noise = noise_of(balancer, COBOT)[0]
    assert turning_round(balancer, COBOT, noise) == ()
    fitter = Fitter(balancer, COBOT, noise, 0.5, np.ones(len(balancer.time), bool))
    assert turning_round(balancer, fitter.on(fitter.first.terms), noise) == (3,)


def test_bristles_are_named_with_their_damping():
    """Their stiffness alone leaves a rest where they damp, and is estimated too large."""
    hidden = typical(SPACE, 'presliding_friction', 'joint1')
    true = SPACE.with_effect(hidden, 'joint1').with_effect(LinkInertiaError(mass=0.01), 'joint2')
    said = diagnose(recorded(true, SPACE, 20.0, 4), SPACE, names=[
        'presliding_friction', 'stribeck_friction', 'coulomb_friction']).diagnosis
    (found,) = said.findings
    assert (found.effect, found.joint) == ('presliding_friction', 'joint1')
    assert found.parameters['stiffness'].value == pytest.approx(hidden.stiffness, rel=0.25)
    assert found.parameters['damping'].value == pytest.approx(hidden.damping, rel=0.25)


def test_a_touch_on_the_tip_of_a_chain_is_located():
    """Where none is, none is found; one is found with its force in space and its time."""
    touch = ExternalContact(force=25.0, direction=0.7, elevation=0.9, onset=6.0, duration=1.0)
    force = 25.0 * np.array([np.cos(0.9) * np.cos(0.7), np.cos(0.9) * np.sin(0.7), np.sin(0.9)])
    noise = None
    for true, touched in ((COBOT, False), (COBOT.with_effect(touch), True)):
        balancer = Balancer(recorded(true, COBOT, 12.0, 6))
        balance = balancer(COBOT)
        noise = noise_of(balancer, COBOT)[0] if noise is None else noise
        found = contact_in(balancer, COBOT, balance.residual - np.median(balance.residual, axis=0),
                           balance.valid, noise)
        assert (found is not None) == touched
    np.testing.assert_allclose(found.force, force, atol=4.0)
    assert abs(found.onset - 6.0) < 0.15 and abs(found.duration - 1.0) < 0.3

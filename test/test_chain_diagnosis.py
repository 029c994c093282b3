"""Arms of many joints are diagnosed: the balances of a chain, and what seven joints tell."""

from dataclasses import replace

from chains import planar
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.chain_links import ChainLinks, kept
from hda_arm_sim.model.effects import BaseTilt, BaseVibration, Effect, Payload
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.model.parts import Encoder, Joint, Links
from hda_arm_sim.model.typical_sizes import typical
from hda_arm_sim.motions import motion, motion_of
from hda_torque_estimator.diagnosis.balances.balance import Balancer
from hda_torque_estimator.diagnosis.balances.healthy import noise_of
from hda_torque_estimator.diagnosis.balances.predict import prediction_errors
from hda_torque_estimator.diagnosis.balances.reversals import turning_round
from hda_torque_estimator.diagnosis.diagnose import diagnose
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
    assert (of_flat.valid | ~of_space.valid).all()      # a chain's shafts turn round in a sample
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


def test_short_stops_of_light_wrists_are_not_friction_that_builds_up():
    for seed, presliding in ((8, False), (11, True)):
        true = COBOT
        if presliding:
            true = COBOT.with_effect(typical(COBOT, 'presliding_friction', 'joint6'), 'joint6')
        balancer = Balancer(recorded(true, COBOT, 60.0, seed))
        found = turning_round(balancer, COBOT, noise_of(balancer, COBOT)[0])
        assert found == ((5,) if presliding else ())


@pytest.mark.parametrize(('effect', 'joint'), [
    (None, None), ('kinematic_error', 'joint5'),
    pytest.param('payload', None, marks=pytest.mark.study)])
def test_what_is_wrong_with_seven_joints_is_told_with_its_joint(effect, joint):
    true = COBOT if effect is None else COBOT.with_effect(typical(COBOT, effect, joint), joint)
    said = diagnose(recorded(true, COBOT, 15.0, 102), COBOT).diagnosis
    assert [(one.effect, one.joint) for one in said.findings] == (
        [] if effect is None else [(effect, joint)])
    assert any('external_contact' in remark for remark in said.remarks)
    assert said.verdict == ('no_discrepancy' if effect is None else 'explained')

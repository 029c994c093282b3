"""A recording in other conventions is no imperfect joint: one sentence says so."""

from dataclasses import replace

from hda_arm_sim.model.effects import LinkEncoderEccentricity
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.model.parts import Encoder, Joint
from hda_arm_sim.motions import motion_of
from hda_torque_estimator.measurements.conventions import (check_conventions, ConventionError,
                                                           disc_slope, wrong_convention)
from hda_torque_estimator.samples import coupling
from hda_torque_estimator.simulating.closed_loop import run
from hypothesis import given, settings, strategies as st
import numpy as np
import pytest

ARM = read_arm('hda_arm.yaml')
TIME = 1e-3 * np.arange(12_000)


def joint_of(ratio: float = 100.0) -> Joint:
    """Return a joint of the shipped arm with another gear."""
    return replace(ARM.joints[0], ratio=ratio)


def moved(ratio: float, reach: float, load: float = 20.0) -> tuple[np.ndarray, ...]:
    """Return motor, link [rad] and motor torque [N*m] of a joint that bears its own weight."""
    link = reach * np.sin(0.9 * TIME)
    torque = load * np.sin(link + 0.3)
    sense = np.sign(np.cos(0.9 * TIME))
    return ratio * (link + torque / 9743.9), link, torque / ratio + 0.03 * sense


WRONG = [
    (lambda motor, link, torque: (-motor, link, torque), 'the sign of one encoder is wrong'),
    (lambda motor, link, torque: (motor, -link, torque), 'the sign of one encoder is wrong'),
    (lambda motor, link, torque: (np.degrees(motor), link, torque), 'motor angle is in degrees'),
    (lambda motor, link, torque: (motor, np.degrees(link), torque), 'link angle is in degrees'),
    (lambda motor, link, torque: (motor / 3.0, link, torque), 'the ratio is wrong'),
    (lambda motor, link, torque: (motor, 0.0 * link, torque), 'the ratio is wrong')]


@pytest.mark.parametrize('ratio', [50.0, 100.0, 160.0])
@pytest.mark.parametrize('reach', [0.05, 0.4, 2.5])
@pytest.mark.parametrize(('spoil', 'said'), WRONG)
def test_other_conventions_are_named(spoil, said, reach, ratio):
    wrong = wrong_convention(joint_of(ratio), *spoil(*moved(ratio, reach)))
    assert wrong is not None and said in wrong.words


@pytest.mark.parametrize('load', [0.0, 20.0])
@pytest.mark.parametrize('reach', [0.4, 2.5])
def test_motor_torques_with_the_other_sign_are_named(reach, load):
    motor, link, torque = moved(100.0, reach, load)
    wrong = wrong_convention(joint_of(), motor, link, -torque)
    assert wrong is not None and 'motor torques have the wrong sign' in wrong.words
    assert wrong_convention(joint_of(), motor, link, torque) is None


def pushed(sign: float = 1.0) -> tuple[np.ndarray, ...]:
    """Return a joint that a hand moves: its motor gives way, and brakes whenever it turns."""
    link = 0.5 * np.sin(0.9 * TIME) + 0.2 * np.sin(2.3 * TIME)
    rate = np.gradient(link, TIME)
    torque = -20.0 * rate + 8.0 * np.sin(3.7 * TIME)
    return 100.0 * (link + torque / 9743.9), link, sign * (torque / 100.0 + 0.03 * np.sign(rate))


def test_a_joint_that_a_hand_moves_is_not_accused():
    """Its motor brakes either way, but its gear twists the way that the motor pulls."""
    assert wrong_convention(joint_of(), *pushed()) is None
    wrong = wrong_convention(joint_of(), *pushed(-1.0))
    assert wrong is not None and 'its gear twists against its motor' in wrong.words


@pytest.mark.parametrize('reach', [0.3, 1.0, 2.5])
def test_a_coarse_encoder_may_be_bent_further(reach):
    """Magnetic encoders of 12 bits err by half a degree over their turn."""
    coarse = replace(joint_of(), link_encoder=Encoder(counts=4096))
    arm = replace(ARM, joints=(coarse, ARM.joints[1]))
    motor, link, torque = moved(100.0, reach)
    bent = link + 8e-3 * np.sin(link - 1.0)
    assert wrong_convention(coarse, motor, bent, torque, disc_slope(arm, 0)) is None
    assert disc_slope(ARM, 0) < 1e-3
    known = ARM.with_effect(LinkEncoderEccentricity(amplitude_1=7e-3), 'joint1')
    assert disc_slope(known, 0) == pytest.approx(7e-3, rel=0.1)


@pytest.mark.parametrize('ratio', [50.0, 100.0, 160.0])
def test_motor_angles_at_the_link_are_named(ratio):
    motor, link, torque = moved(ratio, 1.0)
    wrong = wrong_convention(joint_of(ratio), -motor / ratio, link, torque)
    assert wrong is not None
    assert wrong.options == '--motor-at-link --flip joint1_motor or --flip joint1'


@pytest.mark.parametrize('ratio', [50.0, 80.0, 100.0])
def test_a_gear_with_one_tooth_more_is_another_ratio(ratio):
    wrong = wrong_convention(joint_of(ratio), *moved(ratio + 1.0, 2.0, 5.0))
    assert wrong is not None and 'correct "ratio"' in wrong.words


@settings(max_examples=60, deadline=None)
@given(ratio=st.sampled_from([30.0, 50.0, 100.0, 121.0, 160.0]), reach=st.floats(0.001, 3.0),
       load=st.floats(0.0, 20.0), bend=st.floats(0.0, 3e-3), phase=st.floats(0.0, 6.28),
       scale=st.floats(-3e-3, 3e-3))
def test_a_right_joint_with_a_bent_encoder_is_accepted(ratio, reach, load, bend, phase, scale):
    motor, link, torque = moved(ratio, reach, load)
    bent = link + bend * np.sin(link + phase)
    for shown in (bent, link * (1.0 + scale)):
        assert wrong_convention(joint_of(ratio), motor, shown, torque) is None


@pytest.mark.parametrize('spoil', [1e300, np.nan, np.inf, 40.0])
def test_an_absurd_reading_or_a_slip_is_no_other_convention(spoil):
    motor, link, torque = moved(100.0, 1.0)
    link[5000] = spoil
    motor[9000:] += 0.5
    assert wrong_convention(joint_of(), motor, link, torque) is None


def test_what_cannot_decide_is_accepted():
    motor, link, torque = moved(100.0, 0.005)
    for shown in (motor, -motor, 0.0 * motor):
        assert wrong_convention(joint_of(), shown, link, np.full_like(torque, np.nan)) is None


def test_a_load_that_only_goes_down_drives_its_motor():
    link = 0.2 * TIME
    motor, torque = 100.0 * link, np.full_like(link, -0.2)
    assert wrong_convention(joint_of(), motor, link, torque) is None


def test_the_sentence_names_the_recording():
    motor, link, torque = moved(100.0, 1.0)
    reading = np.stack([np.stack([motor, link], 1)] * 2, 1)
    reading[:, 1, 0] *= -1.0
    with pytest.raises(ConventionError, match='^bag: joint2: its motor turns -100.* times per '
                       'turn of the link where the arm file says 100: the sign of one encoder'):
        check_conventions(ARM, reading, np.stack([torque] * 2, 1), 'bag')


@pytest.mark.parametrize(('sign', 'kind'), [(1.0, coupling.RIGHT), (-1.0, coupling.FLIPPED)])
def test_running_sums_give_the_same_sample_by_sample(sign, kind):
    motor, link, _ = moved(100.0, 0.5)
    memory = np.zeros(coupling.MEMORY)
    reported = [coupling.add(memory, *each, 100.0, 0.005) for each in zip(sign * motor, link)]
    assert reported[-1] == kind
    assert sign > 0.0 and not any(reported) or reported.index(kind) < 100


@settings(max_examples=60, deadline=None)
@given(still=st.integers(0, 3000), rate=st.floats(0.05, 3.0), twist=st.floats(1e-4, 0.02),
       waves=st.floats(0.0, 40.0), phase=st.floats(0.0, 6.28))
def test_a_joint_that_sets_off_is_no_other(still, rate, twist, waves, phase):
    """Most of a stretch at rest, then a fast move whose torsion swings through its whole range."""
    link = np.r_[np.zeros(still), np.arange(0.0, 1.0, rate * 1e-3)]
    torsion = twist * np.sign(np.sin(waves * link + phase))
    memory = np.zeros(coupling.MEMORY)
    reported = [coupling.add(memory, *each, 100.0, twist) for each in zip(
        100.0 * (link + torsion), link)]
    assert set(reported) == {coupling.RIGHT}


@pytest.mark.parametrize('friction', [0.0, 0.05])
def test_joints_of_a_chain_that_hand_on_energy_are_not_accused(friction):
    """Without friction only inertia shows the sign; with friction a wrong one is still found."""
    cobot = read_arm('cobot7.yaml')
    cobot = replace(cobot, effects=(), joints=tuple(
        replace(joint, dry_friction=friction, viscous_friction=0.0) for joint in cobot.joints))
    made = run(cobot, cobot, motion_of(cobot, 'sine', 5.0, 1e-3, 0), 0, estimator=None)
    check_conventions(cobot, made.reading, made.command, 'bag')
    if friction:
        with pytest.raises(ConventionError, match='the wrong sign'):
            check_conventions(cobot, made.reading, -made.command, 'bag')

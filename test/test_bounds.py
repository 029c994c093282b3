"""Whatever is wrong with zero, stiffness or motor torque, no torque runs away from the motor's."""

from dataclasses import replace
from functools import cache

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import motion
from hda_torque_estimator.estimating.belief_words import doubts_in_words
from hda_torque_estimator.estimating.estimates import Estimates
from hda_torque_estimator.estimating.estimator import Estimator, EstimatorSettings
from hda_torque_estimator.estimating.laws import layout
from hda_torque_estimator.estimating.laws.agreement import cut_off
from hda_torque_estimator.simulating.closed_loop import ClosedLoopRun, run
from hypothesis import given, settings, strategies as st
import numpy as np
import pytest

ARM = read_arm('hda_arm.yaml')
WINDOW = 20                     # samples over which the motor's acceleration is taken
Array = np.ndarray


@cache
def moving(path: str) -> ClosedLoopRun:
    """Return five seconds of a healthy arm."""
    return run(ARM, ARM, motion(path, 2, 5.0, 1e-3, 4), 4)


def wrong(softer: float, sure: float = 1.0, held: float = 1.0) -> Arm:
    """Return the arm with another stiffness of joint1, surer by a factor, and at rest."""
    torsion = ARM.joints[0].torsion
    return replace(ARM, joints=(replace(
        ARM.joints[0], deviation_factor=sure, held_share=held, torsion=replace(
            torsion, flexspline_stiffness=torsion.flexspline_stiffness * softer)),
        ARM.joints[1]))


def estimated(arm: Arm, zero: float, command: Array, path: str, **chosen: float) -> Estimates:
    """Return the estimates with a link encoder whose zero is another [rad]."""
    reading = moving(path).reading.copy()
    reading[:, 0, 1] += zero
    stamps = np.arange(1, len(reading) + 1) * 1_000_000
    return Estimator(arm, EstimatorSettings(**chosen)).run(stamps, reading, command)


def allowed(command: Array, path: str) -> tuple[Array, Array]:
    """
    Return what joint1's motor gives its gear without dry friction (k,), and how much that may be.

    The least and the most of what it gave in the last samples: no estimate knows it sooner.
    """
    joint, angle = ARM.joints[0], moving(path).reading[:, 0, 0]
    speed = np.gradient(np.convolve(np.pad(angle, WINDOW // 2, 'edge'),
                                    np.full(WINDOW + 1, 1.0 / (WINDOW + 1)), 'valid'), 1e-3)
    gives = joint.ratio * (command[:, 0] - joint.motor_inertia * np.gradient(speed, 1e-3))
    around = np.lib.stride_tricks.sliding_window_view(
        np.pad(gives, (2 * WINDOW, WINDOW), 'edge'), 3 * WINDOW + 1)
    friction = joint.ratio * (2.0 * joint.dry_friction + joint.viscous_friction * np.abs(speed))
    return around.min(axis=1) - friction, around.max(axis=1) + friction


@settings(max_examples=40, deadline=None)
@given(zero=st.floats(-0.02, 0.02), softer=st.floats(1.0 / 3.0, 3.0),
       constant=st.floats(0.3, 3.0), sign=st.sampled_from([1.0, -1.0]),
       path=st.sampled_from(['rich', 'sine', 'standstill']), sure=st.floats(0.01, 10.0),
       held=st.floats(0.0, 1.0))
def test_no_torque_is_further_from_what_a_motor_allows_than_three_deviations(
        zero, softer, constant, sign, path, sure, held):
    """Every single torque, from the first sample on, believed or not, however sure a file is."""
    command = sign * constant * moving(path).command
    found = estimated(wrong(softer, sure, held), zero, command, path)
    least, most = allowed(command, path)
    torque, doubt = found.torque[:, 0], 3.0 * found.torque_deviation[:, 0]
    assert np.isfinite(torque).all() and np.isfinite(doubt).all()
    assert (torque >= least - doubt).all() and (torque <= most + doubt).all()
    assert np.abs(torque).max() < 3.0 * ARM.joints[0].torsion.valid_torque


@pytest.mark.parametrize('zero', [-0.02, 0.0044, 0.02])
def test_a_zero_is_learnt_within_half_a_second_of_motion(zero):
    found = estimated(ARM, zero, moving('sine').command, 'sine')
    off = np.abs(found.torque - moving('sine').joint_torque)[:, 0]
    assert off[1000:].max() < 4.0
    assert off[3000:].mean() < 0.25
    assert found.joints[-1, 0, layout.ZERO_TAKEN] == pytest.approx(-zero, abs=5e-5)
    assert (off < 3.3 * found.torque_deviation[:, 0])[1500:].mean() > 0.9


def test_a_zero_is_confined_at_rest():
    """Standing still the motor shows no more than its dry friction leaves open."""
    found = estimated(ARM, 0.0044, moving('standstill').command, 'standstill')
    off = np.abs(found.torque - moving('standstill').joint_torque)[:, 0]
    friction = ARM.joints[0].ratio * ARM.joints[0].dry_friction
    assert off[500:].max() < 3.0 * friction
    assert (off < 3.0 * found.torque_deviation[:, 0])[500:].all()


def test_two_witnesses_that_no_zero_reconciles_are_reported():
    found = estimated(ARM, 0.0, -moving('rich').command, 'rich')
    said = {words for row in np.unique(found.joints[:, :, layout.DOUBT], axis=0).tolist()
            for words in doubts_in_words(ARM.labels, row)}
    assert any(words.startswith('joint1: ') and 'motor' in words for words in said)


def test_a_zero_follows_the_motor_only_if_asked():
    stay, follow = (estimated(ARM, 0.0, moving('rich').command, 'rich', fusion_zero_follows=each)
                    for each in (0.0, 0.1))
    assert stay.torque_deviation[-1, 0] < follow.torque_deviation[-1, 0]


def test_a_normal_distribution_is_cut_off_as_samples_of_it_are():
    drawn = 1.0 + 2.0 * np.random.default_rng(3).standard_normal(400_000)
    kept = drawn[np.abs(drawn) < 1.5]
    mean, left = cut_off(1.0, 2.0, 1.5)
    assert mean == pytest.approx(kept.mean(), abs=5e-3)
    assert 4.0 * left == pytest.approx(kept.var(), rel=1e-2)
    assert cut_off(100.0, 0.1, 1.0) == (1.0, 0.0)
    assert cut_off(0.1, 0.2, 100.0) == pytest.approx((0.1, 1.0))

"""Torsion and motor torque correct each other, and only where they can."""

from dataclasses import replace
from functools import cache

from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import motion
from hda_torque_estimator.estimating.estimates import Estimates
from hda_torque_estimator.estimating.estimator import Estimator, EstimatorSettings
from hda_torque_estimator.estimating.laws import fusion, fusion_memory, layout
from hda_torque_estimator.estimating.laws.route_errors import (
    DRY, ERRORS, torsion_effects, TORSION_ERRORS, ZERO)
import numpy as np
import pytest
from truth import record, Reference, TruthRecord
from truth_cases import hide

ARM = read_arm('hda_arm.yaml')
ALONE = EstimatorSettings(fusion=0.0)
LEARNING = 3000                 # samples after which the errors are found


@cache
def recorded(effect: str = '', *, path: str = 'rich', seed: int = 1, seconds: float = 15.0,
             **parameters: float) -> TruthRecord:
    """Return a recording of the independent truth, with an effect of joint1 if one is named."""
    made = motion(path, 2, seconds, 1e-3, seed)
    return record((hide(effect, **parameters),) if effect else (),
                  Reference(made.angle, made.rate, 1e-3), seed=seed)


def reading(seen: TruthRecord) -> np.ndarray:
    """Return the readings of a recording, without velocities."""
    unknown = np.full_like(seen.motor_angle, np.nan)
    return np.stack([seen.motor_angle, seen.link_angle, unknown, unknown], axis=2)


def estimates(seen: TruthRecord, settings: EstimatorSettings = EstimatorSettings(),
              arm=ARM) -> Estimates:
    """Return the estimates of a recording with its commands."""
    return Estimator(arm, settings).run(seen.stamps, reading(seen), seen.command)


def mean_error(seen: TruthRecord, settings: EstimatorSettings = EstimatorSettings(),
               arm=ARM) -> float:
    """Return the mean absolute error of the torques once the errors are found [N*m]."""
    error = estimates(seen, settings, arm).torque - seen.joint_torque
    return float(np.abs(error[LEARNING:]).mean())


def learnt(seen: TruthRecord, arm=ARM) -> np.ndarray:
    """Return the errors that a recording taught (n, ERRORS), in units of their sigma."""
    made = Estimator(arm)
    made.run(seen.stamps, reading(seen), seen.command)
    return made.memory[:, layout.FUSION + fusion.LEARNT:][:, :ERRORS]


def test_what_no_law_describes_is_in_every_interval_and_teaches_little():
    seen = recorded()
    doubtful = replace(ARM, joints=tuple(replace(
        joint, torsion=replace(joint.torsion, deviation=0.05)) for joint in ARM.joints))
    plain, doubted = (estimates(seen, ALONE, arm) for arm in (ARM, doubtful))
    assert (doubted.torque == plain.torque).all()
    assert doubted.torque_deviation ** 2 - plain.torque_deviation ** 2 == pytest.approx(2.5e-3)
    little, much = (np.abs(learnt(seen, arm)).sum() for arm in (doubtful, ARM))
    assert 0.0 < little < 0.7 * much


@pytest.mark.parametrize('settings', [ALONE, EstimatorSettings()])
def test_a_factor_of_all_deviations_changes_no_torque(settings):
    seen = recorded()
    known = replace(ARM, tolerances=replace(ARM.tolerances, torsion_zero=0.0))
    surer = replace(known, joints=tuple(replace(joint, deviation_factor=0.5)
                                        for joint in ARM.joints))
    plain, sure = (estimates(seen, settings, arm) for arm in (known, surer))
    assert (sure.torque == plain.torque).all()
    share = sure.torque_deviation / plain.torque_deviation
    assert (share > 0.5 - 1e-9).all()           # what both ways contradict has no share in it
    assert np.median(share) < 0.6 and (share < 1.0 + 1e-9).all()


def test_a_motor_is_weighed_by_what_no_law_describes():
    seen = recorded()
    coarse = replace(ARM, joints=tuple(replace(
        joint, link_encoder=replace(joint.link_encoder, counts=16384)) for joint in ARM.joints))
    shares = []
    for left in (0.0, 1.0, 100.0):
        arm = replace(coarse, joints=tuple(
            replace(joint, motor_deviation=left) for joint in coarse.joints))
        estimated, alone = (estimates(seen, how, arm) for how in (EstimatorSettings(), ALONE))
        shares.append(float(np.abs(estimated.torque - alone.torque)[LEARNING:].mean()))
    assert shares[0] > shares[1] > shares[2]


def slowed(seen: TruthRecord, every: int) -> TruthRecord:
    """Return a recording of which every so many samples are left; a drive logs mean torques."""
    count = len(seen.stamps) // every * every
    means = seen.command[:count].reshape(-1, every, seen.command.shape[1]).mean(axis=1)
    rest = {name: getattr(seen, name)[:count:every]
            for name in ('stamps', 'motor_angle', 'link_angle', 'joint_torque')}
    return seen._replace(command=means, **rest)


def test_what_no_law_describes_lasts_as_long_at_every_rate():
    """A zero is learnt in the same time at 1 kHz and at 100 Hz, not by as many windows."""
    arm = replace(ARM, tolerances=replace(ARM.tolerances, torsion_zero=1e-4), joints=tuple(
        replace(joint, motor_deviation=0.5) for joint in ARM.joints))
    sure = []
    for every in (1, 10):
        seen, made = slowed(recorded(), every), Estimator(arm)
        made.run(seen.stamps, reading(seen), seen.command)
        gain = fusion_memory.gained(made.memory[0, layout.FUSION:])
        sure.append(1.0 + float(gain[ZERO, ZERO]))
    assert sure[1] < 1.5 * sure[0]


def test_a_zero_that_nobody_knows_leaves_the_torque_to_the_motor():
    seen = recorded()
    arm = replace(ARM, tolerances=replace(ARM.tolerances, torsion_zero=6e-3))
    seen = seen._replace(link_angle=seen.link_angle + 6e-3)
    estimated = estimates(seen, arm=arm)
    standing = slice(1, 20)                     # the zero makes 60 N*m of the torsion
    assert np.abs(estimated.torque - seen.joint_torque)[standing].max() < 1.0
    assert estimated.torque_deviation[standing].max() < 3.0


def test_errors_that_both_ways_share_do_not_weigh():
    memory, effect = np.zeros(fusion_memory.MEMORY), np.linspace(-1.0, 1.0, ERRORS)
    whole, first = fusion_memory.errors_apart(memory, effect)
    assert (whole, first) == pytest.approx((effect @ effect, (effect ** 2)[:TORSION_ERRORS].sum()))
    gain = fusion_memory.gained(memory)
    gain -= np.outer(effect, effect) / (effect @ effect)        # the difference is known
    assert fusion_memory.errors_apart(memory, effect) == pytest.approx((0.0, 0.0), abs=1e-12)


def test_error_falls_by_more_than_published():
    """The scatter of healthy arms: published fusions have 39 to 49 % lower errors."""
    seeds = range(1, 7)
    alone = np.mean([mean_error(recorded(seed=seed), ALONE) for seed in seeds])
    fused = np.mean([mean_error(recorded(seed=seed)) for seed in seeds])
    assert fused < 0.5 * alone
    assert fused < 0.03


@pytest.mark.parametrize(('effect', 'parameters'), [
    ('kinematic_error', {'amplitude_2': 1e-4, 'phase_2': 1.0}),
    ('link_encoder_eccentricity', {'amplitude_1': 2e-4, 'phase_1': 0.5}),
    ('stiffness_error', {'relative_error': 0.15}), ('clock_skew', {'skew': 2e-4})])
def test_what_is_wrong_with_the_torsion_is_taken_away(effect, parameters):
    seen = recorded(effect, **parameters)
    loose = replace(ARM, tolerances=replace(
        ARM.tolerances, kinematic_error=1e-4, eccentricity=1e-4, clock_skew=1e-4, stiffness=0.1))
    assert mean_error(seen, arm=loose) < 0.5 * mean_error(seen, ALONE)


@pytest.mark.parametrize(('effect', 'parameters'), [
    ('coulomb_friction', {'level': 0.02}), ('torque_constant_error', {'relative_error': 0.08}),
    ('current_loop_lag', {'time_constant': 0.004})])
def test_what_is_wrong_with_the_motor_harms_little(effect, parameters):
    """Each is ten or more times its tolerance, and half a N*m or more of the motor's torque."""
    assert mean_error(recorded(effect, **parameters)) < 0.1


def test_errors_are_found_by_name():
    slipped = recorded('coulomb_friction', level=0.0111)
    found = learnt(slipped)[0]
    known = ARM.tolerances.dry_friction * ARM.joints[0].dry_friction
    usual = learnt(recorded())[0]
    assert (found - usual)[DRY] * known == pytest.approx(0.0111, rel=0.05)
    assert abs((found - usual)[ZERO]) < 0.3


def test_standstill_teaches_nothing():
    seen = recorded(path='standstill', seconds=3.0)
    assert not learnt(seen).any()
    np.testing.assert_array_equal(estimates(seen).torque, estimates(seen, ALONE).torque)
    assert (estimates(seen).joints[:, :, layout.MOTOR_SHARE] == 0.0).all()


def test_without_commands_the_torsion_stands_alone():
    seen = recorded()
    blind = Estimator(ARM).run(seen.stamps, reading(seen))
    np.testing.assert_array_equal(blind.joints, estimates(seen, ALONE).joints)


def test_share_of_the_motor_grows_with_what_it_teaches():
    share = estimates(recorded()).joints[:, :, layout.MOTOR_SHARE]
    assert (share[:100] == 0.0).all()
    assert (share >= 0.0).all() and (share <= 1.0).all()
    assert (share[-1] > 0.5).all()
    deviation = estimates(recorded()).torque_deviation
    assert (deviation[-1] < 0.7 * deviation[0]).all()


def test_what_was_learnt_outlasts_a_gap_and_fades_with_time():
    seen = recorded()
    made = Estimator(ARM)
    made.run(seen.stamps, reading(seen), seen.command)
    part = slice(layout.FUSION + fusion.LEARNT, layout.CONTACT)
    before = made.memory[:, part].copy()
    made.update(int(seen.stamps[-1]) + 10**9, reading(seen)[-1], seen.command[-1])
    np.testing.assert_array_equal(made.memory[:, part], before)
    made.reset()
    assert not made.memory.any()
    brief = Estimator(ARM, EstimatorSettings(fusion_memory=1.0))
    brief.run(seen.stamps, reading(seen), seen.command)
    gained = [fusion.gained(each.memory[0, layout.FUSION:])[ZERO, ZERO]
              for each in (brief, _estimator(seen))]
    assert -1.0 < gained[1] < gained[0] < 0.0


def _estimator(seen: TruthRecord) -> Estimator:
    made = Estimator(ARM)
    made.run(seen.stamps, reading(seen), seen.command)
    return made


def test_recording_with_commands_in_pieces_gives_the_same_bits():
    seen = recorded()
    pieces = Estimator(ARM)
    command = seen.command.copy()
    command[700:720] = np.nan                   # a driver that does not always know
    whole = Estimator(ARM).run(seen.stamps, reading(seen), command)
    parts = [pieces.run(seen.stamps[part], reading(seen)[part], command[part])
             for part in (slice(0, 1), slice(1, 5003), slice(5003, None))]
    np.testing.assert_array_equal(np.concatenate([part.joints for part in parts]), whole.joints)
    assert np.isfinite(whole.torque).all()


def test_effects_on_the_torsion_are_its_derivatives():
    """A wave of the kinematic error is what the estimator would see with it in the model."""
    known, effect = ARM.tolerances, np.zeros(ERRORS)
    torsion_effects(ARM.record().joints[0]['tolerances'], 3.0, 0.4, 0.5, effect)
    assert effect[ZERO] == known.torsion_zero
    np.testing.assert_allclose(effect[1:7], known.kinematic_error * np.array(
        [np.sin(3.0), np.cos(3.0), np.sin(6.0), np.cos(6.0), np.sin(12.0), np.cos(12.0)]))
    assert effect[11] == -0.5 * known.clock_skew

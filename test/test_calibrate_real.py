"""Joints as real robots record them: coarse, late, half missing. No calibration dies of it."""

from dataclasses import replace
import json

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.parts import Encoder, Joint, Tolerances
from hda_arm_sim.model.torsion import TorsionLaw
from hda_arm_sim.model.writing import write_arm
from hda_msgs_json.bag import BagWriter
from hda_msgs_json.samples import JointSamples
from hda_msgs_json.topics import JOINT_STATES, link_frame, motor_name, reference_joint_torque
from hda_torque_estimator.calibrate.calibration import Calibration
from hda_torque_estimator.calibrate.fitting.by_hand import line_left_out, mean_left_out
from hda_torque_estimator.calibrate.passages.joint_recording import CalibrationError, Measured
from hda_torque_estimator.calibrate.referenced import calibrate, JointCalibration
from hda_torque_estimator.cli import main
from hda_torque_estimator.estimating.estimator import Estimator
from hda_torque_estimator.samples.readings import by_motor, LINK_READING, MOTOR_READING, READINGS
from hda_torque_estimator.significance import NORMAL_90
from hda_torque_estimator.simulating.recorded import about_z
import numpy as np
import pytest

RATIO, STIFFNESS, INERTIA = 100.0, 1.2e4, 5e-5
STEP = 2.0 * np.pi / 4096       # of both encoders, 12 bits [rad]
SECONDS, DT = 10.0, 0.01
Array = np.ndarray


def leg(**parts: object) -> Arm:
    """Return the arm file of a leg's joint of which little is known."""
    law = TorsionLaw(flexspline_stiffness=1e4, flexspline_curvature=0.0, damping=0.0,
                     wave_generator_stiffness=np.inf, valid_torque=200.0)
    joint = Joint(label='knee', ratio=RATIO, motor_inertia=INERTIA, torque_limit=2.0,
                  dry_friction=0.02, torsion=law, motor_encoder=Encoder(counts=4096),
                  link_encoder=Encoder(counts=4096))
    known = Tolerances(stiffness=0.25, torsion_zero=1e-3, dry_friction=0.5, viscous_friction=0.5,
                       torque_constant=0.1, drive_offset=0.01, torque_ripple=0.01,
                       kinematic_error=1e-4, eccentricity=3e-4)
    return Arm((replace(joint, **parts),), None, tolerances=known)


def recorded(seed: int, *, zero: float = 0.0, constant: float = 1.0, lag: float = 0.0,
             speed: float = 1.0) -> Measured:
    """Return a recording of the leg while a hand pulls at it; its stamps are those of a host."""
    random = np.random.default_rng(seed)
    time = DT * np.arange(round(SECONDS / DT)) + 1e-3 * np.abs(
        random.standard_normal(round(SECONDS / DT)))
    waves = [(random.uniform(0.1, 0.5), random.uniform(0.0, 6.3)) for _ in range(4)]

    def pulled(at: Array) -> Array:
        return np.sum([5.0 * np.sin(6.28 * f * at + phase) for f, phase in waves], axis=0)

    torque, link = pulled(time), 0.4 * np.sin(1.1 * speed * time + random.uniform(0.0, 6.3))
    motor = RATIO * (link + torque / STIFFNESS)
    rate = np.gradient(motor, time)
    given = (torque / RATIO + 0.03 * np.tanh(rate) + 2e-4 * rate
             + INERTIA * np.gradient(rate, time) + 0.004 * np.sin(4.0 * motor)) / constant
    readings = np.full((len(time), 1, READINGS), np.nan)
    readings[:, 0, MOTOR_READING] = STEP * np.round(motor / STEP)
    readings[:, 0, LINK_READING] = STEP * np.round((link + zero) / STEP)
    return Measured(f'run{seed}', (1e9 * time).astype(np.int64) + 1, readings, given,
                    pulled(time - lag))


def four(**wrong: float) -> list[Measured]:
    """Return four recordings, each with a zero of its own."""
    zeros = 0.0, 5e-3, -4e-3, 1e-3
    return [recorded(seed, zero=zero, **wrong) for seed, zero in enumerate(zeros)]


def error(arm: Arm, seen: Measured, *, believed: bool = False) -> float:
    """Return the rms error of the estimator on a recording, or where it believes it [N*m]."""
    estimated = Estimator(arm).run(seen.stamps, seen.readings, seen.command[:, np.newaxis])
    mean = np.nanmean if believed else np.mean
    return float(np.sqrt(mean((estimated.torque[:, 0] - seen.reference) ** 2)))


@pytest.fixture(scope='module')
def found() -> Calibration:
    """Return the leg calibrated from four recordings with a wrong constant and a late sensor."""
    return calibrate(leg(), {'knee': four(constant=0.7, lag=0.04)})


def test_a_coarse_leg_is_no_worse_than_a_line_by_hand(found):
    """On a fifth recording with another zero, against the torque that it really had."""
    other, joint = recorded(9, zero=-6e-3, constant=0.7), found.joints[0]
    assert error(found.arm, other) < 0.6 * error(leg(), other)
    assert error(found.arm, other) <= 1.05 * joint.by_hand
    assert joint.together <= joint.by_hand
    assert joint.lag == pytest.approx(0.04, abs=0.01)
    constant = found.arm.effect('torque_constant_error', 'knee')
    assert constant.error == pytest.approx(-0.3, abs=0.05)


def test_what_each_witness_is_worth_is_in_the_file(found):
    joint, reported = found.arm.joints[0], found.joints[0]
    assert 0.0 < joint.motor_deviation < joint.torsion.deviation
    assert joint.motor_deviation < reported.reference / 4.0
    assert found.arm.tolerances_of('knee').torsion_zero > 2e-3
    assert 'a straight line by' in found.text()
    assert json.loads(json.dumps(found.report(), allow_nan=False))['joints'][0]['together'] > 0.0


def test_nine_in_ten_torques_of_other_recordings_are_within_their_intervals(found):
    """A zero of its own in each, and no recording was seen by the fit."""
    held = []
    for seed, zero in ((9, -6e-3), (10, 3e-3), (11, 6e-3)):
        seen = recorded(seed, zero=zero, constant=0.7)
        estimated = Estimator(found.arm).run(seen.stamps, seen.readings,
                                             seen.command[:, np.newaxis])
        held.append(np.abs(estimated.torque[:, 0] - seen.reference)
                    < NORMAL_90 * estimated.torque_deviation[:, 0])
    assert 0.8 < np.concatenate(held).mean() < 0.97
    assert min(one.mean() for one in held) > 0.8


def scattered(one: Measured) -> Measured:
    """Return a recording whose link angle scatters by more torsion than any law has."""
    readings = one.readings.copy()
    readings[:, 0, LINK_READING] += 0.05 * np.random.default_rng(5).standard_normal(len(readings))
    return replace(one, readings=readings)


def blind(one: Measured) -> Measured:
    """Return a recording without a link encoder."""
    readings = one.readings.copy()
    readings[:, 0, LINK_READING] = np.nan
    return replace(one, readings=readings)


def spiked(one: Measured) -> Measured:
    """Return a recording with readings that no joint can show."""
    readings = one.readings.copy()
    readings[50::400, 0, MOTOR_READING] += 1e4
    return replace(one, readings=readings)


def test_an_angle_that_no_shaft_reaches_is_left_out():
    seen = recorded(1)
    assert len(seen.without_spikes(700.0).stamps) == len(seen.stamps)
    rest = spiked(seen).without_spikes(700.0)
    np.testing.assert_array_equal(rest.stamps, np.delete(seen.stamps, (50, 450, 850)))
    assert np.abs(rest.turning().rate).max() < 700.0


def patchy(one: Measured) -> Measured:
    """Return a recording whose motor torque is unknown for a third of it."""
    command = one.command.copy()
    command[:len(command) // 3] = np.nan
    return replace(one, command=command)


def in_bursts(one: Measured) -> Measured:
    """Return a recording whose samples arrive eight at a time."""
    place = np.arange(len(one.stamps))
    late = one.stamps[place // 8 * 8] + 1000 * (place % 8)
    return replace(one, stamps=late)


def resting(one: Measured) -> Measured:
    """Return a recording in which the joint stands."""
    return replace(one, readings=np.repeat(one.readings[:1], len(one.readings), axis=0))


SPOILS = (scattered, blind, spiked, patchy, in_bursts, resting)


@pytest.mark.parametrize(('spoil', 'all_of_them'), [
    (scattered, False), *((spoil, True) for spoil in SPOILS), *(
        pytest.param(spoil, False, marks=pytest.mark.study) for spoil in SPOILS[1:])])
def test_no_recording_ends_a_calibration_but_by_a_sentence(spoil, all_of_them):
    parts = four()[:3]
    seen = [spoil(one) if all_of_them or place == 1 else one for place, one in enumerate(parts)]
    try:
        calibrated = calibrate(leg(), {'knee': seen})
    except CalibrationError as refused:
        assert all_of_them and '\n' not in str(refused) and 'nan' not in str(refused)
    else:
        assert 'nan' not in calibrated.text()
        assert error(calibrated.arm, parts[0]) < 1.2 * max(calibrated.joints[0].by_hand, 1.0)


def test_a_motor_that_hardly_turns_is_no_worse_than_a_line():
    """A hand pulls at a joint that stands: its shaft moves by the torsion alone."""
    seen = [recorded(seed, zero=zero, speed=0.0) for seed, zero in enumerate((0.0, 5e-3, -4e-3))]
    calibrated = calibrate(leg(), {'knee': seen}).joints[0]
    assert calibrated.motor > 0.0
    assert calibrated.together <= 1.05 * calibrated.by_hand < 0.5 * calibrated.constant


def test_no_better_than_the_mean_torque_is_said():
    calibrated = JointCalibration('knee', ('one', 'two'), together=3.0, given=4.0, by_hand=2.0)
    said = 'the mean torque of the others errs by no more (1.5)'
    assert said in ' '.join(replace(calibrated, constant=1.5).lines())
    assert 'mean torque' not in ' '.join(replace(calibrated, constant=3.5).lines())


def test_the_mean_torque_of_the_others_is_left_out():
    seen = [replace(one, reference=np.full(len(one.stamps), torque))
            for one, torque in zip(four(), (1.0, 2.0, 3.0))]
    assert mean_left_out(seen) == pytest.approx(np.sqrt((1.5 ** 2 + 0.0 + 1.5 ** 2) / 3.0))


def test_a_joint_without_a_link_encoder_is_estimated_by_its_motor(tmp_path, capsys):
    """From the calibration to the estimate of a bag that has no link angle."""
    seen = [blind(one) for one in four(constant=0.7)]
    calibrated = calibrate(leg(), {'knee': seen[:3]})
    assert not any(one.name.startswith('torsion') for one in calibrated.joints[0].numbers)
    assert 0.0 < calibrated.joints[0].together <= 1.2 * calibrated.joints[0].by_hand
    write_arm(calibrated.arm, tmp_path / 'arm.yaml')
    with BagWriter(tmp_path / 'bag', {}) as bag:
        column = [seen[3].readings[:, 0, MOTOR_READING]]
        bag.write_joint_states(JOINT_STATES, JointSamples(
            seen[3].stamps, (motor_name('knee'),), np.stack(column, axis=1),
            np.full((len(seen[3].stamps), 1), np.nan), seen[3].command[:, np.newaxis]))
        bag.write_wrenches(reference_joint_torque('knee'), about_z(
            seen[3].stamps, link_frame('knee'), seen[3].reference))
    assert main(['estimate', str(tmp_path / 'bag'), '--arm', str(tmp_path / 'arm.yaml'), '--json',
                 '--out', str(tmp_path / 'out')]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report['by_motor'] == ['knee']
    assert report['errors']['reference/knee/torque']['rms'] < 1.3 * calibrated.joints[0].by_hand


def test_an_estimate_of_a_wrong_sign_is_refused(tmp_path, capsys):
    seen = recorded(1)
    write_arm(leg(), tmp_path / 'arm.yaml')
    for sign, code in ((1.0, 0), (-1.0, 2)):
        bag = tmp_path / f'bag{code}'
        with BagWriter(bag, {}) as writer:
            nothing = np.full((len(seen.stamps), 2), np.nan)
            writer.write_joint_states(JOINT_STATES, JointSamples(
                seen.stamps, ('knee', motor_name('knee')),
                seen.readings[:, 0, (LINK_READING, MOTOR_READING)], nothing,
                np.stack([nothing[:, 0], sign * seen.command], axis=1)))
        assert main(['estimate', str(bag), '--arm', str(tmp_path / 'arm.yaml'), '--out',
                     str(tmp_path / f'out{code}')]) == code
    assert 'the motor torques have the wrong sign' in capsys.readouterr().err


@pytest.mark.parametrize('segmented', [False, True])
def test_a_single_recording_says_nothing_of_how_its_zero_moves(segmented):
    law = leg().joints[0].torsion
    if segmented:
        law = replace(law, knee_1=5.0, second_stiffness=1.4e4, knee_2=20.0, third_stiffness=1.6e4)
    calibrated = calibrate(leg(torsion=law), {'knee': four()[:1]})
    assert calibrated.arm.tolerances_of('knee').torsion_zero >= 1e-3
    assert calibrated.joints[0].together < 0.3 * calibrated.joints[0].reference


@pytest.mark.parametrize(('flipped', 'said'), [
    ('command', 'they have the wrong sign'), ('angles', 'check the signs of both angles')])
def test_a_witness_of_the_wrong_sign_is_left_aside(flipped, said):
    seen = [replace(one, command=-one.command) if flipped == 'command'
            else replace(one, readings=-one.readings) for one in four()[:2]]
    calibrated = calibrate(leg(), {'knee': seen})
    assert said in calibrated.text()
    assert (calibrated.joints[0].after
            or calibrated.joints[0].motor) < calibrated.joints[0].reference


def test_a_reference_of_the_wrong_sign_is_said():
    with pytest.raises(CalibrationError, match='the sign of the reference is wrong'):
        calibrate(leg(), {'knee': [replace(one, reference=-one.reference) for one in four()[:2]]})


def test_weights_leave_the_torque_to_the_better_witness():
    """A torsion that is nonsense where nobody has seen it must not spoil a good motor."""
    seen = [scattered(one) for one in four(constant=0.7)]
    found = calibrate(leg(), {'knee': seen})
    reported, other = found.joints[0], scattered(recorded(9, zero=-6e-3, constant=0.7))
    alone = by_motor(found.arm, ['knee'])
    assert error(found.arm, other, believed=True) <= 1.05 * error(alone, other, believed=True)
    assert reported.together <= 1.05 * reported.by_hand
    assert line_left_out(leg().joints[0], seen) == pytest.approx(reported.by_hand)


def test_a_motor_that_hardly_turns_tells_no_slope_over_its_speed():
    """A slope of friction found at 0.3 rad/s made 170 N*m of a real joint at 100 rad/s."""
    still = [blind(recorded(seed, speed=0.0)) for seed in (0, 1, 2)]
    found = calibrate(leg(), {'knee': still})
    assert 'viscous_friction.slope' not in {one.name for one in found.joints[0].numbers}
    assert found.joints[0].together <= 1.2 * found.joints[0].by_hand
    moving = recorded(7)
    moving = blind(moving).with_link(RATIO)
    assert error(by_motor(found.arm, ['knee']), moving) < moving.varies()

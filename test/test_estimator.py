"""The estimator is exact when the model is the truth, and says where it cannot know."""

from dataclasses import replace

from hda_arm_sim.foundation.rigid import gravity_torque, tip_torque
from hda_arm_sim.model.arm import Arm, Base, Encoder
from hda_arm_sim.model.effects import ClockSkew, KinematicError, TorsionalHysteresis
from hda_arm_sim.model.effects.transmission import LoadedKinematicError
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.model.kernel import growth
from hda_arm_sim.model.link_side import loaded_inertia
from hda_arm_sim.model.torsion import torsion_of_torque
from hda_arm_sim.motions import motion
from hda_torque_estimator.estimating.estimator import Estimator, EstimatorSettings, Refusal
from hda_torque_estimator.estimating.laws import layout
from hda_torque_estimator.estimating.laws.tip_force import base_force, Posture, tool_force
from hda_torque_estimator.samples.readings import READINGS
from hda_torque_estimator.simulating.closed_loop import run
import numpy as np
import pytest

MILLISECOND = 1_000_000


@pytest.fixture(scope='module')
def arm():
    """Return the nominal arm."""
    return read_arm('hda_arm.yaml')


@pytest.fixture(scope='module')
def pushed(arm):
    """Return a run with pushes at the tip."""
    return run(arm, arm, motion('push', 2, 10.0, 1e-3, 5), 5)


def perfect(arm: Arm) -> Arm:
    """Return the arm with encoders that resolve everything."""
    return replace(arm, joints=tuple(
        replace(joint, motor_encoder=Encoder(), link_encoder=Encoder()) for joint in arm.joints))


def stamps_of(made):
    """Return the stamps of a run."""
    return np.round(made.time * 1e9).astype(np.int64)


def estimates(arm, made, settings=EstimatorSettings()):
    """Return the estimates of a run."""
    return Estimator(arm, settings).run(stamps_of(made), made.reading)


def still(arm, angles, torque):
    """Return a reading of an arm at rest at these link angles under these joint torques."""
    reading = np.full((len(angles), READINGS), np.nan)
    for row, joint, angle, load in zip(reading, arm.record().joints, angles, torque):
        twist = torsion_of_torque(joint['torsion'], joint['ratio'], load)
        row[:2] = (angle + twist) * joint['ratio'], angle
    return reading


def held(arm, angles, force, samples=3000):
    """Return estimates of an arm that holds a force on its tip (2,) [N] long enough."""
    links = arm.links
    load = -np.array(tip_torque(links.length1, links.length2, *angles, *force))
    reading = np.repeat(still(arm, angles, load)[None], samples, axis=0)
    stamps = np.arange(samples, dtype=np.int64) * MILLISECOND
    return Estimator(arm).run(stamps, reading)


@pytest.mark.parametrize('effect', [None, LoadedKinematicError(amplitude=8e-6, phase=0.4)])
def test_torque_is_exact_when_model_is_truth(arm, effect):
    fine = perfect(arm) if effect is None else perfect(arm).with_effect(effect, 'joint1')
    made = run(fine, fine, motion('sine', 2, 6.0, 1e-3, 1), 1)
    reading = made.reading.copy()
    reading[:, :, 2], reading[:, :, 3] = made.state[:, :, 1], made.state[:, :, 3]
    found = Estimator(fine, EstimatorSettings(velocity_bandwidth=1e4, torsion_bandwidth=1e4)).run(
        stamps_of(made), reading)
    np.testing.assert_allclose(found.torque, made.joint_torque, atol=1e-8)


@pytest.mark.parametrize('effect', [
    KinematicError(amplitude_2=2e-4, phase_2=0.4, amplitude_4=3e-5, phase_4=-1.0),
    TorsionalHysteresis(level=1.0, width=1e-4),
    LoadedKinematicError(amplitude=8e-6, phase=0.4),
    ClockSkew(skew=2e-4)])
def test_known_effect_is_compensated(arm, effect):
    other = arm.with_effect(effect, 'joint1')
    made = run(other, arm, motion('sine', 2, 8.0, 1e-3, 2), 2)
    blind = (estimates(arm, made).torque - made.joint_torque)[500:, 0].std()
    aware = (estimates(other, made).torque - made.joint_torque)[500:, 0].std()
    assert aware < 0.25 * blind
    assert aware < 0.1


def test_velocities_are_derived_where_missing(arm, pushed):
    blank = pushed.reading.copy()
    blank[:, :, 2:] = np.nan
    given = estimates(arm, pushed)
    derived = Estimator(arm).run(stamps_of(pushed), blank)
    np.testing.assert_allclose(derived.joints[5:], given.joints[5:], rtol=1e-6, atol=1e-6)


def test_deviation_covers_quantisation(arm, pushed):
    found = estimates(arm, pushed)
    error = found.torque - pushed.joint_torque
    known = replace(arm, tolerances=replace(arm.tolerances, stiffness=0.0))
    quiet = estimates(known, pushed)
    share = (np.abs(error) < 2.0 * quiet.torque_deviation)[500:].mean()
    assert 0.85 < share <= 1.0
    assert (found.torque_deviation >= quiet.torque_deviation).all()


def test_beyond_range_saturates_and_says_so(arm):
    limit = arm.joints[0].torsion.valid_torque
    record = arm.record().joints[0]['torsion']
    torques, flags = [], []
    for torsion in record['valid_torsion'] * np.array([0.99, 1.01, 1.2]):
        reading = np.full((2, 4), np.nan)
        reading[:, :2] = [[torsion * 100.0, 0.0], [0.0, 0.0]]
        made = Estimator(arm)
        made.update(0, reading)
        torques.append(made.joints[0, layout.TORQUE])
        flags.append(made.joints[0, layout.BEYOND_RANGE])
    assert flags == [0.0, 1.0, 1.0]
    assert torques[0] < limit < torques[1]
    slope = (torques[2] - torques[1]) / (0.19 * record['valid_torsion'])
    assert slope == pytest.approx(record['last_stiffness'], rel=1e-9)


@pytest.mark.parametrize('force', [(12.0, -7.0), (0.0, 20.0), (-5.0, 0.5)])
@pytest.mark.parametrize('angles', [(0.4, 1.3), (-1.0, -0.7), (2.0, 2.4)])
def test_force_of_the_environment_on_the_tip(arm, angles, force):
    found = held(arm, angles, force)
    np.testing.assert_allclose(found.base_force[-1], force, atol=1e-6)
    c, s = np.cos(sum(angles)), np.sin(sum(angles))
    np.testing.assert_allclose(
        found.tool_force[-1], (c * force[0] + s * force[1], c * force[1] - s * force[0]),
        atol=1e-6)


def test_stretched_arm_knows_only_the_perpendicular_force(arm):
    found = held(arm, (0.0, 0.0), (30.0, 8.0))
    axial, perpendicular = found.tool_force[-1]
    assert np.isnan(axial)
    assert perpendicular == pytest.approx(8.0, abs=1e-6)
    assert np.isnan(found.base_force[-1, 0])
    assert found.base_force[-1, 1] == pytest.approx(8.0, abs=1e-6)
    assert found.tip[-1, layout.SINGULAR] == 1.0
    slanted = held(arm, (0.7, 0.0), (30.0, 8.0))
    assert np.isnan(slanted.base_force[-1]).all(), 'both axes of the base see the axial part'


def test_covariance_is_that_of_the_errors(arm, pushed):
    """Draw torque errors of the stated deviations: the forces scatter as the covariance says."""
    random = np.random.default_rng(7)
    deviation, angles = np.array([0.05, 0.03]), (0.4, 1.1)
    forces = []
    for _ in range(4000):
        force, covariance, base, spread = (np.zeros(2), np.zeros((2, 2)), np.zeros(2),
                                           np.zeros((2, 2)))
        tool_force(Posture(arm.record().body['links'], 2, angles[1], 0.1),
                   deviation * random.standard_normal(2), deviation, force, covariance)
        base_force(sum(angles), force, covariance, base, spread)
        forces.append(base)
    np.testing.assert_allclose(np.cov(np.array(forces).T), spread, rtol=0.1, atol=2e-3)


def test_gravity_of_a_tilted_base_is_no_contact(arm):
    tilted = replace(arm, base=Base(tilt=0.2, direction=0.8))
    made = run(tilted, tilted, motion('sine', 2, 6.0, 1e-3, 3), 3)
    found = estimates(tilted, made)
    blind = estimates(arm, made)
    assert np.abs(found.external_torque[1500:]).mean() < 0.1
    assert np.abs(blind.external_torque[1500:]).mean() > 1.0


def test_offline_and_sample_by_sample_give_the_same_bits(arm, pushed):
    stamps, reading = stamps_of(pushed)[:3000], pushed.reading[:3000].copy()
    reading[100, 0, 0] = np.nan
    reading[200, 1, 1] = np.inf
    stamps[300] = stamps[299]
    stamps[400] = stamps[390]
    stamps[2000:] += 300 * MILLISECOND
    whole = Estimator(arm).run(stamps, reading)
    one = Estimator(arm)
    rows, refused = [], {}
    for index, (stamp, sample) in enumerate(zip(stamps, reading)):
        refusal = one.update(int(stamp), sample)
        if refusal is Refusal.NONE:
            rows.append((one.joints.copy(), one.tip.copy()))
        else:
            refused[index] = refusal
    assert refused == {100: Refusal.NOT_FINITE, 200: Refusal.NOT_FINITE,
                       300: Refusal.NOT_LATER, 400: Refusal.NOT_LATER}
    assert whole.refused.tolist() == list(refused)
    np.testing.assert_array_equal(whole.joints, [joints for joints, _ in rows])
    np.testing.assert_array_equal(whole.tip, [tip for _, tip in rows])


def test_recording_in_pieces_gives_the_same_bits(arm, pushed):
    stamps = stamps_of(pushed)
    whole = Estimator(arm).run(stamps, pushed.reading)
    pieces = Estimator(arm)
    parts = [pieces.run(stamps[part], pushed.reading[part])
             for part in (slice(0, 1), slice(1, 777), slice(777, None))]
    np.testing.assert_array_equal(np.concatenate([part.joints for part in parts]), whole.joints)


def test_parts_are_views_of_the_whole(arm, pushed):
    stamps, reading = stamps_of(pushed), pushed.reading
    whole, parts = Estimator(arm).in_parts(stamps, reading, size=700)
    drawn = list(parts)
    assert [len(part.stamps) for part in drawn[:-1]] == [700] * (len(drawn) - 1)
    assert sum(len(part.stamps) for part in drawn) == len(whole.stamps)
    for part in drawn:
        assert np.shares_memory(part.joints, whole.joints)
    np.testing.assert_array_equal(whole.joints, Estimator(arm).run(stamps, reading).joints)


def test_tare_takes_an_offset_away_and_reset_brings_it_back(arm):
    offset = still(arm, (0.2, 1.0), (0.0, 0.0))
    offset[0, 0] += 0.02
    made = Estimator(arm)
    made.tare()
    for index in range(600):
        made.update(index * MILLISECOND, offset)
    assert not made.taring
    assert made.zero[0] == pytest.approx(2e-4, rel=1e-9)
    assert abs(made.joints[0, layout.TORQUE]) < 1e-9
    made.reset()
    made.update(0, offset)
    assert made.joints[0, layout.TORQUE] > 1.0


def test_tare_on_a_tilted_base_keeps_the_weight(arm):
    tilted = replace(arm, base=Base(tilt=0.3, direction=0.0))
    made = run(tilted, tilted, motion('standstill', 2, 4.0, 1e-3, 1), 1)
    before = estimates(tilted, made).torque[-1]
    tared = Estimator(tilted)
    tared.run(stamps_of(made)[:3000], made.reading[:3000])
    tared.tare()
    for stamp, sample in zip(stamps_of(made)[3000:], made.reading[3000:]):
        tared.update(int(stamp), sample)
    assert np.abs(before).max() > 1.0
    assert np.abs(tared.zero).max() < 5e-6


def test_tare_knows_an_error_that_grows_with_the_weight(arm):
    loaded = replace(perfect(arm), base=Base(tilt=0.5, direction=1.0)).with_effect(
        LoadedKinematicError(amplitude=8e-6, phase=0.4), 'joint1')
    angles, (joints, body) = (0.4, 1.3), loaded.record()
    weight = np.array(gravity_torque(loaded_inertia(body), body['pull'], body['direction'],
                                     *angles))
    reading = still(loaded, angles, -weight)
    for _ in range(60):                         # the shaft stands where its own error is in it
        growing, _ = growth(joints[0], reading[0, 0])
        reading[0, 0] = still(loaded, angles, -weight)[0, 0] - 100.0 * growing * abs(weight[0])
    tared = Estimator(loaded)
    tared.tare()
    for k in range(2000):
        tared.update(k * MILLISECOND, reading)
    assert np.abs(growing * weight[0]) > 1e-5
    assert np.abs(tared.zero).max() < 1e-12


def test_arm_without_links_offers_torques_only(arm):
    free = replace(arm, links=None)
    reading = still(arm, (0.3, 0.9), (5.0, -2.0))
    found = Estimator(free).run(np.arange(3, dtype=np.int64) * MILLISECOND,
                                np.repeat(reading[None], 3, axis=0))
    np.testing.assert_allclose(found.torque[-1], (5.0, -2.0), rtol=1e-9)
    assert np.isnan(found.external_torque).all() and np.isnan(found.tip).all()


def test_single_joint_arm_knows_the_perpendicular_force(arm):
    single = Arm(arm.joints[:1], replace(arm.links, length2=0.0, p2=0.0, p3=0.0, second=0.0))
    found = Estimator(single).run(
        np.arange(3000, dtype=np.int64) * MILLISECOND,
        np.repeat(still(single, (0.0,), (-6.0 * 0.15,))[None], 3000, axis=0))
    assert found.tool_force[-1, 1] == pytest.approx(6.0, abs=1e-6)
    assert np.isnan(found.tool_force[-1, 0])

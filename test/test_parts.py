"""Balances that are made of known parts are those of whole runs of the kernel."""

from dataclasses import replace

from hda_arm_sim.model.effects import (BaseTilt, BaseVibration, BearingCrosstalk,
                                       CoulombFriction, effect_named, EFFECTS, ExternalContact,
                                       LinkBearingFriction, LinkInertiaError, Payload,
                                       PreslidingFriction, Scope, TorsionalHysteresis)
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.model.kernel import LINK_VELOCITY
from hda_arm_sim.model.typical_sizes import SIZED, typical
from hda_arm_sim.motions import motion_of
from hda_torque_estimator.diagnosis.balances import gears, parts, sensed_motion
from hda_torque_estimator.diagnosis.balances.balance import Balancer, NearRest
from hda_torque_estimator.diagnosis.balances.fields import places_of
from hda_torque_estimator.diagnosis.balances.kernel_along import REST
from hda_torque_estimator.diagnosis.balances.recent_cache import RecentCache
from hda_torque_estimator.measurements.measurement import Measurement
from hda_torque_estimator.simulating.closed_loop import run
import numpy as np
import pytest

ARMS = ('hda_arm.yaml', 'cobot7.yaml', 'one')
OF_A_PLANE = {'inertial_coupling'}
CLOSE = 1e-9            # of the largest torque


def recording(arm):
    """Return 6 s of an arm's motion."""
    made = run(arm, arm, motion_of(arm, 'rich', 6.0, 1e-3, 5), 5, estimator=None)
    return Measurement(arm.labels, 1e-3, np.ascontiguousarray(made.reading[:, :, :2]),
                       made.command)


@pytest.fixture(scope='module', params=ARMS)
def recorded(request):
    """Return an arm and 6 s of its motion."""
    arm = read_arm('hda_arm.yaml' if request.param == 'one' else request.param)
    if request.param == 'one':
        arm = replace(arm, joints=arm.joints[:1], links=replace(
            arm.links, length2=0.0, p2=0.0, p3=0.0, second=0.0))
    return arm, recording(arm)


def others(arm, names=SIZED):
    """Yield arms with one effect more of typical size, at each joint that can have it."""
    for name in names:
        if len(arm.joints) != 2 and name in OF_A_PLANE:
            continue
        joints = (None,) if effect_named(name).scope is Scope.ARM else arm.labels
        yield from ((name, joint, arm.with_effect(typical(arm, name, joint), joint))
                    for joint in joints)


def whole(balancer, arm):
    """Return the residuals of a run of a whole arm, by balances that know nothing yet."""
    fresh = Balancer(balancer.measurement, balancer.near_rest, balancer.unknown,
                     balancer.whitening)
    return fresh.whole(arm)


def agrees(balancer, arm):
    """Return whether balances are those of a whole run: dry friction but at a standstill."""
    balance, expected = balancer(arm), whole(balancer, arm)
    holds = balance.valid.copy()
    holds[:, len(arm.joints):] = True
    assert holds[:, :len(arm.joints)].any(axis=0).all()
    apart = np.where(holds, balance.residual - expected, 0.0)
    return bool(np.abs(apart).max() <= CLOSE * np.abs(expected).max())


def between_zeros(arm, place, away):
    """Return an arm with other zeros of the encoders of one joint."""
    joints = list(arm.joints)
    joint = joints[place]
    joints[place] = replace(
        joint, motor_encoder=replace(joint.motor_encoder, zero=joint.motor_encoder.zero - away),
        link_encoder=replace(joint.link_encoder, zero=joint.link_encoder.zero + away))
    return replace(arm, joints=tuple(joints))


@pytest.mark.parametrize('led', [False, True])
def test_every_effect_at_each_joint_shows_as_in_a_whole_run(recorded, led):
    arm, measurement = recorded
    balancer = Balancer(replace(measurement, led=led))
    balancer = balancer.whitened(arm, np.zeros(2 * len(arm.joints)))
    for name, joint, other in others(arm):
        assert agrees(balancer, other), (name, joint)


def test_links_that_bearings_hold_show_as_in_a_whole_run(recorded):
    arm, measurement = recorded
    balancer = Balancer(measurement)
    resting = np.abs(balancer.motion(arm).state[:, :, LINK_VELOCITY]) <= REST
    assert resting.any(axis=0).all() and not resting.all(axis=1).all()
    for labels in (arm.labels[:1], arm.labels[-1:], arm.labels):
        held = arm
        for label in labels:
            held = held.with_effect(LinkBearingFriction(level=1.0), label)
        for name in ('stiffness_error', 'torsional_hysteresis', 'payload', 'base_tilt'):
            joint = None if effect_named(name).scope is Scope.ARM else arm.labels[0]
            assert agrees(balancer, held.with_effect(typical(arm, name, joint), joint)), name
        assert agrees(balancer, held)


def test_a_link_on_a_bearing_is_not_judged_near_rest(recorded):
    arm, measurement = recorded
    plain, borne = (Balancer(measurement, NearRest(borne=places))(arm).valid
                    for places in ((), (0,)))
    balancer, joints = Balancer(measurement), len(arm.joints)
    speed = np.abs(balancer.motion(arm).state[::balancer.every, 0, LINK_VELOCITY])
    resting = speed <= REST
    assert resting.any() and not (borne[:, joints] & resting).any() and borne[:, joints].any()
    assert (plain[:, joints] >= borne[:, joints]).all() and (plain[resting, joints]).any()
    others = np.arange(2 * joints) != joints
    np.testing.assert_array_equal(plain[:, others], borne[:, others])


def test_parts_of_several_recordings_are_those_of_whole_runs(recorded):
    arm, measurement = recorded
    balancer = Balancer(replace(measurement, begins=(0, 2400)))
    for name, joint, other in others(arm, ('thermal_viscosity', 'torsional_hysteresis',
                                           'presliding_friction', 'current_loop_lag',
                                           'command_delay', 'clock_skew', 'payload',
                                           'link_bearing_friction', 'base_vibration')):
        assert agrees(balancer, other), (name, joint)


def test_an_effect_is_not_taken_for_what_was_known_of_another_arm(recorded):
    """Every effect on top of each other, forth and back, so that parts are kept and forgotten."""
    arm, measurement = recorded
    balancer, label = Balancer(measurement), arm.labels[-1]
    names = [name for name in SIZED if name not in OF_A_PLANE]
    arms = [arm]
    for name in names:
        joint = None if effect_named(name).scope is Scope.ARM else label
        arms.append(arms[-1].with_effect(typical(arms[-1], name, joint), joint))
    for one in (*arms, *arms[::-1]):
        assert agrees(balancer, one), one.effects[-1:]


def test_other_zeros_of_encoders_follow_from_the_derivatives_that_are_known(recorded):
    arm, measurement = recorded
    balancer, last = Balancer(measurement), len(arm.joints) - 1
    for other in (arm, between_zeros(arm, last, 1e-5), between_zeros(arm, 0, -3e-4), arm):
        assert agrees(balancer, other)
    assert balancer.change(between_zeros(arm, last, 1e-5), arm).any()


def test_zeros_beside_an_error_of_the_encoder_are_estimated(recorded):
    """There an angle does not differ by a constant, for the error depends on it."""
    arm, measurement = recorded
    balancer, label = Balancer(measurement), arm.labels[0]
    for name in ('link_encoder_eccentricity', 'motor_encoder_eccentricity', 'clock_skew'):
        other = arm.with_effect(typical(arm, name, label), label)
        for moved in (other, between_zeros(other, 0, 1e-3)):
            assert agrees(balancer, moved), name


def test_a_payload_tilts_a_bearing_that_its_encoder_feels():
    """Where tilting shows in a reading, the motion depends on what the links carry."""
    arm = read_arm('cobot7.yaml')
    balancer, label = Balancer(recording(arm)), arm.labels[1]
    tilted = arm.with_effect(BearingCrosstalk(coefficient=1e-4), label)
    loaded = tilted.with_effect(typical(arm, 'payload', None))
    assert balancer.motion(tilted).state[:, 1, 2] != pytest.approx(
        balancer.motion(loaded).state[:, 1, 2], abs=1e-6)
    for other in (tilted, loaded):
        assert agrees(balancer, other)


def test_a_friction_runs_no_gear_and_a_payload_neither_gear_nor_motor(recorded, monkeypatch):
    arm, measurement = recorded
    balancer, label, ran = Balancer(measurement), arm.labels[0], []
    balancer(arm)
    for module, name in (
            (gears, '_fill_twist'), (gears, '_fill_spring'), (gears, '_fill_torques'),
            (parts, 'fill_missed'), (parts, 'fill_needed'), (parts, 'deliver'),
            (sensed_motion, 'angle_behind')):
        monkeypatch.setattr(module, name, _noted(getattr(module, name), name, ran))
    loaded = ['_fill_torques', 'fill_missed']
    for other, expected in ((CoulombFriction(level=0.2), ['fill_missed']),
                            (typical(arm, 'torque_constant_error', label),
                             ['deliver', 'fill_missed']),
                            (typical(arm, 'structural_damping', label), loaded),
                            (typical(arm, 'stiffness_error', label), ['_fill_spring', *loaded]),
                            (typical(arm, 'kinematic_error', label),
                             ['_fill_spring', '_fill_twist', *loaded])):
        balancer(arm.with_effect(other, label))
        assert sorted(ran) == sorted(expected), other
        balancer(arm)
        ran.clear()
    balancer(arm.with_effect(typical(arm, 'payload', None)))
    balancer(arm)
    assert ran == ['fill_needed']


def test_links_that_are_run_at_once_need_what_each_needs_alone(monkeypatch):
    """A touch, a payload and a tilt stay as they are; arms that differ by more run alone."""
    arm = read_arm('cobot7.yaml')
    for other in (typical(arm, 'payload', None), BaseTilt(tilt=0.1, direction=0.5),
                  ExternalContact(force=20.0, direction=0.5, onset=2.0, duration=1.0)):
        arm = arm.with_effect(other)
    others = [arm.with_effect(LinkInertiaError(**{number: 0.01}), joint) for joint in arm.labels
              for number in ('error', 'mass', 'centre_x', 'centre_z')]
    alone = [arm.with_effect(Payload(mass=2.0)),
             others[0].with_effect(LinkInertiaError(mass=0.02), arm.labels[4]),
             others[0].with_effect(typical(arm, 'link_encoder_eccentricity', arm.labels[2]),
                                   arm.labels[2])]
    made = replace(recording(arm), begins=(0, 2400))
    together, apart, ran = Balancer(made), Balancer(made), []
    together.run_ahead(arm, [*others, *alone])
    for name in ('fill_needed', 'fill_needed_with'):
        monkeypatch.setattr(parts, name, _noted(getattr(parts, name), name, ran))
    found = [together(other).residual for other in others]
    assert not ran
    for residual, other in zip(found, others):
        np.testing.assert_array_equal(residual, apart(other).residual)
    ran.clear()
    for other in alone:
        np.testing.assert_array_equal(together(other).residual, apart(other).residual)
    assert set(ran) == {'fill_needed'}


def _noted(function, name, ran):
    """Return a function that notes when it is called."""
    def noting(*arguments):
        ran.append(name)
        return function(*arguments)
    return noting


@pytest.mark.parametrize(('module', 'which', 'name'), [
    (sensed_motion, '_BEHIND', 'link_encoder_eccentricity'),
    (gears, '_TWISTS', 'kinematic_error'), (gears, '_SPRINGS', 'backlash'),
    (gears, '_BESIDE', 'structural_damping'), (parts, '_DRIVES', 'drive_offset'),
    (parts, '_MOTORS', 'coulomb_friction')])
def test_a_part_that_is_known_by_too_little_is_seen(monkeypatch, module, which, name):
    """So the tests above can fail: a field that is left out leaves an old part in place."""
    arm, out = read_arm('hda_arm.yaml'), set(places_of(effect_named(name)).tolist())

    def less(places):
        return np.array([place for place in places.tolist() if place not in out])

    known = getattr(module, which)
    monkeypatch.setattr(module, which, {side: less(places) for side, places in known.items()}
                        if isinstance(known, dict) else less(known))
    balancer = Balancer(recording(arm))
    balancer(arm)
    other = arm.with_effect(typical(arm, name, 'joint1'), 'joint1')
    assert not agrees(balancer, other)


def test_every_effect_has_a_part_or_changes_a_number():
    """An effect of a new place would be known by nothing, and is to be thought of here."""
    known = {place for places in (gears._TWISTS, gears._SPRINGS, gears._BESIDE, parts._DRIVES,
                                  parts._MOTORS, parts._BEARINGS, *sensed_motion._BEHIND.values())
             for place in places.tolist()}
    elsewhere = {effect.name for effect in EFFECTS if effect.scope is Scope.JOINT
                 and not set(places_of(effect).tolist()) & known}
    assert elsewhere == {'motor_inertia_error', 'stiffness_error', 'stiffening_error',
                         'wave_generator_compliance', 'link_inertia_error',     # numbers
                         'coarse_quantisation'}                                 # of readings


def test_what_a_gear_of_each_second_joint_changes_shows_there_only(recorded):
    arm, measurement = recorded
    balancer, other, count = Balancer(measurement), arm, len(arm.joints)
    for label in arm.labels[::2]:
        other = other.with_effect(typical(arm, 'stribeck_friction', label), label)
    change = balancer.change(other, arm)
    assert np.array_equal(change, balancer(other).residual - balancer(arm).residual)
    shown = [k % 2 == 0 for k in range(count)] + [False] * count    # friction: in A alone
    assert list(change.any(axis=0)) == shown


def test_a_contact_is_that_of_its_own_recording(recorded):
    arm, measurement = recorded
    half = len(measurement.command) // 2
    balancer = Balancer(replace(measurement, begins=(0, half)))
    touched = replace(typical(arm, 'external_contact', None), onset=half * 1e-3 + 0.5)
    assert isinstance(touched, ExternalContact)
    other = arm.with_effect(touched)
    assert agrees(balancer, other)
    assert balancer.change(other, arm).any()


def test_an_arm_like_another_changes_nothing(recorded):
    arm, measurement = recorded
    assert not Balancer(measurement).change(arm, replace(arm)).any()


@pytest.mark.parametrize('beside', [
    (LinkBearingFriction(level=1.0), 'joint1'), (ExternalContact(force=5.0, duration=1.0), None)])
def test_what_acts_by_way_of_a_base_is_run_as_a_whole(beside):
    arm = read_arm('hda_arm.yaml').with_effect(BaseVibration(amplitude=0.01)).with_effect(*beside)
    balancer = Balancer(recording(arm))
    other = arm.with_effect(CoulombFriction(level=0.5), 'joint2')
    for one in (arm, other, arm):
        assert np.array_equal(balancer(one).residual, whole(balancer, one))


@pytest.mark.parametrize('effect', [TorsionalHysteresis(level=2.0, width=1e-4),
                                    PreslidingFriction(stiffness=5.0)])
def test_what_effects_remember_is_that_of_whole_runs(effect):
    arm = read_arm('hda_arm.yaml')
    balancer = Balancer(recording(arm))
    assert not balancer.memory(arm).any()
    assert balancer.memory(arm.with_effect(effect, 'joint1'))[:, 0].any()
    assert not balancer.memory(arm.with_effect(effect, 'joint1'))[:, 1].any()
    shaken = arm.with_effect(BaseVibration(amplitude=0.01))
    memory = balancer.memory(shaken.with_effect(effect, 'joint1'))
    assert np.array_equal(balancer.memory(shaken)[:, 0, [3, 4]], memory[:, 0, [3, 4]])


def test_what_was_not_asked_for_the_longest_is_forgotten():
    found, known = [], RecentCache[str](2)

    def ask(key: str) -> str:
        return known.of(key, lambda: found.append(key) or key.upper())

    assert [ask(key) for key in 'abacab'] == list('ABACAB')
    assert ''.join(found) == 'abcb'

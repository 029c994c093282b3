"""What another arm changes in the balances is what whole runs of the kernel say it is."""

from dataclasses import replace

from hda_arm_sim.model.effects import (BaseVibration, CoulombFriction, effect_named,
                                       ExternalContact, LinkBearingFriction, Scope)
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.model.typical_sizes import SIZED, typical
from hda_arm_sim.motions import motion_of
from hda_torque_estimator.diagnosis.balances.balance import Balancer
from hda_torque_estimator.diagnosis.balances.changes import Changes
from hda_torque_estimator.measurements.measurement import Measurement
from hda_torque_estimator.simulating.closed_loop import run
import numpy as np
import pytest

ARMS = ('hda_arm.yaml', 'cobot7.yaml', 'one')
OF_A_PLANE = {'inertial_coupling'}


@pytest.fixture(scope='module', params=ARMS)
def recorded(request):
    """Return an arm and 6 s of its motion."""
    arm = read_arm('hda_arm.yaml' if request.param == 'one' else request.param)
    if request.param == 'one':
        arm = replace(arm, joints=arm.joints[:1])
    made = run(arm, arm, motion_of(arm, 'rich', 6.0, 1e-3, 5), 5, estimator=None)
    return arm, Measurement(arm.labels, 1e-3, np.ascontiguousarray(made.reading[:, :, :2]),
                            made.command)


@pytest.mark.parametrize('led', [False, True])
def test_changes_are_those_of_whole_runs(recorded, led):
    arm, measurement = recorded
    balancer = Balancer(replace(measurement, led=led))
    balancer = balancer.whitened(arm, np.zeros(2 * len(arm.joints)))
    changes, label = Changes(balancer, arm), arm.labels[-1]
    for name in SIZED:
        if len(arm.joints) != 2 and name in OF_A_PLANE:
            continue
        joint = None if effect_named(name).scope is Scope.ARM else label
        other = arm.with_effect(typical(arm, name, joint), joint)
        whole = balancer(other).residual - balancer(arm).residual
        assert changes.by(other) == pytest.approx(whole, abs=1e-9), name


def test_what_a_gear_of_each_second_joint_changes_shows_there_only(recorded):
    arm, measurement = recorded
    balancer, other, count = Balancer(measurement), arm, len(arm.joints)
    for label in arm.labels[::2]:
        other = other.with_effect(typical(arm, 'stribeck_friction', label), label)
    whole, change = balancer(other).residual - balancer(arm).residual, Changes(balancer, arm)
    assert change.by(other) == pytest.approx(whole, abs=1e-9)
    shown = [k % 2 == 0 for k in range(count)] + [False] * count    # friction: in A alone
    assert list(change.by(other).any(axis=0)) == shown


def test_gears_and_links_change_at_once(recorded):
    arm, measurement = recorded
    balancer, label = Balancer(measurement), arm.labels[0]
    other = arm.with_effect(typical(arm, 'kinematic_error', label), label)
    other = other.with_effect(typical(arm, 'payload', None))
    whole = balancer(other).residual - balancer(arm).residual
    assert Changes(balancer, arm).by(other) == pytest.approx(whole, abs=1e-9)


def test_a_contact_is_that_of_its_own_recording(recorded):
    arm, measurement = recorded
    half = len(measurement.command) // 2
    balancer = Balancer(replace(measurement, begins=(0, half)))
    touched = replace(typical(arm, 'external_contact', None), onset=half * 1e-3 + 0.5)
    assert isinstance(touched, ExternalContact)
    other = arm.with_effect(touched)
    whole = balancer(other).residual - balancer(arm).residual
    change = Changes(balancer, arm).by(other)
    assert change == pytest.approx(whole, abs=1e-9)
    assert change.any()


def test_an_arm_like_another_changes_nothing(recorded):
    arm, measurement = recorded
    assert not Changes(Balancer(measurement), arm).by(arm).any()


@pytest.mark.parametrize('handing', [
    (LinkBearingFriction(level=1.0), 'joint1'), (BaseVibration(amplitude=0.01), None)])
def test_what_hands_on_torques_of_gears_is_run_as_a_whole(handing):
    arm = read_arm('hda_arm.yaml').with_effect(*handing)
    made = run(arm, arm, motion_of(arm, 'rich', 6.0, 1e-3, 5), 5, estimator=None)
    balancer = Balancer(Measurement(
        arm.labels, 1e-3, np.ascontiguousarray(made.reading[:, :, :2]), made.command))
    other = arm.with_effect(CoulombFriction(level=0.5), 'joint2')
    whole = balancer(other).residual - balancer(arm).residual
    assert np.array_equal(Changes(balancer, arm).by(other), whole)

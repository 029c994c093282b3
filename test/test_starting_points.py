"""Find what no fixed grid can start from: effects at a bound, at a time, at a frequency."""

from dataclasses import replace

from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import motion
from hda_torque_estimator.diagnosis.balances.balance import Balancer
from hda_torque_estimator.diagnosis.balances.healthy_twin import noise_of
from hda_torque_estimator.diagnosis.diagnose import diagnose
from hda_torque_estimator.diagnosis.fitting.starting_points import (
    contact_in, split_at_contacts)
from hda_torque_estimator.measurements.measurement import Measurement
from hda_torque_estimator.measurements.running_clock import inside, split
import numpy as np
import pytest
from truth import draw, record, Reference

ARM = read_arm('hda_arm.yaml')
DECOUPLED = replace(ARM, links=replace(ARM.links, coupled=0.0))


def measured(hidden, seed, duration=30.0):
    """Return the measurement of an arm with hidden effects in the motion that shows most."""
    asked = motion('rich', 2, duration, 1e-3, seed)
    made = record(hidden, Reference(asked.angle, asked.rate, 1e-3), seed=seed)
    return Measurement(ARM.labels, 1e-3, np.stack([made.motor_angle, made.link_angle], axis=2),
                       made.command)


def named(diagnosis):
    """Return what a diagnosis names: effects and joints."""
    return [(found.effect, found.joint) for found in diagnosis.findings]


@pytest.mark.parametrize(('hides', 'arm', 'share'), [(True, ARM, -1.0), (False, DECOUPLED, 1.0)])
def test_coupling_is_found_both_ways(hides, arm, share):
    """An arm that is given coupled and is not, and one that is not and should be."""
    hidden = [draw('inertial_coupling', np.random.default_rng(1))] if hides else []
    found = diagnose(measured(hidden, 110), arm).diagnosis
    assert named(found) == [('inertial_coupling', None)]
    assert found.findings[0].parameters['share'].value == pytest.approx(share, abs=0.03)
    assert found.gain.removed > 0.98


@pytest.fixture(scope='module')
def touched():
    """Return a contact and what is found of an arm that it hides in."""
    hidden = draw('external_contact', np.random.default_rng(102))
    hidden.parameters.update(onset=12.3)
    return hidden, diagnose(measured([hidden], 102), ARM).diagnosis


def test_fits_see_begin_and_end_of_every_push_and_not_its_middle():
    """Of three short ones after each other, stretches as they alternate would have one or none."""
    hidden = draw('external_contact', np.random.default_rng(102))
    hidden.parameters.update(onset=8.3, duration=0.8, force=30.0)
    hidden = replace(hidden, form='several', law=(4.0, 5.2, 3.0))
    balancer = Balancer(measured([hidden], 102))
    noise = noise_of(balancer, ARM)[0]
    training, held_out = split_at_contacts(balancer, ARM, noise, *split(balancer.measurement))
    for onset in (8.3, 13.5, 18.7):
        assert inside(onset + np.array([0.02, 0.1, 0.7, 0.78]), training).all()
        assert inside(onset + np.array([0.35, 0.45]), held_out).all()
    time = balancer.time
    assert not (inside(time, training) & inside(time, held_out)).any()


def test_contact_is_found_in_time(touched):
    hidden, found = touched
    assert named(found) == [('external_contact', None)]
    fitted = found.findings[0].parameters
    assert fitted['force'].value == pytest.approx(hidden.parameters['force'], rel=0.07)
    for name, near in (('direction', 0.03), ('onset', 0.06), ('duration', 0.12)):
        assert fitted[name].value == pytest.approx(hidden.parameters[name], abs=near)


def test_contact_gains_where_no_fit_has_seen_it(touched):
    """The middle of the contact is held out; its begin and its end are not."""
    hidden, found = touched
    middle = hidden.parameters['onset'] + 0.5 * hidden.parameters['duration']
    held = [span for span in found.recording.held_out if span[0] <= middle < span[1]]
    assert len(held) == 1
    assert not any(first < held[0][1] and last > held[0][0]
                   for first, last in found.recording.training)
    assert found.gain.before > 10.0 * found.gain.floor and found.gain.removed > 0.98


@pytest.mark.parametrize('name', ['base_tilt', 'payload', 'cubic_spring'])
def test_rest_of_another_cause_is_no_contact(name):
    """A smooth rest has a best time as well; it must not stand out enough to be a contact."""
    hidden = draw(name, np.random.default_rng(3))
    balancer = Balancer(measured([hidden], 103))
    balance = balancer(ARM)
    noise = np.array([0.04, 0.04, 0.007, 0.006])
    assert np.sqrt((balance.residual[balance.valid[:, 2], 2] ** 2).mean()) > 10.0 * noise[2]
    assert contact_in(balancer, ARM, balance.residual, balance.valid, noise) is None

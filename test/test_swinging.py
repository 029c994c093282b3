"""Find a base that swings: it answers the links' own motion; a line of torque does not."""

from hda_arm_sim.model.effects import BaseVibration
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import motion
from hda_torque_estimator.diagnosis.balances.balance import Balancer
from hda_torque_estimator.diagnosis.balances.predict import prediction_errors
from hda_torque_estimator.diagnosis.balances.swinging import swing_in
from hda_torque_estimator.diagnosis.diagnose import diagnose, sought_effects
from hda_torque_estimator.measurements.measurement import Measurement
import numpy as np
import pytest
from truth import CATALOGUE, Device, draw, record, Reference
from truth_cases import EXACT, hide

ARM = read_arm('hda_arm.yaml')
NOISE = np.array([0.04, 0.04, 0.007, 0.006])        # of balances, as readings of this arm leave it
SPANS = ((1.0, 9.0),)
SWINGS = {'frequency': 10.0, 'damping': 0.04, 'amplitude': 0.03, 'direction': 2.0}
SHAKEN = ARM.with_effect(BaseVibration(**SWINGS), None)


def measured(hidden, seed, duration=10.0, **how):
    """Return the measurement of an arm with hidden effects in the motion that shows most."""
    asked = motion('rich', 2, duration, 1e-3, seed)
    made = record(hidden, Reference(asked.angle, asked.rate, 1e-3), seed=seed, **how)
    return Measurement(ARM.labels, 1e-3, np.stack([made.motor_angle, made.link_angle], axis=2),
                       made.command)


def line(frequency, joint):
    """Return a torque on one link that keeps to its frequency whatever the arm does."""
    return hide('link_torque_line', joint, amplitude=1.0, frequency=frequency, phase=0.4)


@pytest.fixture(scope='module')
def shaken():
    """Return the balances of an arm whose base swings, as exact encoders show it."""
    return Balancer(measured([hide('base_vibration', None, **SWINGS)], 101, noise=0.0,
                             device=Device(scatter=False, counts=EXACT)))


def missed(balancer, arm):
    """Return the rms of the torsion balances [N*m]."""
    balance = balancer(arm)
    return np.array([balance.residual[balance.valid[:, column], column].std()
                     for column in (2, 3)])


def test_balances_close_along_a_swinging_base(shaken):
    assert (missed(shaken, ARM) > 0.04).all()
    assert (missed(shaken, SHAKEN) < 0.002).all()


def test_windows_begin_with_the_base_where_it_is(shaken):
    rigid, swinging = (prediction_errors(shaken, arm, SPANS).mean(axis=0)
                       for arm in (ARM, SHAKEN))
    torsions = slice(4, 6)              # motors and links miss what bristles do as well
    assert (swinging[torsions] < [0.01, 0.03] * rigid[torsions]).all()


def test_mode_stands_out_of_what_a_rigid_base_leaves():
    """From readings as a driver has them, of an arm that is off within its tolerances."""
    balancer = Balancer(measured([hide('base_vibration', None, **SWINGS)], 102))
    balance = balancer(ARM)
    found = swing_in(balancer, ARM, balance.residual, balance.valid, NOISE)
    assert found is not None
    assert found.frequency == pytest.approx(SWINGS['frequency'], rel=0.03)
    assert found.amplitude == pytest.approx(SWINGS['amplitude'], rel=0.3)
    assert found.direction == pytest.approx(SWINGS['direction'], abs=0.2)


def test_swinging_base_is_found_alone():
    hidden = draw('base_vibration', np.random.default_rng(3))
    found = diagnose(measured([hidden], 103, 30.0), ARM).diagnosis
    assert [(cause.effect, cause.joint) for cause in found.findings] == [('base_vibration', None)]
    fitted = found.findings[0].parameters
    for name in ('frequency', 'amplitude'):
        assert fitted[name].value == pytest.approx(hidden.parameters[name], rel=0.03)
    assert found.gain.removed > 0.95


def test_base_that_creeps_back_is_found_with_its_damping():
    hidden = hide('base_vibration', None, **{**SWINGS, 'damping': 1.4})
    found = diagnose(measured([hidden], 105, 30.0), ARM).diagnosis
    assert [(cause.effect, cause.joint) for cause in found.findings] == [('base_vibration', None)]
    fitted = found.findings[0].parameters['damping']
    assert fitted.low <= 1.4 <= fitted.high < 2.0


@pytest.mark.study
@pytest.mark.parametrize(('frequency', 'joint'), [(8.3, 'joint1'), (9.0, 'joint2')])
def test_line_at_the_frequency_of_a_base_is_unknown(frequency, joint):
    found = diagnose(measured([line(frequency, joint)], 104, 30.0), ARM).diagnosis
    assert (found.verdict, found.findings) == ('unknown', ())
    assert found.unexplained.line == pytest.approx(frequency, abs=0.05)


def test_every_effect_of_the_catalogue_is_sought():
    assert {effect.name for effect in CATALOGUE} <= set(sought_effects())

"""What a cause gains on held-out stretches: in predictions, or in balances where these hide it."""

from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import motion
from hda_torque_estimator.diagnosis.diagnose import diagnose
from hda_torque_estimator.diagnosis.findings.gains import Gains, METRIC
from hda_torque_estimator.diagnosis.judging import held_out_gain as module
from hda_torque_estimator.diagnosis.judging.held_out_gain import held_out_gain, IN_BALANCES
from hda_torque_estimator.measurements.measurement import Measurement
import numpy as np
import pytest
from truth import record, Reference, worlds
from truth_cases import hide
from world_fits import diagnosed

ARM = read_arm('hda_arm.yaml')
SEED, DT, SECONDS = 141, 1e-3, 20.0
PLACE = ('viscous_friction', 'joint1')
WINDOWS = 60


@pytest.fixture(scope='module')
def evidence():
    """Return what a diagnosis rests on that found a viscous friction."""
    asked = motion('rich', 2, SECONDS, DT, SEED)
    made = record([hide(*PLACE, slope=6e-4)], Reference(asked.angle, asked.rate, DT), seed=SEED)
    found = diagnose(Measurement(ARM.labels, DT, np.stack(
        [made.motor_angle, made.link_angle], 2), made.command), ARM, names=[
            'viscous_friction', 'nonlinear_viscous_friction', 'coulomb_friction'])
    assert [(one.effect, one.joint) for one in found.diagnosis.findings] == [PLACE]
    return found.evidence


def gained(evidence):
    """Return the gain of the cause that was found."""
    term, = evidence.fit.accepted
    return held_out_gain(evidence.fitter, evidence.fit, term, evidence.twin, evidence.held_out)


def predicting(monkeypatch, mean, scatter):
    """Let predictions with the cause be better by a mean, with so much scatter of windows."""
    draws = np.random.default_rng(5).standard_normal(WINDOWS)
    better = mean + scatter * (draws - draws.mean())
    monkeypatch.setattr(module, 'gains', lambda *given: Gains(
        20.0 + better, np.full(WINDOWS, 20.0), np.ones(WINDOWS)))


def test_a_gain_is_that_of_predictions_where_they_show_it(evidence):
    gain = gained(evidence)
    assert gain.metric == METRIC
    assert gain.removed > 0.9 and gain.low > 0.0
    assert gain.placebo < 0.1


@pytest.mark.parametrize('mean', [-0.2, 0.2])
def test_where_predictions_cannot_show_it_the_balances_are_asked(evidence, monkeypatch, mean):
    predicting(monkeypatch, mean, scatter=5.0)
    gain = gained(evidence)
    assert gain.metric == IN_BALANCES
    assert 0.9 < gain.removed <= 1.1 and 0.0 < gain.low < gain.removed < gain.high
    assert gain.removed == pytest.approx((gain.before - gain.after) / (gain.before - gain.floor),
                                         abs=0.05)


def test_predictions_that_see_nothing_of_it_leave_it_to_the_balances(evidence, monkeypatch):
    """Of a short push no window may hold anything, beside what hid it when stretches were cut."""
    predicting(monkeypatch, 0.0, scatter=0.0)
    gain = gained(evidence)
    assert gain.metric == IN_BALANCES
    assert gain.removed > 0.9


@pytest.mark.parametrize('mean', [-0.8, -4.0])
def test_predictions_that_lean_to_the_worse_decide(evidence, monkeypatch, mean):
    """Their means reach 1.1 either way, in 90 % of draws."""
    predicting(monkeypatch, mean, scatter=5.0)
    assert gained(evidence) is None


def test_a_play_that_a_coarse_encoder_hides_from_predictions_is_named():
    """Of 1024 counts at 250 Hz they remove 1.0 with an interval from -1 to 1, balances all."""
    world = worlds.draw(1110116, ('backlash',), motion='rich', rate=250)
    found = diagnosed(world)
    assert [(one.effect, one.gain.metric) for one in found.findings] == [('backlash', IN_BALANCES)]


@pytest.mark.study
def test_what_a_push_leaves_of_some_seconds_hides_no_gain_of_others():
    """Of a half sine a smooth push leaves 4800 times noise; a tilt acts all the time."""
    world = worlds.draw(799451, ('external_contact', 'coarse_quantisation', 'base_tilt'),
                        motion='rich', rate=1000, joints=2)
    found = diagnosed(world)
    assert {one.effect for one in found.findings} == {one.effect for one in world.hidden}

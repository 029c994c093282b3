"""A placebo as free as a cause gains nothing on held-out stretches; a true cause does."""

from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import motion
from hda_torque_estimator.diagnosis.diagnose import diagnose
from hda_torque_estimator.diagnosis.findings.report import OwnGain
from hda_torque_estimator.diagnosis.fitting.hypotheses import terms_of
from hda_torque_estimator.diagnosis.judging import held_out_gain
from hda_torque_estimator.diagnosis.judging.placebo import (moved_away, placebo_shares,
                                                            RemovedShares)
from hda_torque_estimator.diagnosis.judging.search import Reason, SearchResult
from hda_torque_estimator.diagnosis.validation import proven
from hda_torque_estimator.measurements.measurement import Measurement
import numpy as np
import pytest
from truth import record, Reference
from truth_cases import hide

ARM = read_arm('hda_arm.yaml')
SEED, DT = 121, 1e-3
HIDDEN = [
    ('stribeck_friction', 'joint1', {'excess': 0.03, 'speed': 8.0}),
    ('payload', None, {'mass': 2.5}),
    pytest.param('base_tilt', None, {'tilt': 0.03, 'direction': 0.7}, marks=pytest.mark.study),
    pytest.param('kinematic_error', 'joint2', {'amplitude_2': 8e-5, 'phase_2': 0.5},
                 marks=pytest.mark.study),
]


def concluded(hidden=(), seconds=24.0):
    """Return what is concluded of a recording of an arm with hidden effects."""
    asked = motion('rich', 2, seconds, DT, SEED)
    made = record(hidden, Reference(asked.angle, asked.rate, DT), seed=SEED)
    return diagnose(Measurement(ARM.labels, DT, np.stack([made.motor_angle, made.link_angle], 2),
                                made.command), ARM)


@pytest.mark.parametrize(('effect', 'joint', 'numbers'), HIDDEN)
def test_a_true_cause_gains_and_its_placebo_does_not(effect, joint, numbers):
    evidence = concluded([hide(effect, joint, **numbers)]).evidence
    term = next(one for one in evidence.fit.accepted if (one.name, one.joint) == (effect, joint))
    shares = placebo_shares(evidence.fitter, evidence.fit, term)
    assert shares.cause > 0.9
    assert shares.placebo < 0.1


def test_a_cause_that_is_not_there_gains_no_more_than_its_placebo():
    evidence = concluded().evidence
    fitter = evidence.fitter
    for effect in ('motor_cogging', 'kinematic_error', 'encoder_scale_error'):
        wrong = next(term for term in terms_of(fitter.arm, effect) if term.joint == 'joint2')
        fit = fitter.refit(fitter.fit(()), wrong)
        shares = placebo_shares(fitter, fit, fit.accepted[-1])
        assert shares.cause < 0.05


@pytest.mark.study
def test_what_a_dropped_cause_explained_is_a_rest_without_a_name(monkeypatch):
    """Its placebo equals it, so it goes, and takes with it what else rests on its joint."""
    hidden = [hide('kinematic_error', 'joint2', amplitude_2=8e-5, phase_2=0.5),
              hide('coulomb_friction', 'joint2', level=0.01),
              hide('coulomb_friction', 'joint1', level=0.01)]
    findings = concluded(hidden, seconds=12.0).diagnosis.findings
    assert {(found.effect, found.joint) for found in findings} == {
        (cause.effect, cause.joint) for cause in hidden}
    assert all(isinstance(found.gain, OwnGain) and found.gain.placebo < 0.1 for found in findings)
    shares = held_out_gain.placebo_shares
    monkeypatch.setattr(held_out_gain, 'placebo_shares', lambda fitter, fit, term: (
        RemovedShares(0.9, 0.9) if term.name == 'kinematic_error' else shares(fitter, fit, term)))
    left = concluded(hidden, seconds=12.0).diagnosis
    assert left.verdict == 'unknown' and left.unexplained.joint == 'joint2'
    assert [(found.effect, found.joint) for found in left.findings] == [
        ('coulomb_friction', 'joint1')]
    assert any('kinematic_error at joint2 is not named' in remark for remark in left.remarks)


def test_what_chance_explained_is_no_rest():
    """A cause that is not there goes, and the arm is as healthy as before."""
    evidence = concluded(seconds=12.0).evidence
    fitter, known = evidence.fitter, evidence.fitter.fit(())
    wrong = next(term for term in terms_of(fitter.arm, 'kinematic_error')
                 if term.joint == 'joint2')
    fit = fitter.refit(known, wrong)
    found = SearchResult(known, fit, (Reason(100.0, 68.0, None, 100.0),))
    left = proven(fitter, found, evidence.twin, fitter.arm, evidence.held_out, lambda _: None)
    assert (left.findings, left.remarks, left.judged.unexplained.any()) == ((), (), False)


def columns(*made):
    """Return columns over one channel, as a fit has them (m, 1, p)."""
    return np.stack(made, axis=1)[:, None, :]


def test_placebos_have_the_size_and_the_spectrum_of_the_columns_and_are_not_like_them():
    time = np.linspace(0.0, 60.0, 7500, endpoint=False)
    wave, square = np.sin(2.0 * np.pi * 0.5 * time), np.sign(np.sin(2.0 * np.pi * 0.11 * time + 1))
    real = columns(wave, square)
    for placebo in moved_away(real):
        assert placebo.shape == real.shape
        for own, other in zip(real[:, 0].T, placebo[:, 0].T):
            assert other.std() == pytest.approx(own.std())
            assert np.abs(np.fft.rfft(other))[1:] == pytest.approx(
                np.abs(np.fft.rfft(own))[1:], abs=1e-6)
            assert abs(np.corrcoef(own, other)[0, 1]) < 0.15


def test_a_constant_has_no_placebo_but_nothing():
    for placebo in moved_away(columns(np.ones(1000))):
        assert not placebo.any()

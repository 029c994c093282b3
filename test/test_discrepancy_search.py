"""What is in the catalogue is named beside what no catalogue lists, nothing stands for that."""

from dataclasses import replace

from hda_torque_estimator.diagnosis.balances.balance import Balancer, Shape
from hda_torque_estimator.diagnosis.diagnose import diagnose, sought_effects
from hda_torque_estimator.diagnosis.fitting.fit import Fitter
from hda_torque_estimator.diagnosis.fitting.hypotheses import terms_of
from hda_torque_estimator.diagnosis.judging.discrepancy_search import is_outdone
from hda_torque_estimator.diagnosis.judging.discrepancy_terms import (
    DiscrepancyTerm, DiscrepancyTerms)
from hda_torque_estimator.diagnosis.judging.forward_selection import Reason
from hda_torque_estimator.significance import MATERIAL, SCORE_BAR
import numpy as np
import pytest
from truth_cases import hide
import truth_fits
from truth_fits import ARM

LINE = hide('motor_torque_line', 'joint2', amplitude=0.01, frequency=5.3, phase=0.4)
TOOTH = hide('tooth_torque', 'joint1', amplitude=1.2, order=6, phase=1.0)
DRIFT = hide('encoder_drift', 'joint2', rate=-4e-6)
THIRD = hide('third_order_kinematic_error', 'joint2', amplitude=1e-4, phase=0.5)
SOFTER = hide('stiffness_error', 'joint1', relative_error=-0.18)
LAG = hide('current_loop_lag', 'joint2', time_constant=0.005)
FRICTION = hide('coulomb_friction', 'joint2', level=0.02)
BEARING = hide('link_bearing_friction', 'joint1', level=1.0)
LOOSE = hide('coulomb_friction', 'joint2', level=-0.03)     # far beyond the tolerance of it


def measured(*hidden):
    """Return a recording of an arm with hidden effects."""
    return truth_fits.measured(hidden, 24.0, 134)


def fitter_of(measurement):
    """Return what fits all rows of a recording, with the noise that its balances have."""
    balancer = Balancer(measurement)
    added = balancer.noisier(ARM).residual - balancer(ARM).residual
    return Fitter(balancer, ARM, added.std(axis=0), 0.5, np.ones(len(balancer.time), bool))


@pytest.mark.parametrize(('known', 'nameless', 'site', 'follows'), [
    (FRICTION, LINE, 'motor', 'time'),
    pytest.param(SOFTER, TOOTH, 'link', 'link_angle', marks=pytest.mark.study),
    pytest.param(LAG, DRIFT, 'torsion', 'time', marks=pytest.mark.study)],
    ids=lambda one: getattr(one, 'effect', ''))
def test_a_cause_is_named_beside_what_has_no_name_at_its_joint(known, nameless, site, follows):
    said = diagnose(measured(known, nameless), ARM).diagnosis
    assert [(one.effect, one.joint) for one in said.findings] == [(known.effect, known.joint)]
    assert said.verdict == 'unknown'
    assert any(f'without a name at the {site} of {nameless.joint} follows' in remark
               for remark in said.remarks)
    rest = said.unexplained
    assert (rest.site, rest.joint, rest.depends_on) == (site, nameless.joint, follows)
    assert said.findings[0].probability >= 0.95
    assert said.findings[0].gain.removed > 0.0


@pytest.mark.study
def test_nothing_stands_for_a_cause_that_the_catalogue_lacks():
    names = [name for name in sought_effects() if name != 'clock_skew']
    skewed = measured(hide('clock_skew', 'joint2', skew=-3e-4))
    said = diagnose(skewed, ARM, names=names).diagnosis
    assert (said.verdict, said.findings, said.ambiguous) == ('unknown', (), ())
    assert said.unexplained.joint == 'joint2'


@pytest.mark.parametrize(('hidden', 'coordinate', 'form'), [
    (LINE, 'time', 'line of 5.300 Hz'), (TOOTH, 'link_angle', '6 per turn'),
    (DRIFT, 'time', 'trend'),
    (THIRD, 'motor_angle', '3 per turn'),
    (hide('crossed_friction', 'joint1', amplitude=0.5, order=3), 'other_link_angle',
     '3 per turn, by sense'),
    (BEARING, 'motor_velocity', 'sense over 1 rad/s'), (LOOSE, 'motor_velocity', 'sense'),
    (hide('torque_constant_error', 'joint2', relative_error=0.1), 'motor_torque', 'power 1')],
    ids=lambda one: getattr(one, 'effect', ''))
def test_the_best_cause_without_a_name_is_what_was_hidden(hidden, coordinate, form):
    fitter = fitter_of(measured(hidden))
    best = DiscrepancyTerms.along(fitter).best(fitter, fitter.first, ARM.labels)
    assert (best.joint, best.site, best.coordinate, best.form) == (
        hidden.joint, hidden.site, coordinate, form)


def test_noise_of_torques_is_no_cause_without_a_name():
    fitter = fitter_of(measured())
    best = DiscrepancyTerms.along(fitter).best(fitter, fitter.first, ARM.labels)
    assert best.improvement < SCORE_BAR


def test_dry_friction_beyond_its_tolerance_leaves_noise_beside_the_sense_of_motion():
    """A law of the catalogue with a sense that is nearer to a step would stand for it."""
    fitter = fitter_of(measured(LOOSE))
    best = DiscrepancyTerms.along(fitter).best(fitter, fitter.first, ARM.labels)
    beside = replace(fitter, balancer=fitter.balancer.beside(
        best.shapes(fitter.first.balance.valid)))
    motor = fitter.own_channels(LOOSE.joint)[0]
    assert beside.first.variance[motor] < (1.0 + MATERIAL ** 2) * fitter.noise[motor] ** 2


@pytest.mark.parametrize(('joint', 'site', 'more', 'outdone'), [
    ('joint2', 'torsion', True, True), ('joint2', 'gear', True, True),
    ('joint2', 'torsion', False, False), ('joint2', 'motor', True, False),
    ('joint1', 'torsion', True, False)])
def test_what_has_no_name_may_do_less_at_its_site_as_well(joint, site, more, outdone):
    term = next(term for term in terms_of(ARM, 'loaded_kinematic_error')
                if term.joint == 'joint2')
    nameless = DiscrepancyTerm(joint, site, 'motor_angle', '2 per turn', (3,), np.zeros((1, 2)),
                               900.0)
    reason = Reason(800.0 if more else 1000.0, 70.0, None, 0.0)
    assert is_outdone(term, reason, [nameless]) is outdone


def test_what_is_taken_aside_is_in_no_balance_any_more():
    balancer = Balancer(measured(TOOTH))
    balance = balancer(ARM)
    held = balance.valid[:, 0]
    wave = np.sin(6.0 * np.linspace(0.0, 9.0, len(held)))
    beside = balancer.beside([Shape(0, wave, held)])
    column = np.where(held, wave, 0.0)
    other = ARM.with_effect(replace(ARM.effect('coulomb_friction', 'joint1'), level=0.02),
                            'joint1')
    for values in (beside(ARM).residual, beside.change(other, ARM),
                   beside.thinned.change(other, ARM)):
        assert abs(column @ values[:, 0]) < 1e-9 * np.linalg.norm(values[:, 0])
    assert np.array_equal(beside(ARM).residual[:, 1:], balance.residual[:, 1:])
    kept = balance.residual[:, 0] - beside(ARM).residual[:, 0]
    assert np.allclose(kept, column * (column @ balance.residual[:, 0]) / (column @ column))

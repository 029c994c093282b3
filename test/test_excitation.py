"""
A recording shows an effect from the size that it states, and abstains where it shows too little.

Effects are hidden a little below and above that size, in the truth's own formulas.
"""

from dataclasses import replace
from functools import cache

from hda_arm_sim.foundation.parameter import ParameterError
from hda_arm_sim.model.arm import ArmError
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.model.kernel import LINK_ANGLE
from hda_arm_sim.motions import motion
from hda_torque_estimator.diagnosis.detectability.excitation import asked
from hda_torque_estimator.diagnosis.detectability.visibility import Imagined, Visibility
from hda_torque_estimator.diagnosis.diagnose import diagnose, sought_effects
from hda_torque_estimator.diagnosis.findings.smallest import Smallest
from hda_torque_estimator.diagnosis.fitting.fit import Fitter
from hda_torque_estimator.diagnosis.fitting.hypotheses import terms_of
from hda_torque_estimator.diagnosis.judging.screening import shifts
from hda_torque_estimator.diagnosis.judging.search import SearchResult
from hda_torque_estimator.diagnosis.readings.encoder_steps import coarse_encoders, smallest_step
from hda_torque_estimator.diagnosis.readings.line_error import smallest_wave, uneven_lines
from hda_torque_estimator.diagnosis.readings.lost_samples import (lost_samples, slips_of,
                                                                  smallest_rate)
from hda_torque_estimator.measurements.measurement import Measurement
import numpy as np
import pytest
from truth import Device, record, Reference
from truth_cases import hide

ARM = read_arm('hda_arm.yaml')
SEED, SECONDS, DT = 120, 24.0, 1e-3
BELOW, ABOVE = 0.6, 1.6


def measured(hidden=(), name='rich', size=1.0, seconds=SECONDS):
    """
    Return a recording of an arm with hidden effects, all else nominal.

    Motions may be made smaller.
    """
    asked_for = motion(name, 2, seconds, DT, SEED)
    start = asked_for.angle[:1]
    made = record(hidden,
                  Reference(start + size * (asked_for.angle - start), size * asked_for.rate, DT),
                  seed=SEED, device=Device(scatter=False))
    return Measurement(ARM.labels, DT, np.stack([made.motor_angle, made.link_angle], axis=2),
                       made.command)


@cache
def healthy():
    """Return what is concluded of a healthy arm."""
    return diagnose(measured(), ARM)


def smallest(effect, joint):
    """Return the size that a healthy arm's report states."""
    return next(row.smallest_detectable for row in healthy().diagnosis.excitation
                if (row.effect, row.joint) == (effect, joint))


# Effect, joint, number of the truth, shapes, a size that hides and one that shows. Of a tilt the
# size is that of the direction that shows least; others show at less. A tilt of 1.6 times that
# size gains 5 % on held-out stretches, give or take 6 %, so the next thousandth decides.
HIDDEN = [
    ('clock_skew', 'joint2', 'skew', {}, BELOW, ABOVE),
    pytest.param('coulomb_friction', 'joint1', 'level', {}, BELOW, ABOVE,
                 marks=pytest.mark.study),
    pytest.param('base_tilt', None, 'tilt', {'direction': 0.7}, 0.5 * BELOW, 1.8,
                 marks=pytest.mark.study),
]


@pytest.mark.parametrize(('effect', 'joint', 'number', 'shape', 'below', 'above'), HIDDEN)
def test_an_effect_is_found_above_the_smallest_size_and_not_below(effect, joint, number, shape,
                                                                  below, above):
    size = smallest(effect, joint)
    for share, findings in ((below, []), (above, [(effect, joint)])):
        hidden = hide(effect, joint, **{number: share * size}, **shape)
        found = diagnose(measured([hidden]), ARM).diagnosis
        assert [(one.effect, one.joint) for one in found.findings] == findings


def test_the_size_of_a_cable_shows_wherever_it_rests():
    """
    Nobody chooses where: the place within the travel of its link counts that shows least.

    Sizes are made of thinned balances, which show up to a tenth less than all rows would need.
    """
    evidence = healthy().evidence
    fitter = replace(evidence.fitter, balancer=evidence.fitter.balancer.thinned)
    fit = fitter.at(evidence.fit.terms, len(evidence.fit.accepted), evidence.fit.slopes)
    travel = fitter.balancer.motion(fitter.arm).state[:, 1, LINK_ANGLE]
    judge, sizes = Visibility(fitter, SearchResult(fit, fit, ()), fit), []
    for rest_angle in np.linspace(travel.min(), travel.max(), 5):
        start = next(term for term in terms_of(fitter.arm, 'cable_spring')
                     if term.joint == 'joint2')
        start = replace(start, effect=replace(start.effect, rest_angle=float(rest_angle)))
        (_, shift), = shifts(fitter, fit, [start])
        sizes.append(start.all_steps()[0] * judge.least(start, Imagined(shift, 0.0), 1e6))
    assert max(sizes) > 1.2 * min(sizes)
    assert smallest('cable_spring', 'joint2') > 0.95 * max(sizes)


def test_every_effect_at_every_place_has_its_row():
    rows = healthy().diagnosis.excitation
    assert list(dict.fromkeys(row.effect for row in rows)) == list(sought_effects())
    assert len({(row.effect, row.joint) for row in rows}) == len(rows)
    assert all(row.smallest_detectable is None or row.smallest_detectable > 0.0 for row in rows)


def test_sizes_grow_with_the_noise():
    """Where nothing is known of a number beforehand, twice the noise hides twice the size."""
    evidence = healthy().evidence
    fitter, fit = evidence.fitter, evidence.fit
    loud = Fitter(fitter.balancer, fitter.arm, 2.0 * fitter.noise, fitter.effective, fitter.rows)
    twice = replace(fit, variance=4.0 * fit.variance,
                    balance=replace(fit.balance, residual=2.0 * fit.balance.residual))
    for name in ('drive_offset', 'clock_skew', 'encoder_scale_error'):
        term, shift = next(shifts(fitter, fit, list(terms_of(fitter.arm, name))))
        size, larger = (
            Visibility(judge, SearchResult(left, left, ()), left).least(term,
                                                                        Imagined(shift, 0.0), 1e6)
            for judge, left in ((fitter, fit), (loud, twice)))
        assert larger == pytest.approx(2.0 * size, rel=0.05)


def test_healthy_and_rich_is_no_discrepancy():
    assert healthy().diagnosis.verdict == 'no_discrepancy'


@pytest.mark.parametrize(('size', 'verdict'), [
    (0.01, 'insufficient_excitation'),
    (0.027, 'no_discrepancy')])                 # shows 27 of 42 effects, and says so
def test_a_tiny_motion_abstains_or_says_what_it_could_not_show(size, verdict):
    found = diagnose(measured(size=size), ARM).diagnosis
    assert found.verdict == verdict
    assert found.findings == ()
    assert any('could not have been seen' in said for said in found.sentences())


@pytest.mark.parametrize(('word', 'verdict'), [
    ('motor_inertia_error@joint1', 'insufficient_excitation'),
    ('coulomb_friction', 'no_discrepancy'),
])
def test_silence_counts_only_for_effects_that_would_have_shown(word, verdict):
    slow = measured(name='slow_sine', seconds=30.0)
    found = diagnose(slow, ARM, about=asked(ARM, [word])).diagnosis
    assert found.verdict == verdict
    assert any(said.startswith('asked about motor_inertia_error') for said in found.remarks) == (
        verdict != 'no_discrepancy')


def test_standstill_shows_nothing_at_all():
    rows = diagnose(measured(name='standstill', seconds=10.0), ARM).diagnosis.excitation
    assert {row.smallest_detectable for row in rows} == {None}
    assert {row.effect for row in rows} == set(sought_effects())


def test_asked_effects_must_exist():
    assert asked(ARM, ['payload', 'clock_skew@joint2', 'backlash']) == (
        ('payload', None), ('clock_skew', 'joint2'), ('backlash', 'joint1'),
        ('backlash', 'joint2'))
    with pytest.raises(ParameterError, match='no effect is named'):
        asked(ARM, ['rust'])
    with pytest.raises(ArmError):
        asked(ARM, ['backlash@elbow'])


def test_numbers_that_weaken_an_effect_are_stated_as_they_are():
    """A motor that clips at 0.2 N*m is worse than one that clips at 0.25."""
    assert Smallest('torque_saturation', 'joint1', 'limit', 0.2).is_shown(ARM)
    assert not Smallest('torque_saturation', 'joint1', 'limit', 0.01).is_shown(ARM)
    assert Smallest('backlash', 'joint1', 'half_width', 1e-6).is_shown(ARM)
    assert not Smallest('backlash', 'joint1', 'half_width', 1e-3).is_shown(ARM)


def seen():
    """Return the rows that count: all."""
    return np.ones(round(SECONDS / DT) + 1, bool)[:len(measured_once().command)]


@cache
def measured_once():
    """Return the readings of a healthy arm."""
    return measured()


def with_reading(reading):
    """Return the healthy measurement with other readings."""
    return replace(measured_once(), reading=reading)


def test_the_smallest_step_is_that_from_which_an_encoder_is_coarse():
    reading = measured_once().reading
    stated = ARM.effect('coarse_quantisation', 'joint1').values()[1]
    size = smallest_step(reading[:, 0, 1], stated, seen())
    for share, reported in ((BELOW, []), (ABOVE, ['joint1'])):
        coarse = reading.copy()
        coarse[:, 0, 1] = np.floor(reading[:, 0, 1] / (share * size)) * share * size
        assert [one.joint for one in coarse_encoders(with_reading(coarse), ARM,
                                                     seen())] == reported


def test_the_smallest_wave_is_that_from_which_lines_are_uneven():
    reading = measured_once().reading
    step = ARM.effect('coarse_quantisation', 'joint2').values()[1]
    size = smallest_wave(reading[:, 1, 1], DT, seen(), step)
    for share, reported in ((BELOW, []), (ABOVE, ['joint2'])):
        wavy = reading.copy()
        wavy[:, 1, 1] += share * size * np.sin(6000.0 * reading[:, 1, 1])
        assert [one.joint for one in uneven_lines(with_reading(wavy), ARM, seen())] == reported


def test_the_smallest_rate_is_that_from_which_samples_are_lost():
    reading = measured_once().reading
    size = smallest_rate(slips_of(measured_once(), ARM), seen())
    for share, reported in ((BELOW, False), (ABOVE, True)):
        late = reading.copy()
        lost = np.random.default_rng(3).random(len(reading)) < share * size
        late[1:][lost[1:]] = reading[:-1][lost[1:]]
        assert (lost_samples(slips_of(with_reading(late), ARM), seen()) is not None) == reported


def test_what_does_not_move_shows_no_step_no_wave_and_no_lost_sample():
    still = np.zeros((4000, 2, 2))
    rows = np.ones(4000, bool)
    assert smallest_step(still[:, 0, 1], 1.5e-6, rows) is None
    assert smallest_wave(still[:, 0, 1], DT, rows, 1.5e-6) is None
    assert smallest_rate(slips_of(Measurement(ARM.labels, DT, still, still[:, :, 0]), ARM),
                         rows) is None

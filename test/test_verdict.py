"""When a cause may be named: it gains, and no number of it ends; and what verdicts say."""

import math
from types import SimpleNamespace

from hda_arm_sim.model.arm import ArmError
from hda_arm_sim.model.effects import Backlash, effect_named
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import motion
from hda_arm_sim.simulate import checked
from hda_torque_estimator.diagnosis.balances.balance import Balancer
from hda_torque_estimator.diagnosis.detectability.excitation import remarks
from hda_torque_estimator.diagnosis.detectability.slow_rate import FAST, rate_hides
from hda_torque_estimator.diagnosis.diagnose import sought_effects
from hda_torque_estimator.diagnosis.findings.report import (Evidence, Finding, FittedNumber, Gain,
                                                            with_gain)
from hda_torque_estimator.diagnosis.findings.smallest import hidden
from hda_torque_estimator.diagnosis.fitting.hypotheses import HYPOTHESES
from hda_torque_estimator.diagnosis.judging.bounds_reached import limited, limits_of
from hda_torque_estimator.diagnosis.judging.search import Reason
from hda_torque_estimator.diagnosis.judging.verdict import (alike, lead_of, NO_MOTION, rival_of,
                                                            TIED)
from hda_torque_estimator.least_squares.charts import Identity
from hda_torque_estimator.least_squares.term import Term
from hda_torque_estimator.measurements.measurement import Measurement
from hda_torque_estimator.simulating.closed_loop import run
import numpy as np
import pytest
from truth import worlds
from world_fits import diagnosed

ARM = read_arm('hda_arm.yaml')


def finding(effect, removed=0.9, **numbers):
    """Return a finding with these numbers: value, low, high."""
    kind = effect_named(effect)
    return Finding(effect, 'joint1', kind.site.value, kind.cause, {
        name: FittedNumber(value, '', low, high) for name, (value, low, high) in numbers.items()},
        Evidence(500.0, 60.0, None, 1e6), Gain(2.0, 1.0, 1.0, removed, removed, removed))


@pytest.mark.parametrize('removed', [-4.287, -0.006, 0.0, float('nan')])
def test_what_removes_nothing_is_not_named(removed):
    kept = finding('coulomb_friction', level=(0.05, 0.04, 0.06))
    assert with_gain([finding('motor_cogging', removed), kept]) == (kept,)


@pytest.mark.parametrize(('effect', 'numbers'), [
    ('nonlinear_viscous_friction', {'exponent': (0.1, 0.084, 0.116)}),
    ('nonlinear_viscous_friction', {'exponent': (0.12, 0.09, 0.15)}),
    ('nonlinear_viscous_friction', {'exponent': (2.9, 2.5, 3.3)}),
    ('stribeck_friction', {'speed': (50.0, 49.0, 50.0)}),
    ('torsional_hysteresis', {'width': (1e-6, 1e-6, 2e-6)}),
    ('asymmetric_friction', {'asymmetry': (0.95, 0.94, 0.96)})])
def test_a_number_that_reaches_the_bound_of_its_law_is_not_named(effect, numbers):
    said = limited(finding(effect, **numbers))
    assert said is not None and f'{effect} at joint1 is not named' in said
    assert next(iter(numbers)) in said and 'reaches the bound' in said


@pytest.mark.parametrize(('effect', 'numbers'), [
    ('coulomb_friction', {'level': (0.0, -0.001, 0.001)}),          # none: that is an arm as well
    ('inertial_coupling', {'share': (-1.0, -1.0, -0.99)}),          # an arm without coupling
    ('thermal_viscosity', {'time_constant': (10.0, 1.0, 60.0)}),    # a law of several forms
    ('nonlinear_viscous_friction', {'exponent': (0.5, 0.4, 0.6)}),
    ('motor_cogging', {'phase': (7.0, 6.9, 7.1)})])
def test_a_neutral_bound_and_a_phase_limit_nothing(effect, numbers):
    assert limited(finding(effect, **numbers)) is None


def test_no_typical_shape_is_a_limit():
    """A search that starts at a limit would end there."""
    for name, sought in HYPOTHESES.items():
        for number, values in sought.grid.items():
            for one, each in ([(number, values)] if isinstance(number, str)
                              else zip(number, zip(*values))):
                low, high = limits_of(name, one)
                assert one not in sought.free or all(low < value < high for value in each)


def test_an_arm_of_many_joints_is_refused_in_one_honest_sentence():
    with pytest.raises(ArmError) as refused:
        checked(read_arm('kinova_gen3.yaml'))
    assert 'cannot be simulated' in str(refused.value)
    assert 'give {urdf: FILE, tip: FRAME, joints: [...]}' in str(refused.value)
    assert 'its lengths' not in str(refused.value)  # two lengths would not do for seven joints


def recorded(rate, name, duration=10.0):
    """Return the balances of a healthy arm that was recorded at a rate."""
    asked = motion(name, 2, duration, 1e-3, 5)
    made = run(ARM, ARM, asked, 5)
    every = round(1e3 / rate)
    return Balancer(Measurement(ARM.labels, every * 1e-3, np.ascontiguousarray(
        made.reading[::every, :, :2]), made.command[::every]))


@pytest.mark.parametrize(('name', 'effect', 'hides'), [
    ('rich', 'motor_inertia_error', True), ('slow_sine', 'torque_saturation', False)])
def test_the_rate_is_to_blame_where_the_same_motion_would_show_it(name, effect, hides):
    about = [(effect, 'joint1')]
    assert rate_hides(recorded(200.0, name), ARM, [effect], about, 0.5) is hides


def test_what_is_to_blame_is_said():
    """The headline and the remedy are those of the rate, not of the motion."""
    unseen = tuple(hidden('clock_skew', joint) for joint in ARM.labels)
    slow, = remarks(unseen, ARM, (), FAST)
    assert 'the rate is to blame' in slow and 'hda plan' not in slow
    still, = remarks(unseen, ARM, ())
    assert 'hda plan' in still and 'the rate is' not in still


def test_twins_by_nature_have_no_deciding_motion():
    """What the report advises and what a plan says agree."""
    twins = {name for name, sought in HYPOTHESES.items() if sought.twin}
    assert twins == {'asymmetric_friction', 'drive_offset'}
    assert 'no motion separates' in NO_MOTION


def test_a_rate_at_which_the_diagnosis_is_measured_is_never_to_blame():
    assert not rate_hides(recorded(FAST, 'standstill', 5.0), ARM, sought_effects(), (), 0.5)


def test_a_runner_up_is_reported_as_it_was_fitted_and_what_was_found_beside_is_none():
    play = Term(Backlash(half_width=1e-4), 'joint1', (Identity(('half_width',), 1e-6),))
    cause = Term(effect_named('stiffness_error')(), 'joint1', (Identity(('error',), 1e-3),))
    reason, alone = Reason(300.0, 60.0, play, TIED), SimpleNamespace(accepted=())
    rival = rival_of(reason, cause, alone)
    assert rival.joint == 'joint1' and rival.parameters['half_width'].value == 1e-4
    assert math.isnan(rival.parameters['half_width'].low)
    assert rival.probability == pytest.approx(0.05)     # the largest that ties: 19 to 1
    assert rival_of(reason, cause, SimpleNamespace(accepted=(play,))) is None
    nothing = Term(Backlash(), 'joint1', play.charts)
    assert rival_of(reason._replace(runner_up=nothing), cause, alone).parameters == {}
    assert rival_of(reason._replace(runner_up=None), cause, alone) is None


@pytest.mark.parametrize(('cause', 'rival', 'at', 'leads'), [
    ('stiffness_error', 'wave_generator_compliance', 'joint1', 0.85),
    ('stiffness_error', 'wave_generator_compliance', 'joint2', 5.67),
    ('torque_constant_error', 'motor_inertia_error', 'joint1', 5.67),
    ('link_encoder_eccentricity', 'encoder_scale_error', 'joint1', 0.91),
    ('link_encoder_eccentricity', 'encoder_scale_error', 'joint2', 5.67)])
def test_what_other_forms_of_two_laws_may_explain_is_no_lead(cause, rival, at, leads):
    """Forms of a gear's laws follow its torque; a disc must bend. None acts at another joint."""
    term, other = (Term(effect_named(name)(), joint, ()) for name, joint in (
        (cause, 'joint1'), (rival, at)))
    lead = lead_of(Reason(16000.0, 60.0, other, 272.0), term)
    assert lead == pytest.approx(leads, abs=0.01)


@pytest.mark.parametrize(('more', 'tied'), [(TIED - 1.0, False), (TIED, True)])
def test_a_law_of_more_numbers_is_meant_as_well_where_only_another_form_equals_it(more, tied):
    """One with more numbers contains a cause, unless that needs another form to do as much."""
    term = Term(effect_named('coulomb_friction')(), 'joint1', (Identity(('level',), 1e-3),))
    drag = Term(effect_named('nonlinear_viscous_friction')(), 'joint1', (
        Identity(('coefficient',), 1e-3), Identity(('exponent',), 0.1)))
    found = SimpleNamespace(last=SimpleNamespace(accepted=(term,)), evidence=(
        Reason(8000.0, 70.0, drag, 0.0, more),))
    judged = SimpleNamespace(backed=(term,), powers={term.place: np.array([50.0])},
                             margins={term.place: 2.0})
    assert [pair.effects for pair in alike(found, judged)] == [
        (term.place, drag.place)] * tied


@pytest.mark.parametrize(('effect', 'seed', 'rate'), [
    ('encoder_scale_error', 1110146, 250),
    pytest.param('link_encoder_eccentricity', 1110138, None, marks=pytest.mark.study)])
def test_a_disc_that_was_not_seen_to_bend_is_told_together_with_a_scale(effect, seed, rate):
    """Each explains all that there is. Both were without a name."""
    world = worlds.draw(seed, (effect,), motion='rich', rate=rate)
    said = diagnosed(world)
    joint = world.hidden[0].joint
    assert said.verdict == 'ambiguous' and said.findings == ()
    assert [set(pair.effects) for pair in said.ambiguous] == [
        {('link_encoder_eccentricity', joint), ('encoder_scale_error', joint)}]


@pytest.mark.parametrize(('effect', 'form', 'seed', 'along', 'rate'), [
    ('stiffness_error', None, 799808, 'rich', 250),
    ('stiffness_error', None, 1100092, 'fourier', 1000),
    pytest.param('wave_generator_compliance', 'tanh', 799950, 'rich', 1000,
                 marks=pytest.mark.study),
    pytest.param('wave_generator_compliance', 'tanh', 799958, 'rich', None,
                 marks=pytest.mark.study)])
def test_laws_of_a_gear_that_differ_by_less_than_their_forms_look_alike(effect, form, seed, along,
                                                                        rate):
    """
    Another law explains 1.6 to 4.7 % more than the true one, and was named.

    In the second three laws of the gear explain as much.
    """
    world = worlds.draw(seed, (effect,), motion=along, rate=rate, form=form)
    said = diagnosed(world)
    assert said.verdict == 'ambiguous'
    assert {one.site for one in said.findings} <= {'timing'}     # stamps of a host may jitter
    assert (effect, world.hidden[0].joint) in said.ambiguous[0].effects


@pytest.mark.parametrize(('seed', 'along', 'rate'), [
    pytest.param(1120011, 'rich', 250, marks=pytest.mark.study), (800200, 'sine', 1000),
    (810010, 'rich', 1000)])
def test_a_drag_that_levels_is_told_together_with_the_dry_friction_that_it_is_near_to(
        seed, along, rate):
    """An arctan of speed is dry friction that sets in slowly, or a small power of the speed."""
    world = worlds.draw(seed, ('nonlinear_viscous_friction',), motion=along, rate=rate)
    said = diagnosed(world)
    assert said.verdict == 'ambiguous' and said.findings == ()
    assert {name for name, _ in said.ambiguous[0].effects} == {
        'coulomb_friction', 'nonlinear_viscous_friction'}

"""Noise as causes show it: what is dropped shows none, what only quietens it explains nothing."""

from hda_torque_estimator.diagnosis.diagnose import diagnose
import pytest
from truth import worlds
from world_fits import diagnosed
from world_samples import as_read


def healthy(seed, motion):
    """Return the arm and a log at 1 kHz of a world in which nothing is wrong."""
    world = worlds.draw(seed, (), motion=motion, rate=1000)
    return as_read(world)


@pytest.mark.parametrize('seed', [745002, 745008])
def test_a_lag_that_is_dropped_leaves_noise_as_loud_as_it_was(seed):
    """It makes commands smoother, and at first explains more than it costs."""
    arm, measurement = healthy(seed, 'fourier')
    found = diagnose(measurement, arm)
    assert found.diagnosis.verdict in ('no_discrepancy', 'insufficient_excitation')
    fitter, left = found.evidence.fitter, found.evidence.fit.variance
    assert (left < 1.3 * fitter.noise ** 2).all()


def test_a_lag_that_smooths_commands_of_coarse_encoders_explains_no_motion():
    """A controller of 2 kHz repeats rounding that a log of 1 kHz has every second sample of."""
    arm, measurement = healthy(1020035, 'rich')
    found = diagnose(measurement, arm).diagnosis
    assert found.verdict == 'no_discrepancy'


def test_links_that_quieten_the_noise_of_coarse_encoders_explain_nothing():
    """With 4096 counts a turn, a link of a third of its inertia makes a third of the noise."""
    arm, measurement = healthy(745012, 'rich')
    found = diagnose(measurement, arm).diagnosis
    assert found.verdict == 'insufficient_excitation'
    assert not found.findings and not found.listed


@pytest.mark.study
def test_links_that_make_less_noise_take_no_place_of_a_cause():
    """They and a base explained more at first, and the scale that is wrong came fourth."""
    world = worlds.draw(1120147, ('encoder_scale_error',), motion='trapezoid', rate=1000)
    assert [(one.effect, one.joint) for one in diagnosed(world).findings] == [
        (one.effect, one.joint) for one in world.hidden]


@pytest.mark.study
def test_an_arm_that_creeps_at_rest_has_no_cause():
    """At 100 Hz its rest is rounding and stick-slip; most of what laws gain there is chance."""
    world = worlds.draw(740218, ())
    found = diagnosed(world)
    assert world.motion == 'standstill'
    assert not found.findings


def told(seed, effect, rate, form=None):
    """Return the verdict on a world with one cause, and the causes that are named."""
    world = worlds.draw(seed, (effect,), motion='rich', rate=rate, form=form)
    found = diagnosed(world)
    return found.verdict, [(one.effect, one.joint) for one in found.findings]


def test_torques_scatter_as_they_do_beside_missing_inertia():
    """Without 2.6 kg at the tip they seemed to scatter by 0.6 of their power, and beside it."""
    assert told(799636, 'payload', 1000, form='') == ('explained', [('payload', None)])


@pytest.mark.study
def test_a_link_that_quietens_noise_beyond_its_tolerance_takes_no_name_back():
    assert told(799546, 'encoder_scale_error', 250) == (
        'explained', [('encoder_scale_error', 'joint1')])


@pytest.mark.study
def test_a_cogging_may_shake_a_torsion_in_which_it_explains_nothing():
    """Its simulation leaves as much there, as the motion is quicker than the samples."""
    assert told(799555, 'motor_cogging', 1000) == ('explained', [('motor_cogging', 'joint2')])

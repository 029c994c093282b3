"""A law that fits best where it ends stands for another: also one that leaves a gear nothing."""

from dataclasses import replace

from hda_torque_estimator.diagnosis.fitting.hypotheses import terms_of
from hda_torque_estimator.diagnosis.judging.bounds_reached import ends_at_limit, takes_gear_away
import pytest
from truth_cases import hide
from truth_fits import fitter_of

SECONDS, SEED = 24.0, 135
PLAY = 8e-5             # half of a play [rad]


@pytest.fixture(scope='module')
def healthy():
    """Return what fits a recording of a healthy arm."""
    return fitter_of((), SECONDS, SEED)


def begun(fitter, name, **numbers):
    """Return the first fit with an effect of so large numbers at joint 2, as it is."""
    term = next(term for term in terms_of(fitter.arm, name) if term.joint == 'joint2')
    term = replace(term, effect=replace(term.effect, **numbers))
    fit = fitter.refit(fitter.first, term)
    return fitter.at([term, *fit.nuisance], 1, fit.slopes), term


@pytest.mark.parametrize(('name', 'numbers'), [
    ('backlash', {'half_width': 5e-3}), ('stiffness_error', {'error': -0.89})])
def test_a_law_that_leaves_a_gear_nothing_ends_there(healthy, name, numbers):
    fit, term = begun(healthy, name, **numbers)
    assert takes_gear_away(healthy, fit, term) and ends_at_limit(healthy, fit, term)


@pytest.mark.parametrize(('name', 'numbers'), [
    ('backlash', {'half_width': 2e-5}), ('stiffness_error', {'error': -0.3}),
    ('coulomb_friction', {'level': 1.0})])
def test_one_that_leaves_it_most_does_not_nor_one_of_a_motor(healthy, name, numbers):
    assert not takes_gear_away(healthy, *begun(healthy, name, **numbers))


def test_a_play_that_is_there_leaves_a_gear_what_its_link_needs():
    """Its gear carries a part of what its torsion would be without the play."""
    fitter = fitter_of((hide('backlash', 'joint2', half_width=PLAY),), SECONDS, SEED)
    starts = [fitter.refit(fitter.first, term) for term in terms_of(fitter.arm, 'backlash')
              if term.joint == 'joint2']
    fit = fitter.refined(min(starts, key=lambda one: one.score))
    term, = fit.accepted
    assert term.effect.half_width == pytest.approx(PLAY, rel=0.1)
    assert not takes_gear_away(fitter, fit, term) and not ends_at_limit(fitter, fit, term)

"""A right cause is as large in every stretch of a recording, one that stands in for it is not."""

from dataclasses import replace

from hda_torque_estimator.diagnosis.fitting.hypotheses import terms_of
from hda_torque_estimator.diagnosis.judging import parameter_constancy
from hda_torque_estimator.diagnosis.judging.parameter_constancy import (
    only_steady, steady_shares, unsteady_shares)
from hda_torque_estimator.diagnosis.judging.search import Reason, SearchResult
import numpy as np
import pytest
from truth_cases import hide
from truth_fits import ARM, fitter_of

HIDDEN = (hide('coulomb_friction', 'joint2', level=0.02),
          hide('stiffness_error', 'joint1', relative_error=-0.18),
          hide('motor_torque_line', 'joint2', amplitude=0.01, frequency=5.3, phase=0.4))
RIGHT = ('coulomb_friction', 'stiffness_error')
STAND_INS = ('viscous_friction', 'wave_generator_compliance')
JOINTS = ('joint2', 'joint1')


@pytest.fixture(scope='module')
def fitter():
    """Return what fits a recording with two causes and a line that no law has."""
    return fitter_of(HIDDEN, 24.0, 134)


@pytest.fixture(scope='module')
def fits(fitter):
    """Return fits of the right causes, and with a stand-in for the first and for the second."""
    return [fitted(fitter, names) for names in (
        RIGHT, (STAND_INS[0], RIGHT[1]), (RIGHT[0], STAND_INS[1]))]


def fitted(fitter, names):
    """Return a fit of one cause at each joint."""
    fit = fitter.first
    for name, joint in zip(names, JOINTS):
        starts = [term for term in terms_of(ARM, name) if term.joint == joint]
        fit = min((fitter.refined(fitter.refit(fit, term)) for term in starts),
                  key=lambda one: one.score)
    return fit


def test_only_stand_ins_vary_from_stretch_to_stretch(fitter, fits):
    for fit in fits:
        assert (fit.variance > 50.0 * fitter.noise ** 2).any()      # the line has no name
        shares = unsteady_shares(fitter, fit)
        assert max(share for (name, _), share in shares.items() if name in RIGHT) < 0.5
        assert all(share > 2.0 for (name, _), share in shares.items() if name in STAND_INS)


def test_a_size_does_not_hang_on_the_unit_of_a_channel(fitter, fits):
    louder = replace(fits[0], variance=4.0 * fits[0].variance,
                     nuisance=(), slopes=fits[0].slopes.with_columns(
                         fits[0].columns[:, :, :len(RIGHT)]))
    plain = replace(louder, variance=fits[0].variance)
    one, other = (unsteady_shares(fitter, fit) for fit in (louder, plain))
    assert one == pytest.approx(other)


def test_a_rest_beside_few_causes_is_held_against_all_of_them(fitter, fits, monkeypatch):
    found = SearchResult(fitter.first, fits[2], (Reason(1e3, 60.0, None, np.inf),) * 2)
    assert steady_shares(fitter, fits[0]) == {} and only_steady(
        fitter, found, ()) is None
    monkeypatch.setattr(parameter_constancy, 'MANY', 1)
    assert set(steady_shares(fitter, fits[0])) == set(zip(RIGHT, JOINTS))
    kept = only_steady(fitter, found, RIGHT)
    assert [term.place for term in kept.last.accepted] == [(RIGHT[0], JOINTS[0])]
    assert kept.evidence[0].improvement != 1e3      # but what it is beside all others


def test_a_steady_cause_gives_way_to_one_that_is_better_beside_all_others(
        fitter, fits, monkeypatch):
    monkeypatch.setattr(parameter_constancy, 'MANY', 1)
    monkeypatch.setattr(parameter_constancy, '_VARIES', 10.0)
    found = SearchResult(fitter.first, fits[2], (Reason(1e3, 60.0, None, np.inf),) * 2)
    kept = only_steady(fitter, found, (*RIGHT, *STAND_INS))
    assert {term.place for term in kept.last.accepted} == set(zip(RIGHT, JOINTS))
    # what is known is not asked again
    monkeypatch.setattr(parameter_constancy, 'unsteady_shares', None)
    assert steady_shares(fitter, kept.last, kept.steady) == kept.steady


def test_what_was_steady_beside_others_stays_so_where_one_of_them_is_dropped(
        fitter, fits, monkeypatch):
    """It gained nothing on held-out stretches, and the last of many had no names by that."""
    monkeypatch.setattr(parameter_constancy, 'MANY', 2)
    found = SearchResult(fitter.first, fits[0], (Reason(1e3, 60.0, None, np.inf),) * 2)
    kept = only_steady(fitter, found, RIGHT)
    assert len(kept.last.accepted) == 2
    left = kept.keeping(fitter, kept.last.accepted[:1])
    place = left.last.accepted[0].place
    assert steady_shares(fitter, left.last, left.steady) == {place: kept.steady[place]}
    assert steady_shares(fitter, left.last) == {}


@pytest.mark.parametrize(('alone', 'stays'), [(0.4, False), (1.5, True)])
def test_a_cause_without_which_others_are_less_steady_stays(fitter, fits, monkeypatch, alone,
                                                            stays):
    """It is not steady itself, so it has no name by that, but it is none that stands in."""
    first, second = zip(RIGHT, JOINTS)
    known = {2: {first: 0.5, second: 1.2}, 1: {first: alone}}
    monkeypatch.setattr(parameter_constancy, 'MANY', 1)
    monkeypatch.setattr(parameter_constancy, 'unsteady_shares',
                        lambda fitter, fit: known[len(fit.accepted)])
    found = SearchResult(fitter.first, fits[0], (Reason(1e3, 60.0, None, np.inf),) * 2)
    kept = only_steady(fitter, found, RIGHT)
    assert [term.place for term in kept.last.accepted] == [first, second][:1 + stays]
    assert set(steady_shares(fitter, kept.last, kept.steady)) == {first}

"""One step of the search: what explains most may be no cause, and then others are asked."""

from types import SimpleNamespace

from hda_torque_estimator.diagnosis.fitting.hypotheses import terms_of
from hda_torque_estimator.diagnosis.judging import forward_selection
from hda_torque_estimator.diagnosis.judging.discrepancy_search import gone_on
from hda_torque_estimator.diagnosis.judging.goodness_of_fit import goodness_of_fit
from hda_torque_estimator.diagnosis.judging.search import search
from hda_torque_estimator.diagnosis.judging.selection_criteria import Standing
import pytest
from truth_cases import hide
from truth_fits import fitter_of

HIDDEN = (hide('coulomb_friction', 'joint2', level=0.02),
          hide('viscous_friction', 'joint1', slope=2e-4),
          hide('cable_spring', 'joint1', stiffness=6.0, rest_angle=0.2))
NAMES = tuple(one.effect for one in HIDDEN)


@pytest.fixture(scope='module')
def fitter():
    """Return what fits a recording with three causes."""
    return fitter_of(HIDDEN, 24.0, 134)


def refusing(monkeypatch, refused):
    """Let so many causes that are asked be none, and return the places of all that are asked."""
    asked = []

    def standing(fitter, first, without, extended, term):
        asked.append(term.place)
        return Standing.CAUSE if len(asked) > refused else Standing.CHANCE

    monkeypatch.setattr(forward_selection, 'standing', standing)
    return asked


@pytest.mark.parametrize(('refused', 'many'), [(0, 1), (1, 0), (2, 0), (1, 1)])
def test_where_what_explains_most_is_no_cause_the_next_ones_are_asked(fitter, monkeypatch,
                                                                      refused, many):
    """That is so beside many causes: of what few leave the search ends there."""
    monkeypatch.setattr(forward_selection, 'MANY', many)
    monkeypatch.setattr(forward_selection, '_CANDIDATES', 3)
    monkeypatch.setattr(forward_selection, '_FINALISTS', 1)
    asked = refusing(monkeypatch, refused)
    found = forward_selection.look(fitter, fitter.first, fitter.first, NAMES)
    if refused and many:
        assert len(asked) == 1 and found.step is None
        return
    assert len(asked) == len(set(asked)) == refused + 1
    assert found.step[0].accepted[-1].place == asked[-1]
    assert found.step[1].runner_up is None or found.step[1].runner_up.place not in asked


def test_what_noise_makes_of_one_joint_hides_nothing_of_another(fitter, monkeypatch):
    """The first is refused, and the best of the other joint is held against its own runner-up."""
    monkeypatch.setattr(forward_selection, '_CANDIDATES', 1)
    asked = refusing(monkeypatch, 1)
    step, reason = forward_selection.look(fitter, fitter.first, fitter.first, NAMES).step
    (_, refused), (_, taken) = asked
    assert {refused, taken} == {'joint1', 'joint2'}
    assert step.accepted[-1].place == asked[-1]
    assert reason.runner_up.joint == taken


def test_a_law_that_takes_the_gear_away_says_nothing_of_its_joint(fitter, monkeypatch):
    """The next cause of the same joint is asked, which is none for noise alone."""
    monkeypatch.setattr(forward_selection, '_CANDIDATES', 1)
    asked = refusing(monkeypatch, 1)
    monkeypatch.setattr(forward_selection, 'takes_gear_away',
                        lambda fitter, fit, term: term.place == asked[0])
    step, _ = forward_selection.look(fitter, fitter.first, fitter.first, NAMES[:2]).step
    assert asked == [('coulomb_friction', 'joint2'), ('viscous_friction', 'joint2')]
    assert step.accepted[-1].place == asked[-1]


def test_what_takes_names_back_makes_a_search_go_on(fitter):
    """One that ended with a rest finds what explains it, and no more than that."""
    told = []
    begun = search(fitter, NAMES[:1])
    assert goodness_of_fit(fitter, begun).unexplained.any()
    assert gone_on(fitter, begun, NAMES[:1], told.append) is begun
    found = gone_on(fitter, begun, NAMES, told.append)
    assert {term.place for term in found.last.accepted} == {
        (one.effect, one.joint) for one in HIDDEN}
    assert len(found.evidence) == len(HIDDEN)
    assert told == ['looking for cause 2', 'looking for cause 2', 'looking for cause 3']
    assert gone_on(fitter, found, NAMES, told.append) is found


def test_a_tolerance_beside_a_law_does_not_hold_what_another_law_seeks(fitter):
    """A heavier link has its inertia within its tolerance: it is no lighter one of 8 % less."""
    laws = {term.sought: term for term in terms_of(fitter.arm, 'link_inertia_error')
            if term.joint == 'joint2'}
    assert set(laws['error',].free) < set(laws['mass',].free)
    heavier, other = (SimpleNamespace(accepted=(laws[sought],), score=score)
                      for sought, score in ((('mass',), 10.0), (('error',), 0.0)))
    assert forward_selection._from_contained(None, heavier, [heavier, other]) is heavier

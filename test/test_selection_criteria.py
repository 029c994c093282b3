"""When a cause earns its place in a fit."""

from hda_arm_sim.model.arm import ArmError
from hda_torque_estimator.diagnosis.fitting.fit import Fitter
from hda_torque_estimator.diagnosis.fitting.hypotheses import terms_of
from hda_torque_estimator.diagnosis.judging.selection_criteria import accepted
from test_discrepancy_search import ARM, fitter_of, FRICTION, measured


def test_a_cause_that_no_arm_can_be_without_is_not_accepted(monkeypatch):
    """It only makes others possible. A search once ended with an error of the mass matrix."""
    fitter = fitter_of(measured(FRICTION))
    start = next(term for term in terms_of(ARM, 'coulomb_friction') if term.joint == 'joint2')
    without, fit = fitter.first, fitter.refit(fitter.first, start)
    term, = fit.accepted
    assert accepted(fitter, without, without, fit, term)
    on = Fitter.on

    def on_if_rubbed(self, terms):
        if not any(other.place == term.place for other in terms):
            raise ArmError('no arm is without this friction')
        return on(self, terms)
    monkeypatch.setattr(Fitter, 'on', on_if_rubbed)
    assert not fitter.can_lack_each(fit)
    assert not accepted(fitter, without, without, fit, term)

"""Causes that vary along a coordinate as no law of theirs does."""

from dataclasses import replace

from hda_torque_estimator.diagnosis.fitting.hypotheses import terms_of
from hda_torque_estimator.diagnosis.judging import other_laws
from hda_torque_estimator.diagnosis.judging.law_forms import in_best_forms
from hda_torque_estimator.diagnosis.judging.search import Reason, SearchResult
from hda_torque_estimator.significance import CERTAIN
import numpy as np
import pytest
from truth import worlds
from world_fits import fitter_of

TILT, DISC = 'base_tilt', 'link_encoder_eccentricity'


def tilted(fitter):
    """Return what was found where a tilt of the base alone was looked for."""
    start, *_ = terms_of(fitter.arm, TILT)
    fit = fitter.refined(fitter.refit(fitter.first, start))
    improved = fitter.first.score - fit.score
    return SearchResult(fitter.first, fit, (Reason(improved, 60.0, None, np.inf),))


def test_noise_that_a_coordinate_has_as_well_is_no_other_law():
    """The torque through a gear has the noise of its balance: a right tilt followed that."""
    fitter = fitter_of(worlds.draw(720190, (TILT,), motion='rich', rate=1000, seconds=40.0))
    fit = tilted(fitter).last
    assert max(other_laws._gains(fitter, in_best_forms(fitter, fit),
                                 fit.accepted[0])) < 0.5 * CERTAIN


@pytest.mark.parametrize(('names', 'share', 'many', 'doubted'), [
    ((DISC,), 1.05, 1, False),
    ((DISC,), 1.2, 1, True),                    # it explains too little of that
    (('viscous_friction',), 1.05, 1, True),
    ((DISC,), 1.05, 2, True)])                  # one cause is not many
def test_beside_many_causes_what_one_more_effect_explains_is_no_other_law(
        monkeypatch, names, share, many, doubted):
    """A disc on the link that nobody has found yet; a right tilt may vary instead."""
    fitter = fitter_of(worlds.draw(720193, (TILT, DISC), motion='rich', rate=1000, seconds=20.0))
    found = replace(tilted(fitter), names=names)
    place = found.last.accepted[0].place
    monkeypatch.setattr(other_laws, 'MANY', 1)
    explained = other_laws._one_more(fitter, found.last, (DISC,), [place])[place]
    assert explained > 2.0 * CERTAIN
    monkeypatch.setattr(other_laws, 'MANY', many)
    monkeypatch.setattr(other_laws, '_gains', lambda *of: iter([share * explained]))
    assert (found.last.accepted[0] in other_laws.of_other_laws(fitter, found)) == doubted

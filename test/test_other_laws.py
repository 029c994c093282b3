"""Causes that vary along a coordinate as no law of theirs does."""

from dataclasses import replace

from hda_torque_estimator.diagnosis.judging import other_laws, screening
from hda_torque_estimator.diagnosis.judging.law_forms import in_best_forms, reformed
from hda_torque_estimator.diagnosis.judging.search import Reason, SearchResult
from hda_torque_estimator.significance import CERTAIN
import numpy as np
import pytest
from truth import worlds
from world_fits import fitted, fitter_of

TILT, DISC = 'base_tilt', 'link_encoder_eccentricity'


def tilted(fitter):
    """Return what was found where a tilt of the base alone was looked for."""
    fit = fitted(fitter, TILT)
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
    monkeypatch.setattr(screening, 'MANY', 1)
    explained = max(gain for _, gain in screening.one_more(
        fitter, reformed(fitter, found.last), (DISC,)))
    assert explained > 2.0 * CERTAIN
    monkeypatch.setattr(screening, 'MANY', many)
    monkeypatch.setattr(other_laws, '_gains', lambda *of: iter([share * explained]))
    assert (found.last.accepted[0] in other_laws.of_other_laws(fitter, found)) == doubted

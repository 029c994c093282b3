"""Gather what a report shows of a conclusion: residuals, coordinates, predictions."""

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
import numpy as np

from .balances.balance import Balancer
from .balances.coordinates import coordinates_of
from .balances.predict import prediction_errors
from .findings.report import Prediction
from .reporting.exhibits import Exhibits
from .validation import Grounds

# Numerics; choices unless stated otherwise.
HORIZONS = (0.01, 0.02, 0.05, 0.1, 0.2)     # over which predictions are shown [s]


def exhibits_of(evidence: Grounds) -> Exhibits:
    """Return the exhibits of a conclusion."""
    fitter, fit = evidence.fitter, evidence.fit
    balancer = fitter.balancer
    lacking = {term.place: fitter.residual(fitter.terms_without(fit, term), fit.slopes.noise)
               for term in fit.accepted}
    return Exhibits(
        balancer.time, fitter.arm.labels, balancer(evidence.before).residual,
        fit.balance.residual, fit.balance.valid, fitter.noise,
        coordinates_of(balancer, evidence.extended), np.array(HORIZONS),
        _predicted(balancer, evidence.before, evidence),
        _predicted(balancer, evidence.extended, evidence),
        _predicted(evidence.twin, evidence.extended, evidence), lacking=lacking,
        commanded=balancer.filtered(balancer.measurement.command * np.array(
            [joint.ratio for joint in evidence.extended.joints])),
        beyond=tuple(map(fitter.beyond_gear, fitter.arm.labels)), shared=balancer.shared)


def predictions(exhibits: Exhibits) -> tuple[Prediction, ...]:
    """Return the errors of predictions by horizon as the report states them."""
    return tuple(Prediction(float(horizon), float(before), float(after), float(floor), 'rad')
                 for horizon, before, after, floor in zip(
                     exhibits.horizons, exhibits.predicted_before, exhibits.predicted_after,
                     exhibits.predicted_floor))


def _predicted(balancer: Balancer, arm: Arm, evidence: Grounds) -> Array:
    """Return the rms errors of motors and links together, by horizon [rad at the output]."""
    angles = 2 * len(arm.joints)
    return np.array([np.sqrt(prediction_errors(balancer, arm, evidence.held_out, horizon)
                             [:, :angles].sum(axis=1).mean()) for horizon in HORIZONS])

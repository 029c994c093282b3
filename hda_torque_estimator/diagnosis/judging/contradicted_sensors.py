"""
Sensors that motor, torsion and links contradict, where these agree without them.

Beside links a sensor is a third witness: the others fix its scale. A gain beyond its tolerance
shows where the sensor does and nowhere else. So it competes, of any size, with what was found
there. Where it wins, the scale of that sensor tells nothing of the arm.
"""

from collections.abc import Collection, Sequence

import numpy as np

from .equal_noise import equal_noise_score, noise_in
from .search import SearchResult
from ..balances.channels import channels_of
from ..balances.coordinates import coordinates_of
from ..fitting.fit import Fit, Fitter
from ..fitting.nuisance import any_gains, GAIN, SENSOR_GAIN
from ..fitting.solve import condense, REACH, solve
from ..fitting.steps import places_of
from ...least_squares.term import Term
from ...significance import LOUD, SCORE_BAR


def contradicted(fitter: Fitter, found: SearchResult) -> dict[str, float]:
    """
    Return the gains of sensors that the other witnesses contradict, by joint.

    Gains without a tolerance explain more beside all causes. Or they explain as much without the
    causes that show where sensors do. To first order that is known before it is fitted.
    """
    measurement, fit = fitter.balancer.measurement, found.last
    places = {label: place for place, label in enumerate(fitter.arm.labels)
              if measurement.thrice_witnessed[place] and label not in measurement.unscaled}
    if not places:
        return {}
    sensors = [channels_of(measurement, place)[-1] for place in places.values()]
    others = [term for term in fit.accepted
              if not fit.columns[:, sensors][:, :, fit.own(term)].any()]
    trials = [(fit.accepted, -SCORE_BAR)]
    trials += [(tuple(others), SCORE_BAR)] if len(others) < len(fit.accepted) else []
    for causes, most in trials:
        if _first_order(fitter, fit, causes, places) < fit.score + most:
            usual = noise_in(fitter, fit)
            free = fitter.fit(causes, any_gains(fit.nuisance, places, {
                label: _gain_of(fitter, fit, place) for label, place in places.items()}))
            gains = {str(term.joint): float(term.vector()[0]) for term in free.nuisance
                     if term.place[0] == GAIN and term.joint in places
                     and abs(term.vector()[0]) > REACH * SENSOR_GAIN}
            if gains and equal_noise_score(fitter, free, usual) < most + equal_noise_score(
                    fitter, fit, usual):
                return gains
    return {}


def in_sensors_alone(fitter: Fitter, fit: Fit) -> tuple[str, ...]:
    """Return sentences on sensors that leave more than noise where the others leave none."""
    measurement = fitter.balancer.measurement
    loud = fit.variance > (LOUD * fitter.noise) ** 2
    said = []
    for place in np.flatnonzero(measurement.thrice_witnessed).tolist():
        motor, torsion, sensor = channels_of(measurement, place)
        if loud[sensor] and not loud[motor] and not loud[torsion]:
            said.append(
                f'the reference torque of {fitter.arm.labels[place]} differs by '
                f'{np.sqrt(fit.variance[sensor]):.3g} N*m rms from what motor, torsion and links '
                'agree on, which is none of its tolerated errors')
    return tuple(said)


def _first_order(fitter: Fitter, fit: Fit, causes: Sequence[Term],
                 sensors: Collection[str]) -> float:
    """Return the score of a fit with some of its causes alone and any gains of these sensors."""
    free = any_gains(fit.nuisance, sensors)
    beside = fitter.at([*causes, *free], len(causes), fit.slopes.with_columns(
        fit.columns[:, :, places_of(fit.terms, [*causes, *fit.nuisance])]))
    return solve(condense(beside.balance.residual, beside.columns, fitter.valid(beside.balance)),
                 fitter.noise, fitter.effective, fitter.away(beside.terms),
                 beside.deviations).score


def _gain_of(fitter: Fitter, fit: Fit, place: int) -> float:
    """Return by how much a sensor shows more than the torsion of its joint carries."""
    balancer = fitter.balancer
    torque = coordinates_of(balancer, fitter.on(fit.terms))['joint_torque'][:, place]
    shown = balancer.measurement.reference[::balancer.every, place]
    seen = fitter.valid(fit.balance)[:, channels_of(balancer.measurement, place)[-1]]
    columns = np.stack([torque, np.ones_like(torque)], axis=1)[seen]
    return float(np.linalg.lstsq(columns, shown[seen], rcond=None)[0][0]) - 1.0

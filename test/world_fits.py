"""What a diagnosis fits, and what it says, of the record of a world."""

from typing import Any

from hda_torque_estimator.diagnosis.assumptions import EFFECTIVE
from hda_torque_estimator.diagnosis.balances.balance import Balancer
from hda_torque_estimator.diagnosis.balances.healthy_twin import (
    healthy_twin, noise_of, torque_noise_of, torque_response)
from hda_torque_estimator.diagnosis.diagnose import diagnose
from hda_torque_estimator.diagnosis.findings.report import Diagnosis
from hda_torque_estimator.diagnosis.fitting.alignment import aligned
from hda_torque_estimator.diagnosis.fitting.fit import Fit, Fitter
from hda_torque_estimator.diagnosis.fitting.hypotheses import terms_of
from hda_torque_estimator.measurements.upsampling import finer
import numpy as np
from truth.worlds import World
from world_samples import as_read


def fitter_of(world: World) -> Fitter:
    """Return what fits all rows of the record of a world, with a twin that is as noisy."""
    arm, measurement = as_read(world)
    balancer = Balancer(aligned(finer(measurement), arm))
    noise, plain = noise_of(balancer, arm)
    more = torque_noise_of(noise, plain, balancer, arm)
    twin = healthy_twin(balancer, arm, 2, more)
    balancer = balancer.knowing(torque_response(balancer, arm, 5, more))
    return Fitter(balancer, arm, noise, EFFECTIVE, np.ones(len(balancer.time), bool),
                  Balancer(twin))


def fitted(fitter: Fitter, name: str) -> Fit:
    """Return the best fit with an effect at the first joint, or of the whole arm."""
    trials = [fitter.refit(fitter.first, term) for term in terms_of(fitter.arm, name)
              if term.joint in (None, fitter.arm.labels[0])]
    return fitter.refined(min(trials, key=lambda trial: trial.score))


def diagnosed(world: World, **asked: Any) -> Diagnosis:
    """Return what is said of the record of a world, where so much is `asked` of `diagnose`."""
    arm, measurement = as_read(world)
    return diagnose(measurement, arm, **asked).diagnosis

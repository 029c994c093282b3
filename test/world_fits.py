"""What a diagnosis fits of the record of a world, with a twin that is as noisy."""

from hda_torque_estimator.diagnosis.assumptions import EFFECTIVE
from hda_torque_estimator.diagnosis.balances.balance import Balancer
from hda_torque_estimator.diagnosis.balances.healthy_twin import (
    healthy_twin, noise_of, torque_noise_of)
from hda_torque_estimator.diagnosis.fitting.alignment import aligned
from hda_torque_estimator.diagnosis.fitting.fit import Fitter
from hda_torque_estimator.measurements.sample_grid import measurement_from
from hda_torque_estimator.measurements.upsampling import finer
import numpy as np
from truth.worlds import World
from world_samples import arm_of, logged


def fitter_of(world: World) -> Fitter:
    """Return what fits all rows of the record of a world."""
    arm = arm_of(world)
    balancer = Balancer(aligned(finer(measurement_from(arm.labels, logged(world, arm))), arm))
    noise, plain = noise_of(balancer, arm)
    twin = healthy_twin(balancer, arm, 2, torque_noise_of(noise, plain, balancer, arm))
    return Fitter(balancer, arm, noise, EFFECTIVE, np.ones(len(balancer.time), bool),
                  Balancer(twin))

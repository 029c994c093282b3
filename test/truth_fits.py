"""What a diagnosis measures and fits of the truth: the shipped arm along a rich motion."""

from collections.abc import Sequence

from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import motion
from hda_torque_estimator.diagnosis.assumptions import EFFECTIVE
from hda_torque_estimator.diagnosis.balances.balance import Balancer
from hda_torque_estimator.diagnosis.balances.healthy_twin import noise_of
from hda_torque_estimator.diagnosis.fitting.fit import Fitter
from hda_torque_estimator.measurements.measurement import Measurement
import numpy as np
from truth import Hidden, record, Reference

ARM = read_arm('hda_arm.yaml')
PERIOD = 1e-3


def measured(hidden: Sequence[Hidden], seconds: float, seed: int) -> Measurement:
    """Return a measurement of an arm with hidden effects, and its own scatter."""
    asked = motion('rich', len(ARM.joints), seconds, PERIOD, seed)
    made = record(hidden, Reference(asked.angle, asked.rate, PERIOD), seed=seed)
    return Measurement(ARM.labels, PERIOD, np.stack([made.motor_angle, made.link_angle], axis=2),
                       made.command)


def fitter_of(hidden: Sequence[Hidden], seconds: float, seed: int) -> Fitter:
    """Return what fits all rows of such a measurement, with the noise that its balances have."""
    balancer = Balancer(measured(hidden, seconds, seed))
    return Fitter(balancer, ARM, noise_of(balancer, ARM)[0], EFFECTIVE,
                  np.ones(len(balancer.time), bool))

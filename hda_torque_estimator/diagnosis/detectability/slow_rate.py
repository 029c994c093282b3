"""
Whether the rate of a recording hides what its motion would show.

A healthy twin of the arm is simulated along the measured motion at a rate that hides nothing. It
is asked which effects would have been seen. The motion between samples is that of a spline.
"""

from collections.abc import Sequence
from dataclasses import replace

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.kernel import LINK_ANGLE
from hda_arm_sim.motions import Motion
import numpy as np
from scipy.interpolate import CubicSpline

from .excitation import shows_too_little, smallest_sizes
from ..balances.balance import Balancer
from ..balances.healthy_twin import noise_of
from ..fitting.fit import Fitter
from ..judging.search import SearchResult
from ..readings.raw_readings import raw_readings
from ...least_squares.term import Place
from ...measurements.measurement import Measurement
from ...measurements.running_clock import inside, split
from ...significance import NEARLY_ALL
from ...simulating.closed_loop import run

# Judgement; choices unless stated otherwise.
SLOWER = NEARLY_ALL     # share of it, below which a rate may be to blame

# Numerics; choices unless stated otherwise.
# (source: the rate of the records of docs/accuracy.md)
FAST = 1000.0           # rate at which the diagnosis was measured [Hz]
_LONGEST = 60.0         # of the motion that is simulated [s]


def rate_hides(balancer: Balancer, arm: Arm, names: Sequence[str], about: Sequence[Place],
               effective: float) -> bool:
    """Return whether the same motion, sampled faster, would show what this recording does not."""
    if 1.0 / balancer.measurement.as_recorded().dt > SLOWER * FAST:
        return False
    twin = _faster(balancer, arm)
    training = split(twin)[0]
    raw = raw_readings(twin, arm, names, training)
    raw = raw._replace(measurement=replace(raw.measurement, led=balancer.measurement.led))
    fast = Balancer(raw.measurement).apart(arm)
    fitter = Fitter(fast, arm, noise_of(fast, arm)[0], effective, inside(fast.time, training))
    fit = fitter.fit(())
    sizes = smallest_sizes(fitter, SearchResult(fit, fit, ()), fit, raw, training, names)
    return not shows_too_little(sizes, arm, about)


def _faster(balancer: Balancer, arm: Arm) -> Measurement:
    """Return the recording of a healthy arm that moves as measured, at the fast rate."""
    piece = max(balancer.measurement.pieces(), key=lambda part: part.stop - part.start)
    angle = balancer.motion(arm).state[piece, :, LINK_ANGLE]
    spline = CubicSpline(balancer.measurement.dt * np.arange(len(angle)), angle)
    time = np.arange(round(min(float(spline.x[-1]), _LONGEST) * FAST)) / FAST
    made = run(arm, arm, Motion(time, spline(time), spline(time, 1), np.zeros((len(time), 2))), 1)
    measured = balancer.measurement
    sensed = np.where(measured.referenced, made.joint_torque + measured.reference_noise() * (
        np.random.default_rng(1).standard_normal(made.joint_torque.shape)), np.nan)
    return Measurement(measured.labels, 1.0 / FAST,
                       np.ascontiguousarray(made.reading[:, :, :2]), made.command,
                       reference=sensed if measured.referenced.any() else measured.reference)

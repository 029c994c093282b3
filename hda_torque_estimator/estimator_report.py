"""What the estimator says of itself."""

from hda_arm_sim.health import Level, Pace, Refusals, Report
import numpy as np

from . import estimate
from .live_estimator import LiveEstimator


def estimator_report(live: LiveEstimator, pace: Pace, refusals: Refusals) -> Report:
    """Return the report of the second that passed."""
    refused = refusals.take_new()
    level, message = Level.OK, f'{pace.rate:.1f} Hz'
    if not pace.rate:
        level, message = Level.WARN, 'no joint_states that can be used'
    elif refused:
        level, message = Level.WARN, f'{refused} joint_states refused, {message}'
    return Report(level, message, {
        **pace.values(),
        'samples answered': live.answered,
        'samples lost': live.gaps.lost,
        'longest gap [ms]': live.gaps.longest * 1e-6,
        'beyond the valid range': _beyond(live),
        'tip force partly hidden': bool(live.estimator.tip[estimate.SINGULAR] > 0.0),
        'tare under way': live.estimator.taring,
        **refusals.values()})


def _beyond(live: LiveEstimator) -> str:
    beyond = np.flatnonzero(live.estimator.joints[:, estimate.BEYOND_RANGE])
    return ', '.join(live.estimator.arm.labels[joint] for joint in beyond) or 'none'

"""What the estimator says of itself."""

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.health import Level, Pace, Refusals, Report
import numpy as np

from .belief_words import doubts_in_words
from .laws import contact, layout
from .live_estimator import LiveEstimator
from .route_health import health_in_words, UNTAUGHT, WELL


def estimator_report(live: LiveEstimator, pace: Pace, refusals: Refusals) -> Report:
    """Return the report of the second that passed."""
    refused = refusals.take_new()
    level, message = Level.OK, f'{pace.rate:.1f} Hz'
    if not pace.rate:
        level, message = Level.WARN, 'no joint_states that can be used'
    elif refused:
        level, message = Level.WARN, f'{refused} joint_states refused, {message}'
    if live.estimator.tip[layout.CONTACT_LEVEL] == contact.COLLISION:
        level, message = max(level, Level.WARN), f'collision, {message}'
    health = _health(live)
    if any(words not in (WELL, UNTAUGHT) and not words.startswith('unknown')
           for words in health.values()):
        level, message = max(level, Level.WARN), f'a joint changed, {message}'
    doubts = _doubts(live)
    if doubts:
        level, message = max(level, Level.WARN), f'{doubts[0]}, {message}'
    return Report(level, message, {
        **pace.values(),
        'doubts': '; '.join(doubts) or 'none',
        'samples not believed': live.estimator.unbelieved,
        'samples answered': live.answered,
        'samples lost': live.gaps.lost,
        'longest gap [ms]': live.gaps.longest * 1e-6,
        'beyond the valid range': _beyond(live),
        'contact': _touch(live),
        'contacts so far': int(_contact_memory(live)[contact.CONTACTS]),
        **health,
        'mass at the tip beyond the model [kg]': _mass(live),
        'tip force partly hidden': bool(live.estimator.tip[layout.SINGULAR] > 0.0),
        'tare under way': live.estimator.taring,
        **refusals.values()})


def _doubts(live: LiveEstimator) -> list[str]:
    estimator = live.estimator
    return doubts_in_words(estimator.arm.labels, estimator.joints[:, layout.DOUBT].tolist())


def _touch(live: LiveEstimator) -> str:
    level, felt = live.estimator.tip[[layout.CONTACT_LEVEL, layout.CONTACT_DEVIATIONS]]
    if live.estimator.arm.links is None:
        return 'unknown: the arm has no links'
    pushed = 'something pushes the arm now' if _contact_memory(live)[contact.TOUCHING] else 'none'
    if level == contact.COLLISION:
        return f'{pushed}; a hard push was felt, until torque_estimator/reset'
    return f'{pushed} ({felt:.1f} deviations)'


def _mass(live: LiveEstimator) -> str:
    mass, deviation = live.estimator.tip[[layout.MASS, layout.MASS_DEVIATION]]
    return f'{mass:.2f} +- {deviation:.2f}' if np.isfinite(mass) else 'unknown'


def _contact_memory(live: LiveEstimator) -> Array:
    return live.estimator.memory[0, layout.CONTACT:]


def _health(live: LiveEstimator) -> dict[str, str]:
    estimator = live.estimator
    return {f'{joint.label}: torsion against motor torque':
            health_in_words(joint, estimator.arm.tolerances_of(joint.label),
                            memory[layout.FUSION:])
            for joint, memory in zip(estimator.arm.joints, estimator.memory)}


def _beyond(live: LiveEstimator) -> str:
    beyond = np.flatnonzero(live.estimator.joints[:, layout.BEYOND_RANGE])
    return ', '.join(live.estimator.arm.labels[joint] for joint in beyond) or 'none'

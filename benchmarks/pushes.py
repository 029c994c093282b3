"""Pushes at the tip: how close the force is, when a push is felt, what free motion feigns."""

from hda_arm_sim.foundation.arrays import Array
from hda_torque_estimator.estimating.estimates import Estimates
from hda_torque_estimator.estimating.laws import contact, layout
from hidden_truth import TruthRecord
import numpy as np
from numpy.typing import NDArray

REACHED = 0.5                       # |sin(theta2)| from which both components are asked for
PUSH, LASTS = 5.0, 400              # sudden push [N] and its samples
SOON = 50.0                         # when it must be felt [ms]
BEGUN = 3000                        # samples that an estimator may take to learn
WITHIN = 1.645                      # deviations of a 90 % interval
_APART, _LEAD = 1500, 4000          # samples from push to push, and before the first


def sudden(samples: int, random: np.random.Generator) -> tuple[NDArray[np.int64], Array]:
    """Return when sudden pushes of 5 N begin, every way, and their force (samples, 2) [N]."""
    force = np.zeros((samples, 2))
    begins = np.arange(_LEAD, samples - 1000, _APART) + random.integers(0, 500)
    for begin in begins:
        way = random.uniform(0.0, 2.0 * np.pi)
        force[begin:begin + LASTS] = PUSH * np.cos(way), PUSH * np.sin(way)
    return begins, force


def force_error(estimated: Estimates, seen: TruthRecord, force: Array) -> float:
    """Return the rms error of a component of the tip force where both are observable [N]."""
    reached = np.abs(np.sin(seen.states[:, 1, 2])) > REACHED
    reached[:BEGUN] = False
    return float(np.sqrt(((estimated.base_force - force)[reached] ** 2).mean()))


def delays(estimated: Estimates, seen: TruthRecord, begins: NDArray[np.int64]) -> list[float]:
    """Return when each sudden push was felt [ms], inf where it was not."""
    felt = estimated.tip[:, layout.CONTACT_LEVEL] > contact.FREE
    found = []
    for begin in begins[np.abs(np.sin(seen.states[begins, 1, 2])) > REACHED]:
        when = np.flatnonzero(felt[begin:begin + LASTS])
        found.append(float(when[0]) if len(when) else np.inf)
    return found


def alarms(estimated: Estimates) -> tuple[int, float]:
    """Return how often free motion was taken for a contact, and the largest deviations."""
    raised = np.diff(estimated.tip[:, layout.CONTACT_LEVEL] > contact.FREE, prepend=False)
    return int(raised.sum() + 1) // 2, float(estimated.tip[:, layout.CONTACT_DEVIATIONS].max())

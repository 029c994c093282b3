"""Recordings of arms whose every number is wrong by as much as the tolerances say."""

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.parts import Tolerances
from hda_arm_sim.motions import motion
import numpy as np
from truth import Hidden, record, Reference, TruthRecord
from truth_cases import hide

DT = 1e-3
LABELS = ('joint1', 'joint2')


def wave(size: float, random: np.random.Generator) -> tuple[float, float]:
    """Return amplitude and phase of a wave whose sine and cosine have this deviation."""
    sine, cosine = size * random.standard_normal(2)
    return float(np.hypot(sine, cosine)), float(np.arctan2(cosine, sine))


def drawn(known: Tolerances, random: np.random.Generator) -> list[Hidden]:
    """Return effects of both joints as large as the tolerances say, beside the usual scatter."""
    effects = []
    for label in LABELS:
        for name, size, orders in (('kinematic_error', known.kinematic_error, (2, 4)),
                                   ('link_encoder_eccentricity', known.eccentricity, (1, 2)),
                                   ('torque_ripple', known.torque_ripple, (2, 4))):
            numbers: dict[str, float] = {}
            for order in orders:
                numbers[f'amplitude_{order}'], numbers[f'phase_{order}'] = wave(size, random)
            effects.append(hide(name, label, **numbers))
        effects.append(hide('drive_offset', label,
                            offset=known.drive_offset * random.standard_normal()))
        effects.append(hide('clock_skew', label, skew=known.clock_skew * random.standard_normal()))
    return effects


def tolerated(known: Tolerances, path: str, seed: int, seconds: float,
              force: Array | None = None) -> TruthRecord:
    """Return a recording of such an arm in one of the motions, its tip pushed or free."""
    made = motion(path, 2, seconds, DT, seed)
    return record(drawn(known, np.random.default_rng([seed, 77])),
                  Reference(made.angle, made.rate, DT, force), seed=seed)


def reading(seen: TruthRecord) -> Array:
    """Return the readings of a recording (k, 2, 4), without velocities."""
    unknown = np.full_like(seen.motor_angle, np.nan)
    return np.stack([seen.motor_angle, seen.link_angle, unknown, unknown], axis=2)


def pushed(samples: int, size: float, random: np.random.Generator) -> Array:
    """Return soft pushes of up to `size` [N], every way, from half a second on (samples, 2)."""
    time, force, begin = DT * np.arange(samples), np.zeros((samples, 2)), 0.5
    while begin < time[-1]:
        way, most = random.uniform(0.0, 2.0 * np.pi), random.uniform(0.2, 1.0) * size
        edge = np.clip(np.minimum(time - begin, begin + 1.2 - time) / 0.15, 0.0, 1.0)
        force += most * np.outer(edge ** 2 * (3.0 - 2.0 * edge), (np.cos(way), np.sin(way)))
        begin += random.uniform(1.5, 3.0)
    return force

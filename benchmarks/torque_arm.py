"""
An arm of the paper's class with imperfections that nobody may read, and recordings of it.

The arm is that of `test/truth/`: other formulas, integrator and step than the library's. Each
seed is another arm, with its own phases and its own scatter within the tolerances.
"""

from collections.abc import Mapping
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.motions import HOME
from hda_torque_estimator.simulating.recorded import FIRST_STAMP
from hidden_truth import Device, EFFECTS, Hidden, record, Reference, TruthRecord
import numpy as np

DT = 1e-3
LENGTH = 0.15                   # of both links [m]
JOINTS = ('joint1', 'joint2')
TILT = 0.45                     # of the wedge under the base, known to the calibration [rad]

# Sizes of the imperfections; phases are drawn. A micrometre at the disc's 25 mm is 40 urad.
SIZES: dict[str, dict[str, float]] = {
    'kinematic_error': {'amplitude_2': 1.3e-4, 'amplitude_4': 0.45e-4},
    'third_order_kinematic_error': {'amplitude': 0.15e-4},
    'motor_encoder_eccentricity': {'amplitude': 3e-3},
    'link_encoder_eccentricity': {'amplitude_1': 4e-4, 'amplitude_2': 0.3e-4},
    'torsional_hysteresis': {'level': 1.05, 'width': 1.5e-4},
    'clock_skew': {'skew': 2e-4},
    'stiffness_error': {'relative_error': -0.06},
    'wave_generator_compliance': {'psi': 3.5e-4},
    'stribeck_friction': {'excess': 0.012, 'speed': 6.0},
    'asymmetric_friction': {'asymmetry': 0.12},
    'load_dependent_friction': {'coefficient': 0.10},
}


class Loaded(NamedTuple):
    """A motion and what the environment does meanwhile: angles (k, 2), torques (k, 2) [N*m]."""

    angle: Array
    torque: Array
    tilt: float = 0.0


class Recorded(NamedTuple):
    """A recording, the force on the tip that a sensor would show, and the tilt of the base."""

    seen: TruthRecord
    force: Array                # (k, 2) base frame [N]
    tilt: float


def imperfections(seed: int) -> list[Hidden]:
    """Return what is hidden in the arm of a seed, the same sizes in both joints."""
    random = np.random.default_rng([seed, 77])
    return [hidden(name, joint, sizes, random) for joint in JOINTS
            for name, sizes in SIZES.items()]


def hidden(name: str, joint: str | None, sizes: Mapping[str, float],
           random: np.random.Generator) -> Hidden:
    """Return an effect of these sizes; phases that are not given are drawn."""
    effect = EFFECTS[name]
    values = {part.name: random.uniform(-np.pi, np.pi) if 'phase' in part.name else part.neutral
              for part in effect.parameters}
    return Hidden(name, joint, {**values, **sizes}, effect.site, effect.coordinate)


def recorded(arm_seed: int, loaded: Loaded, seed: int) -> Recorded:
    """Record the arm of a seed in a motion under load."""
    force = tip_force(loaded.angle, loaded.torque)
    seen = moved(arm_seed, loaded.angle, force, seed, loaded.tilt)
    measured = force[np.searchsorted(FIRST_STAMP + np.arange(len(force)) * 1_000_000,
                                     seen.stamps - 500_000)]
    noise = 0.05 * np.random.default_rng([seed, 78]).standard_normal(measured.shape)
    return Recorded(seen, measured + noise * force.any(), loaded.tilt)


def moved(arm_seed: int, angle: Array, force: Array, seed: int,
          tilt: float = 0.0) -> TruthRecord:
    """Record the arm of a seed along angles (k, 2), a force (k, 2) on its tip [N, base]."""
    found = imperfections(arm_seed)
    if tilt:
        found.append(hidden('base_tilt', None, {'tilt': tilt, 'direction': 0.0},
                            np.random.default_rng(0)))
    return record(found, Reference(angle, np.gradient(angle, DT, axis=0), DT, force), seed=seed,
                  device=Device(seed=arm_seed))


def tip_force(angle: Array, torque: Array) -> Array:
    """Return the force on the tip (k, 2) that turns the joints by these torques [N, base]."""
    elbow, pointing = angle[:, 1], angle.sum(axis=1)
    across = torque[:, 1] / LENGTH
    along = (torque[:, 0] - (1.0 + np.cos(elbow)) * torque[:, 1]) / (LENGTH * np.sin(elbow))
    c, s = np.cos(pointing), np.sin(pointing)
    return np.stack([c * along - s * across, s * along + c * across], axis=1)


def calibration(seconds: float = 60.0) -> list[Loaded]:
    """
    Return the motions of a calibration: free, on a wedge, and pulled at the tip.

    The first two reach all angles at which the arm works; a map of the link's turn is worth
    little where it was never seen.
    """
    time = times(seconds)
    free = wander(time, (2.8, 1.6), (21.0, 15.5), 0.15)
    tilted = wander(time, (2.8, 1.6), (26.0, 17.0), 0.1)
    pulled = wander(time, (0.9, 0.5), (29.0, 37.0))
    pull = np.stack([20.0 * np.sin(0.7 * time) + 4.0 * np.sin(2.3 * time),
                     -20.0 * np.sin(0.53 * time) + 4.0 * np.sin(1.9 * time)], axis=1)
    return [Loaded(free, np.zeros_like(free)), Loaded(tilted, np.zeros_like(tilted), TILT),
            Loaded(pulled, pull * fade(time, 3.0)[:, None])]


def turning(size: float, seconds: float = 60.0) -> Loaded:
    """Return both joints turning there and back under steps and waves, as in Fig. 11."""
    time = times(seconds)
    angle = wander(time, (2.8, 0.95), (seconds, 0.6 * seconds))
    return Loaded(angle, _loads(time, 0.0, size))


def standing(middle: float, size: float, seconds: float = 40.0) -> Loaded:
    """Return both joints standing under steps and waves of load, as in Fig. 9."""
    time = times(seconds)
    return Loaded(np.tile([HOME[0] + 0.4, 1.5], (len(time), 1)), _loads(time, middle, size))


def _loads(time: Array, middle: float, size: float) -> Array:
    """Return torques on both joints (k, 2): steps with soft edges, then a wave [N*m]."""
    steps = np.array([0.0, 1.0, -0.5, 0.5, -1.0, 0.2])[(time // 2.5).astype(int) % 6]
    soft = np.convolve(steps, np.ones(100) / 100.0, 'same')
    wave = np.where(time < 0.5 * time[-1], soft, np.sin(2.0 * np.pi * 0.4 * time))
    torque = middle + size * wave * fade(time, 1.5)
    return np.stack([torque, -torque], axis=1) * fade(time, 1.5)[:, None]


def times(seconds: float) -> Array:
    """Return the times of all samples [s]."""
    return DT * np.arange(round(seconds / DT), dtype=np.float64)


def fade(time: Array, seconds: float) -> Array:
    """Return a weight that rises smoothly from 0 to 1 within some seconds."""
    share = np.clip(time / seconds, 0.0, 1.0)
    return share ** 2 * (3.0 - 2.0 * share)


def wander(time: Array, size: tuple[float, float], period: tuple[float, float],
           quick: float = 0.0) -> Array:
    """Return both joints going to and fro at constant speeds, a share of it in a quicker wave."""
    columns = []
    for middle, reach, span in zip((HOME[0], 1.55), size, period):
        wave = (1.0 - quick) * _rounded(time / span) + quick * _rounded(time / (0.23 * span))
        columns.append(middle + reach * wave * fade(time, 2.0))
    return np.stack(columns, axis=1)


def _rounded(turns: Array) -> Array:
    """Return a triangle wave with round corners: constant speed nearly all the time."""
    return np.arcsin(0.9 * np.sin(2.0 * np.pi * turns)) / np.arcsin(0.9)

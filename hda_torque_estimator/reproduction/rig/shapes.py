"""Inputs over time that several figures share."""

from hda_arm_sim.foundation.arrays import Array
import numpy as np


def step(time: Array, begin: float, end: float, edge: float) -> Array:
    """Return 1 from begin to end and 0 elsewhere, with smooth edges of a duration [s]."""
    rise = np.clip(np.minimum(time - begin, end - time) / edge, 0.0, 1.0)
    return np.asarray(rise ** 2 * (3.0 - 2.0 * rise))


def sine(time: Array, frequency: float, begin: float) -> Array:
    """Return a sine of a frequency [Hz] that starts at a time [s] with a faded first half."""
    fade = np.clip((time - begin) * 2.0 * frequency, 0.0, 1.0)
    return np.asarray(fade * np.sin(2.0 * np.pi * frequency * np.maximum(time - begin, 0.0)))


def hand(time: Array, seed: int, begin: float, end: float, size: float) -> Array:
    """Return pushes as of a hand: slow, random, up to about a size, from begin to end [s]."""
    random = np.random.default_rng(seed)
    tones = np.array([0.11, 0.19, 0.31, 0.53, 0.83])
    phases, sizes = random.uniform(0.0, 2.0 * np.pi, 5), random.uniform(0.5, 1.0, 5)
    wave = (sizes * np.sin(2.0 * np.pi * np.outer(time, tones) + phases)).sum(axis=1)
    return np.asarray(size * wave / np.abs(wave).max() * step(time, begin, end, 1.0))

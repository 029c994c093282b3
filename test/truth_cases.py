"""Recordings of the truth as its tests make them: one motion, effects of given sizes."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray
from truth import Device, EFFECTS, Hidden, record, Reference, TruthRecord

Array = NDArray[np.float64]

DT, SECONDS = 1e-3, 2.5
EXACT = (1e12, 1e13)            # counts of encoders that hide nothing


def motion(seconds: float) -> tuple[Array, Array]:
    """Return link angles and rates of two sines about (0.3, 1.2) rad, from rest."""
    t = DT * np.arange(round(seconds / DT))
    w, size = 2.0 * np.pi * np.array([0.45, 0.7]), np.array([0.35, -0.3])
    fade = np.minimum(t / 0.5, 1.0)[:, None]
    angle = [0.3, 1.2] + size * (3.0 - 2.0 * fade) * fade ** 2 * np.sin(np.outer(t, w))
    return angle, np.gradient(angle, DT, axis=0)


def recorded(hidden: Iterable[Hidden] = (), seconds: float = SECONDS, seed: int = 3, *,
             noise: float = 1.0, scatter: bool = True,
             counts: tuple[float, float] = (16384, 4e6)) -> TruthRecord:
    """Return a recording of the arm with these effects in the motion of these tests."""
    angle, rate = motion(seconds)
    return record(tuple(hidden), Reference(angle, rate, DT), seed=seed,
                  device=Device(scatter=scatter, counts=counts), noise=noise)


def exact(*hidden: Hidden, seconds: float = 2.0, noise: float = 0.0) -> TruthRecord:
    """Return a recording without scatter and steps, and without noise where none is given."""
    return recorded(hidden, seconds, noise=noise, scatter=False, counts=EXACT)


def hide(name: str, joint: str | None = 'joint1', **parameters: float) -> Hidden:
    """Return an effect of these sizes, other parameters neutral."""
    effect = EFFECTS[name]
    neutral = {parameter.name: parameter.neutral for parameter in effect.parameters}
    return Hidden(name, joint, neutral | parameters, effect.site, effect.coordinate)


def times(seen: TruthRecord) -> Array:
    """Return the time of every sample since the recording began (k,) [s]."""
    return (seen.stamps - 1_000_000_000) * 1e-9

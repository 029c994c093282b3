"""
What one direction, or one load, cannot show of a gear that is held against a reference torque.

Turned one way, friction is a constant, as an offset and the zero of a sensor are. Under one load
the torque is a curve over the link angle. So laws of it and errors over the angle are alike.
"""

from collections.abc import Iterator

from hda_arm_sim.foundation.arrays import Array
import numpy as np

from ...measurements.measurement import Measurement
from ...significance import HARDLY, NEARLY_ALL

_LINK = 1               # side of a reading (layout)


def one_sided(measurement: Measurement) -> tuple[str, ...]:
    """Return sentences on what cannot be distinguished at joints held against a reference."""
    return tuple(sentence for place in np.flatnonzero(measurement.held_against)
                 for sentence in _of_joint(measurement, int(place)))


def _of_joint(measurement: Measurement, place: int) -> Iterator[str]:
    label, torque = measurement.labels[place], measurement.reference[:, place]
    angle, known = measurement.reading[:, place, _LINK], np.isfinite(torque)
    if _share_back(measurement, angle) < HARDLY:
        yield (f'{label} turns one way: dry friction, an offset of its drive and the zero of its '
               'reference torque cannot be distinguished')
    if _of_angle(angle[known], torque[known]) > NEARLY_ALL:
        yield (f'{label} bears one load: a law of its torsion cannot be distinguished from an '
               'error over the link angle')


def _share_back(measurement: Measurement, angle: Array) -> float:
    """Return the share of the travel of a link (k,) in the direction in which it moves less."""
    steps = np.concatenate([np.diff(angle[piece]) for piece in measurement.pieces()])
    ways = float(steps[steps > 0.0].sum()), float(-steps[steps < 0.0].sum())
    return min(ways) / max(sum(ways), 1e-300)


def _of_angle(angle: Array, torque: Array) -> float:
    """Return the share of a torque (k,) that one weight on a link at angles (k,) explains."""
    columns = np.stack([np.ones_like(angle), np.cos(angle), np.sin(angle)], axis=1)
    rest = torque - columns @ np.linalg.lstsq(columns, torque, rcond=None)[0]
    return 1.0 - float(np.var(rest)) / max(float(np.var(torque)), 1e-300)

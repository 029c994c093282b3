"""Messages as the columns of one table, as pandas and its like take them."""

from collections.abc import Mapping
from typing import Any

from hda_msgs_json.samples import JointSamples, Stamps, WrenchSamples
import numpy as np
from numpy.typing import NDArray

from .convert import NANOSECONDS

Columns = dict[str, NDArray[Any]]
QUANTITIES = ('position', 'velocity', 'effort')
AXES = 'xyz'


def time_columns(stamps: Stamps) -> Columns:
    """Return the stamps [ns] as they are, and the time [s] since the first of them (n,)."""
    return {'stamp': stamps, 'time': (stamps - stamps[:1]) / NANOSECONDS}


def joint_columns(samples: JointSamples, topic: str = '') -> Columns:
    """Return the columns JOINT.QUANTITY (n,) behind the name of a topic, without empty ones."""
    columns = {f'{topic}{"." * bool(topic)}{name}.{quantity}': values[:, place]
               for place, name in enumerate(samples.names)
               for quantity, values in zip(QUANTITIES, samples.numbers) if values.shape[1]}
    return {name: values for name, values in columns.items() if not np.isnan(values).all()}


def wrench_columns(samples: WrenchSamples, topic: str) -> Columns:
    """Return the columns TOPIC.force.x to TOPIC.torque.z (n,), without empty ones."""
    columns = {f'{topic}.{quantity}.{axis}': values[:, place]
               for quantity, values in zip(('force', 'torque'), samples.numbers)
               for place, axis in enumerate(AXES)}
    return {name: values for name, values in columns.items() if not np.isnan(values).all()}


def at_stamps(columns: Mapping[str, NDArray[Any]], stamps: Stamps, grid: Stamps) -> Columns:
    """
    Return columns (n,) at other stamps (m,): what is nearest, NaN beyond half a period of these.

    Nothing is interpolated: every number is one that was recorded.
    """
    if not len(stamps) or not len(grid):
        return {name: np.full(len(grid), np.nan) for name in columns}
    order = np.argsort(stamps, kind='stable')
    ordered = stamps[order]
    after = np.clip(np.searchsorted(ordered, grid), 1 if len(stamps) > 1 else 0, len(stamps) - 1)
    before = np.maximum(after - 1, 0)
    nearest = np.where(grid - ordered[before] < ordered[after] - grid, before, after)
    reach = float(np.median(np.abs(np.diff(grid)))) / 2.0 if len(grid) > 1 else 0.0
    is_near = np.abs(ordered[nearest] - grid) <= reach
    return {name: np.where(is_near, values[order[nearest]], np.nan)
            for name, values in columns.items()}

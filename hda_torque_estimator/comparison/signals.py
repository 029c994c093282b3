"""What a bag holds as signals over time: one name, one unit, one column of numbers each."""

from collections.abc import Mapping
from dataclasses import dataclass

from hda_arm_sim.foundation.arrays import Array
from hda_msgs_json.errors import HdaError
from hda_msgs_json.samples import JointSamples, Stamps, WrenchSamples
import numpy as np
from numpy.typing import NDArray

from ..measurements.recording_facts import stamp_facts

JOINT_UNITS = {'position': 'rad', 'velocity': 'rad/s', 'effort': 'N*m'}
WRENCH_UNITS = {'force': 'N', 'torque': 'N*m'}
LEAST = 8                           # samples without which a column is no signal
_MOST_PERIODS = 20_000_000          # in a bag: five hours at 1 kHz
_INFINITE = 1e100                   # numbers whose squares would overflow are none


class CompareError(HdaError):
    """Two bags that cannot be compared."""


@dataclass(frozen=True, eq=False)
class Signal:
    """Hold one column: times (k,) since the start of its bag [s], strictly later each."""

    name: str
    unit: str
    time: Array
    values: Array                   # (k,), all finite

    @property
    def period(self) -> float:
        """Return the usual time between two samples [s]."""
        return float(np.median(np.diff(self.time)))


@dataclass(frozen=True)
class Sampling:
    """How a topic is sampled."""

    samples: int
    rate: float                     # [Hz]
    lost: int                       # samples that never came, by the usual period
    longest_gap: float              # [s]


@dataclass(frozen=True, eq=False)
class BagSignals:
    """Hold the signals of one bag by name, and how its topics are sampled."""

    source: str
    start: int                      # first stamp of all signals [ns]
    signals: Mapping[str, Signal]
    sampling: Mapping[str, Sampling]


def bag_of(source: str, topics: Mapping[str, JointSamples | WrenchSamples]) -> BagSignals:
    """Return the signals of the topics of a bag; raise CompareError if there are none."""
    filled = {name: samples for name, samples in topics.items() if len(samples)}
    start = min((int(samples.stamps.min()) for samples in filled.values()), default=0)
    signals = {}
    for topic, samples in filled.items():
        kept = _later(samples.stamps)
        time = (samples.stamps[kept] - start).astype(np.float64) * 1e-9
        for name, unit, column in _columns(samples):
            values, label = column[kept], f'{topic.strip("/")}/{name}'
            seen = np.abs(values) < _INFINITE
            if seen.sum() >= LEAST:
                signals[label] = Signal(label, unit, time[seen], values[seen])
    if not signals:
        raise CompareError(
            f'{source} has no signal to compare: it needs at least {LEAST} finite samples of a '
            'JointState or WrenchStamped at stamps that grow')
    _check_span(source, signals)
    return BagSignals(source, start, signals, {topic.strip('/'): _sampling(samples.stamps)
                                               for topic, samples in filled.items()})


def _check_span(source: str, signals: Mapping[str, Signal]) -> None:
    """Raise CompareError if even times would not fit in memory: stamps were damaged."""
    span = max(float(signal.time[-1]) for signal in signals.values())
    period = min(signal.period for signal in signals.values())
    if span > _MOST_PERIODS * period:
        raise CompareError(
            f'{source} cannot be compared: its stamps span {span:.4g} s at {1.0 / period:.4g} Hz, '
            f'more than {_MOST_PERIODS:,} samples; one is wrong, or topics have clocks of their '
            'own')


def _columns(samples: JointSamples | WrenchSamples) -> list[tuple[str, str, Array]]:
    """Return name, unit and values (k,) of every column of a topic."""
    if isinstance(samples, JointSamples):
        return [(f'{name}/{field}', unit, getattr(samples, field)[:, column])
                for column, name in enumerate(samples.names)
                for field, unit in JOINT_UNITS.items()]
    return [(f'{field}.{axis}', unit, getattr(samples, field)[:, column])
            for field, unit in WRENCH_UNITS.items() for column, axis in enumerate('xyz')]


def _later(stamps: Stamps) -> NDArray[np.bool_]:
    """Return which stamps are later than all before them."""
    latest = np.maximum.accumulate(stamps)
    return np.append(True, stamps[1:] > latest[:-1])


def _sampling(stamps: Stamps) -> Sampling:
    facts = stamp_facts(stamps)
    missing = np.round(np.diff(stamps) * 1e-9 * facts.rate) - 1.0
    return Sampling(facts.samples, facts.rate, int(np.maximum(missing, 0.0).sum()),
                    facts.longest_gap)

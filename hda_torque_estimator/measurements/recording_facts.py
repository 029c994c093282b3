"""What raw samples alone show: rate, gaps, resolution, travel; and what they cannot show."""

from dataclasses import dataclass

from hda_msgs_json.samples import JointSamples
from hda_msgs_json.topics import MOTOR_SUFFIX
import numpy as np
from numpy.typing import NDArray

# Choices unless stated otherwise.
_GAP = 1.5              # of the usual period
_STANDSTILL = 1e-3      # link travel that counts as none [rad]
_SHORT = 5.0            # recordings below this cannot average friction and ripple [s]


@dataclass(frozen=True)
class StampFacts:
    """The time base of a topic."""

    samples: int
    duration: float             # [s]
    rate: float                 # from the median period, 0 with less than two samples [Hz]
    gaps: int                   # periods over 1.5 times the median
    longest_gap: float          # [s]
    not_later: int              # stamps that repeat or go back


@dataclass(frozen=True)
class NameFacts:
    """One name of the joint states."""

    name: str
    step: float                 # smallest change seen: the resolution [rad], NaN if none
    low: float                  # [rad]
    high: float                 # [rad]
    fastest: float              # [rad/s], from angles
    velocity: bool              # whether velocities are given
    effort: bool                # whether efforts are given


def stamp_facts(stamps: NDArray[np.int64]) -> StampFacts:
    """Return the facts of stamps [ns]."""
    periods = np.diff(stamps) * 1e-9
    usual = float(np.median(periods)) if len(periods) else 0.0
    return StampFacts(
        len(stamps), float(stamps[-1] - stamps[0]) * 1e-9 if len(stamps) else 0.0,
        1.0 / usual if usual > 0.0 else 0.0, int((periods > _GAP * usual).sum()),
        float(periods.max()) if len(periods) else 0.0, int((periods <= 0.0).sum()))


def name_facts(samples: JointSamples) -> tuple[NameFacts, ...]:
    """Return the facts of every name in the joint states."""
    return tuple(_one(samples, column) for column in range(len(samples.names)))


def _one(samples: JointSamples, column: int) -> NameFacts:
    angle = samples.position[:, column]
    seen = np.isfinite(angle)
    changes = np.abs(np.diff(angle[seen]))
    periods = np.diff(samples.stamps[seen]) * 1e-9
    later = periods > 0.0
    speeds = changes[later] / periods[later]
    steps = changes[changes > 1e-12]
    return NameFacts(
        samples.names[column], float(steps.min()) if len(steps) else np.nan,
        float(angle[seen].min()) if seen.any() else np.nan,
        float(angle[seen].max()) if seen.any() else np.nan,
        float(np.percentile(speeds, 99.5)) if len(speeds) else np.nan,
        bool(np.isfinite(samples.velocity[:, column]).any()),
        bool(np.isfinite(samples.effort[:, column]).any()))


def _stands(fact: NameFacts) -> bool:
    """Return whether an angle never changes by more than of a joint that stands."""
    return not fact.high - fact.low > _STANDSTILL


def shortcomings(time: StampFacts, names: tuple[NameFacts, ...],
                 references: tuple[str, ...]) -> tuple[str, ...]:
    """Return what these joint states cannot show, a sentence each."""
    found = []
    known = {fact.name: fact for fact in names}
    links = [name for name in known if not name.endswith(MOTOR_SUFFIX)]
    alone = [name for name in links if name + MOTOR_SUFFIX not in known]
    if alone:
        found.append(f'no torsion of {", ".join(alone)}: there is no motor side')
    motors = [name.removesuffix(MOTOR_SUFFIX) for name in known if name.endswith(MOTOR_SUFFIX)
              and name.removesuffix(MOTOR_SUFFIX) not in known]
    if motors:
        found.append(f'no torsion of {", ".join(motors)}: there is no link angle')
    silent = [name for name in links if name + MOTOR_SUFFIX in known
              and not known[name + MOTOR_SUFFIX].effort]
    if silent:
        found.append(f'no friction or inertia of {", ".join(silent)}: no motor torque is there')
    still = [name for name in links if _stands(known[name])]
    held = [name for name in motors if _stands(known[name + MOTOR_SUFFIX])]
    if held:
        found.append(f'nothing that needs motion of {", ".join(held)}: the motor stands still')
    if still:
        found.append(f'nothing that needs motion of {", ".join(still)}: the link stands still')
    if time.duration < _SHORT:
        found.append(f'no slow or rare effect: the recording lasts {time.duration:.2g} s')
    if not references:
        found.append('no absolute scale of torque: there is no reference torque or force')
    return tuple(found)

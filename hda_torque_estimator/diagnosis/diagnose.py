"""
Diagnose a measurement: from raw readings to causes, an extended arm, and its gain on unseen data.

Fits see the training stretches only. What they claim is confirmed by simulation on the held-out
stretches; a cause that does not gain there is not told.
"""

from collections.abc import Sequence
from typing import NamedTuple

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import EFFECTS
import numpy as np
from numpy.typing import NDArray

from .balance import Balancer
from .fit import Fitter
from .healthy import healthy_twin, noise_of, torque_noise_of
from .hypotheses import HYPOTHESES
from .measurement import Measurement
from .report import Diagnosis, Finding, RecordingFacts
from .search import Found, search
from .verdict import alike, findings, gains, residuals, zeros_only

Array = NDArray[np.float64]
Spans = tuple[tuple[float, float], ...]
EFFECTIVE = 0.5         # share of the balances' samples that are independent
_BLOCK = 2.0            # stretches that are trained on, and held out in turn [s]
_HELD = 3               # of so many stretches one is held out
_STILL = 0.02           # link travel below which nothing was moved [rad]
_REST = 5.0             # rms left over noise from which something is unexplained


class Conclusion(NamedTuple):
    """A diagnosis, the arm extended by it, and the search that led to it."""

    diagnosis: Diagnosis
    extended: Arm
    found: Found
    fitter: Fitter


def diagnose(measurement: Measurement, arm: Arm, *, names: Sequence[str] | None = None,
             arm_file: str = '', version: str = '', seconds: float = 0.0) -> Conclusion:
    """Return what the simulation of `arm` gets wrong about a measurement that passed the gate."""
    balancer = Balancer(measurement)
    training, held_out = stretches(measurement.duration)
    rows = _inside(balancer.time, training)
    fitter = Fitter(balancer, arm, noise_of(balancer, arm)[0], EFFECTIVE, rows)
    found = search(fitter, list(HYPOTHESES) if names is None else names)
    extended = fitter.on(found.last.terms)
    fitter.noise, plain = noise_of(balancer, extended)
    twin = Balancer(healthy_twin(balancer, extended, 1,
                                 torque_noise_of(fitter.noise, plain, balancer, arm)))
    told = findings(fitter, found, twin, held_out)
    before = fitter.on(zeros_only(found.last))
    total = gains(balancer, twin, before, extended, held_out).total()
    pairs = alike(found)
    diagnosis = Diagnosis(
        _verdict(measurement, fitter, found, told, bool(pairs)), told, pairs, None, (), total,
        residuals(fitter, found, _inside(balancer.time, held_out), arm.labels),
        RecordingFacts(measurement.duration, len(measurement.command), 1.0 / measurement.dt,
                       training, held_out), arm_file, version, seconds)
    kept = [term for term in found.last.terms if term.name != 'encoder_zero']
    return Conclusion(diagnosis, fitter.on(kept), found, fitter)


def stretches(duration: float) -> tuple[Spans, Spans]:
    """Return the stretches of time that fits see, and those that they do not [s]."""
    ends = np.append(np.arange(0.0, duration, _BLOCK), duration)
    spans = [(float(begin), float(end)) for begin, end in zip(ends[:-1], ends[1:])]
    held = spans[_HELD - 1::_HELD]
    return tuple(span for span in spans if span not in held), tuple(held)


def sought_effects() -> tuple[str, ...]:
    """Return the names of the effects that the balances can show."""
    return tuple(effect.name for effect in EFFECTS if effect.name in HYPOTHESES)


def _inside(time: Array, spans: Spans) -> NDArray[np.bool_]:
    inside = np.zeros(len(time), bool)
    for begin, end in spans:
        inside |= (time >= begin) & (time < end)
    return inside


def _verdict(measurement: Measurement, fitter: Fitter, found: Found,
             told: tuple[Finding, ...], tied: bool) -> str:
    """Return the verdict that the findings and the rest call for."""
    travel = np.ptp(measurement.reading[:, :, 1], axis=0)
    if (travel < _STILL).all():
        return 'insufficient_excitation'
    rest = np.sqrt(found.last.variance) / fitter.noise
    excess = found.first.variance - fitter.noise ** 2
    left = found.last.variance - fitter.noise ** 2
    unexplained = bool(((rest > _REST) & (left > 0.1 * excess)).any())
    if unexplained:
        return 'unknown'
    if tied:
        return 'ambiguous'
    return 'explained' if told else 'no_discrepancy'

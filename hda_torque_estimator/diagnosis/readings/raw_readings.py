"""
What only raw readings show: causes that a filter would hide, found before any balance.

The balances then work with an arm that senses as the recorded one does. What a cause explains is
how much the readings scatter: what local polynomials leave of them in stretches that were held
out. Simulated recordings with the cause and without it are held against the measured ones. Of
samples that were lost it is how many are. Each detector is made for one effect, so effects have
names here.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple, TypeAlias

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import (ClockJitter, CoarseQuantisation, DroppedSamples,
                                       EncoderInterpolationError)
from hda_arm_sim.model.kernel import LINK_ANGLE, LINK_VELOCITY
from hda_arm_sim.motions import Motion
import numpy as np

from .encoder_steps import coarse_encoders
from .late_stamps import clock_jitter, stamp_slips, stamped_along
from .line_error import is_of_codes, uneven_lines, without_waves
from .local_rest import local_rest
from .lost_samples import counted_gains, lost_samples, slips_of
from .raw_cause import RawCause
from ..balances.balance import Balancer
from ..findings.certainty import margin_of, probability
from ..findings.gains import Gains
from ..findings.report import Evidence, Finding, TotalGain, with_gain
from ...measurements.even_grid import as_stamped, on_grid
from ...measurements.joined_recordings import joined
from ...measurements.measurement import Measurement
from ...measurements.running_clock import inside, Spans, within
from ...measurements.upsampling import finer
from ...significance import SCORE_BAR
from ...simulating.closed_loop import run

# Numerics; choices unless stated otherwise.
_ASIDE = 1e-4           # moves a motion so that its counts fall elsewhere [rad]
WHOLE: Spans = ((0.0, float('inf')),)
RAW_EFFECTS = (CoarseQuantisation.name, DroppedSamples.name, ClockJitter.name,
               EncoderInterpolationError.name)
ON_THEIR_WAY = (DroppedSamples.name, ClockJitter.name)      # of samples, behind the encoders
METRIC = ('squared logarithm of simulated over measured power of what local polynomials leave of '
          'the raw readings, or Poisson deviance of lost samples, on held-out stretches')


# Of an arm, a seed, and how far its motion is moved aside [rad].
Simulation: TypeAlias = Callable[..., Array]


class RawReadings(NamedTuple):
    """Readings, mended and on a fine grid, the arm that gives such ones, and why."""

    measurement: Measurement
    arm: Arm
    causes: tuple[RawCause, ...]
    on_time: Measurement        # lost samples put in and jitter taken out, all else as recorded
    stamped: Measurement        # lost samples put in, all else as stamps date it


def raw_readings(measurement: Measurement, arm: Arm,
                 names: Sequence[str] = RAW_EFFECTS, training: Spans = WHOLE) -> RawReadings:
    """
    Return what the raw readings of an arm show, among the effects of these names.

    Numbers are fitted to the training stretches alone; all readings are mended. Of several
    recordings, each is mended by what it shows itself.
    """
    causes: dict[tuple[str, str | None], RawCause] = {}
    parts = []
    for place, (one, piece) in enumerate(zip(measurement.recordings(), measurement.pieces())):
        seen = within(training, piece, measurement.dt)
        parts.append(_of_one(one, arm, names, seen or WHOLE))
        for cause in parts[-1].causes if seen else ():
            known = causes.get((cause.effect.name, cause.joint))
            if known is None or cause.score > known.score:
                causes[cause.effect.name, cause.joint] = cause._replace(recording=place)
    if len(parts) == 1:
        return parts[0]
    known_arm = extended_by([cause for cause in causes.values()
                             if cause.effect.name == CoarseQuantisation.name], arm)
    return RawReadings(joined([part.measurement for part in parts]), known_arm,
                       tuple(causes.values()), joined([part.on_time for part in parts]),
                       joined([part.stamped for part in parts]))


def _of_one(measurement: Measurement, arm: Arm, names: Sequence[str],
            training: Spans) -> RawReadings:
    """Return what the raw readings of one recording show."""
    causes: list[RawCause] = []
    seen = inside(measurement.time, training)
    if CoarseQuantisation.name in names:
        causes += coarse_encoders(measurement, arm, seen)
    known = extended_by(causes, arm)
    if DroppedSamples.name in names:
        slips = slips_of(measurement, known)
        lost = lost_samples(slips, seen)
        if lost is not None:
            causes.append(lost)
            measurement = replace(measurement, reading=slips.reading, blind=slips.blind)
    if ClockJitter.name in names:
        jitter = clock_jitter(stamp_slips(measurement), seen, arm)
        causes += [] if jitter is None else [jitter]
    stamped = replace(measurement, reading=as_stamped(measurement))
    on_time = measurement = on_grid(measurement)
    if EncoderInterpolationError.name in names:
        waves = list(uneven_lines(measurement, known, seen))
        causes += [wave for wave in waves if not is_of_codes(wave, causes)]
        measurement = without_waves(measurement, waves, known)
    return RawReadings(finer(measurement), known, tuple(causes), on_time, stamped)


def extended_by(causes: Sequence[RawCause], arm: Arm) -> Arm:
    """Return the arm with these causes."""
    for cause in causes:
        arm = cause.on(arm)
    return arm


def raw_findings(raw: RawReadings, measured: Measurement, balancer: Balancer, given: Arm,
                 extended: Arm, held_out: Spans) -> tuple[Finding, ...]:
    """
    Return the causes that gain on held-out stretches as findings, each with its own gain.

    `measured` are the readings as recorded, `balancer` holds them mended, `given` is the arm
    without all causes, `extended` the one that gives the mended readings.
    """
    gaining = []
    for cause in raw.causes:
        place = cause.recording
        piece = measured.pieces()[place]
        whole = extended_by([other for other in raw.causes if other is cause
                             or other.effect.name not in ON_THEIR_WAY], extended)
        spans = within(held_out, piece, measured.dt)
        shown = raw.stamped if cause.effect.name == ClockJitter.name else raw.on_time
        gain = (counted_gains(cause, given, spans, measured.dt)
                or _gains(cause, shown.recordings()[place], _simulation(
                    cause, raw, balancer, extended), given, whole, spans)).gain()
        odds = float(np.exp(min(0.5 * cause.score, 700.0)))
        evidence = Evidence(cause.score, SCORE_BAR, None, odds)
        gaining.append(Finding(cause.effect.name, cause.joint, cause.effect.site.value,
                               cause.effect.cause, cause.numbers, evidence, gain,
                               probability(margin_of(evidence))))
    return with_gain(gaining)


def raw_total(findings: Sequence[Finding]) -> TotalGain:
    """Return the gain of all raw causes together, the mean of theirs."""
    before, after, floor, removed, low, high = np.mean([
        [gain.before, gain.after, gain.floor, gain.removed, gain.low, gain.high]
        for gain in (finding.gain for finding in findings)], axis=0).tolist()
    return TotalGain(before, after, floor, removed, low, high, METRIC, '1')


def _simulation(cause: RawCause, raw: RawReadings, balancer: Balancer, arm: Arm) -> Simulation:
    """Return what simulates the readings of arms, as it needs be to show a cause."""
    if cause.effect.name in (ClockJitter.name, CoarseQuantisation.name):
        return partial(stamped_along, raw.on_time.recordings()[cause.recording])
    there = balancer.measurement.pieces()[cause.recording]
    return partial(_readings, _motion(balancer, arm, there))


def _motion(balancer: Balancer, arm: Arm, piece: slice) -> Motion:
    """Return the links' motion in one recording as a reference for simulations at its rate."""
    made = balancer.measurement
    state = balancer.motion(arm).state[piece][::made.parts]
    angle, rate = state[:, :, LINK_ANGLE].copy(), state[:, :, LINK_VELOCITY].copy()
    time = made.parts * made.dt * np.arange(len(angle), dtype=np.float64)
    return Motion(time, angle, rate, np.zeros((len(angle), 2)))


def _readings(motion: Motion, arm: Arm, seed: int, aside: float = 0.0) -> Array:
    """Return the angles (k, n, 2) that a simulated arm shows beside a motion [rad]."""
    moved = motion._replace(angle=motion.angle + aside)
    return run(arm, arm, moved, seed, estimator=None).reading[:, :, :2]


def _scatter(reading: Array, spans: Spans, dt: float,
             channels: Sequence[tuple[int, int]]) -> Array:
    """Return the logarithm of the power of what scatters (w, c), one row for a span."""
    columns, sides = np.array(channels).T
    fast = local_rest(reading[:, columns, sides], dt) ** 2
    rows = [fast[round(begin / dt):round(end / dt)] for begin, end in spans]
    return np.log(np.array([row.mean(axis=0) for row in rows if len(row)]) + 1e-30)


def _gains(cause: RawCause, measured: Measurement, simulated: Simulation, given: Arm,
           extended: Arm, spans: Spans) -> Gains:
    """Return how far the scatter of simulations is from the measured, and by chance alone."""
    place = cause.effect.name, cause.joint
    lacking = extended.without(*place).with_effect(given.effect(*place), cause.joint)
    shown, before, after, again = (
        _scatter(reading, spans, measured.dt, cause.channels) for reading in
        (measured.reading, simulated(lacking, 1), simulated(extended, 1),
         simulated(extended, 2, _ASIDE)))
    return Gains(*(np.mean((one - other) ** 2, axis=1) for one, other in
                   ((before, shown), (after, shown), (again, after))))

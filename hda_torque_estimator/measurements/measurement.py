"""A recording as the diagnosis sees it: both angles and the commanded torque on a time grid."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

from hda_arm_sim.foundation.arrays import Array
from hda_msgs_json.errors import HdaError
from hda_msgs_json.samples import JointSamples, WrenchSamples
from hda_msgs_json.topics import motor_name
import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from ..samples.readings import readings
from ..significance import FOURTH_DIFFERENCES

# Choices unless stated otherwise.
SEGMENT = 0.5           # of an estimate of noise [s]
QUIET = 0.25            # share of segments that an effect surely leaves quiet
FINEST = 1e-6           # period of a grid: no encoder is read more often [s]
_MOST_KNOWN = 0.5       # share of a recording over which a torque is known that is one
_SINGLE = 0.75          # share by which an interval of one period may differ from the usual one
_STEEPER = 4.0            # deviations by which a line is steeper than jitter makes it
_FIRST = 8              # half of the intervals in the first stretch that sets the period
EMPTIEST = 4.0          # places of a grid for each sample: beyond, most would be made up


class StampsError(HdaError):
    """Stamps from which no even grid can be made."""


@dataclass(frozen=True, eq=False)
class Measurement:
    """
    Evenly sampled readings of n joints.

    `reading` (k, n, 2) are the angles of shaft and link as the encoders show them [rad].
    `command` (k, n) the motor torque in force from a sample until the next [N*m, shaft]. Samples
    that never came, and were put in to keep the grid, are listed in `absent`. Those in which
    nobody knows how the arm moved are `blind`.

    `past` (k,) says by how much each was taken after its tick [s], as far as its stamp
    knows. It is empty if nothing is known. What lies between samples has that of the one before.

    A measurement may hold several recordings of an arm, one after another on one running clock;
    `begins` are their first samples. Of `parts` samples the first was recorded and the others were
    put between (`finer`).

    Links that are `led` move under forces that nobody knows: a hand, or loads without a model.
    A `reference` (k, n) is the torque of each gear as a sensor, or a model of others, has it [N*m
    at the output]. It is NaN where it is not known, and empty where nothing is known of any.
    Joints whose reference has a scale that nobody knows are `unscaled`.
    Whether commands were `held` is asked of readings once (`upsampling.is_held`), None until then.
    """

    labels: tuple[str, ...]
    dt: float
    reading: Array
    command: Array
    absent: tuple[int, ...] = ()
    begins: tuple[int, ...] = (0,)
    past: Array = field(default_factory=lambda: np.zeros(0))
    parts: int = 1
    led: bool = False
    held: bool | None = None
    reference: Array = field(default_factory=lambda: np.zeros((0, 0)))
    unscaled: tuple[str, ...] = ()
    blind: tuple[int, ...] = ()

    @cached_property
    def referenced(self) -> NDArray[np.bool_]:
        """Return of which joints a reference torque is known, for most of the recording (n,)."""
        if not self.reference.size:
            return np.zeros(len(self.labels), bool)
        return np.asarray(np.isfinite(self.reference).mean(axis=0) > _MOST_KNOWN)

    @property
    def unloaded(self) -> NDArray[np.bool_]:
        """Return of which joints nobody knows what loads them (n,)."""
        return self.led & ~self.referenced

    @property
    def held_against(self) -> NDArray[np.bool_]:
        """Return which joints are held against a reference torque in the place of links (n,)."""
        return self.led & self.referenced

    @property
    def thrice_witnessed(self) -> NDArray[np.bool_]:
        """Return of which joints links and a reference torque both say the load (n,)."""
        return ~np.bool_(self.led) & self.referenced

    @property
    def time(self) -> Array:
        """Return the times since the first sample (k,) [s]."""
        return self.dt * np.arange(len(self.command), dtype=np.float64)

    @property
    def duration(self) -> float:
        """Return the time from the first to the last sample [s]."""
        return self.dt * (len(self.command) - 1)

    @property
    def untold(self) -> float:
        """Return for how long after a recorded command nobody knows what acted [s], 0 if held."""
        return 0.0 if self.parts == 1 or self.held else self.parts * self.dt

    @property
    def put_in(self) -> NDArray[np.bool_]:
        """Return which samples never came (k,)."""
        return self._at(self.absent)

    @property
    def is_blind(self) -> NDArray[np.bool_]:
        """Return in which samples nobody knows how the arm moved (k,)."""
        return self._at(self.blind)

    def _at(self, places: Sequence[int]) -> NDArray[np.bool_]:
        """Return a mask (k,) of these samples."""
        mask = np.zeros(len(self.command), bool)
        mask[list(places)] = True
        return mask

    def rescaled(self, gains: Mapping[str, float]) -> 'Measurement':
        """Return references of some joints without these gains; their scales tell nothing then."""
        scale = np.array([1.0 + gains.get(label, 0.0) for label in self.labels])
        return replace(self, reference=self.reference / scale, unscaled=(*self.unscaled, *gains))

    def pieces(self) -> list[slice]:
        """Return the samples of each recording."""
        ends = (*self.begins[1:], len(self.command))
        return [slice(begin, end) for begin, end in zip(self.begins, ends)]

    def reading_noise(self) -> Array:
        """
        Return the white noise of readings (n, 2) in the quieter segments [rad].

        It is at least that of rounding to the smallest step that a reading ever made.
        """
        steps = np.abs(np.diff(self.reading[::self.parts], axis=0))
        rounding = np.where(steps > 0.0, steps, np.inf).min(axis=0) / np.sqrt(12.0)
        rounding = np.where(np.isfinite(rounding), rounding, 0.0)
        return np.maximum(self._white_noise(self.reading), np.maximum(rounding, 1e-13))

    def reference_noise(self) -> Array:
        """Return the white noise of reference torques (n,), 0 where there are none [N*m]."""
        noise = np.zeros(len(self.labels))
        for joint in np.flatnonzero(self.referenced):
            column = self.reference[:, joint]
            noise[joint] = self._white_noise(column[np.isfinite(column)])
        return noise

    def reference_spread(self) -> dict[str, float]:
        """Return how far each reference torque varies, by joint [N*m rms]."""
        return {self.labels[joint]: float(np.nanstd(self.reference[:, joint]))
                for joint in np.flatnonzero(self.referenced)}

    def command_noise(self) -> Array:
        """
        Return the white noise by which commands (n,) differ from what acted [N*m, shaft].

        Those that stand still between samples are what acted. Of a faster loop every so many
        commands were recorded. Each has the noise of its own time, and between them was other.
        """
        joints = self.command.shape[1]
        return self._white_noise(self.command) if self._moves_between else np.zeros(joints)

    @property
    def _moves_between(self) -> bool:
        """Return whether commands change between samples that were recorded."""
        still = np.repeat(self.command[::self.parts], self.parts, axis=0)[:len(self.command)]
        return bool((still != self.command).any())

    def _white_noise(self, values: Array) -> Array:
        """Return the white noise of what was recorded (k, ...), in the quieter segments."""
        fine = np.diff(values[::self.parts], 4, axis=0) / np.sqrt(FOURTH_DIFFERENCES)
        length = max(1, round(SEGMENT / (self.parts * self.dt)))
        segments = fine[:len(fine) // length * length].reshape(-1, length, *fine.shape[1:])
        return np.asarray(np.quantile(segments.std(axis=1), QUIET, axis=0))

    def recordings(self) -> list['Measurement']:
        """Return each recording on its own, its time from zero."""
        return [Measurement(self.labels, self.dt, self.reading[piece], self.command[piece],
                            _within(self.absent, piece), past=self.past[piece],
                            parts=self.parts, held=self.held,
                            reference=self.reference[piece], blind=_within(self.blind, piece))
                for piece in self.pieces()]

    def as_recorded(self) -> 'Measurement':
        """Return the samples that were recorded, without those between them."""
        if self.parts == 1:
            return self
        return Measurement(self.labels, self.parts * self.dt,
                           np.ascontiguousarray(self.reading[::self.parts]),
                           self.command[::self.parts], past=self.past[::self.parts],
                           begins=tuple(begin // self.parts for begin in self.begins),
                           held=self.held, reference=self.reference[::self.parts],
                           blind=tuple(sorted({place // self.parts for place in self.blind})))


def _within(places: Sequence[int], piece: slice) -> tuple[int, ...]:
    """Return those of some samples that are in one recording, counted from its first."""
    return tuple(place - piece.start for place in places if piece.start <= place < piece.stop)


def _running(places: Sequence[Sequence[int]], lengths: Sequence[int]) -> tuple[int, ...]:
    """Return samples of recordings, counted from the first of all."""
    begins = np.cumsum([0, *lengths[:-1]]).tolist()
    return tuple(begin + place for some, length, begin in zip(places, lengths, begins)
                 for place in some if place < length)


def without_gaps(column: Array) -> Array:
    """Return a column (k,) with lines over what is not known, 0 where nothing is."""
    known = np.flatnonzero(np.isfinite(column))
    if len(known) == 0:
        return np.zeros_like(column)
    return np.interp(np.arange(len(column)), known, column[known])


def joined(recordings: Sequence[Measurement], grain: int = 1) -> Measurement:
    """
    Return recordings of one arm and one rate as one measurement.

    If there are several, each is cut to a multiple of `grain` samples.
    """
    if len(recordings) == 1:
        return recordings[0]
    lengths = [len(one.command) // grain * grain for one in recordings]
    begins = np.cumsum([0, *lengths[:-1]]).tolist()
    return Measurement(
        recordings[0].labels, recordings[0].dt,
        np.concatenate([one.reading[:length] for one, length in zip(recordings, lengths)]),
        np.concatenate([one.command[:length] for one, length in zip(recordings, lengths)]),
        _running([one.absent for one in recordings], lengths), tuple(begins),
        _past(recordings, lengths), recordings[0].parts, held=_held(recordings),
        reference=_references(recordings, lengths),
        blind=_running([one.blind for one in recordings], lengths))


def _held(recordings: Sequence[Measurement]) -> bool | None:
    """Return what is known of the commands of all, None where they differ."""
    ways = {one.held for one in recordings}
    return ways.pop() if len(ways) == 1 else None


def _past(recordings: Sequence[Measurement], lengths: Sequence[int]) -> Array:
    """Return how far all are past their ticks, 0 where nothing is known; empty if nowhere."""
    if not any(len(one.past) for one in recordings):
        return np.zeros(0)
    return np.concatenate([one.past[:length] if len(one.past) else np.zeros(length)
                           for one, length in zip(recordings, lengths)])


def _references(recordings: Sequence[Measurement], lengths: Sequence[int]) -> Array:
    """Return the reference torques of all, NaN where a recording has none; empty if nowhere."""
    if not any(one.reference.size for one in recordings):
        return np.zeros((0, 0))
    return np.concatenate([one.reference[:length] if one.reference.size else
                           np.full((length, len(one.labels)), np.nan)
                           for one, length in zip(recordings, lengths)])


def resampled(measurement: Measurement, dt: float) -> Measurement:
    """
    Return a measurement with another period, as it is where less than a sample apart at the end.

    Angles go along splines; a command is the mean of those in force. Nothing is known any more
    about when each sample was taken.
    """
    count = len(measurement.command)
    if abs(dt / measurement.dt - 1.0) * count < 1.0:
        return replace(measurement, dt=dt)
    time = measurement.time
    grid = dt * np.arange(int(time[-1] / dt) + 1)
    asked = measurement.dt * np.arange(count + 1)
    whole = np.concatenate([np.zeros((1, measurement.command.shape[1])),
                            np.cumsum(measurement.command, axis=0)]) * measurement.dt
    edges = np.append(grid, grid[-1] + dt)
    given = np.stack([np.interp(edges, asked, column) for column in whole.T], axis=1)
    absent = {min(round(place * measurement.dt / dt), len(grid) - 1)
              for place in measurement.absent}
    return Measurement(measurement.labels, dt, CubicSpline(time, measurement.reading)(grid),
                       np.diff(given, axis=0) / dt, tuple(sorted(absent)),
                       reference=_interpolated(grid, time, measurement.reference))


def measurement_from(labels: tuple[str, ...], samples: JointSamples,
                     source: str = 'the recording',
                     references: Mapping[str, WrenchSamples] | None = None) -> Measurement:
    """
    Return the joint states on the even grid of their usual period.

    The `references` of some joints, torques about z, are interpolated between their own stamps
    and never beyond them.

    Stamps that jitter by less than half a period only show by how much a sample was past its tick.
    One so late that the next shares its tick belongs to the tick before, if that has none.
    Where samples are missing, angles are joined by straight lines and commands held. Raises
    StampsError, naming the source, for stamps that are on no such grid.
    """
    reading = readings(labels, samples)[:, :, :2]
    command = samples.select([motor_name(label) for label in labels]).effort
    keep = np.isfinite(reading).all(axis=(1, 2)) & np.isfinite(command).all(axis=1)
    latest = np.maximum.accumulate(samples.stamps)
    keep &= np.diff(latest, prepend=latest[:1] - 1) > 0
    reference = _referring(labels, samples.stamps[keep], references or {})
    stamps = samples.stamps[keep]
    _check_count(stamps, samples.stamps, source)
    since = (stamps - stamps[0]) * 1e-9
    dt = _period(since)
    _check_grid(since, dt, source)
    ticks = np.round(since / dt).astype(np.int64)
    order = np.arange(len(ticks))
    ticks = np.minimum.accumulate((ticks - order)[::-1])[::-1] + order  # stamps are never early
    ticks = np.maximum(ticks, order)
    past = since - dt * ticks
    if ticks[-1] == len(ticks) - 1:
        return Measurement(labels, dt, np.ascontiguousarray(reading[keep]), command[keep],
                           past=past, reference=reference)
    grid = np.arange(ticks[-1] + 1)
    flat = reading[keep].reshape(len(ticks), -1)
    full = np.stack([np.interp(grid, ticks, column) for column in flat.T], axis=1)
    held = np.searchsorted(ticks, grid, side='right') - 1
    absent = np.setdiff1d(grid, ticks)
    return Measurement(labels, dt, full.reshape(len(grid), *reading.shape[1:]),
                       command[keep][held], tuple(absent.tolist()),
                       past=np.interp(grid, ticks, past),
                       reference=_interpolated(grid, ticks, reference))


def _interpolated(grid: NDArray[np.floating[Any]], time: Array, reference: Array) -> Array:
    """Return reference torques (k, n) of some times at those of a grid; empty ones stay empty."""
    if not reference.size:
        return reference
    return np.stack([np.interp(grid, time, column) for column in reference.T], axis=1)


def _referring(labels: tuple[str, ...], stamps: NDArray[np.int64],
               references: Mapping[str, WrenchSamples]) -> Array:
    """Return the reference torques at some stamps (k, n), NaN where unknown; empty of none."""
    if not references:
        return np.zeros((0, 0))
    found = np.full((len(stamps), len(labels)), np.nan)
    for joint, label in enumerate(labels):
        known = references.get(label)
        if known is not None and len(known) > 1:
            found[:, joint] = np.interp(stamps, known.stamps, known.torque[:, 2], np.nan, np.nan)
    return found


def _check_count(kept: NDArray[np.int64], stamps: NDArray[np.int64], source: str) -> None:
    """Raise StampsError where there are no two samples, or most stamps are of another time."""
    growing = np.diff(np.maximum.accumulate(stamps), prepend=stamps[:1] - 1) > 0
    if len(stamps) > 1 and 2 * growing.sum() < len(stamps):
        raise StampsError(f'{source}: only {growing.sum()} of {len(stamps)} stamps are later than '
                          'all before them; record the time of each sample in its header')
    if len(kept) < 2:
        raise StampsError(f'{source} is too short: it has {len(kept)} samples of all angles and '
                          'motor torques')


def _check_grid(since: Array, dt: float, source: str) -> None:
    """Raise StampsError for a grid that no encoder is read at, or that is nearly empty."""
    if dt < FINEST:
        raise StampsError(f'{source}: its stamps are {dt:.3g} s apart, at least {FINEST:g} s is '
                          'right; record the time of each sample in its header [ns]')
    if since[-1] > EMPTIEST * dt * len(since):
        at = int(np.argmax(np.diff(since)))
        before, after = since[at:at + 2]
        raise StampsError(f'{source}: its {len(since)} samples of {dt:.3g} s are spread over '
                          f'{since[-1]:.4g} s; the stamps jump by {after - before:.4g} s after '
                          f'{before:.4g} s: cut the recording there')


def _period(since: Array) -> float:
    """
    Return the even period of stamps that jitter about it, some of them missing [s].

    The mean of usual intervals would be wrong by whole samples in the end. So it counts those in a
    stretch of twice the length each time, and lays a line through their stamps. That of a short
    stretch shows less than the mean: it counts where the two differ by more than jitter makes.
    """
    steps = np.diff(since)
    usual = np.median(steps)
    single = steps[np.abs(steps - usual) < _SINGLE * usual]
    period, jitter = float(np.mean(single)), float(np.std(single)) / np.sqrt(2.0)
    reach = min(_FIRST, len(steps))
    while reach < len(since) - 1:
        reach = min(2 * reach, len(since) - 1)
        stretch = since[:reach + 1]
        phase = np.angle(np.exp(2.0j * np.pi * stretch / period).mean()) / (2.0 * np.pi)
        counts = np.round(stretch / period - phase)
        away = counts - counts.mean()
        slope = float(away @ stretch) / max(float(away @ away), 1.0)
        if slope > 0.0 and abs(slope - period) > _STEEPER * jitter / np.sqrt(away @ away):
            period = slope                  # not that of stamps that come in one burst
    return float(since[-1]) / max(round(float(since[-1]) / period), 1)

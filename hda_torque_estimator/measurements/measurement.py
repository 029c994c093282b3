"""A recording as the diagnosis sees it: both angles and the commanded torque on a time grid."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

from hda_arm_sim.foundation.arrays import Array
import numpy as np
from numpy.typing import NDArray

from ..significance import FOURTH_DIFFERENCES

# Choices unless stated otherwise.
SEGMENT = 0.5           # of an estimate of noise [s]
QUIET = 0.25            # share of segments that an effect surely leaves quiet
_MOST_KNOWN = 0.5       # share of a recording over which a torque is known that is one


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
        return self.thinned(self.parts, self.command[::self.parts])

    def thinned(self, part: int, command: Array) -> 'Measurement':
        """Return every so many samples, with these commands (k / part, n) in force from each."""
        if part == 1:
            return self
        return replace(self, dt=part * self.dt, parts=1, absent=(), command=command,
                       reading=np.ascontiguousarray(self.reading[::part]),
                       past=self.past[::part], reference=self.reference[::part],
                       begins=tuple(begin // part for begin in self.begins),
                       blind=tuple(sorted({place // part for place in self.blind})))


def _within(places: Sequence[int], piece: slice) -> tuple[int, ...]:
    """Return those of some samples that are in one recording, counted from its first."""
    return tuple(place - piece.start for place in places if piece.start <= place < piece.stop)


def without_gaps(column: Array) -> Array:
    """Return a column (k,) with lines over what is not known, 0 where nothing is."""
    known = np.flatnonzero(np.isfinite(column))
    if len(known) == 0:
        return np.zeros_like(column)
    return np.interp(np.arange(len(column)), known, column[known])

"""
Estimate joint torques and the tip force from the encoders, live or over a whole recording.

Both ways accept and refuse the same samples and run the same compiled step. So a recording gives
the same bits as the live run it was made from.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from itertools import pairwise
from typing import ClassVar

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.parameter import Declared, parameter
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.arm_arrays import plain
from hda_arm_sim.model.chain_links import ChainLinks
from hda_arm_sim.model.effects.catalogue import effects_at
from hda_arm_sim.model.effects.place import LOAD
from hda_arm_sim.model.link_numbers import LinkTolerance
from hda_arm_sim.model.link_side import loaded_inertia
import numpy as np
from numpy.typing import NDArray

from .estimates import Estimates, tip_results
from .laws import belief, estimate, fusion_memory, layout
from .laws.compiled_settings import CompiledSettings
from .laws.contact import contact_level
from .laws.stream import Remembered, run, Stream, StreamArrays
from ..samples.sample_judge import WATCH_MEMORY
from ..samples.sample_limits import LARGEST, watch_limits
from ..samples.stamp_order import follow, follow_one, ORDER

# Choices unless stated otherwise.
PART = 1 << 15          # samples of a part: small enough for a cache, large enough to pay
FARTHEST = 1e4          # angle of a link that may be turned (choice) [rad]


class Refusal(Enum):
    """Why a sample is not used."""

    NONE = 'accepted'
    NOT_FINITE = 'an angle is NaN or infinite'
    NOT_LATER = 'its stamp is not later than that of the sample before'


_REFUSALS = (Refusal.NONE, Refusal.NOT_FINITE, Refusal.NOT_LATER)


@dataclass(frozen=True)
class EstimatorSettings(Declared):
    """What a user may tune; nothing here is a property of the arm."""

    name: ClassVar[str] = 'estimator'
    velocity_bandwidth: float = parameter(
        40.0, 'Hz', 0.1, 1e4, 'low-pass of the velocities')
    torsion_bandwidth: float = parameter(
        80.0, 'Hz', 0.1, 1e4, 'low-pass of the rate of the torsion, for damping and lateness')
    observer_bandwidth: float = parameter(
        20.0, 'Hz', 0.01, 1e3, 'momentum observer of the external torque')
    singular_sine: float = parameter(
        0.1, '', 1e-6, 1.0, '|sin(theta2)| below which the axial tip force is not observed')
    longest_gap: float = parameter(
        0.1, 's', 1e-4, 10.0, 'time between samples after which filters start afresh')
    contact_deviations: float = parameter(
        4.0, '', 1.0, 1e3, 'external torque over its deviation that is a contact')
    collision_torque: float = parameter(
        2.0, 'N*m', 0.0, 1e4, 'external torque of a contact that stays until the reset')
    tare_time: float = parameter(
        0.5, 's', 0.0, 60.0, 'time over which a tare takes the mean torsion')
    fusion: float = parameter(
        1.0, '', 0.0, 1.0, '1: torsion and motor torque correct each other, 0: torsion alone')
    fusion_window: float = parameter(
        0.01, 's', 1e-3, 1.0, 'half the time over which both torques are compared')
    fusion_memory: float = parameter(
        600.0, 's', 1.0, 1e6, 'time after which what the comparison taught has faded')
    fusion_zero_follows: float = parameter(
        0.0, 's', 0.0, 1e6, 'time in which the zero may wander by its tolerance, 0 for never')


class Estimator:
    """The estimator with its memory; `update` takes samples one by one, `run` many at once."""

    def __init__(self, arm: Arm, settings: EstimatorSettings = EstimatorSettings()) -> None:
        """Prepare for an arm; without links only the torsion's results will be numbers."""
        joints = len(arm.joints)
        self.arm, self.settings = arm, settings
        self._result = np.zeros((1, joints, layout.RESULTS))
        self._tips = np.full((1, tip_results(arm)), np.nan)
        self._unknown = np.full((1, joints), np.nan)
        self.joints, self.tip = self._result[0], self._tips[0]
        self._record = arm.record()
        self._plain = plain(self._record)
        self._inertia = loaded_inertia(self._record.body)
        self.tune(settings)
        self._memory = np.zeros((joints, layout.MEMORY))
        self._limits = watch_limits(arm)
        self._limits[:, LARGEST] = np.maximum(self._limits[:, LARGEST], FARTHEST)
        self._watch = np.zeros((joints, WATCH_MEMORY))
        self._belief = np.zeros((joints, belief.MEMORY))
        self._order, self._seconds = np.zeros(ORDER, np.int64), np.zeros(1)
        self._tare_left = 0.0
        self._tared = 0

    def tune(self, settings: EstimatorSettings) -> None:
        """Use other settings from the next sample on; filters and zero stay as they are."""
        self.settings = settings
        self._settings = compiled_settings(self.arm, settings)
        self._numbers = np.array([*self._settings[:-1], *self._settings.links_known.ravel()])

    def reset(self) -> None:
        """Forget every sample, filter and tare."""
        for memory in (self._memory, self._watch, self._belief, self._order):
            memory[:] = 0
        self._tare_left, self._tared = 0.0, 0

    def tare(self) -> None:
        """Take the mean torsion of the coming `tare_time` for that of an arm without contact."""
        self._memory[:, layout.TARE_SUM] = 0.0
        self._tare_left, self._tared = max(self.settings.tare_time, 1e-9), 0

    @property
    def taring(self) -> bool:
        """Return whether a tare is under way."""
        return self._tare_left > 0.0

    @property
    def memory(self) -> Array:
        """Return what was learnt and filtered so far (n, MEMORY), to be read only."""
        view = self._memory.view()
        view.flags.writeable = False
        return view

    @property
    def zero(self) -> Array:
        """Return what a tare took for no torsion, by joint [rad]."""
        return self._memory[:, layout.ZERO].copy()

    def update(self, stamp: int, reading: Array, command: Array | None = None) -> Refusal:
        """
        Estimate from one sample (n, READINGS) with its stamp [ns]; fills `joints` and `tip`.

        `command` (n,) is the motor torque in force from this sample on [N*m at the shaft]; without
        it the torsion stands alone. A refused sample changes nothing.
        """
        place, dt = follow_one(self._order, stamp, estimate.usable(reading),
                               self.settings.longest_gap)
        refusal = _REFUSALS[place]
        if refusal is Refusal.NONE:
            self._seconds[0] = dt
            self._step(np.ascontiguousarray(reading)[np.newaxis],
                       self._unknown if command is None else command[np.newaxis], self._seconds,
                       self._result, self._tips)
            if self._tare_left > 0.0 and self.believed:
                self._add_to_tare()
                self._tare_left -= min(max(dt, 0.0), self.settings.longest_gap)
                if self._tare_left <= 1e-12:
                    self._end_tare()
        return refusal

    @property
    def believed(self) -> bool:
        """Return whether the last sample could be estimated from."""
        return bool(np.isfinite(self.joints[:, layout.TORQUE]).all())

    @property
    def unbelieved(self) -> int:
        """Return how many samples no arm can have shown, since the last reset or gap."""
        return int(self._belief[0, belief.UNBELIEVED])

    def run(self, stamps: NDArray[np.int64], reading: Array,
            command: Array | None = None) -> Estimates:
        """
        Estimate a recording: stamps (k,) ns, reading (k, n, READINGS); goes on from before.

        `command` (k, n) is the motor torque in force from each sample on [N*m at the shaft].
        """
        whole, parts = self.in_parts(stamps, reading, command)
        for _ in parts:
            pass
        return whole

    def in_parts(self, stamps: NDArray[np.int64], reading: Array, command: Array | None = None,
                 size: int = PART,
                 tare: tuple[int, int] = (0, 0)) -> tuple[Estimates, Iterator[Estimates]]:
        """
        Return the estimates of a recording, which are there when all of the parts were drawn.

        The parts, of `size` samples, are views of them in order. Arguments are those of `run`.
        The mean torsion between both stamps of `tare` [ns], the second excluded, becomes zero
        there, as if `tare` had been called at the first. Stamps must rise for that.
        """
        refusals, seconds = self._follow(stamps, reading)
        used = refusals == 0
        given = np.full(reading.shape[:2], np.nan) if command is None else command
        count = int(used.sum())
        whole = Estimates(stamps[used], np.empty((count, len(self.arm.joints), layout.RESULTS)),
                          np.empty((count, tip_results(self.arm))), np.flatnonzero(~used))
        tared = range(*np.searchsorted(whole.stamps, tare).tolist())
        return whole, self._parts(whole, np.ascontiguousarray(reading[used]),
                                  np.ascontiguousarray(given[used]), seconds[used], size, tared)

    def _parts(self, whole: Estimates, reading: Array, command: Array, seconds: Array,
               size: int, tare: range) -> Iterator[Estimates]:
        """Fill estimates part by part, and yield each part."""
        for rows in _pieces(len(whole.stamps), size, tare):
            taring = rows.start in tare
            part = Estimates(whole.stamps[rows], whole.joints[rows], whole.tip[rows],
                             np.empty(0, np.intp), taring and rows.stop < tare.stop)
            if rows.start == tare.start and taring:
                self.tare()
            for each in _one_by_one(rows) if taring else (rows,):
                self._step(reading[each], command[each], seconds[each], whole.joints[each],
                           whole.tip[each])
                if taring and np.isfinite(whole.joints[each, :, layout.TORQUE]).all():
                    self._add_to_tare()
            if rows.stop == tare.stop and taring:
                self._end_tare()
            yield part

    def _follow(self, stamps: NDArray[np.int64],
                reading: Array) -> tuple[NDArray[np.int64], Array]:
        """Return refusals (k,), as places in `_REFUSALS`, and times since the last samples."""
        refusals, seconds = np.empty(len(stamps), np.int64), np.empty(len(stamps))
        finite = np.all(np.isfinite(reading[:, :, :2]), axis=(1, 2))
        follow(self._order, stamps, finite, self.settings.longest_gap, refusals, seconds)
        return refusals, seconds

    def _step(self, reading: Array, command: Array, seconds: Array, joints: Array,
              tip: Array) -> None:
        run(StreamArrays(*self._plain, self._numbers),
            Remembered(self._limits, self._watch, self._belief, self._memory),
            Stream(reading, command, seconds), joints, tip)

    def _add_to_tare(self) -> None:
        estimate.add_to_tare(self._record, self._settings, self._inertia, self._memory)
        self._tared += 1

    def _end_tare(self) -> None:
        """Take the mean of what was added for zero; without anything the zero stays."""
        if self._tared:
            self._memory[:, layout.ZERO] += self._memory[:, layout.TARE_SUM] / self._tared
            self._memory[:, layout.FUSION + fusion_memory.SLIPPED] = 0.0
        self._tare_left = 0.0


def _pieces(count: int, size: int, tare: range) -> Iterator[slice]:
    """Yield the parts of a recording in order; a tare and its last sample are parts of theirs."""
    cuts = {*range(0, count, size), count}
    if tare:
        cuts |= {tare.start, tare.stop - 1, tare.stop}
    for begin, end in pairwise(sorted(cuts)):
        yield slice(begin, end)


def _one_by_one(rows: slice) -> Iterator[slice]:
    for row in range(rows.start, rows.stop):
        yield slice(row, row + 1)


def compiled_settings(arm: Arm, settings: EstimatorSettings) -> CompiledSettings:
    """Return what the compiled step reads of the settings and of the arm's links."""
    return CompiledSettings(
        settings.velocity_bandwidth, settings.observer_bandwidth, settings.singular_sine,
        links_tolerance(arm), float(arm.links is not None), settings.torsion_bandwidth,
        settings.fusion, settings.fusion_window, settings.fusion_memory,
        settings.fusion_zero_follows, contact_level(settings.contact_deviations, len(arm.joints)),
        settings.collision_torque, links_known(arm))


def links_known(arm: Arm) -> Array:
    """Return how well mass, centre [m] and inertia of each link are known (n, 3), of a chain."""
    if not isinstance(arm.links, ChainLinks):
        return np.zeros((len(arm.joints), 3))
    known = np.array([one.values() for one in arm.links.known(arm.tolerances.link_inertia)])
    shares = [place for place, rule in enumerate(LinkTolerance.declarations()) if not rule.unit]
    known[-1, shares] = np.maximum(known[-1, shares], carried_tolerance(arm))
    return known


def links_tolerance(arm: Arm) -> float:
    """Return how well the inertia of links in a plane is known with what they carry."""
    return max(arm.tolerances.link_inertia, carried_tolerance(arm))


def carried_tolerance(arm: Arm) -> float:
    """Return how well what an arm is stated to carry is known, 0 where it carries nothing."""
    return max((getattr(arm.tolerances, kind.tolerance[1]) for kind in effects_at(LOAD)
                if kind.tolerance and getattr(arm.effect(kind.name), kind.tolerance[0])),
               default=0.0)

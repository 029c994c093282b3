"""
The balances of an arm along a motion: the kernel read backwards (eq:balance-a, balance-b).

The kernel says how the arm would accelerate in the measured state under the recorded command.
What the measurement did instead, as a torque, is the residual. Because it is the simulator's own
equation of motion, every effect of the catalogue acts here as it acts there.

    A, motor:    N J (ddtheta_m - predicted) + B,  the motor balance closed over the link
    B, torsion:  M (ddq - predicted),              the torsion against the link

Where something unknown leads the links, A is closed over the torsion alone (eq:balance-led),
and nothing is said of B:

    A, motor:    N J (ddtheta_m - predicted)

Where a sensor has the torque of such a gear, it stands for what the link needs
(eq:balance-reference):

    A, motor:    N J (ddtheta_m - predicted) + B
    B, torsion:  reference - torsion torque

Where links and a sensor both say the load, the sensor is a third witness. It is held against the
torsion, and what of that is noise in B as well is taken out (eq:balance-third):

    C, sensor:   reference - torsion torque - shared B

Torques at the output side; what is hardly smoothed in them passes one filter with all else. A
wrong friction shows in A alone, a wrong torsion in B and C, a wrong load in A and B alike. What a
sensor has wrong shows in C alone.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d

from .base_motion import gives_way
from .bearings import bearings_act
from .channels import of_sides
from .low_pass import LowPass
from .more_noise import KnownNoise, less_known_commands, noisier_readings, TorqueResponse
from .parts import Parts
from .recent_cache import RecentCache
from .sensed_motion import sensing
from .whitening import MOTION, Whitening, whitening_of
from .whole_runs import is_whole, remembered, run_whole
from ...measurements.measurement import Measurement
from ...measurements.motion import jolts, LINK, MeasuredMotion, MOTOR
from ...measurements.upsampling import is_held

# Numerics; choices unless stated otherwise.
BANDWIDTH = 40.0        # of the balances [Hz]
RATE = 125.0            # at which balances are kept [Hz]
_ENOUGH = 500.0         # samples that show what a change of the arm changes in them [1/s]
_KEPT = 3               # runs of whole arms, where balances hold, predictions, and noises
_MARGIN = 12            # samples beyond the filter's reach, for the polynomials
_STOP = 0.006           # for which a shaft that turns round is slow [s]
_SLOW = 0.3             # shaft speed below which dry friction is not known [rad/s]


@dataclass(frozen=True, eq=False)
class Balance:
    """Residuals over time, columns A1, A2, B1, B2 (m, c), C1, C2 if any [N*m at the output]."""

    residual: Array
    valid: NDArray[np.bool_]        # (m, c): away from ends, jolts, and for A standstill


class Shape(NamedTuple):
    """What something without a name may do in one balance."""

    channel: int
    values: Array                   # (m,) at the balances' times, before any whitening
    held: NDArray[np.bool_]         # (m,) where the balance is valid


class NearRest(NamedTuple):
    """Joints of which more, or less, is known of dry friction near rest than of others."""

    turning: tuple[int, ...] = ()   # motors that do not stop where they turn round
    borne: tuple[int, ...] = ()     # links on bearings that have friction


class Balancer:
    """The balances of one measurement, for one arm after another."""

    def __init__(self, measurement: Measurement, near_rest: NearRest = NearRest(),
                 unknown: NDArray[np.bool_] | None = None,
                 whitening: Whitening | None = None, parts: Parts | None = None,
                 aside: Sequence[Shape] = (), noise: KnownNoise = KnownNoise()) -> None:
        """
        Prepare filters, and use what is known of `parts` of the same measurement.

        Motor balances are valid `near_rest` where shafts turn round without a stop, those of links
        not where bearings may hold them. Motor balances are not valid where the torque of the
        motor is `unknown` (m, n). Balances may pass a `whitening` filter, and what they have along
        the shapes `aside` is taken out of them. What a third balance has in common with the
        second by `noise` is taken out of it.
        """
        self.measurement, self.near_rest, self.unknown = measurement, near_rest, unknown
        self.whitening, self.aside = whitening, tuple(aside)
        self.shared = np.zeros(len(measurement.labels)) if noise.shared is None else noise.shared
        self.noise = noise
        self.every = max(1, round(1.0 / (RATE * measurement.dt)))
        self.time = measurement.time[::self.every]
        self.filtered = LowPass(measurement, BANDWIDTH, self.every)
        self._reach = self.filtered.reach + _MARGIN
        self._parts = parts or Parts(measurement, self.filtered)
        self._runs, self._valid = RecentCache[Array](_KEPT), RecentCache[NDArray[np.bool_]](_KEPT)
        self.predictions = RecentCache[Array](_KEPT)  # how far off those of arms end (`predict`)
        self.noises = RecentCache[tuple[Array, Array]](_KEPT)     # of arms (`healthy_twin`)

    def knowing(self, of_torques: TorqueResponse | None) -> 'Balancer':
        """Return these balances, with what noise of torques makes of the recording."""
        return self.but(noise=self.noise._replace(of_torques=of_torques))

    def like(self, measurement: Measurement) -> 'Balancer':
        """Return the balances of another measurement along the same motion."""
        return self.but(measurement=measurement, parts=None)

    def beside(self, shapes: Sequence[Shape]) -> 'Balancer':
        """Return balances without what they have along these shapes (eq:beside)."""
        return self.but(aside=shapes)

    def but(self, **other: Any) -> 'Balancer':
        """Return these balances with something of what they are made of in another way."""
        own = {'measurement': self.measurement, 'near_rest': self.near_rest,
               'unknown': self.unknown, 'whitening': self.whitening, 'parts': self._parts,
               'aside': self.aside, 'noise': self.noise}
        return Balancer(**{**own, **other})

    def apart(self, arm: Arm) -> 'Balancer':
        """
        Return balances whose third has no noise of readings that the second has as well.

        Where arms move, torsion and links have it from one encoder. A coarse one blurs the
        torsion, and then the sensor is held against the links, which are known better.
        """
        if not self.measurement.thrice_witnessed.any():
            return self
        joints, noise = len(arm.joints), self._noise_made(arm)
        slow = np.fft.rfft(noise, axis=0)[np.fft.rfftfreq(len(noise), 1.0 / RATE) < MOTION]
        second, third = slow[:, joints:2 * joints], slow[:, 2 * joints:]
        shared = (second.conj() * third).real.sum(axis=0) / np.maximum(
            (np.abs(second) ** 2).sum(axis=0), 1e-300)
        return self.but(noise=self.noise._replace(shared=self.shared + shared))

    @property
    def unwhitened(self) -> 'Balancer':
        """Return the balances as they are, with all of their noise at all frequencies."""
        return self if self.whitening is None else self._unwhitened     # never holds itself

    @cached_property
    def _unwhitened(self) -> 'Balancer':
        return self.but(whitening=None)

    def whitened(self, arm: Arm, white: Array) -> 'Balancer':
        """
        Return balances whose noise is as loud at all frequencies.

        It is what readings make, and beside it `white` noise of these deviations (c,) [N*m].
        """
        whitening = whitening_of(self._noise_made(arm), white ** 2 / BANDWIDTH, RATE, BANDWIDTH)
        return self if whitening is None else self.but(whitening=whitening)

    def _noise_made(self, arm: Arm) -> Array:
        """Return what as much noise of the readings again makes of the balances (m, c) [N*m]."""
        plain = self(arm)
        return np.where(plain.valid, self.noisier(arm).residual - plain.residual, 0.0)

    def motion(self, arm: Arm) -> MeasuredMotion:
        """Return the motion behind the measurement if the arm senses as `arm` does."""
        return self._parts.motions.of(arm)

    def __call__(self, arm: Arm) -> Balance:
        """Return the balances of an arm."""
        turning, borne = self.near_rest
        known = sensing(arm, range(len(arm.joints)), [MOTOR, LINK] if borne else [MOTOR])
        return Balance(self._in_balances(self._filtered_residual(arm)), self._valid.of(
            known, lambda: self.valid_if_turning(arm, turning)))

    def change(self, arm: Arm, other: Arm) -> Array:
        """Return what the residual (m, c) of an arm has more than that of another [N*m]."""
        return self._in_balances(self._filtered_residual(arm) - self._filtered_residual(other))

    def run_ahead(self, arm: Arm, others: Sequence[Arm]) -> None:
        """Prepare for others that differ from an arm by a link each: they share their motion."""
        if not is_whole(arm):
            self._parts.run_ahead(arm, others)

    def whole(self, arm: Arm) -> Array:
        """Return the residual (m, c) of a run of the whole arm, not of parts [N*m]."""
        return self._in_balances(self._of_run(arm, self._filtered_run(arm)))

    def _filtered_run(self, arm: Arm) -> Array:
        return self.filtered(run_whole(self.measurement, self._parts, arm)[0])

    def _of_run(self, arm: Arm, run: Array) -> Array:
        """Return the residual (m, c) of a run (m, 2 n) with what sensors witness beside it."""
        if self.measurement.held_against.any():
            return self._against_sensors(run[:, :len(arm.joints)], arm)
        return self._with_third(run, arm)

    def _against_sensors(self, motor: Array, arm: Arm) -> Array:
        """
        Return residuals (m, 2 n) with what motors miss (m, n), some gears behind sensors.

        Those of motors are as if their drives gave what they were asked for (eq:in-commands).
        """
        sensor = self._sensor(arm)
        motor = (motor + self.measurement.held_against * sensor) / self._parts.drive_gains(arm)
        return np.concatenate([motor, sensor], axis=1)

    def _sensor(self, arm: Arm) -> Array:
        """Return what sensors behind gears show beyond the torque by torsion (m, n) [N*m]."""
        return self._parts.sensed(arm) - self._parts.through(arm)

    def _with_third(self, two: Array, arm: Arm) -> Array:
        """Return residuals (m, 2 n) with those of sensors beside links (eq:balance-third)."""
        witnessed = self.measurement.thrice_witnessed
        if not witnessed.any():
            return two
        third = self._sensor(arm) - self.shared * two[:, len(arm.joints):]
        return np.concatenate([two, witnessed * third], axis=1)

    def _filtered_residual(self, arm: Arm) -> Array:
        """Return the filtered residual (m, c), whose noise may not be white."""
        if is_whole(arm):
            record = arm.record()
            return self._of_run(arm, self._runs.of(
                record.joints.tobytes() + record.body.tobytes(), lambda: self._filtered_run(arm)))
        if self.measurement.held_against.any():
            return self._against_sensors(self._parts.missed(arm), arm)
        motor, link = self._parts.missed(arm), self._parts.needed(arm) - self._parts.carried(arm)
        if bearings_act(arm):
            link = link + self._parts.borne(arm)
        if gives_way(arm):
            link = link + self._parts.swung(arm)
        if not self.measurement.led:
            motor = motor + link
        return self._with_third(np.concatenate([motor, link], axis=1), arm)

    def gear_torques(self, arm: Arm) -> tuple[Array, Array]:
        """Return what gears carry, and what links or sensors ask of them (m, n) [N*m]."""
        asked = self._parts.sensed if self.measurement.led else self._parts.needed
        return self._parts.through(arm), asked(arm)

    @property
    def of_link_torque(self) -> Array:
        """Return how much each balance (c,) has of a torque that a link needs."""
        both = np.ones_like(self.shared)
        return of_sides(self.measurement, both, both, -self.shared)

    @cached_property
    def _jolted(self) -> NDArray[np.bool_]:
        """Return where a jolt, or a motion that nobody knows, is in the filter's reach (k,)."""
        return np.concatenate([_spread(jolts(one) | one.is_blind, self._reach)
                               for one in self.measurement.recordings()])

    @cached_property
    def _sensed(self) -> NDArray[np.bool_]:
        """Return where the filter has seen all that it needs of reference torques (k, n)."""
        lacking = ~np.isfinite(self.measurement.reference) & self.measurement.referenced
        return ~np.stack([_spread(column, self._reach) for column in lacking.T], axis=1)

    @cached_property
    def is_commanded(self) -> bool:
        """Return whether all commands were recorded: by a loop of the recording's own rate."""
        return self.unknown is None and is_held(self.measurement.as_recorded())

    @property
    def thinned(self) -> 'Balancer':
        """Return balances at the same times from fewer samples, to find changes of the arm."""
        return self if self._part == 1 else self._thinned

    @cached_property
    def _part(self) -> int:
        """Return of how many samples one is enough to find changes of the arm."""
        return max((part for part in range(1, self.every + 1)
                    if self.every % part == 0 and self.measurement.dt * part * _ENOUGH < 1.01),
                   default=1)

    @cached_property
    def _thinned(self) -> 'Balancer':
        made, part = self.measurement, self._part
        padded = np.concatenate([made.command, np.repeat(made.command[-1:], part, axis=0)])
        command = np.mean([padded[k:k + len(made.command):part] for k in range(part)], axis=0)
        thin = replace(made.thinned(part, command), past=np.zeros(0))
        return self.like(thin).knowing(None)

    @cached_property
    def noisier(self) -> 'Balancer':
        """Return balances of the same readings with about as much noise again."""
        return self.like(noisier_readings(self.measurement))

    @cached_property
    def noisier_each(self) -> tuple['Balancer', ...]:
        """Return `noisier`, and balances beside commands that a log has not all kept likewise."""
        unkept = less_known_commands(self.measurement)
        return (self.noisier,) if unkept is None else (self.noisier, self.like(unkept))

    @cached_property
    def beside_torque_noise(self) -> 'Balancer | None':
        """Return balances of a motion that noise of torques moved as much again, if it does."""
        added = self.noise.of_torques
        return None if added is None else self.like(added.added_to(self.measurement))

    def memory(self, arm: Arm) -> Array:
        """Return what the arm's effects remember along the motion (k, n, STATES - MEASURED)."""
        return remembered(self.measurement, self._parts, arm)

    def _in_balances(self, values: Array) -> Array:
        """Return filtered columns (m, c), one for each balance, as the balances have them."""
        if self.whitening is None and not self.aside:
            return values
        return np.concatenate([
            self.in_balance(column, channel) if column.any() else column
            for channel, column in enumerate(np.split(values, values.shape[1], axis=1))], axis=1)

    def in_balance(self, values: Array, channel: int) -> Array:
        """Return columns (m, k) at the balances' times as one of the balances has them."""
        values = self._white(values, channel)
        basis = self._bases.get(channel)
        return values if basis is None else values - basis @ (basis.T @ values)

    @cached_property
    def _bases(self) -> dict[int, Array]:
        """Return an orthonormal basis (m, q) of what is taken aside, by channel."""
        channels = {shape.channel for shape in self.aside}
        made = {channel: [np.where(shape.held, self._white(shape.values[:, None], channel)[:, 0],
                                   0.0) for shape in self.aside if shape.channel == channel]
                for channel in channels}
        return {channel: np.linalg.qr(np.stack(columns, axis=1))[0]
                for channel, columns in made.items()}

    def _white(self, values: Array, channel: int) -> Array:
        """Return columns (m, k) as the whitening of a balance has them."""
        if self.whitening is None:
            return values
        ends = np.cumsum([-(-(piece.stop - piece.start) // self.every)
                          for piece in self.measurement.pieces()])
        return np.concatenate([self.whitening.of(part, channel)
                               for part in np.split(values, ends[:-1])])

    def valid_if_turning(self, arm: Arm, joints: Sequence[int]) -> NDArray[np.bool_]:
        """
        Return where the balances of an arm hold if these joints are turning (m, c).

        Their filter has seen no end, no jolt and no motion that nobody knows. Those of motors have
        seen no standstill either, nor have those of links on bearings with friction.
        """
        reach = self._reach
        smooth = np.zeros(len(self._jolted), bool)
        for piece in self.measurement.pieces():
            whole = slice(piece.start + reach, piece.stop - reach)
            smooth[whole] = ~self._jolted[whole]
        slow = np.stack([self._slow(arm, joint, MOTOR) for joint in range(len(arm.joints))], 1)
        for joint in joints:
            slow[:, joint] = _lasting(slow[:, joint], round(_STOP / self.measurement.dt))
        near = np.zeros((len(slow), 2 * slow.shape[1]), bool)
        near[:, :slow.shape[1]] = np.stack([_spread(column, reach) for column in slow.T], axis=1)
        for joint in self.near_rest.borne:
            near[:, slow.shape[1] + joint] = _spread(self._slow(arm, joint, LINK), reach)
        valid = (smooth[:, None] & ~near)[::self.every]
        if self.unknown is not None:
            valid[:, :slow.shape[1]] &= ~self.unknown
        valid[:, slow.shape[1]:] &= ~self.measurement.unloaded
        if self.measurement.held_against.any():
            valid &= np.tile(self._sensed[::self.every], 2)
        if self.measurement.thrice_witnessed.any():
            valid = np.concatenate([valid, smooth[::self.every, None] & self._sensed[
                ::self.every] & self.measurement.thrice_witnessed], axis=1)
        return valid if self.whitening is None else self.whitening.holds(valid)

    def _slow(self, arm: Arm, joint: int, side: int) -> NDArray[np.bool_]:
        """Return where dry friction of the motor or link side of a joint is not known (k,)."""
        velocity = self._parts.motions.course(arm, joint, side).velocity
        ratio = 1.0 if side == MOTOR else arm.joints[joint].ratio
        slow = np.abs(velocity) * ratio < _SLOW
        slow[1:] |= velocity[1:] * velocity[:-1] < 0.0      # it may turn round within a sample
        return slow


def _spread(marked: NDArray[np.bool_], reach: int) -> NDArray[np.bool_]:
    """Return what is within `reach` samples of what is marked (k,)."""
    return np.asarray(maximum_filter1d(marked, 2 * reach + 1, mode='constant'))


def _lasting(marked: NDArray[np.bool_], least: int) -> NDArray[np.bool_]:
    """Return what is marked for longer than `least` samples (k,)."""
    return ~_spread(~marked, least // 2) if least > 1 else marked

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

Torques at the output side; what is hardly smoothed in them passes one filter with all else. A
wrong friction shows in A alone, a wrong torsion in B alone, a wrong load in both alike.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.chain_links import ChainLinks
from hda_arm_sim.model.effects.catalogue import effects_at
from hda_arm_sim.model.effects.place import CLOCK, LINK_READING, MOTOR_READING
from hda_arm_sim.model.kernel import MOTOR_VELOCITY, STATES
from hda_arm_sim.model.link_side import loaded_inertia
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d
from scipy.signal import firwin, upfirdn

from .base_motion import base_motion
from .kernel_along import centred, deliver, Driven, fill_along, fill_gears, MEASURED
from .needed_torques import fill_needed
from .whitening import Whitening, whitening_of
from ...measurements.measurement import Measurement
from ...measurements.motion import jolts, Motion, motion_of, SHORT
from ...measurements.running_clock import arm_during
from ...measurements.upsampling import between, is_held

# Choices unless told otherwise.
BANDWIDTH = 40.0        # of the balances [Hz]
RATE = 125.0            # at which balances are kept [Hz]
_ENOUGH = 500.0         # samples that tell what a change of the arm changes in them [1/s]
_KEPT = 8              # motions, for arms that sense differently
_MARGIN = 12            # samples beyond the filter's reach, for the polynomials
_STOP = 0.006           # for which a shaft that turns round is slow [s]
_SLOW = 0.3             # shaft speed below which dry friction is not known [rad/s]
_SENSED = ('motor_encoder', 'link_encoder', *(
    effect.name for place in (MOTOR_READING, LINK_READING, CLOCK) for effect in effects_at(place)))


@dataclass(frozen=True, eq=False)
class Balance:
    """Residuals over time, columns A1, A2, B1, B2 (m, 2 n) [N*m at the output]."""

    residual: Array
    valid: NDArray[np.bool_]        # (m, 2 n): away from ends, jolts, and for A standstill


class Balancer:
    """The balances of one measurement, for one arm after another."""

    def __init__(self, measurement: Measurement, turning: Sequence[int] = (),
                 unknown: NDArray[np.bool_] | None = None,
                 whitening: Whitening | None = None) -> None:
        """
        Prepare filters; the motion is found anew only when an arm's sensing differs.

        Joints that are `turning` are valid where they turn round without a stop. Motor balances
        are not valid where the torque of the motor is `unknown` (m, n). Balances may pass a
        `whitening` filter.
        """
        self.measurement, self.turning, self.unknown = measurement, tuple(turning), unknown
        self.whitening = whitening
        self.every = max(1, round(1.0 / (RATE * measurement.dt)))
        self.time = measurement.time[::self.every]
        half = 4 * max(1, round(0.25 / (BANDWIDTH * measurement.dt) / 4.0) * 4)
        self._low_pass = firwin(2 * half + 1, BANDWIDTH, window=('kaiser', 6.0),
                                fs=1.0 / measurement.dt)
        self._reach = half + _MARGIN
        self._motions: dict[bytes, tuple[Motion, NDArray[np.bool_]]] = {}

    def like(self, measurement: Measurement) -> 'Balancer':
        """Return the balances of another measurement along the same motion."""
        return Balancer(measurement, self.turning, self.unknown, self.whitening)

    @cached_property
    def unwhitened(self) -> 'Balancer':
        """Return the balances as they are, with all of their noise at all frequencies."""
        if self.whitening is None:
            return self
        return Balancer(self.measurement, self.turning, self.unknown)

    def whitened(self, arm: Arm, white: Array) -> 'Balancer':
        """
        Return balances whose noise is as loud at all frequencies.

        It is what readings make, and beside it `white` noise of these deviations (c,) [N*m].
        """
        plain = self(arm)
        noise = np.where(plain.valid, self.noisier(arm).residual - plain.residual, 0.0)
        whitening = whitening_of(noise, white ** 2 / BANDWIDTH, RATE, BANDWIDTH)
        return self if whitening is None else Balancer(self.measurement, self.turning,
                                                       self.unknown, whitening)

    def motion(self, arm: Arm) -> Motion:
        """Return the motion behind the measurement if the arm senses as `arm` does."""
        return self._behind(arm)[0]

    def _behind(self, arm: Arm) -> tuple[Motion, NDArray[np.bool_]]:
        """Return the motion, and where the balances are valid along it."""
        key = sensing(arm)
        if key not in self._motions:
            if len(self._motions) > _KEPT:
                self._motions.pop(next(iter(self._motions)))
            parts = [motion_of(one, arm, SHORT) for one in self.measurement.recordings()]
            motion = Motion(*map(np.concatenate, zip(*parts))) if len(parts) > 1 else parts[0]
            self._motions[key] = motion, self._valid(arm, motion, self.turning)
        return self._motions[key]

    def __call__(self, arm: Arm) -> Balance:
        """Return the balances of an arm."""
        residual, _ = self._along(arm)
        return Balance(self.balances(residual), self._behind(arm)[1])

    @cached_property
    def _jolted(self) -> NDArray[np.bool_]:
        """Return where a jolt is within the filter's reach (k,)."""
        return np.concatenate([_spread(jolts(one), self._reach)
                               for one in self.measurement.recordings()])

    @cached_property
    def is_commanded(self) -> bool:
        """Tell whether all commands were recorded: by a loop of the recording's own rate."""
        return self.unknown is None and is_held(self.measurement.as_recorded())

    @cached_property
    def thinned(self) -> 'Balancer':
        """Return balances at the same times from fewer samples, to tell changes of the arm."""
        made = self.measurement
        part = max((part for part in range(1, self.every + 1)
                    if self.every % part == 0 and made.dt * part * _ENOUGH < 1.01),
                   default=1)
        if part == 1:
            return self
        padded = np.concatenate([made.command, np.repeat(made.command[-1:], part, axis=0)])
        command = np.mean([padded[k:k + len(made.command):part] for k in range(part)], axis=0)
        return self.like(replace(made, dt=part * made.dt, command=command, absent=(), parts=1,
                                 reading=np.ascontiguousarray(made.reading[::part]),
                                 begins=tuple(begin // part for begin in made.begins)))

    @cached_property
    def noisier(self) -> 'Balancer':
        """Return balances of the same readings with about as much noise again."""
        made = self.measurement
        recorded = made.reading[::made.parts].shape
        random = made.reading_noise() * np.random.default_rng(0).standard_normal(recorded)
        return self.like(replace(made, reading=made.reading + between(random, made.parts)))

    def memory(self, arm: Arm) -> Array:
        """Return what the arm's effects remember along the motion (k, n, STATES - MEASURED)."""
        return self._along(arm)[1]

    def needed(self, arm: Arm) -> Array:
        """Return what the links need for the motion (k, n), unfiltered; their base is at rest."""
        torques, dt = np.empty(self.measurement.command.shape), self.measurement.dt
        for piece in self.measurement.pieces():
            record = arm_during(arm, piece, dt).record()
            fill_needed(record, loaded_inertia(record.body), self._moved(arm, piece), dt,
                        torques[piece])
        return torques

    def gears(self, arm: Arm, joints: Sequence[int]) -> Array:
        """Return what motors of joints miss and what their gears carry (2, k, c), unfiltered."""
        chosen, dt = np.array(joints, np.int64), self.measurement.dt
        torques = np.empty((2, len(self.measurement.command), len(chosen)))
        for piece in self.measurement.pieces():
            missed, carried = torques[:, piece]
            fill_gears(arm.record(), chosen, self._driven(arm, piece), dt, missed, carried)
        return torques

    def _along(self, arm: Arm) -> tuple[Array, Array]:
        dt, (samples, joints) = self.measurement.dt, self.measurement.command.shape
        residual = np.empty((samples, 2 * joints))
        memory = np.zeros((samples, joints, STATES - MEASURED))
        for piece in self.measurement.pieces():
            record = arm_during(arm, piece, dt).record()
            fill_along(record, loaded_inertia(record.body), self._driven(arm, piece), dt,
                       residual[piece], memory[piece])
        if self.measurement.led:
            residual[:, :joints] -= residual[:, joints:]
        return residual, memory

    def _driven(self, arm: Arm, piece: slice) -> Driven:
        """Return the motion of one recording, and what an arm has of the commands there."""
        moved, dt = self._moved(arm, piece), self.measurement.dt
        command = self.measurement.command[piece]
        delivered = np.empty_like(command)
        deliver(arm.record(), command, dt, delivered)
        return Driven(*moved, base_motion(arm, moved, dt), centred(delivered))

    def _moved(self, arm: Arm, piece: slice) -> Motion:
        """Return the motion of one recording."""
        motion = self.motion(arm)
        return Motion(motion.state[piece], motion.acceleration[piece])

    def filtered(self, raw: Array) -> Array:
        """Return columns (k, m) low-passed without delay and thinned to the balances' rate."""
        return np.concatenate([self._filtered(raw[piece]) for piece in self.measurement.pieces()])

    def balances(self, raw: Array) -> Array:
        """Return columns (k, c), one for each balance, filtered as balances are."""
        parts = [self._filtered(raw[piece]) for piece in self.measurement.pieces()]
        if self.whitening is not None:
            parts = [self.whitening.balances(part) for part in parts]
        return np.concatenate(parts)

    def in_balance(self, values: Array, channel: int) -> Array:
        """Return columns (m, k) at the balances' times as one of the balances has them."""
        if self.whitening is None:
            return values
        ends = np.cumsum([-(-(piece.stop - piece.start) // self.every)
                          for piece in self.measurement.pieces()])
        return np.concatenate([self.whitening.of(part, channel)
                               for part in np.split(values, ends[:-1])])

    def _filtered(self, raw: Array) -> Array:
        """Return the filtered columns of one recording."""
        half = len(self._low_pass) // 2
        early = -half % self.every                  # so that an output falls on the first sample
        padded = np.concatenate([np.zeros((early, raw.shape[1])), raw])
        thin = upfirdn(self._low_pass, padded, down=self.every, axis=0)
        first = (half + early) // self.every
        return np.asarray(thin[first:first + -(-len(raw) // self.every)])

    def valid_if_turning(self, arm: Arm, joints: Sequence[int]) -> NDArray[np.bool_]:
        """Return where the balances of an arm would be valid if these joints were turning."""
        return self._valid(arm, self.motion(arm), joints)

    def _valid(self, arm: Arm, motion: Motion, turning: Sequence[int]) -> NDArray[np.bool_]:
        """Return where balances hold: their filter has seen no end, no jolt and no standstill."""
        reach = self._reach
        smooth = np.zeros(len(motion.state), bool)
        for piece in self.measurement.pieces():
            whole = slice(piece.start + reach, piece.stop - reach)
            smooth[whole] = ~self._jolted[whole]
        velocity = motion.state[:, :, MOTOR_VELOCITY]
        slow = np.abs(velocity) < _SLOW
        if isinstance(arm.links, ChainLinks):       # light links turn round within a sample
            slow[1:] |= velocity[1:] * velocity[:-1] < 0.0
        for joint in turning:
            slow[:, joint] = _lasting(slow[:, joint], round(_STOP / self.measurement.dt))
        near = np.stack([_spread(column, reach) for column in slow.T], axis=1)
        valid = np.concatenate([smooth[:, None] & ~near,
                                np.repeat(smooth[:, None], slow.shape[1], 1)], axis=1)
        valid = valid[::self.every]
        if self.unknown is not None:
            valid[:, :slow.shape[1]] &= ~self.unknown
        valid[:, slow.shape[1]:] &= not self.measurement.led
        return valid if self.whitening is None else self.whitening.holds(valid)


def _spread(marked: NDArray[np.bool_], reach: int) -> NDArray[np.bool_]:
    """Return what is within `reach` samples of what is marked (k,)."""
    return np.asarray(maximum_filter1d(marked, 2 * reach + 1, mode='constant'))


def _lasting(marked: NDArray[np.bool_], least: int) -> NDArray[np.bool_]:
    """Return what is marked for longer than `least` samples (k,)."""
    return ~_spread(~marked, least // 2) if least > 1 else marked


def sensing(arm: Arm) -> bytes:
    """Return what the motion depends on: all that stands between an angle and its reading."""
    joints = arm.record().joints
    return b''.join(np.ascontiguousarray(joints[name]).tobytes() for name in _SENSED)

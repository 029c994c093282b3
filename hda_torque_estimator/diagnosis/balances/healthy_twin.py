"""What a healthy arm would have recorded on the same motion: the noise of the diagnosis."""

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.kernel import LINK_ANGLE, LINK_VELOCITY
from hda_arm_sim.model.parts import Joint
from hda_arm_sim.motions import Motion
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from .balance import Balancer, RATE
from .clean_motion import CleanMotion
from .more_noise import TorqueResponse
from ...measurements.measurement import Measurement, QUIET, SEGMENT
from ...measurements.running_clock import arm_during
from ...measurements.upsampling import between, is_held
from ...significance import MOSTLY
from ...simulating.closed_loop import ClosedLoopRun, run

# Numerics; choices unless stated otherwise.
_UNSEEN = 1.0           # noise of a balance that never holds, for which any will do [N*m]


class TorqueNoise(NamedTuple):
    """White noise of torques (n,), one sigma of every recorded sample."""

    motor: Array            # that drives give beyond the commands [N*m shaft]
    sensor: Array           # of reference torques, beyond what they show [N*m]

    @classmethod
    def none(cls, joints: int) -> 'TorqueNoise':
        """Return none at so many joints."""
        return cls(np.zeros(joints), np.zeros(joints))


def healthy_twin(balancer: Balancer, arm: Arm, seed: int,
                 more: 'TorqueNoise | None' = None) -> Measurement:
    """
    Return a simulated recording of `arm` along the links' measured motion.

    Its readings are as noisy as the measured ones, and so are its reference torques. `more` is
    what torques have beyond that. That of motors moves them, and the loop answers: curves along a
    motion or a command go with it. With noise that is in the log alone none does.
    """
    more = more or TorqueNoise.none(len(arm.joints))
    measured, noise = balancer.measurement, balancer.measurement.reading_noise()
    reading = np.empty(measured.reading.shape)          # rows in a row, as compiled code has them
    command, torque = np.empty((2, *measured.command.shape))
    random = np.random.default_rng(seed)
    of_drives = more.motor * _white(random, measured, len(arm.joints))
    for piece, made in _along_motion(balancer, arm, seed, of_drives):
        read = made.reading[::measured.parts, :, :2]
        reading[piece], command[piece] = between(read, measured.parts), made.command
        torque[piece] = made.joint_torque
    twin = Measurement(measured.labels, measured.dt, reading, command, begins=measured.begins,
                       parts=measured.parts, led=measured.led,
                       held=is_held(measured.as_recorded()), unscaled=measured.unscaled,
                       blind=measured.blind)
    if measured.referenced.any():
        scatter = np.hypot(measured.reference_noise(), more.sensor)
        twin = replace(twin, reference=np.where(
            np.isfinite(measured.reference),
            torque + scatter * _white(random, measured, len(arm.joints)), np.nan))
    lacking = np.sqrt(np.maximum(noise ** 2 - twin.reading_noise() ** 2, 0.0))
    missing = lacking * random.standard_normal(reading[::measured.parts].shape)
    return replace(twin, reading=reading + between(missing, measured.parts))


def torque_response(balancer: Balancer, arm: Arm, seed: int,
                    more: TorqueNoise) -> TorqueResponse | None:
    """
    Return what a recording of an arm has more by noise of torques, None without any.

    The loop answers what motors give beside its commands, and so does the motion. It is simulated
    with perfect encoders with and without that noise.
    """
    if not (more.motor.any() or more.sensor.any()):
        return None
    measured = balancer.measurement
    random = np.random.default_rng(seed)
    of_drives, of_sensors = (each * _white(random, measured, len(arm.joints)) for each in more)
    perfect = replace(arm, joints=tuple(map(_with_perfect_encoders, arm.joints)))
    reading, command = np.empty(measured.reading.shape), np.empty(measured.command.shape)
    for (piece, noisy), (_, quiet) in zip(*(
            _along_motion(balancer, perfect, seed, share * of_drives) for share in (1.0, 0.0))):
        reading[piece] = (noisy.reading - quiet.reading)[:, :, :2]
        command[piece] = noisy.command - quiet.command
    return TorqueResponse(reading, command,
                          of_sensors if measured.reference.size else measured.reference)


def _with_perfect_encoders(joint: Joint) -> Joint:
    """Return a joint whose encoders have no steps and no noise."""
    motor, link = (replace(encoder, counts=0.0, noise=0.0)
                   for encoder in (joint.motor_encoder, joint.link_encoder))
    return replace(joint, motor_encoder=motor, link_encoder=link)


def _along_motion(balancer: Balancer, arm: Arm, seed: int,
                  of_drives: Array) -> Iterator[tuple[slice, ClosedLoopRun]]:
    """Return runs of an arm along the links' measured motion, one for each recording."""
    measured, noise = balancer.measurement, balancer.measurement.reading_noise()
    for place, piece in enumerate(measured.pieces()):
        state = balancer.motion(arm).state[piece]
        clean = CleanMotion(measured.reading[piece][::measured.parts, :, 1], noise[:, 1],
                            measured.parts * measured.dt, measured.dt)
        angle = clean.angles(state[:, :, LINK_ANGLE])
        rate = clean.rates(state[:, :, LINK_VELOCITY])
        time = measured.dt * np.arange(len(angle), dtype=np.float64)
        asked = Motion(time, angle, rate, np.zeros((len(angle), 2)))
        own = arm_during(arm, piece, measured.dt)
        yield piece, run(own, own, asked, seed + place, estimator=None,
                         drive_noise=of_drives[piece])


def torque_noise_of(noise: Array, plain: Array, balancer: Balancer, arm: Arm) -> TorqueNoise:
    """
    Return the noise of torques that lifts balances so far.

    Noise of a sensor in the place of links is in both balances of its joint. That of a sensor
    beside them is in the third alone, that of a motor in its own alone.
    """
    measurement, joints = balancer.measurement, len(arm.joints)
    excess = np.maximum(noise ** 2 - plain ** 2, 0.0)
    last = slice(len(noise) - joints, None)             # B, or C where there is one
    sensed = np.where(measurement.referenced, excess[last], 0.0)
    passed = _of_white(balancer, len(noise), 0).std(axis=0)
    sensor, passed = np.sqrt(sensed) / passed[last], passed[:joints]
    of_sensor = np.where(measurement.held_against, sensor * passed, 0.0)
    motor = np.maximum(excess[:joints] - of_sensor ** 2, 0.0)
    return TorqueNoise(np.asarray(np.sqrt(motor) / passed / arm.record().joints['ratio']), sensor)


def noise_of(balancer: Balancer, arm: Arm, twin: Measurement | None = None, *,
             seed: int = 0) -> tuple[Array, Array]:
    """
    Return the standard deviation (c,) of each balance that noise leaves, and readings alone.

    A `twin` that was made of this arm and these readings before need not be made again. Of the
    last few arms all is known.

    The second is what the noise of the measured readings makes of the balances: they are made
    again with as much more of it [N*m]. Rounding of slow readings is not white, and a simulated
    twin shows how much more it makes. White noise stays most of it, so it is twice that at most.
    The rest of what a twin has is of its own loop. What motor balances then have more at high
    frequency, where effects seldom show, is white noise of the torque, which is added. What
    torsion balances have more there is of clocks that jitter, the more the faster a joint moves,
    or noise of a sensor.
    """
    record = arm.record()
    return balancer.noises.of(
        (record.joints.tobytes(), record.body.tobytes(), seed),
        lambda: _noise_beside(
            balancer, arm, healthy_twin(balancer, arm, seed) if twin is None else twin, seed))


def _noise_beside(balancer: Balancer, arm: Arm, twin: Measurement,
                  seed: int) -> tuple[Array, Array]:
    """Return what `noise_of` does, with a twin of the arm."""
    ours = balancer(arm)
    added = balancer.noisier(arm).residual - ours.residual
    made = balancer.like(twin)(arm)
    added_level = _rms(added, ours.valid)
    plain = np.clip(_rms(made.residual, made.valid), added_level, added_level / MOSTLY)
    joints = len(arm.joints)
    rough = [_roughness(values[:, :joints], ours.valid[:, :joints])
             for values in (ours.residual, added)]
    of_white = _of_white(balancer, joints, seed)
    share = _roughness(of_white / of_white.std(axis=0), np.ones(of_white.shape, bool))
    white = np.nan_to_num((rough[0] ** 2 - rough[1] ** 2) / share ** 2)
    command_noise = balancer.measurement.command_noise() * arm.record().joints['ratio']
    noise = plain.copy()
    noise[:joints] = np.sqrt(plain[:joints] ** 2 + np.maximum(
        white, (command_noise * of_white.std(axis=0)) ** 2))
    usual = [_segments(values[:, joints:], ours.valid[:, joints:])
             for values in (ours.residual, added)]
    ratio = [_usual(*both) for both in zip(*usual)]
    noise[joints:] = np.maximum(plain[joints:], added_level[joints:] * ratio)
    if balancer.measurement.referenced.any():
        noise = np.maximum(noise, _of_sensors(
            balancer, (ours.residual, added), ours.valid, plain, seed))
    return noise, plain


def _of_sensors(balancer: Balancer, residuals: tuple[Array, Array], valid: NDArray[np.bool_],
                plain: Array, seed: int) -> Array:
    """Return the noise (c,) of torsion against sensors with a white one beside, 0 of others."""
    last = slice(len(plain) - len(balancer.measurement.labels), None)
    left, added = (_roughness(values[:, last], valid[:, last]) for values in residuals)
    of_white = _of_white(balancer, len(plain), seed)[:, last]
    share = _roughness(of_white / of_white.std(axis=0), np.ones(of_white.shape, bool))
    white = np.maximum(np.nan_to_num((left ** 2 - added ** 2) / share ** 2), 0.0)
    found = np.zeros_like(plain)
    found[last] = np.where(balancer.measurement.referenced, np.sqrt(plain[last] ** 2 + white), 0.0)
    return found


def _rms(values: Array, valid: NDArray[np.bool_]) -> Array:
    """Return the rms of columns where they are valid (c,) [N*m]."""
    return np.array([np.sqrt(np.mean(column[seen] ** 2)) if seen.any() else _UNSEEN
                     for column, seen in zip(values.T, valid.T)])


def _of_white(balancer: Balancer, count: int, seed: int) -> Array:
    """Return what white noise of a deviation of 1 makes of the first balances (m, c)."""
    balance = balancer.filtered(_white(np.random.default_rng(seed), balancer.measurement, 1))
    return np.concatenate([balancer.in_balance(balance, channel) for channel in range(count)],
                          axis=1)


def _white(random: np.random.Generator, measurement: Measurement, columns: int) -> Array:
    """Return white noise of recorded samples (k, columns), and between them their spline."""
    recorded = random.standard_normal((len(measurement.command[::measurement.parts]), columns))
    return between(recorded, measurement.parts)


def _roughness(residual: Array, valid: NDArray[np.bool_]) -> Array:
    """Return the high-frequency level (c,) of quiet segments [N*m]."""
    return np.array([np.quantile(parts, QUIET) if len(parts) else np.nan
                     for parts in _segments(residual, valid)])


def _segments(residual: Array, valid: NDArray[np.bool_]) -> list[Array]:
    """
    Return the high-frequency level of every segment, for each balance (c) [N*m].

    Where a motion stops so often that no segment holds throughout, those are of rows that hold.
    """
    fast = residual - gaussian_filter1d(residual, 1.0, axis=0)
    length = round(SEGMENT * RATE)
    levels = []
    for column, good in zip(fast.T, valid.T):
        whole = [k for k in range(0, len(column) - length, length) if good[k:k + length].all()]
        levels.append(np.array([column[k:k + length].std() for k in whole] or [
            column[good][k:k + length].std() for k in range(0, good.sum() - length, length)]))
    return levels


def _usual(ours: Array, of_readings: Array) -> float:
    """
    Return how loud segments (k,) are against noise of readings, all together (eq:jitter-noise).

    Clocks that jitter are louder the faster a joint moves. What is louder than twice the
    readings' noise counts as that: it may be a cause.
    """
    if not len(ours) or not of_readings.any():
        return 1.0
    counted = np.minimum(ours, of_readings / MOSTLY)
    return float(np.sqrt(np.mean(counted ** 2) / np.mean(of_readings ** 2)))

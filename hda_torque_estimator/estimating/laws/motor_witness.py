"""
A joint's torque as its motor determines it at one sample, how sure that is, and what it allows.

Its inertia needs an acceleration, `shaft_motion.py`. How good it is shows in how far both
witnesses differ from sample to sample.
"""

from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.compiled import compiled, inlined, Record
from hda_arm_sim.model.encoders import counts_of
import numpy as np

from .fusion import FEWEST, restart, SETTLED
from .fusion_memory import (errors_learnt, LAG, LAST_COMMAND, LONG, MEAN_APART, MEAN_MOTOR,
                            PRIOR, SCATTER, share, SLID, SLIDING, SLOW_TIME, STEADY, TIME, WEIGHED)
from .route_errors import dry_friction, motor_effects, motor_torque, ShaftState, TORSION_ERRORS
from .shaft_motion import begin_motion, follow_motion, jump_motion, Speeding
from .torque_jumps import jump_of
from .torsion_scatter import forget_twist
from .witnesses import Bound

# Choices unless stated otherwise.
_STILL = 1.25e-4        # [rad] in which a shaft may rest, for encoders without counts
_STILL_COUNTS = 2.0     # of the motor encoder within the time of its low-pass
_RECENT = 0.1           # over which a torque lasts, beside which it scatters [s]
_FRICTION = 2.0         # times the dry friction known, that a motor may have at most
_CERTAIN = 4.0          # deviations beyond what the motor can give, or a shaft at rest shows
_ROUNDS = 3             # of a torque and the friction it loads: usual shares leave below 1 %


class MotorSample(NamedTuple):
    """What a sample gives of a motor."""

    command: float              # torque in force from now on, at the shaft [N*m], NaN for unknown
    angle: float                # of the shaft [rad]
    velocity: float             # [rad/s]
    link_angle: float           # [rad]
    dt: float                   # since the last sample [s]
    late: float                 # by which the velocity is [s]


class Motor(NamedTuple):
    """The estimate of a motor [N*m at the link]."""

    moving: bool
    driving: float              # without inertia, with what was learnt of it
    plain: float                # the same before anything was learnt
    inertia: float              # what speeds up its shaft
    friction: float             # the most that dry friction opposes
    holds: float                # and what of it may hold a shaft at rest
    lawless: float              # variance of what no law describes [N^2*m^2]


class Seen(NamedTuple):
    """What a sample of the torsion shows of a motor."""

    apart: float                # by how much the torsion's is larger [N*m]
    lawless: float              # variance of what no law of it describes [N^2*m^2]


class Own(NamedTuple):
    """Variances of a witness's torque, but for errors that are learnt [N^2*m^2]."""

    random: float               # another from sample to sample
    held: float                 # by friction that may hold either way
    lawless: float              # of what no law describes, which lasts


@inlined
def has_friction(joint: Record) -> bool:
    """Return whether a motor is known: by its deviation, or dry friction, if only under load."""
    if joint.motor_deviation > 0.0:
        return True
    return dry_friction(joint, ShaftState(0.0, 0.0, 0.0, 0.0), joint.torsion.valid_torque) > 0.0


@inlined
def turns(joint: Record, velocity: float, time: float) -> bool:
    """Return whether a shaft turns for certain by what it passes in a time [s]."""
    still = max(counts_of(joint).motor_step, _STILL)
    noise = _CERTAIN * np.sqrt(2.0) * joint.motor_encoder.noise
    return abs(velocity) * time > max(_STILL_COUNTS * still, noise)


@compiled
def hear(memory: Array, heard: MotorSample) -> bool:
    """Return whether a motor determines a torque at a sample; if not, begin a window anew."""
    if heard.dt > 0.0 and np.isfinite(memory[LAST_COMMAND] + heard.command):
        return True
    restart(memory, heard.angle)
    memory[LAST_COMMAND] = heard.command
    memory[WEIGHED] = memory[SLOW_TIME] = memory[SLID] = 0.0
    begin_motion(memory, heard.angle)
    forget_twist(memory)
    return False


@compiled
def motor_estimate(joint: Record, memory: Array, heard: MotorSample, window: float,
                   effect: Array) -> Motor:
    """
    Return the torque of a motor, and fill the effects of its errors (ERRORS,).

    `window` is the least time of half a window [s]. Its friction is loaded by the torque that it
    has itself. The torque of the torsion may be far off until its zero is known.
    """
    mean = _acting(joint, memory, heard.command)
    step = heard.command - memory[LAST_COMMAND]
    memory[LAST_COMMAND] = heard.command
    moving = turns(joint, heard.velocity, max(heard.dt, 0.4 * window))
    span, through = max(window, FEWEST * heard.dt), joint.ratio * joint.motor_inertia
    jump = jump_of(memory, step, heard.dt) / joint.motor_inertia
    speeding = _speeding(joint, memory, heard, window, jump if moving else 0.0)
    at = ShaftState(heard.angle, heard.velocity + heard.late * speeding.now,
                    np.sign(heard.velocity) if moving else 0.0, heard.link_angle)
    memory[LAG] += share(heard.dt, span) * (through * speeding.lag - memory[LAG])
    inertia = through * speeding.now
    plain = joint.ratio * mean
    for _ in range(_ROUNDS):
        load = min(max(plain - inertia, -joint.torsion.valid_torque), joint.torsion.valid_torque)
        plain = motor_torque(joint, mean, at, load, memory[TIME])
    friction = dry_friction(joint, at, load)
    motor_effects(joint, joint.tolerances, mean, at, friction, effect)
    learnt = np.dot(effect[TORSION_ERRORS:], errors_learnt(memory)[TORSION_ERRORS:])
    return Motor(moving, plain + learnt, plain, inertia, friction, joint.held_share * friction,
                 joint.motor_deviation ** 2)


@inlined
def _speeding(joint: Record, memory: Array, heard: MotorSample, window: float,
              jump: float) -> Speeding:
    """Return how fast a shaft speeds up whose motor's torque jumped, (eq:jump) [rad/s^2]."""
    late = min(max(joint.effort_lag, 0.0), 1.0)
    before = max(0.5 - late, 0.0) * jump        # of a jump between two stamps
    jump_motion(memory, before)
    seen = follow_motion(memory, heard.angle, window, heard.dt)
    jump_motion(memory, jump - before)
    return Speeding(seen.now + (1.0 - late) * jump - before, seen.lag)


@inlined
def _acting(joint: Record, memory: Array, command: float) -> float:
    """Return the torque that acts about a sample, as far as it is there yet, (eq:effort-lag)."""
    late = min(max(joint.effort_lag, 0.0), 1.0)
    return (1.0 - late) * command + late * memory[LAST_COMMAND]


@compiled
def bound(memory: Array, motor: Motor, effect: Array) -> Bound:
    """Return what motor, inertia and friction allow, with no dry friction or twice as much."""
    slack = motor.friction * (_FRICTION - 1.0 if motor.moving else _FRICTION)
    unsure = np.sqrt(effect[TORSION_ERRORS:] @ effect[TORSION_ERRORS:] + max(memory[SCATTER], 0.0)
                     + motor.lawless)
    return Bound(motor.plain - motor.inertia, slack, abs(memory[LAG]) + _CERTAIN * unsure)


@compiled
def first_bound(joint: Record, heard: MotorSample, torque: float) -> Bound:
    """
    Return what a motor allows at a first sample, when only its torque is known.

    `torque` loads its friction [N*m].
    """
    at = ShaftState(heard.angle, heard.velocity, 0.0, heard.link_angle)
    slack = _FRICTION * dry_friction(joint, at, torque)
    return Bound(joint.ratio * heard.command, slack,
                 joint.ratio * abs(heard.command) + _CERTAIN * joint.motor_deviation)


@compiled
def torque_at_rest(memory: Array, motor: Motor, dt: float) -> float:
    """
    Return the torque of a motor; at rest it is the last one, as far as friction allows, (eq:rest).

    A pose that stands has the load that it had, while friction takes up what the motor changes.
    """
    torque = motor.driving - motor.inertia
    if motor.moving:
        memory[SLIDING] += (share(dt, _RECENT) if memory[SLID] > 0.0 else 1.0) * (
            torque - memory[SLIDING])
        memory[SLID] = 1.0
        return torque
    if memory[SLID] > 0.0:
        memory[SLIDING] = min(max(memory[SLIDING], torque - motor.holds), torque + motor.holds)
        return float(memory[SLIDING])
    return torque


@compiled
def own_variance(joint: Record, memory: Array, motor: Motor) -> Own:
    """Return the variances of one sample of the motor; sticking it holds either way."""
    rotor = joint.tolerances.motor_inertia * motor.inertia
    sliding = motor.moving and memory[STEADY] >= SETTLED
    holds = motor.friction if motor.moving else motor.holds
    held = 0.0 if sliding and memory[WEIGHED] > 0.0 else holds ** 2 / 3.0
    return Own(max(memory[SCATTER], 0.0) + memory[LAG] ** 2, held, motor.lawless + rotor ** 2)


@compiled
def follow_scatter(memory: Array, motor: Motor, seen: Seen, dt: float) -> None:
    """
    Follow how much the motor's torque scatters from sample to sample, (eq:scatter).

    What changes in the motor's torque and in its difference to the torsion's is its own; what it
    shares with the torsion is the torque's. The less the law of a torsion determines, the slower
    it teaches. A motor of which more is known scatters at first by its deviation, others by
    friction.
    """
    torque, apart = motor.driving - motor.inertia, seen.apart
    if not motor.moving or memory[STEADY] < SETTLED:
        memory[MEAN_APART], memory[MEAN_MOTOR] = apart, torque
        return
    if memory[WEIGHED] == 0.0:
        better = 0.0 < motor.lawless < seen.lawless
        memory[SCATTER] = motor.lawless if better else motor.friction ** 2
    most = abs(memory[SCATTER]) + motor.lawless
    passed = dt * most / max(most + seen.lawless, 1e-300)
    part = max(share(passed, LONG), passed / (memory[WEIGHED] + PRIOR + passed))
    memory[WEIGHED] += max(passed, 1e-12)
    recent = share(dt, _RECENT)
    memory[MEAN_APART] += recent * (apart - memory[MEAN_APART])
    memory[MEAN_MOTOR] += recent * (torque - memory[MEAN_MOTOR])
    own = (torque - memory[MEAN_MOTOR]) * (memory[MEAN_APART] - apart)
    memory[SCATTER] += part * (own - memory[SCATTER])

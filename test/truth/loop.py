"""The arm under its controller, sample by sample: a digital PD on quantised motor angles."""

import math
from typing import NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from .drive import delayed, issued, looped, Sent
from .encoders import FOURTH_ORDER, PEAKED, TWO_ORDERS
from .handed import uncounted
from .layout import Record
from .links import contact, leverage
from .plant import accelerate, drift, kick, locate, Plant, relative, State

Array = NDArray[np.float64]

RATE_FILTER = 0.002             # time constant of the rate that the controller takes [s]

FRESH, STALE, LOST = 0, 1, 2    # what becomes of a sample on the bus


class Plan(NamedTuple):
    """What is given for k samples: reference, push, times, chance."""

    angle: Array                # (k, 2) links [rad]
    angle_rate: Array           # (k, 2)
    force: Array                # (k + 1, 2) on the tip, straight in between [N]
    instant: Array              # (k + 1,) when samples are really taken [s]
    arrival: Array              # (k + 1, 2) when commands reach the amplifiers, without delay [s]
    fate: NDArray[np.int64]     # (k,) FRESH, STALE or LOST
    noise: Array                # (k, 2) of the motor torque [N*m]
    jitter: Array               # (k, 2) of the motor encoder [rad]


class Log(NamedTuple):
    """What came out of k samples."""

    motor: Array                # (k, 2) as the encoder shows it [rad]
    command: Array              # (k, 2) in force from the sample on [N*m]
    link: Array                 # (k + 1, 2) true, when the link encoder is sampled [rad]
    state: Array                # (k, 2, 4) true motor angle and rate, link angle and rate
    torque: Array               # (k, 2) true, through the gear [N*m]
    external: Array             # (k, 2) true, of the force on the tip about the joints [N*m]


class Seen(NamedTuple):
    """What the controller sees of a motor, beside the last reading that was new."""

    angle: float                # as the encoder shows it [rad]
    moved: float                # since then [rad]
    elapsed: float              # since then [s]


class Step(NamedTuple):
    """One step of integration between a sample and the next."""

    k: int                      # the sample
    since: float                # when the step begins, after the sample [s]
    h: float                    # how long it is [s]
    span: float                 # between the samples [s]


def blank(samples: int) -> Log:
    """Return a log to be filled."""
    return Log(np.zeros((samples, 2)), np.zeros((samples, 2)), np.zeros((samples + 1, 2)),
               np.zeros((samples, 2, 4)), np.zeros((samples, 2)), np.zeros((samples, 2)))


@numba.njit(cache=True, error_model='numpy')
def shaft_reading(joint: Record, angle: float, jitter: float) -> float:
    """Return what a motor encoder shows of an angle [rad]."""
    shown = angle + jitter + joint.motor_zero
    if joint.motor_encoder_eccentricity_amplitude != 0.0:
        size, first = (joint.motor_encoder_eccentricity_amplitude,
                       joint.motor_encoder_eccentricity_first)
        turn = angle + joint.motor_encoder_eccentricity_phase
        if joint.motor_encoder_eccentricity_form == PEAKED:
            turn += first * math.sin(turn)
        shown += size * math.sin(turn)
        if joint.motor_encoder_eccentricity_form == TWO_ORDERS:
            shown += first * size * math.sin(
                2.0 * angle + joint.motor_encoder_eccentricity_second)
        if joint.motor_encoder_eccentricity_form == FOURTH_ORDER:
            shown += first * size * math.sin(
                4.0 * angle + joint.motor_encoder_eccentricity_second)
    if joint.motor_step > 0.0:
        shown = math.floor(shown / joint.motor_step) * joint.motor_step
    return shown


@numba.njit(cache=True, error_model='numpy')
def control(joint: Record, plan: Plan, k: int, j: int, seen: Seen, rate: Array) -> float:
    """Return the command that answers a reading [N*m], and move the filtered rate `rate[j]`."""
    rate[j] += (seen.moved - seen.elapsed * rate[j]) / (RATE_FILTER + seen.elapsed)
    torque = (joint.k_p * (joint.ratio * plan.angle[k, j] - seen.angle)
              + joint.k_d * (joint.ratio * plan.angle_rate[k, j] - rate[j]))
    return min(max(torque, -joint.limit), joint.limit)


@numba.njit(cache=True, error_model='numpy')
def hand(joint: Record, plan: Plan, k: int, j: int, state: State) -> float:
    """Return what a hand that leads a link along the motion does to its joint [N*m]."""
    return (joint.hand * (plan.angle[k, j] - relative(state.position, j))
            + joint.hand_damping * (plan.angle_rate[k, j] - relative(state.rate, j)))


@numba.njit(cache=True, error_model='numpy')
def remember(plant: Plant, state: State, plan: Plan, k: int, log: Log, spare: Array) -> None:
    """Keep the true state and torques at a sample."""
    accelerate(plant, state, state.rate, spare)
    for j in range(2):
        log.state[k, j, 0], log.state[k, j, 1] = state.position[j], state.rate[j]
        log.state[k, j, 2] = relative(state.position, j)
        log.state[k, j, 3] = relative(state.rate, j)
        log.torque[k, j] = state.held[j].torque
    push_x, push_y = contact(plant.arm[0], plan.instant[k])
    fx, fy = plan.force[k, 0] + push_x, plan.force[k, 1] + push_y
    arm = plant.arm[0]
    log.external[k, 1] = leverage(arm.length_2, state.position[3], fx, fy)
    log.external[k, 0] = leverage(arm.length_1, state.position[2], fx, fy) + log.external[k, 1]
    for j in range(2):
        if plant.joints[j].hand != 0.0:
            log.external[k, j] += hand(plant.joints[j], plan, k, j, state)


@numba.njit(cache=True, error_model='numpy')
def catch(plant: Plant, state: State, step: Step, late: bool, log: Log) -> None:
    """
    Keep the link angles at their own sampling times within a step.

    A skew behind the sample falls into the interval after it, one ahead into the interval before;
    halfway through a step the present angles and rates give both halves of it.
    """
    for j in range(2):
        skew = plant.joints[j].clock_skew_skew
        offset, sample = (skew, step.k) if skew >= 0.0 else (step.span + skew, step.k + 1)
        ahead = offset - step.since - 0.5 * step.h
        if (ahead >= 0.0) == late and abs(ahead) <= 0.5000001 * step.h:
            log.link[sample, j] = (relative(state.position, j)
                                   + ahead * relative(state.rate, j))


@numba.njit(cache=True, error_model='numpy')
def advance(plant: Plant, state: State, plan: Plan, k: int, steps: int, sent: Sent,
            log: Log) -> None:
    """Integrate from sample k to the next one."""
    begin, span = plan.instant[k], plan.instant[k + 1] - plan.instant[k]
    h, spare = span / steps, np.zeros((2, 5))
    for i in range(steps):
        drift(plant, state, h if i > 0 else 0.5 * h)
        share = (i + 0.5) / steps
        fx = plan.force[k, 0] + share * (plan.force[k + 1, 0] - plan.force[k, 0])
        fy = plan.force[k, 1] + share * (plan.force[k + 1, 1] - plan.force[k, 1])
        locate(plant, state, fx, fy, begin + share * span)
        for j in range(2):
            joint = plant.joints[j]
            mean = delayed(sent, k, j, joint.command_delay_delay, begin + i * h, h)
            state.held[j].applied = looped(joint, mean, j, state.lag, state.memory[j], h)
            if joint.hand != 0.0:
                state.held[j].load += hand(joint, plan, k, j, state)
        step = Step(k, i * h, h, span)
        catch(plant, state, step, False, log)
        kick(plant, state, h, spare[0], spare[1])
        catch(plant, state, step, True, log)
    drift(plant, state, 0.5 * h)


@numba.njit(cache=True, error_model='numpy')
def run(plant: Plant, state: State, plan: Plan, steps: int, log: Log) -> None:
    """Run all samples of a plan, `steps` integration steps each, and fill the log."""
    sent = Sent(np.zeros((plan.angle.shape[0], 2)), plan.arrival, np.zeros(2, np.int64))
    follow(plant, state, plan, steps, sent, np.zeros((3, 5)), log)


@numba.njit(cache=True, error_model='numpy')
def follow(plant: Plant, state: State, plan: Plan, steps: int, sent: Sent, spare: Array,
           log: Log) -> None:
    """Run the samples; rows of `spare` (3, 5) are for what one of them needs."""
    c = uncounted
    plant = Plant(c(plant.arm), c(plant.joints), c(plant.law), c(plant.body))
    state = State(c(state.position), c(state.rate), c(state.bristle), c(state.sliders),
                  c(state.heat), c(state.lag), c(state.memory), c(state.held), c(state.pose))
    plan = Plan(c(plan.angle), c(plan.angle_rate), c(plan.force), c(plan.instant),
                c(plan.arrival), c(plan.fate), c(plan.noise), c(plan.jitter))
    sent, spare = Sent(c(sent.torque), c(sent.arrival), c(sent.active)), c(spare)
    log = Log(c(log.motor), c(log.command), c(log.link), c(log.state), c(log.torque),
              c(log.external))
    rate, answer, last = spare[0], spare[1], 0
    locate(plant, state, plan.force[0, 0], plan.force[0, 1], plan.instant[0])
    for k in range(plan.angle.shape[0]):
        locate(plant, state, plan.force[k, 0], plan.force[k, 1], plan.instant[k])
        remember(plant, state, plan, k, log, spare[2])
        for j in range(2):
            joint = plant.joints[j]
            if plan.fate[k] != FRESH:
                log.command[k, j], log.motor[k, j] = log.command[k - 1, j], log.motor[last, j]
            else:
                log.command[k, j] = answer[j]
                log.motor[k, j] = shaft_reading(joint, state.position[j], plan.jitter[k, j])
                seen = Seen(log.motor[k, j], log.motor[k, j] - log.motor[last, j],
                            plan.instant[k] - plan.instant[last])
                answer[j] = plant.arm[0].powered * control(joint, plan, k, j, seen, rate)
            sent.torque[k, j] = issued(joint, log.command[k, j], plan.noise[k, j],
                                       state.rate[j], plan.instant[k])
        if plan.fate[k] == FRESH:
            last = k
        advance(plant, state, plan, k, steps, sent, log)

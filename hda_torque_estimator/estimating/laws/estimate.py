"""
The estimator's compiled step: one sample in, torques and tip force out (docs/model.md#estimator).

Memory is an array (n, MEMORY), a row per joint. Results are an array (n, RESULTS) per sample for
the joints and one (TIP_RESULTS,) for the tip. The node, the offline command and the closed-loop
simulation all run this function, so they give the same bits.
"""

from typing import NamedTuple

from hda_arm_sim.foundation.compiled import Array, compiled, inlined, Record
from hda_arm_sim.foundation.rigid import gravity_torque, Inertia
from hda_arm_sim.model.arm import ArmRecord
from hda_arm_sim.model.effects.transmission import SLIDERS
from hda_arm_sim.model.encoders import tilt_moments
from hda_arm_sim.model.kernel import growth
from hda_arm_sim.model.link_side import link_torque
from hda_arm_sim.model.torsion import torsion_of_torque
import numpy as np

from . import belief, contact, fusion, payload
from .momentum import expected_rate, hold, inertia_doubt, momentum
from .route_errors import (ERRORS, Known, motor_effects, motor_torque, STIFFNESS, torque_effects,
                           torsion_effects, TORSION_ERRORS)
from .tip_force import base_force, tool_force
from .torsion_torque import (link, reading_deviation, shaft, slide, torque_through_gear,
                             torsions)
from ...samples.readings import LINK_READING, MOTOR_RATE, MOTOR_READING

# Memory, per joint.
(LAST_MOTOR, LAST_LINK,                 # last readings [rad]
 MOTOR_VELOCITY, LINK_VELOCITY,         # low-passed [rad/s]
 LAST_TORSION, TURNED_TORSION,          # elastic torsion, and where the hysteresis stands [rad]
 LAST_MOMENTUM, LATE_RATE, EXTERNAL,    # of the momentum observer
 LATE, LAST_SPEED, ACCELERATION,        # what it lags behind [N*m]; of the link, low-passed
 ZERO, TARE_SUM,                        # torsion taken for zero [rad], its running sum
 QUICK_MOTOR, QUICK_LINK,               # velocities, less low-passed, for the torsion [rad/s]
 STRETCH,                               # of the elements of the hysteresis, the first [rad]
 ) = range(17)
FUSION = STRETCH + SLIDERS              # from here on the memory of the fusion
CONTACT = FUSION + fusion.MEMORY        # in row 0: the memory of contacts
PAYLOAD = CONTACT + contact.MEMORY       # in row 0: the memory of the payload
MEMORY = PAYLOAD + payload.MEMORY

# Results, per joint.
(TORSION, KINEMATIC_TORSION,            # total and kinematic torsion, output side [rad]
 TORQUE, TORQUE_DEVIATION,              # through the gear [N*m]
 EXTERNAL_TORQUE, EXTERNAL_DEVIATION,   # by the environment [N*m], NaN without links
 BEYOND_RANGE,                          # 1 where the torque exceeds the law's valid range
 MOTOR_SHARE,                           # of the motor's torque in what is known of the torque
 DOUBT,                                 # why a torque is not believed, a number of `belief.py`
 ) = range(9)
RESULTS = 9

# Results of the tip: force ON the tip [N], covariances [N^2] by rows.
TOOL_X, TOOL_Y, BASE_X, BASE_Y, TOOL_COVARIANCE, BASE_COVARIANCE = 0, 1, 2, 3, 4, 8
SINGULAR, CONDITIONING = 12, 13
CONTACT_DEVIATIONS, CONTACT_LEVEL = 14, 15      # external torques over their deviations
MASS, MASS_DEVIATION = 16, 17                   # at the tip, beyond the model's [kg]
TIP_RESULTS = 18


class CompiledSettings(NamedTuple):
    """What the compiled step reads of the settings and of the arm's tolerances."""

    velocity_bandwidth: float
    observer_bandwidth: float
    singular_sine: float
    inertia_tolerance: float
    links: float
    torsion_bandwidth: float
    fusion: float
    window: float
    span: float
    contact_deviations: float
    collision_torque: float
    known: Known


@compiled
def usable(reading: Array) -> bool:
    """Tell whether all angles of a reading (n, READINGS) are finite."""
    for j in range(reading.shape[0]):
        if not (np.isfinite(reading[j, MOTOR_READING]) and np.isfinite(reading[j, LINK_READING])):
            return False
    return True


@inlined
def _share(bandwidth: float, dt: float) -> float:
    """Return the share of a new value in a low-pass of this bandwidth [Hz], (eq:low-pass)."""
    return 1.0 - np.exp(-2.0 * np.pi * bandwidth * dt)


@inlined
def _rates(record: ArmRecord, settings: CompiledSettings, memory: Array, reading: Array, j: int,
           dt: float) -> None:
    """Renew the low-passed velocities from given ones, or from angles and stamps."""
    share = _share(settings.velocity_bandwidth, dt)
    quick = _share(settings.torsion_bandwidth, dt)
    for side in range(2):
        rate = reading[j, MOTOR_RATE + side]
        if not np.isfinite(rate):
            rate = (reading[j, side] - memory[j, LAST_MOTOR + side]) / dt
        memory[j, MOTOR_VELOCITY + side] += share * (rate - memory[j, MOTOR_VELOCITY + side])
        memory[j, QUICK_MOTOR + side] += quick * (rate - memory[j, QUICK_MOTOR + side])
        memory[j, LAST_MOTOR + side] = reading[j, side]


@inlined
def _joint(record: ArmRecord, settings: CompiledSettings, tilt_moment: float, memory: Array,
           reading: Array, command: Array, j: int, dt: float, result: Array) -> float:
    """Fill one joint's torsions, torque and deviation; returns its link angle [rad]."""
    joint, learning = record.joints[j], memory[j, FUSION:]
    motor_angle, motor_velocity = shaft(joint, reading[j, MOTOR_READING], memory[j, QUICK_MOTOR])
    link_angle, link_velocity = link(joint, tilt_moment, reading[j, LINK_READING],
                                     memory[j, QUICK_LINK])
    total, kinematic, rate = torsions(joint, motor_angle, motor_velocity, link_angle,
                                      link_velocity)
    effect, known = np.zeros(ERRORS), settings.known
    torsion_effects(known, motor_angle, link_angle, link_velocity, effect)
    learnt = fusion.errors_learnt(learning)
    wrong = effect[:STIFFNESS] @ learnt[:STIFFNESS]
    elastic = total - kinematic - memory[j, ZERO] - wrong
    loop = 0.0
    if joint.torsional_hysteresis.level > 0.0:
        if dt == 0.0:
            memory[j, TURNED_TORSION] = elastic     # where in its loop it begins nobody knows
        loop = slide(joint, elastic - memory[j, TURNED_TORSION],
                     memory[j, STRETCH:STRETCH + SLIDERS])
        memory[j, TURNED_TORSION] = elastic
    memory[j, LAST_TORSION] = elastic
    torque = torque_through_gear(joint, motor_angle, elastic, rate, loop)
    torque *= fusion.stiffness_factor(known.stiffness, learnt[STIFFNESS])
    gain = _share(settings.torsion_bandwidth, dt) / dt if dt > 0.0 else 0.0
    stiffness, random = reading_deviation(joint, torque, gain)
    torque_effects(known, torque, stiffness, effect)
    now, before = fusion.effect_variance(learning, effect, TORSION_ERRORS)
    if settings.fusion > 0.0 and joint.coulomb_friction.level > 0.0:
        _compare(joint, settings, learning, motor_angle, memory[j, MOTOR_VELOCITY], link_angle,
                 command[j], torque, stiffness, effect, dt)
    apart = random ** 2 + joint.torsion.deviation ** 2      # of it the motor corrects nothing
    if fusion.falls_back(learning):
        elastic += wrong
        torque = torque_through_gear(joint, motor_angle, elastic, rate, loop)
        now, apart = before, apart + learning[fusion.EXCESS] ** 2
    result[j, TORSION], result[j, KINEMATIC_TORSION] = total, kinematic
    result[j, TORQUE] = torque
    result[j, DOUBT] = belief.of_fusion(learning)
    result[j, TORQUE_DEVIATION] = np.sqrt(apart + now)
    result[j, MOTOR_SHARE] = max(1.0 - (apart + now) / max(apart + before, 1e-300), 0.0)
    result[j, BEYOND_RANGE] = 1.0 if abs(elastic) > joint.torsion.valid_torsion else 0.0
    return link_angle


@inlined
def _compare(joint: Record, settings: CompiledSettings, learning: Array, motor_angle: float,
             velocity: float, link_angle: float, command: float, torque: float, stiffness: float,
             effect: Array, dt: float) -> None:
    """Hold the torque of the torsion against that of the motor."""
    mean = 0.5 * (learning[fusion.LAST_COMMAND] + command)
    if dt == 0.0 or not np.isfinite(mean):
        fusion.restart(learning, motor_angle, command)
        return
    learning[fusion.LAST_COMMAND] = command
    learnt, sense = fusion.errors_learnt(learning), np.sign(velocity)
    motor_effects(joint, settings.known, mean, velocity, sense, motor_angle, effect)
    told = (motor_torque(joint, mean, motor_angle, velocity, torque, link_angle,
                         learning[fusion.TIME])
            + np.dot(effect[TORSION_ERRORS:], learnt[TORSION_ERRORS:]))
    fusion.gather(learning, torque - told, effect, dt)
    fusion.close_half(joint, learning, motor_angle, settings.window, stiffness, settings.span)


@inlined
def _external(record: ArmRecord, settings: CompiledSettings, inertia: Inertia, memory: Array,
              q1: float, q2: float, dt: float, result: Array) -> None:
    """Renew the momentum observer and fill the external torques, (eq:observer)."""
    joints = record.joints.shape[0]
    last = joints - 1
    dq1 = memory[0, QUICK_LINK]
    dq2 = memory[last, QUICK_LINK] if joints == 2 else 0.0
    now = momentum(inertia, joints, q2, dq1, dq2)
    pull1, doubt1 = hold(record.joints[0], q1, dq1)
    pull2, doubt2 = hold(record.joints[last], q2, dq2)
    rate = expected_rate(inertia, record.body, joints, q1, q2, dq1, dq2,
                         result[0, TORQUE] + pull1, result[last, TORQUE] + pull2)
    share = _share(settings.observer_bandwidth, dt) if dt > 0.0 else 0.0
    quick = _share(settings.torsion_bandwidth, dt) if dt > 0.0 else 1.0
    for j in range(joints):
        if dt > 0.0:
            change = (now[j] - memory[j, LAST_MOMENTUM]) / dt
            ahead = change - memory[j, LATE_RATE] - memory[j, EXTERNAL]
            memory[j, EXTERNAL] += share * ahead
            memory[j, LATE] += share * (ahead - memory[j, LATE])
            speeding = (memory[j, QUICK_LINK] - memory[j, LAST_SPEED]) / dt
            memory[j, ACCELERATION] += share * (speeding - memory[j, ACCELERATION])
        memory[j, LAST_MOMENTUM] = now[j]
        memory[j, LATE_RATE] += quick * (rate[j] - memory[j, LATE_RATE])
        memory[j, LAST_SPEED] = memory[j, QUICK_LINK]
        result[j, EXTERNAL_TORQUE] = memory[j, EXTERNAL]
    carried = memory[0, PAYLOAD:]
    if dt > 0.0:
        payload.gather(carried, inertia, record.body, joints, q1, q2, dq1, dq2, now,
                       (memory[0, LATE_RATE], memory[last, LATE_RATE]),
                       settings.inertia_tolerance, settings.span, dt)
    else:
        payload.restart(carried)
    moved1, moved2 = inertia_doubt(inertia, q2, dq1, dq2, memory[0, ACCELERATION],
                                   memory[last, ACCELERATION] if joints == 2 else 0.0)
    _external_deviation(settings, memory, 0, moved1, doubt1, result)
    if joints == 2:
        _external_deviation(settings, memory, 1, moved2, doubt2, result)


@inlined
def _external_deviation(settings: CompiledSettings, memory: Array, j: int, moved: float,
                        doubt: float, result: Array) -> None:
    """Fill how sure an external torque is: gear, inertia, lag, bearing at rest, (eq:sigma-ext)."""
    result[j, EXTERNAL_DEVIATION] = np.sqrt(
        result[j, TORQUE_DEVIATION] ** 2 + settings.inertia_tolerance ** 2 * moved
        + memory[j, LATE] ** 2 + doubt ** 2)


@inlined
def _tip(record: ArmRecord, settings: CompiledSettings, q1: float, q2: float, result: Array,
         tip: Array) -> None:
    joints = record.joints.shape[0]
    tool, base = tip[TOOL_X:TOOL_X + 2], tip[BASE_X:BASE_X + 2]
    tool_covariance = tip[TOOL_COVARIANCE:TOOL_COVARIANCE + 4].reshape((2, 2))
    base_covariance = tip[BASE_COVARIANCE:BASE_COVARIANCE + 4].reshape((2, 2))
    singular, ratio = tool_force(record.body.links, joints, q2, result[:, EXTERNAL_TORQUE],
                                 result[:, EXTERNAL_DEVIATION], settings.singular_sine,
                                 tool, tool_covariance)
    base_force(q1 + q2, tool, tool_covariance, base, base_covariance)
    tip[SINGULAR], tip[CONDITIONING] = 1.0 if singular else 0.0, ratio


@compiled
def step(record: ArmRecord, settings: CompiledSettings, inertia: Inertia, memory: Array,
         reading: Array, command: Array, dt: float, result: Array, tip: Array) -> None:
    """
    Estimate from one sample; dt [s] is the time since the last one, 0 starts afresh.

    `reading` is (n, READINGS), `command` (n,) the motor torque in force from now on [N*m], NaN
    where none is given. `result` (n, RESULTS) and `tip` (TIP_RESULTS,) are filled. An arm without
    links (`settings.links == 0`) leaves external torques and tip NaN.
    """
    joints = record.joints.shape[0]
    q1 = q2 = 0.0
    moments = tilt_moments(record.body, inertia, reading[joints - 1, LINK_READING])
    for j in range(joints):
        if dt > 0.0:
            _rates(record, settings, memory, reading, j, dt)
        else:
            restart(memory, reading, j)
        angle = _joint(record, settings, moments[min(j, 1)], memory, reading, command, j,
                       dt, result)
        q1, q2 = (angle, q2) if j == 0 else (q1, angle)
    if settings.links == 0.0:
        result[:, EXTERNAL_TORQUE] = np.nan
        result[:, EXTERNAL_DEVIATION] = np.nan
        tip[:] = np.nan
        return
    _external(record, settings, inertia, memory, q1, q2, dt, result)
    _tip(record, settings, q1, q2, result, tip)
    torque = result[:, EXTERNAL_TORQUE]
    tip[CONTACT_DEVIATIONS] = contact.deviations(torque, result[:, EXTERNAL_DEVIATION])
    tip[MASS], tip[MASS_DEVIATION] = payload.mass(memory[0, PAYLOAD:])
    tip[CONTACT_LEVEL] = contact.feel(memory[0, CONTACT:], tip[CONTACT_DEVIATIONS], torque,
                                      settings.contact_deviations, settings.collision_torque, dt)


@compiled
def restart(memory: Array, reading: Array, j: int) -> None:
    """Begin afresh at a reading: known velocities or none, no external torque, the old zero."""
    zero, tare = memory[j, ZERO], memory[j, TARE_SUM]
    memory[j, :FUSION] = 0.0
    memory[j, ZERO], memory[j, TARE_SUM] = zero, tare
    for side in range(2):
        memory[j, LAST_MOTOR + side] = reading[j, side]
        rate = reading[j, MOTOR_RATE + side]
        rate = rate if np.isfinite(rate) else 0.0
        memory[j, MOTOR_VELOCITY + side] = memory[j, QUICK_MOTOR + side] = rate


@compiled
def add_to_tare(record: ArmRecord, settings: CompiledSettings, inertia: Inertia,
                memory: Array) -> None:
    """Add to the tare sum how far each torsion is from that without contact, (eq:tare)."""
    joints = record.joints.shape[0]
    weight = gravity_torque(inertia, record.body.pull, record.body.direction,
                            memory[0, LAST_LINK], memory[joints - 1, LAST_LINK])
    for j in range(joints):
        joint = record.joints[j]
        load = link_torque(joint, memory[j, LAST_LINK])
        if settings.links > 0.0 and record.body.pull > 0.0:
            load += weight[min(j, 1)]
        angle, _ = shaft(joint, memory[j, LAST_MOTOR], 0.0)
        expected = (torsion_of_torque(joint.torsion, joint.ratio, -load)
                    - growth(joint, angle)[0] * abs(load))
        memory[j, TARE_SUM] += memory[j, LAST_TORSION] - expected

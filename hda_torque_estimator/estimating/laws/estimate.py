"""
The estimator's compiled step: one sample in, torques and tip force out (docs/model.md#estimator).

Memory is an array (n, MEMORY), a row per joint. Results are an array (n, RESULTS) per sample for
the joints and one (TIP_RESULTS,) for the tip. The node, the offline command and the closed-loop
simulation all run this function, so they give the same bits.
"""

from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.chain import lent, of_links
from hda_arm_sim.foundation.compiled import borrowed, compiled, inlined, Record
from hda_arm_sim.foundation.rigid import Inertia
from hda_arm_sim.model.arm import ArmRecord
from hda_arm_sim.model.effects.place import SLIDERS
from hda_arm_sim.model.encoders import tilt_moments, tilt_of
from hda_arm_sim.model.kernel import growth, loops
from hda_arm_sim.model.link_side import link_torque
from hda_arm_sim.model.torsion import torsion_of_torque
from hda_arm_sim.model.weight import weights
import numpy as np

from . import belief, chain_estimate, contact, fusion_memory, payload
from .chain_estimate import ChainMotion
from .compiled_settings import CompiledSettings, Model
from .joint_torque import GearState, joint_torque
from .layout import (
    ACCELERATION, BASE_COVARIANCE, BASE_X, BEYOND_RANGE, CONDITIONING, CONTACT,
    CONTACT_DEVIATIONS, CONTACT_LEVEL, DOUBT, EXTERNAL, EXTERNAL_DEVIATION, EXTERNAL_TORQUE,
    FUSION, KINEMATIC_TORSION, LAST_LINK, LAST_MOMENTUM, LAST_MOTOR, LAST_TORSION, LATE,
    LATE_RATE, MASS, MASS_DEVIATION, MOTOR_SHARE, MOTOR_VELOCITY, PAYLOAD, QUICK_LINK,
    QUICK_MOTOR, SINGULAR, STRETCH, TARE_SUM, TOOL_COVARIANCE, TOOL_X, TORQUE,
    TORQUE_DEVIATION, TORSION, TURNED_TORSION, ZERO, ZERO_TAKEN)
from .low_pass import lateness, share_of
from .momentum import expected_rate, hold, inertia_doubt, LinkMotion, momentum
from .motor_witness import MotorSample
from .observer import LowPassShares, observe, observed_variance, shares_of
from .route_errors import ERRORS, STIFFNESS, torsion_effects, ZERO as ZERO_ERROR
from .tip_force import base_force, Posture, tool_force
from .torsion_torque import link, shaft, slide, torsions
from ...samples.readings import LINK_READING, MOTOR_RATE, MOTOR_READING


class EncoderSample(NamedTuple):
    """One sample: what the encoders show and what is in force from then on."""

    reading: Array              # (n, READINGS)
    command: Array              # (n,) motor torque [N*m], NaN where none is given
    dt: float                   # since the last one, 0 starts afresh [s]


@compiled
def usable(reading: Array) -> bool:
    """Return whether all angles of a reading (n, READINGS) are finite."""
    for j in range(reading.shape[0]):
        if not (np.isfinite(reading[j, MOTOR_READING]) and np.isfinite(reading[j, LINK_READING])):
            return False
    return True


@inlined
def _rates(settings: CompiledSettings, memory: Array, reading: Array, dt: float) -> None:
    """Renew one joint's low-passed velocities from given ones, or from angles and stamps."""
    share = share_of(settings.velocity_bandwidth, dt)
    quick = share_of(settings.torsion_bandwidth, dt)
    for side in range(2):
        rate = reading[MOTOR_RATE + side]
        if not np.isfinite(rate):
            rate = (reading[side] - memory[LAST_MOTOR + side]) / dt
        memory[MOTOR_VELOCITY + side] += share * (rate - memory[MOTOR_VELOCITY + side])
        memory[QUICK_MOTOR + side] += quick * (rate - memory[QUICK_MOTOR + side])
        memory[LAST_MOTOR + side] = reading[side]


@inlined
def _joint(model: Model, tilt_moment: float, memory: Array, sample: EncoderSample, j: int,
           result: Array) -> float:
    """Fill one joint's torsions, torque and deviation; returns its link angle [rad]."""
    joint, dt, learning = model.record.joints[j], sample.dt, memory[FUSION:]
    settings = model.settings
    motor_angle, motor_velocity = shaft(joint, sample.reading[j, MOTOR_READING],
                                        memory[QUICK_MOTOR])
    link_angle, link_velocity = link(joint, tilt_moment, sample.reading[j, LINK_READING],
                                     memory[QUICK_LINK])
    total, kinematic, rate = torsions(joint, motor_angle, motor_velocity, link_angle,
                                      link_velocity)
    effect, learnt = np.zeros(ERRORS), fusion_memory.errors_learnt(learning)
    torsion_effects(joint.tolerances, motor_angle, link_angle, link_velocity, effect)
    slipped = effect[ZERO_ERROR] * learnt[ZERO_ERROR]
    wrong = effect[:STIFFNESS] @ learnt[:STIFFNESS]
    certain = slipped * learning[fusion_memory.FREED]
    elastic = total - kinematic - memory[ZERO] - wrong
    loop = _loop(joint, memory, elastic, dt)
    memory[LAST_TORSION] = elastic
    gain, late = 0.0, 0.0
    if dt > 0.0:
        gain = share_of(settings.torsion_bandwidth, dt) / dt
        late = lateness(settings.velocity_bandwidth, dt)
    estimated = joint_torque(
        joint, settings, learning,
        GearState(elastic, rate, loop, wrong - certain, gain,
                  fusion_memory.stiffness_factor(joint.tolerances.stiffness,
                                                 learnt[STIFFNESS])),
        MotorSample(sample.command[j], motor_angle, memory[MOTOR_VELOCITY], link_angle, dt, late),
        effect)
    result[TORSION], result[KINEMATIC_TORSION] = total, kinematic
    result[TORQUE], result[TORQUE_DEVIATION] = estimated.torque, estimated.deviation
    result[MOTOR_SHARE], result[DOUBT] = estimated.motor_share, belief.of_fusion(learning)
    result[BEYOND_RANGE] = 1.0 if abs(elastic) > joint.torsion.valid_torsion else 0.0
    result[ZERO_TAKEN] = memory[ZERO] + slipped
    return link_angle


@inlined
def _loop(joint: Record, memory: Array, elastic: float, dt: float) -> float:
    """Return the hysteresis z in [-1, 1] at a torsion [rad], and let it follow."""
    if not loops(joint):
        return 0.0
    if dt == 0.0:
        memory[TURNED_TORSION] = elastic        # where in its loop it begins nobody knows
    loop = slide(joint, elastic - memory[TURNED_TORSION], memory[STRETCH:STRETCH + SLIDERS])
    memory[TURNED_TORSION] = elastic
    return loop


@inlined
def _external(model: Model, memory: Array, at: LinkMotion, dt: float, result: Array) -> None:
    """Renew the momentum observer and fill the external torques, (eq:observer)."""
    record, settings, inertia = model.record, model.settings, model.inertia
    joints = record.joints.shape[0]
    last = joints - 1
    now = momentum(inertia, joints, at)
    pull1, doubt1 = hold(record.joints[0], at.q1, at.dq1)
    pull2, doubt2 = hold(record.joints[last], at.q2, at.dq2)
    rate = expected_rate(inertia, record.body, joints, at,
                         (result[0, TORQUE] + pull1, result[last, TORQUE] + pull2))
    share = shares_of(settings, dt)
    for j in range(joints):
        observe(memory[j], now[j], rate[j], share)
        result[j, EXTERNAL_TORQUE] = memory[j, EXTERNAL]
    moved1, moved2 = inertia_doubt(inertia, at, memory[0, ACCELERATION],
                                   memory[last, ACCELERATION] if joints == 2 else 0.0)
    _external_deviation(settings, memory[0], (moved1, doubt1), share, result[0])
    if joints == 2:
        _external_deviation(settings, memory[1], (moved2, doubt2), share, result[1])


@inlined
def _carried(model: Model, memory: Array, at: LinkMotion, dt: float) -> None:
    """Let the payload hear of a sample, once the momentum observer has."""
    last = model.record.joints.shape[0] - 1
    carried = memory[0, PAYLOAD:]
    if dt > 0.0:
        payload.gather(carried, model, at, (memory[0, LAST_MOMENTUM], memory[last, LAST_MOMENTUM]),
                       (memory[0, LATE_RATE], memory[last, LATE_RATE]), dt)
    else:
        payload.restart(carried)


@inlined
def _external_deviation(settings: CompiledSettings, memory: Array, doubts: tuple[float, float],
                        share: LowPassShares, result: Array) -> None:
    """Fill how sure an external torque is: gear, inertia, lag, bearing at rest, (eq:sigma-ext)."""
    result[EXTERNAL_DEVIATION] = np.sqrt(
        observed_variance(memory, result[TORQUE_DEVIATION], share)
        + settings.inertia_tolerance ** 2 * doubts[0] + memory[LATE] ** 2 + doubts[1] ** 2)


@inlined
def _tip(model: Model, at: LinkMotion, result: Array, tip: Array) -> None:
    tool, base = tip[TOOL_X:TOOL_X + 2], tip[BASE_X:BASE_X + 2]
    tool_covariance = tip[TOOL_COVARIANCE:TOOL_COVARIANCE + 4].reshape((2, 2))
    base_covariance = tip[BASE_COVARIANCE:BASE_COVARIANCE + 4].reshape((2, 2))
    singular, ratio = tool_force(
        Posture(model.record.body.links, model.record.joints.shape[0], at.q2,
                model.settings.singular_sine),
        result[:, EXTERNAL_TORQUE], result[:, EXTERNAL_DEVIATION], tool, tool_covariance)
    base_force(at.q1 + at.q2, tool, tool_covariance, base, base_covariance)
    tip[SINGULAR], tip[CONDITIONING] = 1.0 if singular else 0.0, ratio


@compiled
def _in_plane(model: Model, memory: Array, moved: ChainMotion, result: Array, tip: Array) -> None:
    """Fill external torques and tip of one or two links in a plane."""
    last = model.record.joints.shape[0] - 1
    q2, dq2 = (moved.angles[1], memory[1, QUICK_LINK]) if last == 1 else (0.0, 0.0)
    at = LinkMotion(moved.angles[0], q2, memory[0, QUICK_LINK], dq2)
    _external(model, memory, at, moved.dt, result)
    _carried(model, memory, at, moved.dt)
    _tip(model, at, result, tip)
    tip[MASS], tip[MASS_DEVIATION] = payload.mass(memory[0, PAYLOAD:])
    tip[CONTACT_DEVIATIONS] = contact.deviations(result[:, EXTERNAL_TORQUE],
                                                 result[:, EXTERNAL_DEVIATION])


_of_links = of_links(_in_plane, chain_estimate.in_space)


@compiled
def step(model: Model, memory: Array, sample: EncoderSample, result: Array, tip: Array) -> None:
    """
    Estimate from one sample; `result` (n, RESULTS) and `tip` (TIP_RESULTS,) are filled.

    An arm without links (`settings.links == 0`) leaves external torques and tip NaN.
    """
    memory, result, tip = borrowed(memory), borrowed(result), borrowed(tip)
    record = ArmRecord(borrowed(model.record.joints), model.record.body)
    model = Model(record, model.settings, lent(model.inertia))
    sample = EncoderSample(borrowed(sample.reading), borrowed(sample.command), sample.dt)
    settings, dt = model.settings, sample.dt
    joints = record.joints.shape[0]
    angles = np.empty(joints)
    moments = tilt_moments(record.body, model.inertia, sample.reading[:, LINK_READING])
    for j in range(joints):
        if dt > 0.0:
            _rates(settings, memory[j], sample.reading[j], dt)
        else:
            restart(memory, sample.reading, j)
        angles[j] = _joint(model, tilt_of(moments, j), memory[j], sample, j, result[j])
    if settings.links == 0.0:
        result[:, EXTERNAL_TORQUE] = np.nan
        result[:, EXTERNAL_DEVIATION] = np.nan
        tip[:] = np.nan
        return
    _of_links(model, memory, ChainMotion(angles, dt), result, tip)
    tip[CONTACT_LEVEL] = contact.feel(
        memory[0, CONTACT:], tip[CONTACT_DEVIATIONS], result[:, EXTERNAL_TORQUE],
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
    weight = np.zeros(joints)
    if settings.links > 0.0:
        weights(record, inertia, memory[:, LAST_LINK], weight)
    for j in range(joints):
        joint = record.joints[j]
        load = link_torque(joint, memory[j, LAST_LINK]) + weight[j]
        angle, _ = shaft(joint, memory[j, LAST_MOTOR], 0.0)
        expected = (torsion_of_torque(joint.torsion, joint.ratio, -load)
                    - growth(joint, angle)[0] * abs(load))
        memory[j, TARE_SUM] += memory[j, LAST_TORSION] - expected

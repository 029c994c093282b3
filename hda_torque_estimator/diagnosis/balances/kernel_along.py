"""
The kernel along a measured motion, compiled: residuals, and what the effects remember there.

The motor of one joint is run alone as well (eq:balance-parts), under what its gear does.
"""

from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.chain import lent
from hda_arm_sim.foundation.compiled import compiled, inlined, Record
from hda_arm_sim.foundation.rigid import Inertia
from hda_arm_sim.model.arm import ArmRecord
from hda_arm_sim.model.effect_loops import record_at
from hda_arm_sim.model.effects.catalogue import sole_at
from hda_arm_sim.model.effects.place import Bent, BRISTLES, Commanded, WIRE
from hda_arm_sim.model.kernel import (AXES, BASE_OFFSET, BASE_RATE, bends, BRISTLE, bristles_of,
                                      COMMAND, LINK_ANGLE, LINK_VELOCITY, MODE, MOTOR_ANGLE,
                                      MOTOR_VELOCITY, NOW, REGISTERS, settle, shaft_side, slope,
                                      SLOPE_1, STATE, STATES, TORQUE)
from hda_arm_sim.model.motor_side import (clipped, friction_budget, lagging, lags, loop_of,
                                          shaft_torque)
import numpy as np

from .gears import Geared
from .sample_residuals import missed_torques, motor_missed
from .sensed_motion import JointMotion

# Numerics; choices unless stated otherwise.
REST = 2e-3             # link speed at which a bearing may stick [rad/s]
MEASURED = 4           # states that a motion gives; the kernel's others are its memory (layout)
_wire_of, _bent_after = record_at(WIRE), sole_at(BRISTLES).law_after


class Driven(NamedTuple):
    """A motion over time, and what drove it."""

    state: Array                # (k, n, MEASURED), columns of the kernel
    acceleration: Array         # (k, n, 2) motor, link [rad/s^2]
    base: Array                 # (k, 2) its offset and rate
    command: Array              # (k, n) mean torque at the shaft around every sample [N*m]


def centred(command: Array) -> Array:
    """Return the command around every sample: the mean of the one before and the one after."""
    return 0.5 * (command + np.concatenate([command[:1], command[:-1]]))


@compiled
def deliver(joints: Record, j: int, command: Array, dt: float, delivered: Array) -> None:
    """Fill the mean torque (k,) at the shaft of a joint from a sample until the next."""
    joint = joints[j]
    late = _wire_of(joint).delay / dt
    whole, lag, current = int(late), loop_of(joint).time_constant, 0.0
    for k in range(command.shape[0]):
        new, old = command[max(k - whole, 0), j], command[max(k - whole - 1, 0), j]
        mean = new + (late - whole) * (old - new)
        mean = clipped(joint, mean)
        if lags(joint):
            before = current if k > 0 else mean
            current = lagging(joint, Commanded(mean, mean, before, dt))
            mean = mean - (current - before) * lag / dt     # the lag's mean over the sample
        delivered[k] = shaft_torque(joint, mean)


@compiled
def fill_along(arm: ArmRecord, inertia: Inertia, driven: Driven, dt: float, residual: Array,
               memory: Array) -> None:
    """Fill the residuals (k, 2 n): A of every joint, then B; and what the effects remember."""
    state, acceleration, base, command = driven
    joints = state.shape[1]
    w = np.zeros((max(AXES, joints), REGISTERS))
    links = lent(inertia)
    for k in range(state.shape[0]):
        w[0, NOW] = k * dt
        w[0, STATE + BASE_OFFSET], w[0, STATE + BASE_RATE] = base[k, 0], base[k, 1]
        for j in range(joints):
            _stand(arm.joints[j], state[k, j], command[k, j], w, j, dt)
            rate = state[k, j, LINK_VELOCITY]
            w[j, MODE + 1] = np.sign(rate) if abs(rate) > REST else 0.0
            for i in range(MEASURED, STATES):
                memory[k, j, i - MEASURED] = w[j, STATE + i]
        slope(arm, links, w, STATE, SLOPE_1)
        settle(arm, w)
        missed_torques(arm, links, w, acceleration[k], residual[k])


@compiled
def fill_missed(joints: Record, j: int, moved: JointMotion, geared: Geared, command: Array,
                dt: float,
                missed: Array) -> None:
    """Fill what the motor of a joint misses under the torques of its gear (k,) [N*m, output]."""
    joint, w = joints[j], np.zeros((1, REGISTERS))
    for k in range(missed.shape[0]):
        w[0, NOW] = k * dt
        w[0, COMMAND] = command[k]
        w[0, STATE + MOTOR_ANGLE] = moved.motor.angle[k]
        w[0, STATE + MOTOR_VELOCITY] = moved.motor.velocity[k]
        w[0, STATE + LINK_ANGLE] = moved.link.angle[k]
        w[0, MODE] = np.sign(moved.motor.velocity[k])
        _bend(joint, w, 0, dt)
        shaft_side(joint, w, 0, (geared.through[k], geared.against[k]), STATE, SLOPE_1)
        missed[k] = motor_missed(joint, w, 0, moved.motor.acceleration[k])


@inlined
def _stand(joint: Record, state: Array, command: float, w: Array, j: int, dt: float) -> None:
    """Put a joint into a measured state (MEASURED,), its bristles bent as far as they are then."""
    w[j, COMMAND] = command
    w[j, MODE] = np.sign(state[MOTOR_VELOCITY])
    for i in range(MEASURED):
        w[j, STATE + i] = state[i]
    _bend(joint, w, j, dt)


@inlined
def _bend(joint: Record, w: Array, j: int, dt: float) -> None:
    """Bend the bristles for a sample, under the torque of the one before."""
    if bends(joint):
        rate, angle = w[j, STATE + MOTOR_VELOCITY], w[j, STATE + LINK_ANGLE]
        budget = friction_budget(joint, rate, np.sign(rate), w[j, TORQUE], angle)
        at = Bent(rate, w[j, STATE + BRISTLE], 0.0, budget)
        w[j, STATE + BRISTLE] = _bent_after(bristles_of(joint), at, dt)

"""The kernel along a measured motion, compiled: residuals, and what the effects remember there."""

from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.chain import lent
from hda_arm_sim.foundation.compiled import compiled, inlined, Record
from hda_arm_sim.foundation.rigid import Inertia
from hda_arm_sim.model.arm import ArmRecord
from hda_arm_sim.model.effects.friction import bristle_after
from hda_arm_sim.model.effects.place import Bent, Commanded
from hda_arm_sim.model.kernel import (AXES, BASE_OFFSET, BASE_RATE, BRISTLE, COMMAND, LINK_ANGLE,
                                      LINK_VELOCITY, MODE, motor_side, MOTOR_VELOCITY, NOW,
                                      REGISTERS, settle, settle_gear, slope, SLOPE_1, STATE,
                                      STATES, TORQUE)
from hda_arm_sim.model.link_side import link_torque
from hda_arm_sim.model.motor_side import clipped, friction_budget, lagging, shaft_torque
import numpy as np
from numpy.typing import NDArray

from .sample_residuals import missed_torques, motor_missed

# Choices unless told otherwise.
_REST = 2e-3            # link speed at which a bearing may stick [rad/s]
MEASURED = 4           # states that a motion gives; the kernel's others are its memory (layout)


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
def deliver(arm: ArmRecord, command: Array, dt: float, delivered: Array) -> None:
    """Fill the mean torque (k, n) at each shaft from a sample until the next."""
    for j in range(command.shape[1]):
        joint = arm.joints[j]
        late = joint.command_delay.delay / dt
        whole, lag, current = int(late), joint.current_loop_lag.time_constant, 0.0
        for k in range(command.shape[0]):
            new, old = command[max(k - whole, 0), j], command[max(k - whole - 1, 0), j]
            mean = new + (late - whole) * (old - new)
            mean = clipped(joint, mean)
            if lag > 0.0:
                before = current if k > 0 else mean
                current = lagging(joint, Commanded(mean, mean, before, dt))
                mean = mean - (current - before) * lag / dt     # the lag's mean over the sample
            delivered[k, j] = shaft_torque(joint, mean)


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
            w[j, MODE + 1] = np.sign(rate) if abs(rate) > _REST else 0.0
            for i in range(MEASURED, STATES):
                memory[k, j, i - MEASURED] = w[j, STATE + i]
        slope(arm, links, w, STATE, SLOPE_1)
        settle(arm, w)
        missed_torques(arm, links, w, acceleration[k], residual[k])


@compiled
def fill_gears(arm: ArmRecord, chosen: NDArray[np.int64], driven: Driven, dt: float,
               missed: Array, carried: Array) -> None:
    """
    Fill what the motors of chosen joints miss and what reaches their links, (eq:balance-parts).

    These are (k, c) each, torques at the output. Nothing of links is needed for them.
    """
    state, acceleration, _, command = driven
    w = np.zeros((max(AXES, state.shape[1]), REGISTERS))
    for place in range(chosen.shape[0]):
        j = chosen[place]
        joint = arm.joints[j]
        for k in range(state.shape[0]):
            w[0, NOW] = k * dt
            _stand(joint, state[k, j], command[k, j], w, j, dt)
            motor_side(arm, w, j, STATE, SLOPE_1)
            settle_gear(joint, w, j)
            missed[k, place] = motor_missed(joint, w, j, acceleration[k, j, 0])
            carried[k, place] = w[j, TORQUE] + link_torque(joint, w[j, STATE + LINK_ANGLE])


@inlined
def _stand(joint: Record, state: Array, command: float, w: Array, j: int, dt: float) -> None:
    """Put a joint into a measured state (MEASURED,), its bristles bent as far as they are then."""
    w[j, COMMAND] = command
    w[j, MODE] = np.sign(state[MOTOR_VELOCITY])
    put_state(state, w, j)
    _bend(joint, w, j, dt)


@inlined
def put_state(state: Array, w: Array, j: int) -> None:
    """Put what was measured of a joint (MEASURED,) into its registers."""
    for i in range(MEASURED):
        w[j, STATE + i] = state[i]


@inlined
def _bend(joint: Record, w: Array, j: int, dt: float) -> None:
    """Bend the bristles for a sample, under the torque of the one before."""
    if joint.presliding_friction.stiffness > 0.0:
        rate, angle = w[j, STATE + MOTOR_VELOCITY], w[j, STATE + LINK_ANGLE]
        budget = friction_budget(joint, rate, np.sign(rate), w[j, TORQUE], angle)
        at = Bent(rate, w[j, STATE + BRISTLE], 0.0, budget)
        w[j, STATE + BRISTLE] = bristle_after(joint.presliding_friction, at, dt)

"""
The registers in which all that moves stands: an array (n, REGISTERS), a row per joint.

A row holds the joint's state, the stages and slopes of the integration, and the torques of the
last slope taken. One array and not a dozen, because handing over many arrays costs more than the
physics itself.
"""

import numpy as np

from .effects.place import SLIDERS
from ..foundation.arrays import Array

# The state of one joint: shaft [rad, rad/s], link [rad, rad/s]; then what effects remember:
# torsion at which the elements of the hysteresis stand [rad], bristles [rad], torque of the
# current loop [N*m motor], in row 0 the base along its swing [m, m/s], the elements' stretches
# [rad].
MOTOR_ANGLE, MOTOR_VELOCITY, LINK_ANGLE, LINK_VELOCITY = range(4)
HYSTERESIS, BRISTLE, CURRENT, BASE_OFFSET, BASE_RATE, STRETCH = range(4, 10)
STATES = STRETCH + SLIDERS

# Registers: blocks of STATES first, then single ones.
STATE, STAGE, TRIAL, SLOPE_1, SLOPE_2, SLOPE_3, SLOPE_4 = range(0, 7 * STATES, STATES)
TIME = 7 * STATES       # in row 0: since the start of the recording [s]
(NOW,                   # in row 0: time of the stage [s]
 COMMAND,               # motor torque at the stage, shaft [N*m]
 FORCE,                 # on the tip at the stage, base frame: a component in each row [N, N*m]
 TORQUE,                # through the gear, output side [N*m]
 ) = range(TIME + 1, TIME + 5)

# Registers of a joint's two contacts, first the motor's, then that of the link bearing.
MODE = TORQUE + 1       # direction of sliding, 0 for sticking
DRIVE = MODE + 2        # what drives a contact, or what it must hold [N*m at its side]
BUDGET = DRIVE + 2      # most torque that it can oppose [N*m at its side]

GUESS = BUDGET + 2      # last torsion of the spring, its torque and its slope
COMMANDS = GUESS + 3    # commanded torque at the start, the middle and the end of a step [N*m]
FORCES = COMMANDS + 3   # on the tip likewise, a component in each row [N, N*m]
SENT = FORCES + 3       # the last commands, the newest first [N*m]
HISTORY = 66
PUSHED = SENT + HISTORY     # in row 0: link of a chain that is pushed at its end, 0 for the tip
REGISTERS = PUSHED + 1
AXES = 6                # of a wrench: force x, y, z and moment about them; a plane has two


def registers(state: Array, pushed: int = 0) -> Array:
    """
    Return registers for a state (n, STATES), with rows for each component on the tip.

    What acts on the tip acts on a link of a chain at its end instead where `pushed` is its number.
    """
    fresh = np.zeros((max(AXES, len(state)), REGISTERS))
    fresh[:len(state), STATE:STATE + STATES] = state
    fresh[0, PUSHED] = pushed
    fresh[:, MODE] = np.sign(fresh[:, STATE + MOTOR_VELOCITY])
    fresh[:, MODE + 1] = np.sign(fresh[:, STATE + LINK_VELOCITY])
    return fresh

"""
Torques of a motor that jump: a shaft that turns speeds up with them at once (eq:jump).

An acceleration by angles alone comes some samples late. Usual changes of a motor's torque go with
the load that they bear, and so does the estimate. A motor that goes from one limit to the other in
a sample moves itself first, for no gear's torque jumps.
"""

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.compiled import compiled
import numpy as np

from .fusion_memory import LONG, PRIOR, share, STEPPED, STEPS

# Choices unless stated otherwise.
_UNUSUAL = 4.0          # deviations of usual steps, beyond which a torque jumps


@compiled
def jump_of(memory: Array, step: float, dt: float) -> float:
    """Return what a step of a motor's torque after a time [s] is beyond usual ones [N*m]."""
    most, known = _UNUSUAL * np.sqrt(memory[STEPS]), memory[STEPPED] > PRIOR
    jump = step - min(max(step, -most), most) if known else 0.0
    memory[STEPPED] += dt
    part = max(share(dt, LONG), dt / memory[STEPPED])
    memory[STEPS] += part * ((step - jump) ** 2 - memory[STEPS])
    return jump

"""
Whole runs of an arm along a measured motion: the residuals of all joints at once.

Gears, bearings and a base alone need none (`parts.py`). A bearing on a base that gives way does,
for that lightens the links. So does a push on the tip that the base feels.
"""

from collections.abc import Iterator

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effect_loops import any_acts
from hda_arm_sim.model.effects.place import BRISTLES, LOOP, TIP
from hda_arm_sim.model.kernel import BASE_OFFSET, BASE_RATE, STATES
from hda_arm_sim.model.link_side import loaded_inertia
import numpy as np

from .base_motion import base_motion, gives_way
from .bearings import bearings_act
from .kernel_along import Driven, fill_along, MEASURED
from .parts import Parts
from ...measurements.measurement import Measurement
from ...measurements.running_clock import arm_during


def is_whole(arm: Arm) -> bool:
    """Return whether something acts by way of the base, so that no part is known alone."""
    return gives_way(arm) and (bearings_act(arm) or any_acts(arm.record().body, TIP))


def run_whole(measurement: Measurement, parts: Parts, arm: Arm) -> tuple[Array, Array]:
    """Return residuals (k, 2 n) and what effects remember (k, n, STATES - MEASURED)."""
    dt, (samples, joints) = measurement.dt, measurement.command.shape
    residual = np.empty((samples, 2 * joints))
    memory = np.zeros((samples, joints, STATES - MEASURED))
    for piece, driven in zip(measurement.pieces(), _driven(measurement, parts, arm)):
        record = arm_during(arm, piece, dt).record()
        fill_along(record, loaded_inertia(record.body), driven, dt, residual[piece], memory[piece])
    if measurement.led:
        residual[:, :joints] -= residual[:, joints:]
    return residual, memory


def remembered(measurement: Measurement, parts: Parts, arm: Arm) -> Array:
    """Return what effects remember (k, n, STATES - MEASURED): without such ones, the base."""
    if any_acts(arm.record().joints, LOOP, BRISTLES):
        return run_whole(measurement, parts, arm)[1]
    memory = np.zeros((*measurement.command.shape, STATES - MEASURED))
    motion = parts.motions.of(arm)
    for piece in measurement.pieces():
        base = base_motion(arm, motion.during(piece).links, measurement.dt)
        memory[piece, 0, BASE_OFFSET - MEASURED] = base[:, 0]
        memory[piece, 0, BASE_RATE - MEASURED] = base[:, 1]
    return memory


def _driven(measurement: Measurement, parts: Parts, arm: Arm) -> Iterator[Driven]:
    """Yield the motion of each recording, and what the arm has of the commands there."""
    motion = parts.motions.of(arm)
    command = np.stack([parts.command(arm, joint) for joint in range(len(arm.joints))], axis=1)
    for piece in measurement.pieces():
        moved = motion.during(piece)
        yield Driven(*moved, base_motion(arm, moved.links, measurement.dt), command[piece])

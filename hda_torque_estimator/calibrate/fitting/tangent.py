"""How a joint's torque changes with its torsion along a recording, for many changes at once."""

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.compiled import compiled, Record
from hda_arm_sim.model.effects.catalogue import sole_at
from hda_arm_sim.model.effects.place import LOOP, SLIDERS
from hda_arm_sim.model.kernel import loop_of, played_torsion
from hda_arm_sim.model.torsion import stiffness_at, torque_of_torsion
import numpy as np

_slid = sole_at(LOOP).law_after


@compiled
def tangents(joint: Record, elastic: Array, change: Array, slope: Array) -> None:
    """
    Fill the slopes (k, m) of the torque over changes (k, m) of the elastic torsion (k,).

    The spring answers by its stiffness, a friction element only while it does not slide. Damping
    is left out: it is small, and a descent needs slopes that are nearly right.
    """
    loop, law = loop_of(joint), joint.torsion
    stretch, moved = np.zeros(SLIDERS), np.zeros((SLIDERS, change.shape[1]))
    share = loop.level / (SLIDERS * loop.width)
    last = elastic[0]
    for k in range(elastic.shape[0]):
        spring = played_torsion(joint, elastic[k])
        torque = torque_of_torsion(law, joint.ratio, spring)
        stiffness = stiffness_at(law, joint.ratio, torque)
        for column in range(change.shape[1]):
            slope[k, column] = stiffness * change[k, column]
        if share == 0.0:
            continue
        for place in range(SLIDERS):
            free = stretch[place] + elastic[k] - last
            stretch[place] = _slid(loop, stretch[place], elastic[k] - last, place)
            for column in range(change.shape[1]):
                before = change[k - 1, column] if k > 0 else 0.0
                moved[place, column] += change[k, column] - before
                if stretch[place] != free:
                    moved[place, column] = 0.0
                slope[k, column] += share * moved[place, column]
        last = elastic[k]

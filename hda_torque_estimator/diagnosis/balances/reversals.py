"""
Whether friction builds up after a shaft has turned round.

Dry friction is not known at rest, so a motor balance does not hold near it. Where a shaft turns
round without a stop, friction that sets in at once leaves little, but for stops too short to be
seen. One that builds up over an angle leaves much there and nothing elsewhere. Where an arm has
bristles it does not stick, and its friction is known there as everywhere.
"""

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.chain_links import ChainLinks
from hda_arm_sim.model.effect_loops import where_acts
from hda_arm_sim.model.effects.place import BRISTLES
import numpy as np

from .balance import Balancer
from ...significance import IMMATERIAL, STANDS_OUT

# Numerics; choices unless stated otherwise.
_FEWEST = 25            # rows that suffice

# Power where a shaft turns round, over that of noise: even what is immaterial of it stands out.
# Short stops of 52 joints of healthy arms left 167 to 594, presliding 1109 and more.
_LOUD = STANDS_OUT / IMMATERIAL


def bristled(arm: Arm) -> tuple[int, ...]:
    """Return the places of the joints where bristles act, so that dry friction never sticks."""
    return where_acts(arm.record().joints, BRISTLES)


def turning_round(balancer: Balancer, arm: Arm, noise: Array) -> tuple[int, ...]:
    """Return the places of the joints whose friction builds up, by the balances of an arm."""
    joints, chain = range(len(arm.joints)), isinstance(arm.links, ChainLinks)
    known, wider = balancer(arm), balancer.valid_if_turning(arm, joints)
    found = []
    for joint in joints:
        usual = known.valid[:, joint]
        turns = wider[:, joint] & ~usual
        power = (known.residual[:, joint] / noise[joint]) ** 2
        if turns.sum() < _FEWEST or not usual.any():
            continue
        here = power[turns].mean()
        # A wrist that is light behind its gear stops shortly in many turns.
        broad = not chain or np.median(power[turns]) > STANDS_OUT * max(
            1.0, float(np.median(power[usual])))
        if broad and here > _LOUD and here > STANDS_OUT * power[usual].mean():
            found.append(joint)
    return tuple(found)

"""What the compiled step reads: settings and the arm."""

from typing import Any, NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import ArmRecord


class CompiledSettings(NamedTuple):
    """What the compiled step reads of the settings, and of all links together."""

    velocity_bandwidth: float
    observer_bandwidth: float
    singular_sine: float
    inertia_tolerance: float
    links: float
    torsion_bandwidth: float
    fusion: float
    window: float
    span: float
    following: float
    contact_deviations: float
    collision_torque: float
    links_known: Array          # (n, 3) how well the links of a chain are, `chain.own_doubts`


class Model(NamedTuple):
    """What is believed of an arm, and how it is to be estimated."""

    record: ArmRecord
    settings: CompiledSettings
    inertia: Any                # Inertia or Chain of the links, with a payload that is known

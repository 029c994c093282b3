"""The numbers that a recorder can be given."""

from dataclasses import dataclass
from typing import ClassVar

from hda_arm_sim.foundation.parameter import Declared, parameter


@dataclass(frozen=True)
class RecorderSettings(Declared):
    """When a bag goes on in another file, and what is held until it is asked for."""

    name: ClassVar[str] = 'bag_recorder'
    split_size: float = parameter(0.0, 'MB', 0.0, 1e6, 'size of a file of the bag, 0 for one file')
    split_time: float = parameter(0.0, 's', 0.0, 1e9, 'time in a file of the bag, 0 for one file')
    snapshot_time: float = parameter(
        0.0, 's', 0.0, 3600.0, 'time that is held in memory for a snapshot, 0 writes everything')

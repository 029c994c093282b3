"""The numbers that a player can be given."""

from dataclasses import dataclass
from typing import ClassVar

from hda_arm_sim.foundation.parameter import Declared, parameter


@dataclass(frozen=True)
class RateSettings(Declared):
    """How fast time goes by; it may change while a bag is played."""

    name: ClassVar[str] = 'bag_player'
    rate: float = parameter(1.0, '', 0.01, 100.0, 'time of the bag per real time')


@dataclass(frozen=True)
class PlaySettings(Declared):
    """What is played, and when it begins."""

    name: ClassVar[str] = 'bag_player'
    start_offset: float = parameter(0.0, 's', 0.0, 1e9, 'time of the bag to leave out at first')
    duration: float = parameter(1e9, 's', 0.0, 1e9, 'time of the bag to play')
    clock_rate: float = parameter(100.0, 'Hz', 0.0, 1e3, 'messages on /clock, 0 for none')
    settle_time: float = parameter(
        1.0, 's', 0.0, 60.0, 'time without a new subscriber before the first message')
    wait_time: float = parameter(
        1e9, 's', 0.0, 1e9, 'longest wait for subscribers before giving up')

"""The momentum observer of one joint: what acts on a link from outside, (eq:observer)."""

from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.compiled import inlined

from .compiled_settings import CompiledSettings
from .layout import (
    ACCELERATION, EXTERNAL, LAST_MOMENTUM, LAST_SPEED, LATE, LATE_RATE, OBSERVED, QUICK_LINK)
from .low_pass import share_of


class LowPassShares(NamedTuple):
    """What low-passes take of a sample; the first one is taken whole for the expected rate."""

    observer: float
    quick: float
    dt: float                   # since the last sample, 0 starts afresh [s]


@inlined
def shares_of(settings: CompiledSettings, dt: float) -> LowPassShares:
    """Return the shares of a sample dt after the last one [s]."""
    return LowPassShares(share_of(settings.observer_bandwidth, dt) if dt > 0.0 else 0.0,
                         share_of(settings.torsion_bandwidth, dt) if dt > 0.0 else 1.0, dt)


@inlined
def observe(memory: Array, now: float, rate: float, share: LowPassShares) -> None:
    """Let a joint's observer hear of a momentum and of the rate without what acts outside."""
    if share.dt > 0.0:
        change = (now - memory[LAST_MOMENTUM]) / share.dt
        ahead = change - memory[LATE_RATE] - memory[EXTERNAL]
        memory[EXTERNAL] += share.observer * ahead
        memory[LATE] += share.observer * (ahead - memory[LATE])
        speeding = (memory[QUICK_LINK] - memory[LAST_SPEED]) / share.dt
        memory[ACCELERATION] += share.observer * (speeding - memory[ACCELERATION])
    memory[LAST_MOMENTUM] = now
    memory[LATE_RATE] += share.quick * (rate - memory[LATE_RATE])
    memory[LAST_SPEED] = memory[QUICK_LINK]


@inlined
def observed_variance(memory: Array, deviation: float, share: LowPassShares) -> float:
    """
    Return the variance of the torques that an observer holds, of this deviation now [N^2*m^2].

    Once a torque is better known the observer still holds those of before.
    """
    part = share.observer if share.dt > 0.0 else 1.0
    memory[OBSERVED] += part * (deviation * deviation - memory[OBSERVED])
    return max(memory[OBSERVED], deviation * deviation)

"""Other forms of waves: another phase, other orders, and once a turn what is off its centre."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from hda_arm_sim.model.effects import MotorCogging, TorqueRipple
from hda_arm_sim.model.effects.effect import Effect
import numpy as np

from ...least_squares.bounds import bounded

ORDERS = 'orders'       # of a wave that has its own order and twice that: all others
ONCE = 'once_a_turn'    # of a ripple: what is off its centre makes one as well
PHASES = (0.0, 0.5 * np.pi)     # of a wave, that make one of any phase [rad]


def wave(effect: Effect, phase: float, order: float) -> Effect:
    """Return a law of waves with another phase and order, the nearest one that it may have."""
    numbers: dict[str, Any] = {'phase': phase, **bounded(type(effect), {'order': order})}
    return replace(effect, **numbers)


def other_orders(effect: Effect) -> Iterator[Effect]:
    """Yield a law of a wave and of one twice as often with the other whole orders it may have."""
    own = effect.order      # type: ignore[attr-defined]
    last = bounded(type(effect), {'order': np.inf})['order']
    for order in np.arange(1.0, last + 1.0):
        if order not in (own, 2.0 * own):
            yield from (wave(effect, phase, order) for phase in PHASES)


def once_a_turn(ripple: TorqueRipple) -> Iterator[Effect]:
    """Yield a torque as large as a ripple that comes once a turn of the motor."""
    size = float(np.hypot(ripple.amplitude_2, ripple.amplitude_4))
    yield from (MotorCogging(amplitude=size, order=1.0, phase=phase) for phase in PHASES)

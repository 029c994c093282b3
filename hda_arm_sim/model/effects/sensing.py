"""What the encoders add: when they look, how they err and in which steps (model.md, 20-21)."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from .effect import Effect, Site
from ..compiled import compiled
from ..parameter import parameter


@compiled
def sampled_late(angle, velocity, acceleration, skew):              # type: ignore[no-untyped-def]
    """Return the angle that an encoder shows when read `skew` after the stamp, (20) [rad]."""
    return angle + skew * (velocity + 0.5 * skew * acceleration)


@compiled
def quantised(angle, step):                                         # type: ignore[no-untyped-def]
    """Return the angle in whole steps, (21); a step of zero is a perfect encoder [rad]."""
    return np.floor(angle / step + 0.5) * step if step > 0.0 else angle + 0.0


@dataclass(frozen=True)
class ClockSkew(Effect):
    """Link encoder read later (positive) or earlier than the motor encoder, (20)."""

    name: ClassVar[str] = 'clock_skew'
    cause: ClassVar[str] = 'link and motor encoders are sampled at different times'
    site: ClassVar[Site] = Site.TIMING
    law = staticmethod(sampled_late)
    skew: float = parameter(0.0, 's', -0.1, 0.1, 'link sampled after the motor by this time')


@dataclass(frozen=True)
class CoarseQuantisation(Effect):
    """Encoder step of one side, (21); zero is a perfect encoder."""

    name: ClassVar[str] = 'coarse_quantisation'
    cause: ClassVar[str] = 'an encoder counts in larger steps than stated'
    site: ClassVar[Site] = Site.SENSING
    law = staticmethod(quantised)
    motor_step: float = parameter(0.0, 'rad', 0.0, 0.1, 'step of the motor encoder, shaft')
    link_step: float = parameter(0.0, 'rad', 0.0, 0.1, 'step of the link encoder')

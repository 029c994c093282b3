"""When the encoders are read, and what of it arrives (docs/model.md, 78-79)."""

from dataclasses import dataclass
from typing import ClassVar

from .effect import Effect, Scope, Site
from ..compiled import compiled
from ..parameter import parameter


@compiled
def sampled_late(angle, velocity, acceleration, skew):              # type: ignore[no-untyped-def]
    """Return the angle that an encoder shows when read `skew` after the stamp, (78) [rad]."""
    return angle + skew * (velocity + 0.5 * skew * acceleration)


@compiled
def lost(chance, rate):                                             # type: ignore[no-untyped-def]
    """Tell whether a sample is lost, for a chance drawn evenly from [0, 1), (79)."""
    return chance < rate


@dataclass(frozen=True)
class ClockSkew(Effect):
    """Link encoder read later (positive) or earlier than the motor encoder, (78)."""

    name: ClassVar[str] = 'clock_skew'
    cause: ClassVar[str] = 'link and motor encoders are sampled at different times'
    site: ClassVar[Site] = Site.TIMING
    law = staticmethod(sampled_late)
    skew: float = parameter(0.0, 's', -0.1, 0.1, 'link sampled after the motor by this time')


@dataclass(frozen=True)
class DroppedSamples(Effect):
    """Samples that are lost on their way; the one before is shown again in their place, (79)."""

    name: ClassVar[str] = 'dropped_samples'
    cause: ClassVar[str] = 'samples are lost, and the one before is shown again'
    site: ClassVar[Site] = Site.TIMING
    scope: ClassVar[Scope] = Scope.ARM
    law = staticmethod(lost)
    rate: float = parameter(0.0, '', 0.0, 0.5, 'share of the samples that are lost')

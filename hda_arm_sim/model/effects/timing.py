"""When encoders are read, what arrives, how it is stamped (docs/model.md, eq:skew, dropped)."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from .effect import Effect, KnownBy, Scope, Site
from .hypothesis import Hypothesis, Typical, Unmeasured
from .place import CLOCK, Place, SAMPLE, Sent, Signal, STAMP, Stamped, Triggered
from .words import Words
from ...foundation.compiled import compiled, Record
from ...foundation.parameter import parameter


@compiled
def skewed(own: Record, at: Triggered) -> Signal:
    """Return how much later than the motor encoder that of the link is read, (eq:skew) [s]."""
    return own.skew


@compiled
def lost(own: Record, at: Sent) -> bool:
    """Return whether a sample is lost, for a chance drawn evenly from [0, 1), (eq:dropped)."""
    return at.chance < own.rate


@compiled
def waited(own: Record, at: Stamped) -> Signal:
    """Return how late a sample is stamped, for a chance from [0, 1), (eq:clock-jitter) [s]."""
    return -own.jitter * np.log1p(-at.chance)


@dataclass(frozen=True)
class ClockSkew(Effect):
    """Link encoder read later (positive) or earlier than the motor encoder, (eq:skew)."""

    name: ClassVar[str] = 'clock_skew'
    cause: ClassVar[str] = 'link and motor encoders are sampled at different times'
    site: ClassVar[Site] = Site.TIMING
    place: ClassVar[Place] = CLOCK
    stated: ClassVar[Mapping[str, str]] = {'skew': 'skew'}
    law = staticmethod(skewed)
    hypothesis: ClassVar[Hypothesis | None] = Hypothesis(
        varies=('time',), free={'skew': 5e-05}, alike=('torsional_hysteresis',),
        experiment='two constant speeds both ways')
    typical: ClassVar[Typical | None] = Typical({'skew': 0.00015})
    unmeasured: ClassVar[Unmeasured | None] = Unmeasured({'skew': 5e-4})    # half a bus cycle
    known_by: ClassVar[KnownBy | None] = KnownBy(
        'clock_skew', ('skew',),
        'the encoders are read {size:.1e} s further apart')
    words: ClassVar[Words] = Words(
        'has a link encoder that is read {size} after its motor encoder', 'link_encoder',
        'Check the time stamps of the drive: trigger both encoders from one clock.', ('skew',),
        less='has a link encoder that is read {size} before its motor encoder')
    skew: float = parameter(0.0, 's', -0.1, 0.1, 'link sampled after the motor by this time')


@dataclass(frozen=True)
class DroppedSamples(Effect):
    """Samples that are lost on their way; the one before is shown again, (eq:dropped)."""

    name: ClassVar[str] = 'dropped_samples'
    cause: ClassVar[str] = 'samples are lost, and the one before is shown again'
    site: ClassVar[Site] = Site.TIMING
    place: ClassVar[Place] = SAMPLE
    acts: ClassVar[tuple[str, ...]] = ('rate',)
    scope: ClassVar[Scope] = Scope.ARM
    law = staticmethod(lost)
    words: ClassVar[Words] = Words(
        'loses {size} of its samples', 'drive',
        'Check bus load, cable and the queue of the recorder.', ('rate',))
    rate: float = parameter(0.0, '', 0.0, 0.5, 'share of the samples that are lost')


@dataclass(frozen=True)
class ClockJitter(Effect):
    """Stamps that do not say when a sample was taken: late by chance, (eq:clock-jitter)."""

    name: ClassVar[str] = 'clock_jitter'
    cause: ClassVar[str] = 'stamps do not say when a sample was taken'
    site: ClassVar[Site] = Site.TIMING
    place: ClassVar[Place] = STAMP
    acts: ClassVar[tuple[str, ...]] = ('jitter',)
    scope: ClassVar[Scope] = Scope.ARM
    law = staticmethod(waited)
    words: ClassVar[Words] = Words(
        'stamps its samples with a jitter of {size}', 'drive',
        'Stamp samples where they are taken, in the drive or a real-time process, not in the '
        'recorder.', ('jitter',))
    jitter: float = parameter(
        0.0, 's', 0.0, 0.01, 'standard deviation of the time from sampling to stamp')

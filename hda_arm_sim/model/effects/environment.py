"""What acts on the arm from outside (docs/model.md#effects)."""

from collections.abc import Mapping
from dataclasses import dataclass
import math
from typing import ClassVar

import numpy as np

from .effect import Effect, Scope, Site
from .hypothesis import Hypothesis, SearchStart, Typical
from .place import BASE, Place, Signal, Swung, TIP, Touched, Weighed, WEIGHT
from .words import Words
from ...foundation.compiled import compiled, Record
from ...foundation.parameter import parameter

EDGE = 0.1              # share of a contact in which its force rises, and in which it falls


@compiled
def downhill_pull(own: Record, at: Weighed) -> tuple[Signal, Signal]:
    """Return gravity in the plane of a tilted base, x and y in base, (eq:base-tilt) [m/s^2]."""
    pull = at.gravity * np.sin(own.tilt)
    return pull * np.cos(own.direction), pull * np.sin(own.direction)


@compiled
def _contact(own: Record, at: Touched) -> Signal:
    """Return the size of the force of a contact [N]."""
    left = own.onset + own.duration - at.time
    ramp = np.minimum(at.time - own.onset, left) / (EDGE * own.duration)
    edge = np.minimum(np.maximum(ramp, 0.0), 1.0)
    return own.force * edge * edge * (3.0 - 2.0 * edge)


@compiled
def contact_force(own: Record, at: Touched) -> tuple[Signal, Signal]:
    """Return the force of a contact on the tip, x and y in the base frame, (eq:contact) [N]."""
    size = _contact(own, at)
    return size * np.cos(own.direction), size * np.sin(own.direction)


@compiled
def contact_in_space(own: Record, at: Touched) -> tuple[Signal, Signal, Signal]:
    """Return the force of a contact on the tip of a chain, x, y and z, (eq:contact) [N]."""
    size = _contact(own, at)
    level = size * np.cos(own.elevation)
    return (level * np.cos(own.direction), level * np.sin(own.direction),
            size * np.sin(own.elevation))


@compiled
def base_acceleration(own: Record, at: Swung) -> Signal:
    """Return the acceleration of a base beneath joints at rest, (eq:base-motion) [m/s^2]."""
    pace = 2.0 * np.pi * own.frequency
    return own.amplitude * at.push - pace * (2.0 * own.damping * at.offset_rate
                                             + pace * at.offset)


@dataclass(frozen=True)
class BaseTilt(Effect):
    """A base that is not level, so that gravity acts in the plane of motion, (eq:base-tilt)."""

    name: ClassVar[str] = 'base_tilt'
    cause: ClassVar[str] = 'the base is not level, so gravity moves the links'
    site: ClassVar[Site] = Site.LINK
    place: ClassVar[Place] = WEIGHT
    scope: ClassVar[Scope] = Scope.ARM
    stated: ClassVar[Mapping[str, str]] = {'tilt': 'tilt', 'direction': 'direction'}
    law = staticmethod(downhill_pull)
    hypothesis: ClassVar[Hypothesis | None] = Hypothesis(
        varies=('time',),
        waves={('tilt', 'direction'): 0.005}, alike=('cable_spring',),
        experiment='hold postures all round the base')
    typical: ClassVar[Typical | None] = Typical({'tilt': 0.03}, {'direction': 0.7})
    words: ClassVar[Words] = Words(
        'stands on a base that is tilted by {size}', 'base', 'Put a spirit level on the base.',
        ('tilt',))
    tilt: float = parameter(0.0, 'rad', 0.0, math.pi / 2, 'angle between base and horizontal')
    direction: float = parameter(0.0, 'rad', -7.0, 7.0, 'downhill direction in the base frame')


@dataclass(frozen=True)
class ExternalContact(Effect):
    """A force on the tip for some time, with soft edges, (eq:contact)."""

    name: ClassVar[str] = 'external_contact'
    cause: ClassVar[str] = 'something touches the tip for some time'
    site: ClassVar[Site] = Site.LINK
    place: ClassVar[Place] = TIP
    acts: ClassVar[tuple[str, ...]] = ('force',)
    spatial: ClassVar[tuple[str, ...]] = ('elevation',)
    scope: ClassVar[Scope] = Scope.ARM
    law = staticmethod(contact_force)
    law_chain = staticmethod(contact_in_space)
    # (source: pushes have any course, and there may be four alike)
    hypothesis: ClassVar[Hypothesis | None] = Hypothesis(
        varies=('push',), reach=3.0,
        free={'force': 1.0, 'direction': 0.02, 'onset': 0.01, 'duration': 0.01},
        in_space={'elevation': 0.02},
        alike=('payload',), form_share=0.08, form_error=0.03, passing=True,
        start=SearchStart.TOUCH,
        doubts={'force': (0.5, 'force'), 'direction': (0.03, ''), 'onset': (0.045, 'duration'),
                'duration': (0.09, 'duration')},    # edges may be a fifth, a peak twice the mean
        experiment='the same motion again, with nothing near the arm')
    typical: ClassVar[Typical | None] = Typical(
        {'force': 20.0},
        {'direction': 0.7, 'onset': 6.0, 'duration': 1.0})
    words: ClassVar[Words] = Words(
        'was touched at the tip with {size}', 'tip',
        'Look what the arm met there; keep its space free.', ('force',))
    force: float = parameter(0.0, 'N', 0.0, 1e4, 'largest force on the tip')
    direction: float = parameter(0.0, 'rad', -7.0, 7.0, 'of the force, in the base frame')
    onset: float = parameter(0.0, 's', -1e6, 1e6, 'begin, from the start of the recording')
    duration: float = parameter(1.0, 's', 1e-2, 1e6, 'from begin to end, edges included')
    elevation: float = parameter(0.0, 'rad', -1.6, 1.6, 'of the force on a chain, above x and y')


@dataclass(frozen=True)
class BaseVibration(Effect):
    """A structural mode of the base, driven by the links, (eq:base-motion, base-load)."""

    name: ClassVar[str] = 'base_vibration'
    cause: ClassVar[str] = 'a structural mode of the base swings with the arm'
    site: ClassVar[Site] = Site.LINK
    place: ClassVar[Place] = BASE
    acts: ClassVar[tuple[str, ...]] = ('amplitude',)
    scope: ClassVar[Scope] = Scope.ARM
    law = staticmethod(base_acceleration)
    hypothesis: ClassVar[Hypothesis | None] = Hypothesis(
        free={'amplitude': 0.002, 'frequency': 0.05, 'damping': 0.005, 'direction': 0.05},
        alike=('kinematic_error',), start=SearchStart.SWING,
        experiment='sudden stops at several postures')
    typical: ClassVar[Typical | None] = Typical(
        {'damping': 0.04, 'amplitude': 0.025},
        {'frequency': 11.0, 'direction': 0.7})
    words: ClassVar[Words] = Words(
        'stands on a base that swings at {frequency} Hz', 'base',
        'Tighten the feet of the base, or stiffen its stand.')
    frequency: float = parameter(10.0, 'Hz', 0.5, 200.0, 'of the mode with the joints locked')
    damping: float = parameter(0.02, '', 0.0, 5.0, 'damping ratio of the mode')
    amplitude: float = parameter(
        0.0, '1/kg', 0.0, 1.0, 'acceleration per force: inverse of the modal mass, 0 if rigid')
    direction: float = parameter(0.0, 'rad', -7.0, 7.0, 'of the swing, in the base frame')

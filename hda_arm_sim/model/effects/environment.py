"""What acts on the arm from outside (docs/model.md, 85-88)."""

from dataclasses import dataclass
import math
from typing import ClassVar

import numpy as np

from .effect import Effect, Scope, Site
from ..compiled import compiled
from ..parameter import parameter

EDGE = 0.1              # share of a contact in which its force rises, and in which it falls


@compiled
def downhill_pull(gravity, tilt, direction):                        # type: ignore[no-untyped-def]
    """Return the part of gravity in the plane of a tilted base, x and y in base, (85) [m/s^2]."""
    return gravity * np.sin(tilt) * np.cos(direction), gravity * np.sin(tilt) * np.sin(direction)


@compiled
def contact_force(time, force, direction, onset, duration):         # type: ignore[no-untyped-def]
    """Return the force of a contact on the tip, x and y in the base frame, (86) [N]."""
    ramp = np.minimum(time - onset, onset + duration - time) / (EDGE * duration)
    edge = np.minimum(np.maximum(ramp, 0.0), 1.0)
    size = force * edge * edge * (3.0 - 2.0 * edge)
    return size * np.cos(direction), size * np.sin(direction)


@compiled
def base_acceleration(                                              # type: ignore[no-untyped-def]
        push, offset, offset_rate, frequency, damping, amplitude):
    """Return the acceleration of a base that joints at rest leave to itself, (87) [m/s^2]."""
    pace = 2.0 * np.pi * frequency
    return amplitude * push - pace * (2.0 * damping * offset_rate + pace * offset)


@dataclass(frozen=True)
class BaseTilt(Effect):
    """A base that is not level, so that gravity acts in the plane of motion, (85)."""

    name: ClassVar[str] = 'base_tilt'
    cause: ClassVar[str] = 'the base is not level, so gravity moves the links'
    site: ClassVar[Site] = Site.LINK
    scope: ClassVar[Scope] = Scope.ARM
    law = staticmethod(downhill_pull)
    tilt: float = parameter(0.0, 'rad', 0.0, math.pi / 2, 'angle between base and horizontal')
    direction: float = parameter(0.0, 'rad', -7.0, 7.0, 'downhill direction in the base frame')


@dataclass(frozen=True)
class ExternalContact(Effect):
    """A force on the tip for some time, with soft edges, (86)."""

    name: ClassVar[str] = 'external_contact'
    cause: ClassVar[str] = 'something touches the tip for some time'
    site: ClassVar[Site] = Site.LINK
    scope: ClassVar[Scope] = Scope.ARM
    law = staticmethod(contact_force)
    force: float = parameter(0.0, 'N', 0.0, 1e4, 'largest force on the tip')
    direction: float = parameter(0.0, 'rad', -7.0, 7.0, 'of the force, in the base frame')
    onset: float = parameter(0.0, 's', -1e6, 1e6, 'begin, from the start of the recording')
    duration: float = parameter(1.0, 's', 1e-2, 1e6, 'from begin to end, edges included')


@dataclass(frozen=True)
class BaseVibration(Effect):
    """A structural mode of the base, driven by the reaction of the links, (87-88)."""

    name: ClassVar[str] = 'base_vibration'
    cause: ClassVar[str] = 'a structural mode of the base swings with the arm'
    site: ClassVar[Site] = Site.LINK
    scope: ClassVar[Scope] = Scope.ARM
    law = staticmethod(base_acceleration)
    frequency: float = parameter(10.0, 'Hz', 0.5, 200.0, 'of the mode with the joints locked')
    damping: float = parameter(0.02, '', 0.0, 1.0, 'damping ratio of the mode')
    amplitude: float = parameter(
        0.0, '1/kg', 0.0, 1.0, 'acceleration per force: inverse of the modal mass, 0 if rigid')
    direction: float = parameter(0.0, 'rad', -7.0, 7.0, 'of the swing, in the base frame')

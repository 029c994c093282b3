"""What the links carry (docs/model.md, 22)."""

from dataclasses import dataclass
from typing import ClassVar

from .effect import Effect, Scope, Site
from ..compiled import compiled
from ..parameter import parameter
from ..rigid import Inertia


@compiled
def loaded(inertia, length1, length2, mass):                        # type: ignore[no-untyped-def]
    """Return the inertia of links that carry a point mass at the tip, (22)."""
    far = mass * length2 * length2
    return Inertia(inertia.p1 + mass * length1 * length1 + far, inertia.p2 + far,
                   inertia.p3 + mass * length1 * length2,
                   inertia.first + mass * length1, inertia.second + mass * length2,
                   inertia.coupled)


@dataclass(frozen=True)
class Payload(Effect):
    """An unmodelled point mass at the tip, (22)."""

    name: ClassVar[str] = 'payload'
    cause: ClassVar[str] = 'an unmodelled mass is fixed to the tip'
    site: ClassVar[Site] = Site.LINK
    scope: ClassVar[Scope] = Scope.ARM
    law = staticmethod(loaded)
    mass: float = parameter(0.0, 'kg', 0.0, 100.0, 'mass at the tip')

"""What the links carry, and what holds or hampers them (docs/model.md, 80-84)."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from .effect import Effect, Scope, Site
from ..compiled import compiled
from ..parameter import parameter
from ..rigid import Inertia


@compiled
def loaded(inertia, length1, length2, mass):                        # type: ignore[no-untyped-def]
    """Return the inertia of links that carry a point mass at the tip, (81)."""
    far = mass * length2 * length2
    return Inertia(inertia.p1 + mass * length1 * length1 + far, inertia.p2 + far,
                   inertia.p3 + mass * length1 * length2,
                   inertia.first + mass * length1, inertia.second + mass * length2,
                   inertia.coupled)


@compiled
def heavier(nominal, error):                                        # type: ignore[no-untyped-def]
    """Return the inertia of the links about one joint, (82) [kg*m^2]."""
    return nominal * (1.0 + error)


@compiled
def coupling(nominal, share):                                       # type: ignore[no-untyped-def]
    """Return how far the links feel each other, 0 to 1, (83)."""
    return np.minimum(np.maximum(nominal + share, 0.0), 1.0)


@compiled
def bearing_budget(level):                                          # type: ignore[no-untyped-def]
    """Return the most torque that the link bearing can oppose, (80) [N*m at the output]."""
    return level


@compiled
def cable_torque(link_angle, stiffness, rest_angle):                # type: ignore[no-untyped-def]
    """Return the torque of a cable on the link, (84) [N*m at the output]."""
    return stiffness * (rest_angle - link_angle)


@dataclass(frozen=True)
class Payload(Effect):
    """An unmodelled point mass at the tip, (81)."""

    name: ClassVar[str] = 'payload'
    cause: ClassVar[str] = 'an unmodelled mass is fixed to the tip'
    site: ClassVar[Site] = Site.LINK
    scope: ClassVar[Scope] = Scope.ARM
    law = staticmethod(loaded)
    mass: float = parameter(0.0, 'kg', 0.0, 100.0, 'mass at the tip')


@dataclass(frozen=True)
class LinkInertiaError(Effect):
    """Inertia about one joint differs, p1 or p2; the mass moments and p3 stay, (82)."""

    name: ClassVar[str] = 'link_inertia_error'
    cause: ClassVar[str] = 'the inertia of the link about its joint differs'
    site: ClassVar[Site] = Site.LINK
    law = staticmethod(heavier)
    error: float = parameter(
        0.0, '', -0.9, 5.0, 'relative error of p1 (first joint) or p2 (second joint)')


@dataclass(frozen=True)
class InertialCoupling(Effect):
    """Links that feel each other where the arm is given decoupled, or the reverse, (83)."""

    name: ClassVar[str] = 'inertial_coupling'
    cause: ClassVar[str] = 'the links feel each other: M(q) and C(q, dq) instead of constants'
    site: ClassVar[Site] = Site.LINK
    scope: ClassVar[Scope] = Scope.ARM
    law = staticmethod(coupling)
    share: float = parameter(
        0.0, '', -1.0, 1.0, '1 couples links that are given decoupled, -1 the other way round')


@dataclass(frozen=True)
class LinkBearingFriction(Effect):
    """Dry friction of the link bearing, between this link and the one before it, (80)."""

    name: ClassVar[str] = 'link_bearing_friction'
    cause: ClassVar[str] = 'dry friction of the link bearing'
    site: ClassVar[Site] = Site.LINK
    law = staticmethod(bearing_budget)
    level: float = parameter(0.0, 'N*m', 0.0, 50.0, 'dry friction level, output side')


@dataclass(frozen=True)
class CableSpring(Effect):
    """A cable or hose that pulls the joint to a rest angle, (84)."""

    name: ClassVar[str] = 'cable_spring'
    cause: ClassVar[str] = 'a cable or hose pulls the joint like a spring'
    site: ClassVar[Site] = Site.LINK
    law = staticmethod(cable_torque)
    stiffness: float = parameter(0.0, 'N*m/rad', 0.0, 1e3, 'of the cable, output side')
    rest_angle: float = parameter(0.0, 'rad', -10.0, 10.0, 'link angle without pull')

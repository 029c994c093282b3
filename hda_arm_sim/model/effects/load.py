"""What the links carry, and what holds or hampers them (docs/model.md#effects)."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from .effect import Effect, Scope, Site
from .hypothesis import Hypothesis, NO_OTHER_FORM, SCALE, Typical
from .place import (BEARING, Carried, COUPLING, LINK_INERTIA, LINK_TORQUE, LOAD, Place, Pulled,
                    Signal, Stated)
from .words import Words
from ...foundation.arrays import Array
from ...foundation.chain import INERTIA, MASS, MOMENT, OFFSET, ROTATION
from ...foundation.compiled import compiled, Record
from ...foundation.parameter import parameter
from ...foundation.rigid import Inertia
from ...foundation.vectors import plus, put, rotated, rotation, times, vector


@compiled
def loaded(own: Record, at: Carried) -> Inertia:
    """Return the inertia of links that carry a body at the tip, (eq:payload)."""
    bare, far = at.inertia, at.length2 + own.x
    about = own.mass * far * far + own.mass * own.radius * own.radius
    return Inertia(bare.p1 + own.mass * at.length1 * at.length1 + about, bare.p2 + about,
                   bare.p3 + own.mass * at.length1 * far,
                   bare.first + own.mass * at.length1, bare.second + own.mass * far,
                   bare.coupled)


@compiled
def loaded_tip(own: Record, table: Array) -> Array:
    """Return a chain (foundation.chain) whose last link carries a body, (eq:payload-chain)."""
    last = table.shape[0] - 2
    x, y, z = plus(vector(table, last + 1, OFFSET), rotated(
        rotation(table, last + 1, ROTATION), (own.x, own.y, own.z)))
    around = own.radius * own.radius
    table[last, MASS] += own.mass
    put(table, last, MOMENT, plus(vector(table, last, MOMENT), times(own.mass, (x, y, z))))
    put(table, last, INERTIA, plus(vector(table, last, INERTIA), times(
        own.mass, (y * y + z * z + around, x * x + z * z + around, x * x + y * y + around))))
    put(table, last, INERTIA + 3, plus(vector(table, last, INERTIA + 3), times(
        -own.mass, (x * y, x * z, y * z))))
    return table


@compiled
def heavier(own: Record, at: Stated) -> Signal:
    """Return the inertia of the links about one joint, (eq:link-inertia) [kg*m^2]."""
    return at.nominal * (1.0 + own.error)


@compiled
def coupling(own: Record, at: Stated) -> Signal:
    """Return how far the links feel each other, 0 to 1, (eq:coupling)."""
    return np.minimum(np.maximum(at.nominal + own.share, 0.0), 1.0)


@compiled
def bearing_budget(own: Record, at: Pulled) -> Signal:
    """Return the most torque that a link bearing opposes, (eq:bearing) [N*m at the output]."""
    return own.level


@compiled
def cable_torque(own: Record, at: Pulled) -> Signal:
    """Return the torque of a cable on the link, (eq:cable) [N*m at the output]."""
    return own.stiffness * (own.rest_angle - at.link_angle)


@compiled
def cable_energy(own: Record, at: Pulled) -> Signal:
    """Return the energy in a cable, whose torque is its slope, (eq:cable) [J]."""
    return 0.5 * own.stiffness * (at.link_angle - own.rest_angle) ** 2


def _length(links: Any) -> float:
    """Return how long the last link is, of a chain its forearm (choice: half its reach) [m]."""
    return float(links.last_length)


def _half(links: Any) -> float:
    """Return half of that: a mass beyond is nearer to a joint, or far from the tip [m]."""
    return 0.5 * _length(links)


@dataclass(frozen=True)
class Payload(Effect):
    """An unmodelled mass at the tip, a point or a body, (eq:payload, payload-chain)."""

    name: ClassVar[str] = 'payload'
    cause: ClassVar[str] = 'an unmodelled mass is fixed to the tip'
    site: ClassVar[Site] = Site.LINK
    place: ClassVar[Place] = LOAD
    scope: ClassVar[Scope] = Scope.ARM
    acts: ClassVar[tuple[str, ...]] = ('mass',)
    spatial: ClassVar[tuple[str, ...]] = ('y', 'z')
    law = staticmethod(loaded)
    law_chain = staticmethod(loaded_tip)
    tolerance: ClassVar[tuple[str, str] | None] = ('mass', 'carried_load')
    # (measured: a right payload left 12 to 31 of score, one that stood for an inertia 256 or more)
    hypothesis: ClassVar[Hypothesis | None] = Hypothesis(
        free={'mass': 0.5}, more=('x', 'y', 'z', 'radius'),
        within={'x': _half, 'y': _half, 'z': _half, 'radius': _length},
        alike=('link_inertia_error',), form=2.0 * NO_OTHER_FORM, form_share=0.002,
        experiment=SCALE)
    typical: ClassVar[Typical | None] = Typical({'mass': 1.0})
    words: ClassVar[Words] = Words(
        'carries {size} more at its tip', 'tip', 'Look what is mounted at the tip, and weigh it.',
        ('mass',), less='carries {size} less at its tip', beside=(
            ('x', 'its centre {size} along x'), ('y', 'its centre {size} along y'),
            ('z', 'its centre {size} along z'), ('radius', 'a radius of gyration of {size}')))
    mass: float = parameter(0.0, 'kg', 0.0, 100.0, 'mass at the tip')
    x: float = parameter(0.0, 'm', -1.0, 1.0, 'of its centre, along x of the tip')
    y: float = parameter(0.0, 'm', -1.0, 1.0, 'likewise, of a chain')
    z: float = parameter(0.0, 'm', -1.0, 1.0, 'likewise')
    radius: float = parameter(0.0, 'm', 0.0, 1.0, 'of gyration about its centre, any axis alike')


@dataclass(frozen=True)
class LinkInertiaError(Effect):
    """
    Inertia about one joint differs, mass and mass moments stay, (eq:link-inertia).

    That is p1 or p2 of two links (p3 stays), and of a chain that of the joint's own link. Mass
    may differ too, with all moments, and of a chain the centre, (eq:link-mass).
    """

    name: ClassVar[str] = 'link_inertia_error'
    cause: ClassVar[str] = 'the inertia of the link about its joint differs'
    site: ClassVar[Site] = Site.LINK
    place: ClassVar[Place] = LINK_INERTIA
    spatial: ClassVar[tuple[str, ...]] = ('centre_x', 'centre_y', 'centre_z')
    law = staticmethod(heavier)
    hypothesis: ClassVar[Hypothesis | None] = Hypothesis(
        free={'error': 0.05}, instead={'mass': 0.05}, alike=('payload', 'stiffness_error'),
        experiment='accelerate at several elbow angles')
    typical: ClassVar[Typical | None] = Typical({'error': 0.1})
    words: ClassVar[Words] = Words(
        'has a link with {size} more mass or inertia than stated', 'link',
        'Compare the link with its drawing: tool, cover or cable that the file does not know.',
        ('error', 'mass'), less='has a link with {size} less mass or inertia than stated')
    error: float = parameter(
        0.0, '', -0.9, 5.0,
        'relative error of p1 (first joint) or p2 (second joint); of a chain, of the own link')
    mass: float = parameter(
        0.0, '', -0.9, 5.0, 'relative error of mass, moment and inertia of a link; of two links, '
        'of what turns about the joint')
    centre_x: float = parameter(
        0.0, 'm', -1.0, 1.0, 'by which its centre is off, in the frame with z along its joint')
    centre_y: float = parameter(0.0, 'm', -1.0, 1.0, 'likewise')
    centre_z: float = parameter(0.0, 'm', -1.0, 1.0, 'likewise')


@dataclass(frozen=True)
class InertialCoupling(Effect):
    """Links that feel each other in an arm given decoupled, or the reverse, (eq:coupling)."""

    name: ClassVar[str] = 'inertial_coupling'
    cause: ClassVar[str] = 'the links feel each other: M(q) and C(q, dq) instead of constants'
    site: ClassVar[Site] = Site.LINK
    place: ClassVar[Place] = COUPLING
    scope: ClassVar[Scope] = Scope.ARM
    planar: ClassVar[bool] = True
    law = staticmethod(coupling)
    hypothesis: ClassVar[Hypothesis | None] = Hypothesis(
        free={'share': -0.2}, grid={'share': (-0.2, 0.2)}, alike=('link_inertia_error',),
        experiment='move one joint and hold the other, then swap',
        ends=('share',))                                    # no coupling at all
    typical: ClassVar[Typical | None] = Typical({'share': 1.0})
    words: ClassVar[Words] = Words(
        'has links that feel each other otherwise than the model says', 'link',
        'None: give the arm file inertias that depend on the posture.')
    share: float = parameter(
        0.0, '', -1.0, 1.0, '1 couples links that are given decoupled, -1 the other way round')


@dataclass(frozen=True)
class LinkBearingFriction(Effect):
    """Dry friction of the link bearing, between this link and the one before it, (eq:bearing)."""

    name: ClassVar[str] = 'link_bearing_friction'
    cause: ClassVar[str] = 'dry friction of the link bearing'
    site: ClassVar[Site] = Site.LINK
    place: ClassVar[Place] = BEARING
    acts: ClassVar[tuple[str, ...]] = ('level',)
    law = staticmethod(bearing_budget)
    # (measured: fitted alone, it left 0.3 % of its power)
    hypothesis: ClassVar[Hypothesis | None] = Hypothesis(
        varies=('link_velocity', 'link_path'),
        free={'level': 0.3}, alike=('cable_spring',), form_share=0.08, form_error=0.006,
        experiment='reversals at two loads', doubts={'level': (0.17, 'level')})
    typical: ClassVar[Typical | None] = Typical({'level': 0.8})
    words: ClassVar[Words] = Words(
        'has {size} of dry friction in its link bearing', 'bearing',
        'Turn the link by hand with the gear free; check preload, seal and cables.', ('level',))
    level: float = parameter(0.0, 'N*m', 0.0, 50.0, 'dry friction level, output side')


@dataclass(frozen=True)
class CableSpring(Effect):
    """A cable or hose that pulls the joint to a rest angle, (eq:cable)."""

    name: ClassVar[str] = 'cable_spring'
    cause: ClassVar[str] = 'a cable or hose pulls the joint like a spring'
    site: ClassVar[Site] = Site.LINK
    place: ClassVar[Place] = LINK_TORQUE
    acts: ClassVar[tuple[str, ...]] = ('stiffness',)
    law = staticmethod(cable_torque)
    law_energy = staticmethod(cable_energy)
    # (source: one that stiffens leaves up to 0.01 to a line; one that is cubic alone 0.16)
    hypothesis: ClassVar[Hypothesis | None] = Hypothesis(
        varies=('link_angle',), reach=0.02,
        free={'stiffness': 0.3, 'rest_angle': 0.3}, grid={'rest_angle': (-1.5, 1.5)},
        stands={'rest_angle': 1.5}, faintest=True, rests='rest_angle',
        contains=('link_angle^1',),         # one that rests where the angle is zero
        alike=('base_tilt',), experiment='a slow sweep of the whole range')
    typical: ClassVar[Typical | None] = Typical({'stiffness': 0.8}, {'rest_angle': 0.5})
    words: ClassVar[Words] = Words(
        'is pulled by a cable or hose of {size}', 'link',
        'Unhook cables and hoses, and record again.', ('stiffness',))
    stiffness: float = parameter(0.0, 'N*m/rad', 0.0, 1e3, 'of the cable, output side')
    rest_angle: float = parameter(0.0, 'rad', -10.0, 10.0, 'link angle without pull')

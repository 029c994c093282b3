"""Masses, frames and joints of a robot description as numbers, checked as they are read."""

import math
from typing import NamedTuple

import numpy as np

from .urdf import Element, UrdfError
from ..foundation.arrays import Array

TURNING = ('revolute', 'continuous')
_FARTHEST = 100.0      # from one frame to the next: a choice, ten times a long boom [m]
_SLACK = 1e-2           # of a principal inertia: descriptions print them with three digits


class Frame(NamedTuple):
    """Where a frame stands in another one: rotation (3, 3) and place (3,) [m]."""

    rotation: Array
    place: Array

    def then(self, inner: 'Frame') -> 'Frame':
        """Return where a frame within this one stands."""
        return Frame(self.rotation @ inner.rotation, self.place + self.rotation @ inner.place)


class RigidBody(NamedTuple):
    """A rigid body: mass [kg], mass moment (3,) [kg*m], inertia (3, 3) at the origin [kg*m^2]."""

    mass: float
    moment: Array
    inertia: Array

    def seen_from(self, frame: Frame) -> 'RigidBody':
        """Return the body that stands in a frame as the outer frame has it."""
        turned = frame.rotation @ self.moment
        lever = np.outer(frame.place, turned)
        far = self.mass * np.outer(frame.place, frame.place) + lever + lever.T
        inertia = frame.rotation @ self.inertia @ frame.rotation.T
        return RigidBody(self.mass, turned + self.mass * frame.place,
                         inertia + np.trace(far) * np.eye(3) - far)

    def with_body(self, other: 'RigidBody') -> 'RigidBody':
        """Return both as one."""
        return RigidBody(self.mass + other.mass, self.moment + other.moment,
                         self.inertia + other.inertia)


NO_BODY = RigidBody(0.0, np.zeros(3), np.zeros((3, 3)))


class UrdfJoint(NamedTuple):
    """A joint of a description: its frame in that of its parent, and how it moves."""

    name: str
    kind: str
    parent: str
    child: str
    frame: Frame
    axis: Array                 # (3,) of length one
    limits: dict[str, float]    # lower, upper [rad], effort [N*m], velocity [rad/s]
    mimics: bool


def joint_of(element: Element) -> UrdfJoint:
    """Return a joint; raises UrdfError."""
    label, kind = element.label, element.attributes.get('type', '')
    parent, child = _end(element, 'parent'), _end(element, 'child')
    axis = _numbers(element.part('axis'), 'xyz', (1.0, 0.0, 0.0), label)
    length = float(np.linalg.norm(axis))
    if kind in TURNING and length < 1e-6:
        raise UrdfError(f'joint {label}: its axis must not be zero')
    limit = element.part('limit')
    limits = {} if limit is None else {
        key: _number(limit, key, label) for key in ('lower', 'upper', 'effort', 'velocity')
        if key in limit.attributes}
    return UrdfJoint(label, kind, parent, child, frame_of(element, label),
                     axis / max(length, 1e-6), limits, element.part('mimic') is not None)


def frame_of(element: Element, owner: str) -> Frame:
    """Return the frame of an element's origin."""
    origin = element.part('origin')
    place = _numbers(origin, 'xyz', (0.0, 0.0, 0.0), owner)
    if not np.linalg.norm(place) <= _FARTHEST:
        raise UrdfError(f'{owner}: its origin must lie within {_FARTHEST:g} m, got '
                        f'{np.linalg.norm(place):g} m; lengths of a description are in m')
    return Frame(turned(*_numbers(origin, 'rpy', (0.0, 0.0, 0.0), owner)), place)


def turned(roll: float, pitch: float, yaw: float) -> Array:
    """Return the rotation (3, 3) by angles about the fixed axes x, y and z in turn [rad]."""
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a), math.sin(a)) for a in (roll, pitch, yaw))
    return np.array([[cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
                     [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
                     [-sp, cp * sr, cp * cr]])


def onto(axis: Array) -> Array:
    """Return the least rotation (3, 3) that brings z onto an axis."""
    x, y, z = axis
    if z < -1.0 + 1e-12:
        return np.diag([1.0, -1.0, -1.0])
    share = 1.0 / (1.0 + z)
    return np.array([[1.0 - x * x * share, -x * y * share, x],
                     [-x * y * share, 1.0 - y * y * share, y], [-x, -y, z]])


def body_of(link: Element) -> RigidBody | None:
    """Return what a link is by its inertial, None without one; raises UrdfError."""
    inertial = link.part('inertial')
    if inertial is None:
        return None
    label = f'link {link.label}'
    mass, tensor = inertial.part('mass'), inertial.part('inertia')
    if mass is None or tensor is None:
        raise UrdfError(f'{label}: its inertial needs both <mass> and <inertia>')
    kilograms = _number(mass, 'value', label)
    if kilograms < 0.0:
        raise UrdfError(f'{label}: its mass must not be negative, got {kilograms:g} kg')
    xx, yy, zz, xy, xz, yz = (_number(tensor, f'i{key}', label)
                              for key in ('xx', 'yy', 'zz', 'xy', 'xz', 'yz'))
    central = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    _check_inertia(central, kilograms, label)
    return RigidBody(kilograms, np.zeros(3), central).seen_from(frame_of(inertial, label))


def _check_inertia(central: Array, mass: float, label: str) -> None:
    """Raise UrdfError for an inertia about the centre of mass that no body has."""
    principal = np.linalg.eigvalsh(central)
    listed = ', '.join(f'{value:.4g}' for value in principal)
    if mass == 0.0 and not central.any():
        return
    if not mass > 0.0:
        raise UrdfError(f'{label}: it has inertia but no mass')
    if not principal[0] > 0.0:
        raise UrdfError(f'{label}: its inertia must be positive definite, got principal values '
                        f'{listed} kg*m^2')
    if principal[2] > (1.0 + _SLACK) * (principal[0] + principal[1]):
        raise UrdfError(f'{label}: no body has this inertia: its largest principal value must be '
                        f'at most the sum of the others, got {listed} kg*m^2')


def _end(element: Element, which: str) -> str:
    part = element.part(which)
    name = '' if part is None else part.attributes.get('link', '')
    if not name:
        raise UrdfError(f'joint {element.label}: it needs <{which} link="..."/>')
    return name


def _number(element: Element, key: str, owner: str) -> float:
    text = element.attributes.get(key, '')
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not abs(number) < 1e9:
        raise UrdfError(f'{owner}: {key} of its <{element.name}> must be a finite number, '
                        f'got {text!r:.40}')
    return number


def _numbers(element: Element | None, key: str, default: tuple[float, ...],
             owner: str) -> Array:
    """Return three numbers of an attribute, or what they are without it."""
    if element is None or key not in element.attributes:
        return np.array(default)
    words = element.attributes[key].split()
    try:
        numbers = np.array([float(word) for word in words])
    except ValueError:
        numbers = np.full(3, np.nan)
    if numbers.shape != (3,) or not (np.abs(numbers) < 1e9).all():
        raise UrdfError(f'{owner}: {key} must be three finite numbers, got '
                        f'{element.attributes[key]!r:.40}')
    return numbers

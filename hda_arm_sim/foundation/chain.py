"""
Rigid dynamics of a chain of turning joints in space, compiled (docs/model.md#chains).

A chain stands in one table. Row 0 is the base, the last row the tip, and between them is a row for
each joint with the link that it turns. Each link's frame has its z axis along its joint.
Everything is expressed in the base frame about its origin. So velocities, forces and inertias of
different links add without being carried from frame to frame. Fill ANGLE, SPEED and SPEEDING,
then ask.
"""

from typing import Any, NamedTuple, TypeVar

from numba.core import types
import numpy as np

from .arrays import Array
from .compiled import borrowed, compiled, either, inlined
from .vectors import (back_rotated, cross, dot, plus, put, rotated, rotation, row_turned, times,
                      Vector, vector)

MOST = 12               # joints of a chain: two more than arms on a rail with a wrist have

# What does not change: frame of the joint at angle zero in that of the link before [m]; mass [kg],
# mass moment [kg*m] and inertia about the frame's origin (xx yy zz xy xz yz) [kg*m^2]. The base
# has gravity [m/s^2] in the place of the moment.
ROTATION, OFFSET, MASS, MOMENT, INERTIA, CONSTANTS = 0, 9, 12, 13, 16, 22
DOWN = MOMENT
# What is asked about: angle [rad], its rates [rad/s, rad/s^2].
ANGLE, SPEED, SPEEDING = 22, 23, 24
# In base: frame, place of its origin [m]; screw of the joint, rotation and velocity at the origin;
# moment and inertia of the link there; its velocity screw; moment and force on it.
FRAME, PLACE, TURNING, SLIDING, MOMENT_HERE, INERTIA_HERE = 25, 34, 37, 40, 43, 46
SPIN, DRIFT, TWIST, FORCE = 52, 55, 58, 61
# Answers: torque on the joint [N*m], a row of the mass matrix [kg*m^2], torque per acceleration
# of the base [kg*m]; the wrench of the environment on a link at its end, which is where the next
# row's frame is, in the last row on the tip: force and moment [N, N*m].
TORQUE, MATRIX, COUPLING, WRENCH = 64, 65, 77, 78
SOLVING = 84            # a row of the matrix while it is solved, and the right side
ASKED = SOLVING         # acceleration screw of a link, before any matrix is solved
WIDTH = SOLVING + MOST + 1
RIGHT = SOLVING + MOST


class Chain(NamedTuple):
    """A chain of joints: its table (n + 2, WIDTH)."""

    table: Array


Planar = TypeVar('Planar')
CHAIN_RECORD = np.dtype([('joints', float), ('parts', float, (MOST + 2, CONSTANTS))])


def _is_spatial(kind: Any) -> bool:
    """Return whether the numba type of an argument is or has a chain."""
    if isinstance(kind, types.NamedTuple):
        return kind.instance_class is Chain or any(map(_is_spatial, kind.types))
    if isinstance(kind, types.NamedUniTuple):
        return kind.instance_class is Chain
    if isinstance(kind, types.Record):
        return 'parts' in kind.fields or any(map(_is_spatial, map(kind.typeof, kind.fields)))
    return False


def of_links(planar: Planar, spatial: Any) -> Planar:
    """
    Return what compiled code calls for one of two laws: links in a plane, or a chain in space.

    Which of them follows from the types of the arguments, when the caller is compiled.
    """
    made: Any = either(planar, spatial, _is_spatial)
    result: Planar = made
    return result


class Composite(NamedTuple):
    """What some links are together: mass, moment and inertia about the origin of the base."""

    mass: float
    moment: Vector
    diagonal: Vector                # of the inertia: xx yy zz
    products: Vector                # xy xz yz


@inlined
def turned_by(body: Composite, spin: Vector) -> Vector:
    """Return inertia times a rotation: angular momentum or moment."""
    (xx, yy, zz), (xy, xz, yz) = body.diagonal, body.products
    return (xx * spin[0] + xy * spin[1] + xz * spin[2], xy * spin[0] + yy * spin[1] + yz * spin[2],
            xz * spin[0] + yz * spin[1] + zz * spin[2])


@inlined
def momentum(body: Composite, spin: Vector, drift: Vector) -> tuple[Vector, Vector]:
    """Return angular and linear momentum of a body with a velocity screw, or a force likewise."""
    return (plus(turned_by(body, spin), cross(body.moment, drift)),
            plus(times(body.mass, drift), cross(spin, body.moment)))


@inlined
def here(c: Array, row: int) -> Composite:
    """Return a link in the base frame."""
    return Composite(c[row, MASS], vector(c, row, MOMENT_HERE), vector(c, row, INERTIA_HERE),
                     vector(c, row, INERTIA_HERE + 3))


@inlined
def together(a: Composite, b: Composite) -> Composite:
    """Return two bodies as one."""
    return Composite(a.mass + b.mass, plus(a.moment, b.moment), plus(a.diagonal, b.diagonal),
                     plus(a.products, b.products))


@inlined
def nothing() -> Composite:
    """Return a body without mass."""
    return Composite(0.0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


@inlined
def _put_frame(c: Array, row: int, cosine: float, sine: float) -> None:
    """Place a frame by that of the row before."""
    outer, inner = rotation(c, row - 1, FRAME), rotation(c, row, ROTATION)
    for k in range(3):
        put(c, row, FRAME + 3 * k, row_turned(outer[k], inner, cosine, sine))
    put(c, row, PLACE, plus(vector(c, row - 1, PLACE), rotated(outer, vector(c, row, OFFSET))))


@inlined
def put_inertia(c: Array, row: int) -> None:
    """Put moment and inertia of a link into the base frame, about its origin."""
    frame, place = rotation(c, row, FRAME), vector(c, row, PLACE)
    own = Composite(0.0, place, vector(c, row, INERTIA), vector(c, row, INERTIA + 3))
    mass, moment = c[row, MASS], rotated(frame, vector(c, row, MOMENT))
    lever, far = plus(times(mass, place), times(2.0, moment)), plus(times(mass, place), moment)
    whole = dot(place, lever)
    x, y, z = (turned_by(own, frame[0]), turned_by(own, frame[1]), turned_by(own, frame[2]))
    put(c, row, MOMENT_HERE, far)
    put(c, row, INERTIA_HERE, (dot(frame[0], x) + whole - place[0] * lever[0],
                               dot(frame[1], y) + whole - place[1] * lever[1],
                               dot(frame[2], z) + whole - place[2] * lever[2]))
    put(c, row, INERTIA_HERE + 3, (
        dot(frame[0], y) - place[0] * far[1] - moment[0] * place[1],
        dot(frame[0], z) - place[0] * far[2] - moment[0] * place[2],
        dot(frame[1], z) - place[1] * far[2] - moment[1] * place[2]))


@compiled
def place(c: Array) -> None:
    """Place all frames, screws and inertias of a chain at its angles."""
    last = c.shape[0] - 1
    for row in range(1, last):
        _put_frame(c, row, np.cos(c[row, ANGLE]), np.sin(c[row, ANGLE]))
        axis = (c[row, FRAME + 2], c[row, FRAME + 5], c[row, FRAME + 8])
        put(c, row, TURNING, axis)
        put(c, row, SLIDING, cross(vector(c, row, PLACE), axis))
        put_inertia(c, row)
    _put_frame(c, last, 1.0, 0.0)


@inlined
def needed(c: Array, row: int, body: Composite) -> tuple[Vector, Vector]:
    """Return the moment and force that a body needs to move as a link does."""
    spin, drift = vector(c, row, SPIN), vector(c, row, DRIFT)
    angular, linear = momentum(body, spin, drift)
    moment, force = momentum(body, vector(c, row, ASKED), vector(c, row, ASKED + 3))
    return (plus(moment, plus(cross(spin, angular), cross(drift, linear))),
            plus(force, cross(spin, linear)))


@inlined
def move(c: Array) -> None:
    """Set the velocities of all links, and moment and force that their motion needs."""
    spin, drift = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    speeding, rising = (0.0, 0.0, 0.0), times(-1.0, vector(c, 0, DOWN))
    for row in range(1, c.shape[0] - 1):
        turning, sliding = vector(c, row, TURNING), vector(c, row, SLIDING)
        rate, change = c[row, SPEED], c[row, SPEEDING]
        spin, drift = plus(spin, times(rate, turning)), plus(drift, times(rate, sliding))
        speeding = plus(speeding, plus(times(change, turning), times(rate, cross(spin, turning))))
        rising = plus(rising, plus(times(change, sliding), times(
            rate, plus(cross(spin, sliding), cross(drift, turning)))))
        put(c, row, SPIN, spin)
        put(c, row, DRIFT, drift)
        put(c, row, ASKED, speeding)
        put(c, row, ASKED + 3, rising)
        moment, force = needed(c, row, here(c, row))
        put(c, row, TWIST, moment)
        put(c, row, FORCE, force)


@inlined
def withstood(c: Array, row: int, end: int) -> tuple[Vector, Vector]:
    """Return moment at the origin and force that withstand a WRENCH where the row `end` is."""
    pull = vector(c, row, WRENCH)
    moment = plus(vector(c, row, WRENCH + 3), cross(vector(c, end, PLACE), pull))
    return times(-1.0, moment), times(-1.0, pull)


@compiled
def inverse_dynamics(c: Array) -> None:
    """
    Set the TORQUE that joints need for the SPEEDING that is asked, at the frames placed.

    It holds gravity and each WRENCH. With SPEEDING zero it is C dq - gravity - J^T F.
    """
    move(c)
    last = c.shape[0] - 1
    moment, force = withstood(c, last, last)
    for row in range(last - 1, 0, -1):
        twisted, pushed = withstood(c, row, row + 1)
        moment, force = plus(moment, vector(c, row, TWIST)), plus(force, vector(c, row, FORCE))
        moment, force = plus(moment, twisted), plus(force, pushed)
        put(c, row, TWIST, moment)
        put(c, row, FORCE, force)
        c[row, TORQUE] = (dot(vector(c, row, TURNING), moment)
                          + dot(vector(c, row, SLIDING), force))


@compiled
def mass_matrix(c: Array) -> None:
    """Set the mass matrix, MATRIX + k of row j + 1, at the frames placed (composite bodies)."""
    body = nothing()
    for row in range(c.shape[0] - 2, 0, -1):
        body = together(body, here(c, row))
        moment, force = momentum(body, vector(c, row, TURNING), vector(c, row, SLIDING))
        for other in range(1, row + 1):
            both = (dot(vector(c, other, TURNING), moment)
                    + dot(vector(c, other, SLIDING), force))
            c[row, MATRIX + other - 1] = both
            c[other, MATRIX + row - 1] = both


@compiled
def momenta(c: Array) -> None:
    """
    Set TORQUE to the generalised momentum M dq and COUPLING to C^T dq, at frames placed.

    C^T dq is the slope of the kinetic energy over the angles. It is the momentum of the links
    beyond a joint, times the velocity that turning the joint gives them.
    """
    spin, drift = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    last = c.shape[0] - 1
    for row in range(1, last):
        rate = c[row, SPEED]
        spin = plus(spin, times(rate, vector(c, row, TURNING)))
        drift = plus(drift, times(rate, vector(c, row, SLIDING)))
        put(c, row, SPIN, spin)
        put(c, row, DRIFT, drift)
    angular, linear = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    for row in range(last - 1, 0, -1):
        spin, drift = vector(c, row, SPIN), vector(c, row, DRIFT)
        more, pushed = momentum(here(c, row), spin, drift)
        angular, linear = plus(angular, more), plus(linear, pushed)
        turning, sliding = vector(c, row, TURNING), vector(c, row, SLIDING)
        c[row, TORQUE] = dot(turning, angular) + dot(sliding, linear)
        c[row, COUPLING] = (dot(cross(spin, turning), angular)
                            + dot(plus(cross(spin, sliding), cross(drift, turning)), linear))


@compiled
def weights(c: Array) -> None:
    """Set TORQUE to what gravity does to the joints [N*m], at the frames placed."""
    moment, mass, down = (0.0, 0.0, 0.0), 0.0, vector(c, 0, DOWN)
    for row in range(c.shape[0] - 2, 0, -1):
        mass, moment = mass + c[row, MASS], plus(moment, vector(c, row, MOMENT_HERE))
        c[row, TORQUE] = (dot(vector(c, row, TURNING), cross(moment, down))
                          + mass * dot(vector(c, row, SLIDING), down))


@compiled
def base_couplings(c: Array, direction: Vector) -> float:
    """Set COUPLING for a base that moves along a direction; return weight along it [N]."""
    moment, mass = (0.0, 0.0, 0.0), 0.0
    for row in range(c.shape[0] - 2, 0, -1):
        mass, moment = mass + c[row, MASS], plus(moment, vector(c, row, MOMENT_HERE))
        c[row, COUPLING] = (dot(vector(c, row, TURNING), cross(moment, direction))
                            + mass * dot(vector(c, row, SLIDING), direction))
    return mass * dot(vector(c, 0, DOWN), direction)


@compiled
def tilting_moment(c: Array, row: int) -> float:
    """Return the moment of the weight beyond a joint across its axis, at its origin [N*m]."""
    mass, moment, axis = 0.0, (0.0, 0.0, 0.0), vector(c, row, TURNING)
    for other in range(row, c.shape[0] - 1):
        mass, moment = mass + c[other, MASS], plus(moment, vector(c, other, MOMENT_HERE))
    lever = plus(moment, times(-mass, vector(c, row, PLACE)))
    whole = cross(lever, vector(c, 0, DOWN))
    across = plus(whole, times(-dot(whole, axis), axis))
    return float(np.sqrt(dot(across, across)))


@inlined
def tip_velocity(c: Array, row: int) -> Vector:
    """Return a column of the tip's Jacobian: its velocity per rate of a joint [m]."""
    tip = vector(c, c.shape[0] - 1, PLACE)
    return plus(vector(c, row, SLIDING), cross(vector(c, row, TURNING), tip))


@inlined
def in_tool(c: Array, what: Vector) -> Vector:
    """Return a vector of the base frame in that of the tip."""
    return back_rotated(rotation(c, c.shape[0] - 1, FRAME), what)


@compiled
def tip_jacobian(c: Array, jacobian: Array) -> None:
    """Fill the Jacobian of the tip (6, n) in the base frame: velocity [m], then rotation."""
    for row in range(1, c.shape[0] - 1):
        jacobian[:3, row - 1] = tip_velocity(c, row)
        jacobian[3:, row - 1] = vector(c, row, TURNING)


@compiled
def solve(c: Array) -> None:
    """
    Turn the right sides RIGHT into the solution with the matrix in SOLVING (LDL^T, in place).

    The matrix must be symmetric and positive definite; its lower half is read.
    """
    n = c.shape[0] - 2
    for j in range(n):
        pivot = c[j + 1, SOLVING + j]
        for k in range(j):
            pivot -= c[j + 1, SOLVING + k] ** 2 * c[k + 1, SOLVING + k]
        c[j + 1, SOLVING + j] = pivot
        for i in range(j + 1, n):
            rest = c[i + 1, SOLVING + j]
            for k in range(j):
                rest -= c[i + 1, SOLVING + k] * c[j + 1, SOLVING + k] * c[k + 1, SOLVING + k]
            c[i + 1, SOLVING + j] = rest / pivot
        for k in range(j):
            c[j + 1, RIGHT] -= c[j + 1, SOLVING + k] * c[k + 1, RIGHT]
    for j in range(n - 1, -1, -1):
        c[j + 1, RIGHT] /= c[j + 1, SOLVING + j]
        for k in range(j + 1, n):
            c[j + 1, RIGHT] -= c[k + 1, SOLVING + j] * c[k + 1, RIGHT]


@compiled
def forward_dynamics(c: Array, torque: Array, speeding: Array) -> None:
    """Fill the accelerations (n,) [rad/s^2] under joint torques (n,) [N*m], at ANGLE and SPEED."""
    place(c)
    c[:, SPEEDING] = 0.0
    inverse_dynamics(c)
    mass_matrix(c)
    n = c.shape[0] - 2
    for j in range(n):
        for k in range(j + 1):
            c[j + 1, SOLVING + k] = c[j + 1, MATRIX + k]
        c[j + 1, RIGHT] = torque[j] - c[j + 1, TORQUE]
    solve(c)
    for j in range(n):
        speeding[j] = c[j + 1, RIGHT]


@compiled
def torques_along(c: Array, motion: Array, torque: Array) -> None:
    """Fill the torques (k, n) that a motion needs: angles, rates, accelerations (k, n, 3)."""
    for k in range(motion.shape[0]):
        c[1:-1, ANGLE:SPEEDING + 1] = motion[k]
        place(c)
        inverse_dynamics(c)
        torque[k] = c[1:-1, TORQUE]


@compiled
def chain(parts: Array) -> Chain:
    """Return a chain from the rows of its base, links and tip (n + 2, CONSTANTS)."""
    table = np.zeros((parts.shape[0], WIDTH))
    table[:, :CONSTANTS] = parts
    table[0, FRAME] = table[0, FRAME + 4] = table[0, FRAME + 8] = 1.0
    return Chain(table)


@inlined
def _as_it_is(inertia: Any) -> Any:
    return inertia


@inlined
def _lent(inertia: Chain) -> Chain:
    return Chain(borrowed(inertia.table))


lent = of_links(_as_it_is, _lent)           # handed on in compiled code as cheaply as numbers

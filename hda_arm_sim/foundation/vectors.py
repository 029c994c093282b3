"""Vectors and rotations in space as tuples, for compiled code that allocates nothing."""

from typing import TypeAlias

from .arrays import Array
from .compiled import inlined

Vector: TypeAlias = tuple[float, float, float]
Rotation: TypeAlias = tuple[Vector, Vector, Vector]         # by rows


@inlined
def vector(table: Array, row: int, column: int) -> Vector:
    """Return three numbers that stand in a row of a table."""
    return table[row, column], table[row, column + 1], table[row, column + 2]


@inlined
def put(table: Array, row: int, column: int, what: Vector) -> None:
    """Put three numbers into a row of a table."""
    table[row, column], table[row, column + 1], table[row, column + 2] = what


@inlined
def dot(a: Vector, b: Vector) -> float:
    """Return the inner product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inlined
def cross(a: Vector, b: Vector) -> Vector:
    """Return the cross product."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@inlined
def plus(a: Vector, b: Vector) -> Vector:
    """Return the sum."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@inlined
def times(s: float, a: Vector) -> Vector:
    """Return a vector s times as long."""
    return s * a[0], s * a[1], s * a[2]


@inlined
def rotation(table: Array, row: int, column: int) -> Rotation:
    """Return the rotation whose nine numbers stand in a row of a table."""
    return (vector(table, row, column), vector(table, row, column + 3),
            vector(table, row, column + 6))


@inlined
def rotated(turn: Rotation, a: Vector) -> Vector:
    """Return a vector of the inner frame in the outer one."""
    return dot(turn[0], a), dot(turn[1], a), dot(turn[2], a)


@inlined
def back_rotated(turn: Rotation, a: Vector) -> Vector:
    """Return a vector of the outer frame in the inner one."""
    return plus(plus(times(a[0], turn[0]), times(a[1], turn[1])), times(a[2], turn[2]))


@inlined
def row_turned(row: Vector, inner: Rotation, cosine: float, sine: float) -> Vector:
    """Return a row of outer times inner times a turn about z."""
    x, y, z = back_rotated(inner, row)
    return cosine * x + sine * y, cosine * y - sine * x, z

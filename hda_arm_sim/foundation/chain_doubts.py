"""How unsure the torques of a chain are, by links whose numbers are not known exactly."""

from .arrays import Array
from .chain import (ASKED, Composite, FORCE, INERTIA, MASS, MOMENT_HERE, move, needed, SLIDING,
                    SPIN, TORQUE, TURNING, TWIST)
from .compiled import compiled, inlined
from .vectors import cross, dot, plus, times, Vector, vector


@compiled
def own_doubts(c: Array, known: Array, covariance: Array) -> None:
    """
    Fill the covariance of the joints' torques (n, n) by links known so well, (eq:link-doubt).

    `known` (n, 3) are deviations of each link's mass (relative), of each coordinate of its centre
    [m] and of its inertia about its joint (relative). The torques are those of its motion and
    weight, at the frames placed, for the SPEEDING that is asked.
    """
    move(c)
    covariance[:] = 0.0
    for link in range(1, c.shape[0] - 1):
        heavy, shifted, inert = known[link - 1, 0], known[link - 1, 1], known[link - 1, 2]
        _doubt(c, link, (vector(c, link, TWIST), vector(c, link, FORCE)), heavy, covariance)
        axis, spin = vector(c, link, TURNING), vector(c, link, SPIN)
        about = plus(times(dot(axis, vector(c, link, ASKED)), axis),
                     times(dot(axis, spin), cross(spin, axis)))
        _doubt(c, link, (about, (0.0, 0.0, 0.0)), inert * c[link, INERTIA + 2], covariance)
        if shifted > 0.0:
            for way in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)):
                _doubt(c, link, needed(c, link, _shifted(c, link, way)), shifted, covariance)


@inlined
def _doubt(c: Array, link: int, wrench: tuple[Vector, Vector], size: float,
           covariance: Array) -> None:
    """Add the products of what a wrench on a link (moment, force) of a size asks of joints."""
    for row in range(1, link + 1):
        c[row, TORQUE] = size * (dot(vector(c, row, TURNING), wrench[0])
                                 + dot(vector(c, row, SLIDING), wrench[1]))
        for other in range(1, row + 1):
            both = c[row, TORQUE] * c[other, TORQUE]
            covariance[row - 1, other - 1] += both
            if other < row:
                covariance[other - 1, row - 1] += both


@inlined
def _shifted(c: Array, link: int, way: Vector) -> Composite:
    """Return what each metre adds to a link whose centre moves in the base frame."""
    moment = vector(c, link, MOMENT_HERE)
    twice = 2.0 * dot(moment, way)
    (x, y, z), (a, b, d) = moment, way
    return Composite(0.0, times(c[link, MASS], way),
                     (twice - 2.0 * x * a, twice - 2.0 * y * b, twice - 2.0 * z * d),
                     (-x * b - y * a, -x * d - z * a, -y * d - z * b))

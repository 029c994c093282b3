"""
Dry friction as bristles that bend before they slide (LuGre), and viscous drag.

A bristle bends as dz/dt = v (1 - z / z_end) and pushes back with k z + c dz/dt; at a steady rate
z is z_end = level(v) / k. Up to ELASTIC of that, and after a reversal, it only bends, dz/dt = v,
so that a drive which sticks does not creep away under vibration (Dupont et al. 2002).
"""

import math

import numba

from .curves import drawn_line, tabulated
from .layout import Record

ELASTIC = 0.7                   # share of its reach over which a bristle springs back

# Forms of laws, by effect (`forms.py`); 0 is the one of README.md.
DAHL, SMOOTH = 1, 2                                                 # coulomb_friction
THINNING, THICKENING = 1, 2                                         # viscous_friction
SATURATING, ARCTAN, CUBIC, TABLE = 1, 2, 3, 4                       # nonlinear_viscous_friction
TUSTIN, POWER, HESS_SOOM, WITH_LOAD, RISING, ONE_WAY = 1, 2, 3, 4, 5, 6     # stribeck_friction
LUGRE, BRISTLE_DAHL, BOUC_WEN = 1, 2, 3                             # presliding_friction
VISCOUS_TOO, FADING = 1, 2                                          # asymmetric_friction
THRESHOLD, SQUARE, DRIVEN = 1, 2, 3                                 # load_dependent_friction
LOSSES, TWO_CONSTANTS = 1, 2                                        # thermal_viscosity
TWO_ORDERS, BUMP = 1, 2                                             # position_dependent_friction
WIDE, BEARING_STRIBECK = 1, 2                                       # link_bearing_friction


@numba.njit(cache=True, error_model='numpy')
def level(joint: Record, held: Record, rate: float) -> float:
    """Return the torque of steady sliding at a motor rate, without viscous drag [N*m]."""
    dry, mesh = held.dry, held.mesh
    asymmetry = joint.asymmetric_friction_asymmetry
    if joint.asymmetric_friction_form == FADING:
        asymmetry /= 1.0 + abs(rate) / (joint.asymmetric_friction_first * joint.pace)
    if joint.coulomb_friction_form == SMOOTH:
        soft = abs(rate) / (joint.coulomb_friction_first * joint.pace)
        dry -= joint.coulomb_friction_level * (1.0 - math.tanh(soft))
    if rate > 0.0:
        dry *= 1.0 + asymmetry
    elif rate < 0.0:
        dry *= 1.0 - asymmetry
    if joint.stribeck_friction_excess > 0.0:
        dry += joint.stribeck_friction_excess * breakaway(joint, held, rate)
    if joint.load_dependent_friction_form == DRIVEN and rate * held.torque < 0.0:
        mesh *= joint.load_dependent_friction_first
    return dry + mesh


@numba.njit(cache=True, error_model='numpy')
def breakaway(joint: Record, held: Record, rate: float) -> float:
    """Return the share of the breakaway excess that is left at a motor rate."""
    form, first = joint.stribeck_friction_form, joint.stribeck_friction_first
    slowness = abs(rate) / joint.stribeck_friction_speed
    if form == TUSTIN:
        return math.exp(-slowness)
    if form == POWER:
        return math.exp(-slowness ** first)
    if form == HESS_SOOM:
        return 1.0 / (1.0 + slowness * slowness)
    if form == RISING:
        return drawn_line(slowness, 0.5, 1.0 - first, 1.5, 0.0, 6.0, 0.3 * first)
    left = math.exp(-slowness * slowness)
    if form == WITH_LOAD:
        left *= first + (1.0 - first) * abs(held.torque) / (10.0 * joint.size)
    elif form == ONE_WAY:
        left *= 1.0 + math.copysign(first, rate)
    return left


@numba.njit(cache=True, error_model='numpy')
def meshing(joint: Record, torque: float) -> float:
    """Return the dry friction at the motor that a gear torque brings [N*m]."""
    load, form = abs(torque), joint.load_dependent_friction_form
    if form == THRESHOLD:
        load = max(load - joint.load_dependent_friction_first * 10.0 * joint.size, 0.0)
    elif form == SQUARE:
        load *= load / (10.0 * joint.size)
    return joint.load_dependent_friction_coefficient * load / joint.ratio


@numba.njit(cache=True, error_model='numpy')
def waviness(joint: Record, q: float, other: float) -> float:
    """Return the factor on dry friction at the angles of this and of the other link."""
    factor, size = 1.0, joint.position_dependent_friction_amplitude
    if size != 0.0:
        first, second = joint.position_dependent_friction_first, (
            joint.position_dependent_friction_second)
        order = joint.position_dependent_friction_order
        form = joint.position_dependent_friction_form
        if form == BUMP:
            away = (q - joint.middle - first) / second
            return factor + 2.0 * size * math.exp(-away * away)
        factor += size * math.sin(order * q + joint.position_dependent_friction_phase)
        if form == TWO_ORDERS:
            factor += first * size * math.sin(2.0 * order * q + second)
    if joint.crossed_friction_amplitude != 0.0:
        factor += joint.crossed_friction_amplitude * math.sin(
            joint.crossed_friction_order * other + joint.crossed_friction_phase)
    return factor


@numba.njit(cache=True, error_model='numpy')
def springs_back(joint: Record) -> float:
    """Return the share of their reach over which the bristles of a motor only bend."""
    if joint.coulomb_friction_form == DAHL or joint.presliding_friction_form > 0.0:
        return 0.0
    return ELASTIC


@numba.njit(cache=True, error_model='numpy')
def bent(bristle: float, rate: float, stiffness: float, sliding: float, h: float,
         elastic: float = ELASTIC) -> float:
    """Return the bristle after h seconds at a constant rate, exactly [rad]."""
    if rate == 0.0 or sliding <= 0.0:
        return bristle
    way, end, path = math.copysign(1.0, rate), sliding / stiffness, abs(rate) * h
    bend = way * bristle
    if elastic > 0.0 and bend < elastic * end:
        spring = min(path, elastic * end - bend)
        bend, path = bend + spring, path - spring
    return way * (end + (bend - end) * math.exp(-path / end))


@numba.njit(cache=True, error_model='numpy')
def bent_softly(share: float, path: float) -> float:
    """
    Return where a Bouc-Wen element of exponent 2 is after a path, both as shares of its reach.

    dz/dx = 1 - sgn(x) z abs(z), solved exactly.
    """
    way, left = math.copysign(1.0, path), abs(path)
    share *= way
    if share < 0.0:
        back = -math.atan(share)
        if left < back:
            return way * math.tan(left - back)
        share, left = 0.0, left - back
    return way * math.tanh(math.atanh(min(share, 1.0 - 1e-12)) + left)


@numba.njit(cache=True, error_model='numpy')
def moved(joint: Record, bristle: float, rate: float, sliding: float, h: float) -> float:
    """Return the bristle of a motor after h seconds at a constant rate [rad]."""
    stiffness = joint.presliding_friction_stiffness
    if joint.presliding_friction_form == BOUC_WEN and sliding > 0.0:
        end = sliding / stiffness
        return end * bent_softly(bristle / end, rate * h / end)
    return bent(bristle, rate, stiffness, sliding, h, springs_back(joint))


@numba.njit(cache=True, error_model='numpy')
def resistance(bristle: float, rate: float, stiffness: float, damping: float,
               sliding: float, elastic: float = ELASTIC) -> float:
    """
    Return the torque of a bristle against the motion [N*m].

    Its damping fades above the rate at which it would reach half the sliding level, as dirt and
    grease do not dampen a bristle that is torn along.
    """
    if sliding <= 0.0:
        return 0.0
    share = math.copysign(bristle, bristle * rate) * stiffness / sliding
    bending = rate if elastic > 0.0 and share < elastic else rate * (1.0 - share)
    fast = 2.0 * damping * rate / sliding
    return stiffness * bristle + damping * bending / (1.0 + fast * fast)


@numba.njit(cache=True, error_model='numpy')
def sticking(joint: Record, held: Record, bristle: float, rate: float) -> float:
    """Return the dry friction of a motor against the motion [N*m]."""
    damping = joint.presliding_friction_damping
    if joint.presliding_friction_form >= BRISTLE_DAHL or joint.coulomb_friction_form == DAHL:
        damping = 0.0
    return resistance(bristle, rate, joint.presliding_friction_stiffness, damping,
                      level(joint, held, rate), springs_back(joint))


@numba.njit(cache=True, error_model='numpy')
def drag(joint: Record, heat: float, slow_heat: float, rate: float) -> float:
    """Return the viscous torque against the motion at a motor rate and heats [N*m]."""
    more, first = joint.viscous_friction_slope, joint.viscous_friction_first
    if joint.viscous_friction_form == THINNING:
        more /= 1.0 + abs(rate) / (first * joint.pace)
    elif joint.viscous_friction_form == THICKENING:
        more *= 1.0 + first * (rate / joint.pace) ** 2
    slope = joint.viscous + more
    if joint.thermal_viscosity_amplitude != 0.0:
        cold = coldness(heat)
        if joint.thermal_viscosity_form == TWO_CONSTANTS:
            cold = 0.5 * (cold + coldness(slow_heat))
        slope += joint.thermal_viscosity_amplitude * cold
    if joint.asymmetric_friction_form == VISCOUS_TOO:
        slope *= 1.0 + math.copysign(joint.asymmetric_friction_asymmetry, rate)
    torque = slope * rate
    if joint.nonlinear_viscous_friction_coefficient != 0.0:
        torque += curved_drag(joint, rate)
    return torque


@numba.njit(cache=True, error_model='numpy')
def curved_drag(joint: Record, rate: float) -> float:
    """Return what a curved viscous law adds at a motor rate [N*m]."""
    form, first = joint.nonlinear_viscous_friction_form, joint.nonlinear_viscous_friction_first
    size, exponent = (joint.nonlinear_viscous_friction_coefficient,
                      joint.nonlinear_viscous_friction_exponent)
    if form == 0.0:
        return size * rate * (rate * rate + 0.01) ** (0.5 * (exponent - 1.0))
    usual, pace = size * joint.pace ** exponent, rate / joint.pace
    if form == SATURATING:
        return usual * (1.0 + first) * pace / (first + abs(pace))
    if form == ARCTAN:
        return usual * math.atan(pace / first) / math.atan(1.0 / first)
    if form == CUBIC:
        return usual * ((1.0 - first) * pace + first * pace ** 3)
    return usual * tabulated(pace, 0.2, first, 1.0, 1.0, 3.0,
                             joint.nonlinear_viscous_friction_second)


@numba.njit(cache=True, error_model='numpy')
def coldness(heat: float) -> float:
    """Return how viscous the grease still is: 1 when cold, 0 at the duty's own temperature."""
    return (math.exp(-0.3 * heat) - math.exp(-0.3)) / (1.0 - math.exp(-0.3))


@numba.njit(cache=True, error_model='numpy')
def bearing(joint: Record, rate: float) -> float:
    """Return the sliding level of a link's bearing at its rate [N*m]."""
    size = joint.link_bearing_friction_level
    if joint.link_bearing_friction_form == BEARING_STRIBECK:
        slow = abs(rate) * joint.ratio / (joint.link_bearing_friction_second * joint.pace)
        size *= 1.0 + joint.link_bearing_friction_first * math.exp(-slow)
    return size


@numba.njit(cache=True, error_model='numpy')
def bearing_gives(joint: Record, bends: float) -> float:
    """Return how far a link's bearing bends before it slides, nominally `bends` [rad]."""
    if joint.link_bearing_friction_form == WIDE:
        return bends * joint.link_bearing_friction_first
    return bends

"""
Dry friction as bristles that bend before they slide (LuGre), and viscous drag.

A bristle bends as dz/dt = v (1 - z / z_end) and pushes back with k z + c dz/dt; at a steady rate
z is z_end = level(v) / k. Up to ELASTIC of that, and after a reversal, it only bends, dz/dt = v,
so that a drive which sticks does not creep away under vibration (Dupont et al. 2002).
"""

import math

import numba

from .layout import Record

ELASTIC = 0.7                   # share of its reach over which a bristle springs back


@numba.njit(cache=True, error_model='numpy')
def level(joint: Record, dry: float, mesh: float, rate: float) -> float:
    """Return the torque of steady sliding at a motor rate, without viscous drag [N*m]."""
    if rate > 0.0:
        dry *= 1.0 + joint.asymmetric_friction_asymmetry
    elif rate < 0.0:
        dry *= 1.0 - joint.asymmetric_friction_asymmetry
    if joint.stribeck_friction_excess > 0.0:
        slowness = rate / joint.stribeck_friction_speed
        dry += joint.stribeck_friction_excess * math.exp(-slowness * slowness)
    return dry + mesh


@numba.njit(cache=True, error_model='numpy')
def bent(bristle: float, rate: float, stiffness: float, sliding: float, h: float) -> float:
    """Return the bristle after h seconds at a constant rate, exactly [rad]."""
    if rate == 0.0 or sliding <= 0.0:
        return bristle
    way, end, path = math.copysign(1.0, rate), sliding / stiffness, abs(rate) * h
    bend = way * bristle
    if bend < ELASTIC * end:
        spring = min(path, ELASTIC * end - bend)
        bend, path = bend + spring, path - spring
    return way * (end + (bend - end) * math.exp(-path / end))


@numba.njit(cache=True, error_model='numpy')
def resistance(bristle: float, rate: float, stiffness: float, damping: float,
               sliding: float) -> float:
    """
    Return the torque of a bristle against the motion [N*m].

    Its damping fades above the rate at which it would reach half the sliding level, as dirt and
    grease do not dampen a bristle that is torn along.
    """
    if sliding <= 0.0:
        return 0.0
    share = math.copysign(bristle, bristle * rate) * stiffness / sliding
    bending = rate if share < ELASTIC else rate * (1.0 - share)
    fast = 2.0 * damping * rate / sliding
    return stiffness * bristle + damping * bending / (1.0 + fast * fast)


@numba.njit(cache=True, error_model='numpy')
def drag(joint: Record, heat: float, rate: float) -> float:
    """Return the viscous torque against the motion at a motor rate and heat [N*m]."""
    slope = joint.viscous + joint.viscous_friction_slope
    if joint.thermal_viscosity_amplitude != 0.0:
        slope += joint.thermal_viscosity_amplitude * coldness(heat)
    torque = slope * rate
    if joint.nonlinear_viscous_friction_coefficient != 0.0:
        power = 0.5 * (joint.nonlinear_viscous_friction_exponent - 1.0)
        torque += (joint.nonlinear_viscous_friction_coefficient * rate
                   * (rate * rate + 0.01) ** power)
    return torque


@numba.njit(cache=True, error_model='numpy')
def coldness(heat: float) -> float:
    """Return how viscous the grease still is: 1 when cold, 0 at the duty's own temperature."""
    return (math.exp(-0.3 * heat) - math.exp(-0.3)) / (1.0 - math.exp(-0.3))

"""The harmonic drive: transmission error, play, torsion law and hysteresis."""

import math

import numba

from .friction import bent, bent_softly
from .layout import Record
from .torsion import Array, look_up

SLIDERS = 10

# Forms of laws, by effect (`forms.py`); 0 is the one of README.md.
MORE_ORDERS, BEATING = 1, 2             # kinematic_error
OFF_CENTRE, SOFT_WALLS, ROUNDED = 1, 2, 3       # backlash
BOUC_WEN, DAHL, POWER = 1, 2, 3         # torsional_hysteresis
SIGNED, LEVELLING = 1, 2                # loaded_kinematic_error
WITH_TORSION, HYSTERETIC = 1, 2         # structural_damping


@numba.njit(cache=True, error_model='numpy')
def transmission_error(joint: Record, motor: float) -> tuple[float, float]:
    """Return the error of the output angle at a motor angle [rad], and its slope."""
    error, slope = 0.0, 0.0
    for order, size, phase in (
            (2, joint.kinematic_error_amplitude_2, joint.kinematic_error_phase_2),
            (4, joint.kinematic_error_amplitude_4, joint.kinematic_error_phase_4),
            (3, joint.third_order_kinematic_error_amplitude,
             joint.third_order_kinematic_error_phase)):
        if size != 0.0:
            error += size * math.sin(order * motor + phase)
            slope += order * size * math.cos(order * motor + phase)
    first, second = joint.kinematic_error_first, joint.kinematic_error_second
    if joint.kinematic_error_form == MORE_ORDERS:
        for order, share in ((1, first), (6, 0.4 * first)):
            size = share * joint.kinematic_error_amplitude_2
            error += size * math.sin(order * motor + second)
            slope += order * size * math.cos(order * motor + second)
    elif joint.kinematic_error_form == BEATING:
        beat = 2.0 / joint.ratio
        swell = 1.0 + first * math.sin(beat * motor + second)
        slope = slope * swell + error * first * beat * math.cos(beat * motor + second)
        error *= swell
    return error, slope


@numba.njit(cache=True, error_model='numpy')
def seat(joint: Record, torsion: float) -> tuple[float, float]:
    """
    Return the torsion behind the play [rad], and the share of its rate that gets there.

    The flanks meet over a thirtieth of the play, not at a corner.
    """
    half = joint.backlash_half_width
    if half <= 0.0:
        return torsion, 1.0
    form, first, soft = joint.backlash_form, joint.backlash_first, half / 30.0
    if form == ROUNDED:
        soft = first * half
    if form == OFF_CENTRE:
        torsion -= first * half
    out, back = torsion - half, -torsion - half
    behind = 0.5 * (out + math.sqrt(out * out + soft * soft)
                    - back - math.sqrt(back * back + soft * soft))
    share = 1.0 + 0.5 * (out / math.sqrt(out * out + soft * soft)
                         + back / math.sqrt(back * back + soft * soft))
    if form == SOFT_WALLS:
        behind += first * (torsion - behind)
        share += first * (1.0 - share)
    return behind, share


@numba.njit(cache=True, error_model='numpy')
def drag_sliders(joint: Record, torsion: float, was: float, sliders: Array) -> float:
    """Move the friction elements along with the torsion; return their torque [N*m]."""
    full = joint.torsional_hysteresis_level
    if full == 0.0:
        return 0.0
    width, form = joint.torsional_hysteresis_width, joint.torsional_hysteresis_form
    if form == BOUC_WEN:
        sliders[0] = bent_softly(sliders[0], (torsion - was) / width)
        return full * sliders[0]
    if form == DAHL:
        sliders[0] = bent(sliders[0], (torsion - was) / width, 1.0, 1.0, 1.0, 0.0)
        return full * sliders[0]
    stiffness = full / width / SLIDERS
    torque = 0.0
    for i in range(SLIDERS):
        yields = width * (2 * i + 1) / SLIDERS
        if form == POWER:
            yields = width * 10.0 * 1.6 ** i / 181.6    # as far together as the others
        stretch = min(max(sliders[i] + torsion - was, -yields), yields)
        sliders[i] = stretch
        torque += stiffness * stretch
    return torque


@numba.njit(cache=True, error_model='numpy')
def elastic_torque(joint: Record, law: Array, behind: float, link: float) -> float:
    """Return the spring's torque at a torsion behind the play and a link angle [N*m]."""
    torque = look_up(law, behind)
    if joint.angle_dependent_stiffness_amplitude != 0.0:
        torque *= 1.0 + joint.angle_dependent_stiffness_amplitude * math.sin(
            joint.angle_dependent_stiffness_order * link + joint.angle_dependent_stiffness_phase)
    return torque


@numba.njit(cache=True, error_model='numpy')
def ovalised(joint: Record, torque: float) -> tuple[float, float]:
    """
    Return what of a torque makes the loaded error, and the share of its slope that is the lever's.

    The rest is what the spring stores: the integral of the first over the torque, times two.
    """
    size, form = abs(torque), joint.loaded_kinematic_error_form
    if form == SIGNED:
        return torque, torque
    if form == LEVELLING and size > 0.0:
        end = joint.loaded_kinematic_error_first * 10.0 * joint.size
        return size / (1.0 + size / end), 2.0 * end * (1.0 - end / size * math.log1p(size / end))
    return size, size


@numba.njit(cache=True, error_model='numpy')
def under_load(joint: Record, law: Array, behind: float, motor: float,
               link: float) -> tuple[float, float]:
    """
    Return the spring's torque with the error that it causes [N*m], and what its lever gains.

    The error follows the torque and the torque the error, until both stand still. Half of the
    error's slope is the lever's: the other half is what the spring stores.
    """
    torque = elastic_torque(joint, law, behind, link)
    size = joint.loaded_kinematic_error_amplitude
    if size == 0.0:
        return torque, 0.0
    angle = 2.0 * motor + joint.loaded_kinematic_error_phase
    for _ in range(200):
        before = torque
        load, _ = ovalised(joint, torque)
        torque = elastic_torque(joint, law, behind + size * load * math.sin(angle), link)
        if abs(torque - before) < 1e-12:
            break
    _, lever = ovalised(joint, torque)
    return torque, size * lever * math.cos(angle)


@numba.njit(cache=True, error_model='numpy')
def hold(joint: Record, law: Array, motor: float, link: float, sliders: Array,
         held: Record) -> None:
    """Write what follows from the angles alone: spring torque, lever and damping."""
    error, slope = transmission_error(joint, motor)
    torsion, share = seat(joint, motor / joint.ratio + error - link)
    torque, gained = under_load(joint, law, torsion, motor, link)
    held.elastic = torque + drag_sliders(joint, torsion, held.torsion, sliders)
    held.torsion = torsion
    held.lever = 1.0 / joint.ratio + slope + gained
    more = joint.structural_damping_coefficient
    if joint.structural_damping_form == WITH_TORSION:
        more *= joint.structural_damping_first * abs(torque) / (5.0 * joint.size)
    held.damping = share * (joint.damping + more)


@numba.njit(cache=True, error_model='numpy')
def dampened(joint: Record, held: Record, rate: float) -> float:
    """Return the torque of the damping at a rate of the torsion [N*m]."""
    if joint.structural_damping_form != HYSTERETIC:
        return held.damping * rate
    pace = joint.structural_damping_first * abs(held.torsion)       # [rad/s], of a slow swing
    share = pace / math.sqrt(rate * rate + 0.09 * pace * pace + 1e-16)
    return (joint.damping + joint.structural_damping_coefficient * share) * rate

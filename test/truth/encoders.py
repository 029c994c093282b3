"""What the link encoders show, and the steps and zeros of all encoders."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
JITTER = 0.3                    # one sigma of both encoders' own noise, in counts as stated
WOBBLES = 32                    # counts over which the steps of an uneven encoder repeat

# Forms of laws, by effect (`forms.py`); 0 is the one of README.md.
THIRD_ORDER, DENT = 1, 2        # link_encoder_eccentricity
TWO_ORDERS, PEAKED, FOURTH_ORDER = 1, 2, 3      # motor_encoder_eccentricity
WARMING, CURVED = 1, 2          # encoder_scale_error
THIRD_HARMONIC, QUADRATURE = 1, 2       # encoder_interpolation_error
UNEVEN, MISSING_CODES = 1, 2    # coarse_quantisation
UNSTEADY, DRIFTING = 1, 2       # clock_skew
STEEPENING, LEVELLING = 1, 2    # bearing_crosstalk


def mount(joints: NDArray[np.void], counts: tuple[float, float], rng: np.random.Generator) -> None:
    """Set the step of each encoder, the stated one or the hidden coarse one, and its phase."""
    for joint in joints:
        for side, name in enumerate(('motor', 'link')):
            stated = 2.0 * np.pi / counts[side]
            hidden = joint['coarse_quantisation_step']
            of_motor = joint['coarse_quantisation_motor_side'] > 0.5
            step = hidden if hidden > 0.0 and of_motor == (name == 'motor') else stated
            joint[f'{name}_step'] = step
            joint[f'{name}_zero'] += rng.uniform(0.0, step)


def link_reading(arm: np.void, joints: NDArray[np.void], link: Array, time: Array,
                 jitter: Array) -> Array:
    """Return what the link encoders show (k, 2) of the true link angles (k, 2) [rad]."""
    return np.stack([
        quantised(joint, shown(joint, link[:, j], time) - crosstalk(arm, joints, j, link)
                  + jitter[:, j])
        for j, joint in enumerate(joints)], axis=1)


def unsteady(joints: NDArray[np.void], link: Array, rate: Array, time: Array,
             deviates: Array) -> Array:
    """Return the link angles (k, 2) where the skew of their clock is not steady [rad]."""
    skew, first = joints['clock_skew_skew'], joints['clock_skew_first']
    jumps = np.where(joints['clock_skew_form'] == UNSTEADY, first, 0.0) * deviates
    drifts = np.where(joints['clock_skew_form'] == DRIFTING, first, 0.0) * (
        2.0 * time / time[-1] - 1.0)[:, None]
    return link + rate * skew * (jumps + drifts)


def shown(joint: np.void, q: Array, time: Array) -> Array:
    """Return the angle with the errors of the scale and its disc [rad]."""
    return (q * (1.0 + scale(joint, q, time))
            + joint['link_encoder_eccentricity_amplitude_1']
            * np.sin(q + joint['link_encoder_eccentricity_phase_1'])
            + joint['link_encoder_eccentricity_amplitude_2']
            * np.sin(2.0 * q + joint['link_encoder_eccentricity_phase_2'])
            + disc(joint, q)
            + joint['encoder_interpolation_error_amplitude'] * interpolation(joint, q)
            + joint['encoder_drift_rate'] * time)


def scale(joint: np.void, q: Array, time: Array) -> Array | float:
    """Return the relative error of the scale, over time or angle where it is not the same."""
    error, first = joint['encoder_scale_error_relative_error'], joint['encoder_scale_error_first']
    if joint['encoder_scale_error_form'] == WARMING:
        return error * (1.0 - 0.5 * np.exp(-np.maximum(time, 0.0) / first))
    if joint['encoder_scale_error_form'] == CURVED:
        return error * (1.0 + first * np.tanh(q - joint['middle']))
    return error


def disc(joint: np.void, q: Array) -> Array | float:
    """Return what a disc has besides two orders: a third one, or a dent [rad]."""
    size = (joint['link_encoder_eccentricity_amplitude_1']
            * joint['link_encoder_eccentricity_first'])
    second = joint['link_encoder_eccentricity_second']
    if joint['link_encoder_eccentricity_form'] == THIRD_ORDER:
        return size * np.sin(3.0 * q + second)
    if joint['link_encoder_eccentricity_form'] == DENT:
        return size * np.exp(-((q - joint['middle'] - second) / 0.15) ** 2)
    return 0.0


def interpolation(joint: np.void, q: Array) -> Array:
    """Return the error between two lines as a share of its size."""
    first, second = (joint[f'encoder_interpolation_error_{name}'] for name in ('first', 'second'))
    angle = (joint['encoder_interpolation_error_lines'] * q
             + joint['encoder_interpolation_error_phase'])
    if joint['encoder_interpolation_error_form'] == THIRD_HARMONIC:
        return np.sin(angle) + first * np.sin(3.0 * angle + second)
    if joint['encoder_interpolation_error_form'] == QUADRATURE:
        return np.sin(angle) + first * np.sin(2.0 * angle + second)
    return np.sin(angle)


def crosstalk(arm: np.void, joints: NDArray[np.void], j: int, link: Array) -> Array | float:
    """
    Return the torsion that is read because the arm's weight tilts the bearing [rad].

    What counts is the tilting moment along the joint's own link: G1 + G2 cos(q2) times g for
    joint 1; for joint 2 it never changes.
    """
    coefficient = joints[j]['bearing_crosstalk_coefficient']
    if coefficient == 0.0:
        return 0.0
    reach = arm['moment_1'] + arm['moment_2'] * np.cos(link[:, 1]) if j == 0 else arm['moment_2']
    if form := joints[j]['bearing_crosstalk_form']:
        usual = arm['moment_1'] + 0.4 * arm['moment_2']
        power = joints[j]['bearing_crosstalk_first'] * (1.0 if form == STEEPENING else -1.0)
        reach = reach * np.abs(reach / usual) ** power
    return coefficient * arm['across'] * reach


def quantised(joint: np.void, angle: Array) -> Array:
    """Return the angle rounded down to the encoder's step, from its own zero [rad]."""
    step = joint['link_step']
    if step <= 0.0:
        return angle
    return np.floor((angle + joint['link_zero']) / step) * step


def missing(joints: NDArray[np.void], reading: Array, side: str) -> Array:
    """Return readings (k, 2) of one side with the codes that coarse encoders lack [rad]."""
    shown = reading.copy()
    for j, joint in enumerate(joints):
        coarse = joint['coarse_quantisation_step'] > 0.0 and (
            (joint['coarse_quantisation_motor_side'] > 0.5) == (side == 'motor'))
        step, first = joint[f'{side}_step'], joint['coarse_quantisation_first']
        code = np.rint(reading[:, j] / max(step, 1e-300))
        if coarse and joint['coarse_quantisation_form'] == MISSING_CODES:
            shown[:, j] -= step * (code % np.round(first) == 0.0)
        elif coarse and joint['coarse_quantisation_form'] == UNEVEN:
            shown[:, j] += step * joint['coarse_quantisation_second'] * np.sin(
                2.0 * np.pi * code / WOBBLES)
    return shown

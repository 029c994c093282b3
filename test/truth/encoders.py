"""What the link encoders show, and the steps and zeros of all encoders."""

import numpy as np
from numpy.typing import NDArray

from .nominal import GRAVITY

Array = NDArray[np.float64]
JITTER = 0.3                    # one sigma of both encoders' own noise, in counts as stated


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


def shown(joint: np.void, q: Array, time: Array) -> Array:
    """Return the angle with the errors of the scale and its disc [rad]."""
    return (q * (1.0 + joint['encoder_scale_error_relative_error'])
            + joint['link_encoder_eccentricity_amplitude_1']
            * np.sin(q + joint['link_encoder_eccentricity_phase_1'])
            + joint['link_encoder_eccentricity_amplitude_2']
            * np.sin(2.0 * q + joint['link_encoder_eccentricity_phase_2'])
            + joint['encoder_interpolation_error_amplitude']
            * np.sin(joint['encoder_interpolation_error_lines'] * q
                     + joint['encoder_interpolation_error_phase'])
            + joint['encoder_drift_rate'] * time)


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
    return coefficient * GRAVITY * reach


def quantised(joint: np.void, angle: Array) -> Array:
    """Return the angle rounded down to the encoder's step, from its own zero [rad]."""
    step = joint['link_step']
    if step <= 0.0:
        return angle
    return np.floor((angle + joint['link_zero']) / step) * step

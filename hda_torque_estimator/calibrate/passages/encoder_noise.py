"""The noise of a motor encoder: what its angle does while the shaft stands."""

from collections.abc import Iterator, Sequence

from hda_arm_sim.model.arm import Arm
import numpy as np
from numpy.typing import NDArray

from .joint_recording import Measured
from ...least_squares.bounds import entered
from ...measurements.measurement import SEGMENT
from ...samples.readings import MOTOR_READING
from ...significance import FOURTH_DIFFERENCES

Floats = NDArray[np.float64]
# Choices unless stated otherwise.
STANDS = 2.0            # times its white noise, by which the angle of a shaft at rest varies
FEWEST = 4              # stretches in which a shaft stands: two seconds
NOISE = 'motor_encoder.noise'


def with_noise(arm: Arm, recordings: Sequence[Measured]) -> Arm:
    """
    Return a joint with the noise that its motor encoder shows at rest, if that is over a count.

    Stated counts may be those of a table that was rounded more finely than its angles are known.
    A shaft that stands would seem to turn then.
    """
    encoder = arm.joints[0].motor_encoder
    stretches = [noise for one in recordings for noise in _at_rest(one)]
    if len(stretches) < FEWEST:
        return arm
    noise = float(np.median(stretches))
    if noise <= max(encoder.step, encoder.noise):
        return arm
    return entered(arm, arm.labels[0], {NOISE: noise})


def _at_rest(one: Measured) -> Iterator[float]:
    """Yield the white noise of each stretch in which the shaft stands [rad]."""
    length = max(round(SEGMENT / one.dt), 8)
    angle = one.readings[:, 0, MOTOR_READING]
    for begin in range(0, len(angle) - length + 1, length):
        part = angle[begin:begin + length]
        noise = float(np.diff(part, 4).std() / np.sqrt(FOURTH_DIFFERENCES))
        if 0.0 < float(part.std()) <= STANDS * noise:
            yield noise

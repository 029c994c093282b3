"""
The numbers of the estimator's state as plain topics, which tools plot by dragging.

They come with `estimator_state`, of the same samples: one JointState for each quantity that every
joint has, one Float64 for each other number. The node and the offline command give the same bytes.
Torques and the tip force have topics of their own (`estimate_messages.py`) and are not repeated.
"""

from collections.abc import Iterator

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.chain_links import ChainLinks
from hda_msgs_json.cdr import encode_number, JointStateEncoder
from hda_msgs_json.samples import JointSamples, NumberSamples
from hda_msgs_json.topics import state_number, state_of_joints, Topic
import numpy as np

from .estimates import Estimates
from .laws import layout
from .state_messages import due_rows, STATE_RATE

ANGLES = {
    'torsion': layout.TORSION, 'kinematic_torsion': layout.KINEMATIC_TORSION,
    'torsion_zero': layout.ZERO_TAKEN}
"""Results of a joint that travel as `position` [rad, output side]."""
TORQUES = {'torque_std': layout.TORQUE_DEVIATION}
EXTERNAL_TORQUES = {
    'external_torque': layout.EXTERNAL_TORQUE, 'external_torque_std': layout.EXTERNAL_DEVIATION}
"""Results of a joint that travel as `effort` [N*m, output side]; those of arms with links."""
OF_TIP = {
    'contact_deviations': layout.CONTACT_DEVIATIONS, 'payload': layout.MASS,
    'payload_std': layout.MASS_DEVIATION, 'conditioning': layout.CONDITIONING}
"""Results of the tip, each a number of its own: 1, kg, kg, 1; of arms with links."""
_VARIANCES = {
    False: (layout.BASE_COVARIANCE, layout.BASE_COVARIANCE + 3),
    True: tuple(layout.WRENCH_COVARIANCE + 7 * axis for axis in range(3))}
_AXES = 'xyz'

Plain = JointSamples | NumberSamples


def number_topics(arm: Arm) -> tuple[Topic, ...]:
    """Return the topics of all numbers, in the order of the messages."""
    nothing = Estimates(np.empty(0, np.int64), np.empty((0, len(arm.joints), layout.RESULTS)),
                        np.empty((0, layout.CHAIN_TIP_RESULTS)), np.empty(0, np.int64))
    return tuple(number_samples(arm, nothing))


def number_samples(arm: Arm, estimates: Estimates, rate: float = STATE_RATE,
                   before: int | None = None) -> dict[Topic, Plain]:
    """Return the numbers of a recording at a rate [Hz], after a sample at `before` [ns]."""
    rows = due_rows(estimates.stamps, rate, before)
    stamps, joints, tip = estimates.stamps[rows], estimates.joints[rows], estimates.tip[rows]
    nothing = np.empty((len(rows), 0))
    found: dict[Topic, Plain] = {
        state_of_joints(name): JointSamples(stamps, arm.labels, joints[:, :, index], nothing,
                                            nothing)
        for name, index in ANGLES.items()}
    found |= {
        state_of_joints(name): JointSamples(stamps, arm.labels, nothing, nothing,
                                            joints[:, :, index])
        for name, index in _torques(arm).items()}
    single = np.column_stack([joints[:, :, layout.MOTOR_SHARE], _of_tip(arm, tip)])
    return found | {state_number(name): NumberSamples(stamps, values)
                    for name, values in zip(_single_names(arm), single.T)}


class NumberEncoder:
    """Encode the numbers of one sample after another, a message for each topic."""

    def __init__(self, arm: Arm) -> None:
        """Prepare the bytes of all messages."""
        self._arm = arm
        self._angles = JointStateEncoder(arm.labels, velocity=False, effort=False)
        self._torques = JointStateEncoder(arm.labels, position=False, velocity=False)
        self._of_torques = tuple(_torques(arm).values())

    def __call__(self, stamp: int, joints: Array, tip: Array) -> list[bytes]:
        """Return the messages of results (n, RESULTS) and (TIP_RESULTS,), as `number_topics`."""
        messages = [self._angles(stamp, position=joints[:, index].tolist())
                    for index in ANGLES.values()]
        messages += [self._torques(stamp, effort=joints[:, index].tolist())
                     for index in self._of_torques]
        single = (joints[:, layout.MOTOR_SHARE], _of_tip(self._arm, tip[np.newaxis])[0])
        return messages + [encode_number(value) for part in single for value in part.tolist()]


def _torques(arm: Arm) -> dict[str, int]:
    return TORQUES if arm.links is None else TORQUES | EXTERNAL_TORQUES


def _single_names(arm: Arm) -> Iterator[str]:
    """Yield the names of the numbers that are no quantity of all joints in one message."""
    yield from (f'motor_share/{label}' for label in arm.labels)
    if arm.links is not None:
        yield from OF_TIP
        in_space = isinstance(arm.links, ChainLinks)
        yield from (f'tip_force_std/{axis}' for axis, _ in zip(_AXES, _VARIANCES[in_space]))


def _of_tip(arm: Arm, tip: Array) -> Array:
    """Return the single numbers of the tip (k, m), none without links."""
    if arm.links is None:
        return np.empty((len(tip), 0))
    variances = tip[:, _VARIANCES[isinstance(arm.links, ChainLinks)]]
    return np.hstack([tip[:, tuple(OF_TIP.values())], np.sqrt(variances)])

"""
The messages that hold estimates: of one sample for the node, of a recording for the command.

Both give the same bytes. What cannot be observed is NaN, or zero for tools that refuse NaN. Of two
links that is all of a tip wrench but its force in the plane. Of any arm it is what the pose hides.
"""

from collections.abc import Sequence

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.chain_links import ChainLinks
from hda_msgs_json.cdr import JointStateEncoder, WrenchEncoder
from hda_msgs_json.samples import JointSamples, WrenchSamples
from hda_msgs_json.topics import (
    BASE_FRAME, joint_torque, JOINT_TORQUES, link_frame, TIP_WRENCH, TIP_WRENCH_TOOL, TOOL_FRAME,
    Topic)
import numpy as np

from .estimates import Estimates
from .laws import layout

UNOBSERVED: dict[str, float] = {'nan': np.nan, 'zero': 0.0}
"""What stands in a wrench where nothing is known."""


def estimate_topics(arm: Arm) -> tuple[Topic, ...]:
    """Return the topics that carry every estimate; without links there is no tip."""
    tip = (TIP_WRENCH, TIP_WRENCH_TOOL) if arm.links is not None else ()
    return (*(joint_torque(label) for label in arm.labels), JOINT_TORQUES, *tip)


class EstimateEncoder:
    """Encode the estimates of one sample after another, a message for each topic."""

    def __init__(self, arm: Arm, unobserved: str = 'nan') -> None:
        """Prepare the bytes of all messages."""
        self._nothing = UNOBSERVED[unobserved]
        self.topics = estimate_topics(arm)
        self._has_tip = arm.links is not None
        self._in_space = isinstance(arm.links, ChainLinks)
        self._joint_wrenches = [WrenchEncoder(link_frame(label)) for label in arm.labels]
        self._torques = JointStateEncoder(arm.labels, position=False, velocity=False)
        self._base, self._tool = WrenchEncoder(BASE_FRAME), WrenchEncoder(TOOL_FRAME)

    def __call__(self, stamp: int, joints: Array, tip: Array) -> list[bytes]:
        """Return the messages of results (n, RESULTS) and (TIP_RESULTS,) in order of `topics`."""
        torque = joints[:, layout.TORQUE].tolist()
        nothing = self._nothing
        unknown = (nothing,) * 3
        messages = [encode(stamp, unknown, (nothing, nothing, *self._known([value])))
                    for encode, value in zip(self._joint_wrenches, torque)]
        messages.append(self._torques(stamp, effort=torque))
        if self._has_tip:
            for encode, plane, space in (
                    (self._base, layout.BASE_X, layout.BASE_WRENCH),
                    (self._tool, layout.TOOL_X, layout.TOOL_WRENCH)):
                if self._in_space:
                    wrench = self._known(tip[space:space + 6].tolist())
                    messages.append(encode(stamp, wrench[:3], wrench[3:]))
                else:
                    force = self._known(tip[plane:plane + 2].tolist())
                    messages.append(encode(stamp, (*force, nothing), unknown))
        return messages

    def _known(self, values: Sequence[float]) -> Sequence[float]:
        """Return values, with those that are NaN as they shall be written."""
        nothing = self._nothing
        return values if nothing != nothing else [
            nothing if value != value else value for value in values]


def estimate_samples(arm: Arm, estimates: Estimates, unobserved: str = 'nan',
                     ) -> dict[Topic, JointSamples | WrenchSamples]:
    """Return the messages of a recording, by the topics of `estimate_topics`."""
    stamps, torque = estimates.stamps, estimates.torque
    unknown = np.full((len(stamps), 3), UNOBSERVED[unobserved])

    def known(values: Array) -> Array:
        return values if unobserved == 'nan' else np.where(np.isnan(values), 0.0, values)

    samples: dict[Topic, JointSamples | WrenchSamples] = {
        joint_torque(label): WrenchSamples(
            stamps, link_frame(label), unknown, np.column_stack([unknown[:, :2], column]))
        for label, column in zip(arm.labels, known(torque).T)}
    nothing = np.empty((len(stamps), 0))
    samples[JOINT_TORQUES] = JointSamples(stamps, arm.labels, nothing, nothing, torque)
    if isinstance(arm.links, ChainLinks):
        for topic, frame, wrench in ((TIP_WRENCH, BASE_FRAME, known(estimates.base_wrench)),
                                     (TIP_WRENCH_TOOL, TOOL_FRAME, known(estimates.tool_wrench))):
            samples[topic] = WrenchSamples(stamps, frame, wrench[:, :3], wrench[:, 3:])
    elif arm.links is not None:
        for topic, frame, force in ((TIP_WRENCH, BASE_FRAME, estimates.base_force),
                                    (TIP_WRENCH_TOOL, TOOL_FRAME, estimates.tool_force)):
            samples[topic] = WrenchSamples(
                stamps, frame, np.column_stack([known(force), unknown[:, 2]]), unknown)
    return samples

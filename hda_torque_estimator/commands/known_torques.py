"""What a bag knows of torques and forces that no estimator knows: truths and sensors."""

from collections.abc import Sequence
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
from hda_msgs_json.bag import Recording
from hda_msgs_json.samples import WrenchSamples
from hda_msgs_json.topics import (reference_joint_torque, REFERENCE_TIP_WRENCH, truth_joint_torque,
                                  TRUTH_TIP_WRENCH)
import numpy as np
from numpy.typing import NDArray

from ..estimating.accuracy import errors, EstimateErrors
from ..estimating.estimates import Estimates


class KnownSignal(NamedTuple):
    """A known signal (m,) at its stamps [ns], and the estimate (k,) that it speaks of."""

    stamps: NDArray[np.int64]
    values: Array
    estimate: Array


def known_signals(recording: Recording, arm: Arm, estimates: Estimates) -> dict[str, KnownSignal]:
    """Return every truth and reference that a bag holds, by its topic and axis."""
    found = {}
    for column, label in zip(estimates.torque.T, arm.labels):
        for topic in (truth_joint_torque(label), reference_joint_torque(label)):
            if name := _held(recording, topic.name):
                wrenches = recording.wrenches(name)
                found[topic.name] = KnownSignal(wrenches.stamps, wrenches.torque[:, 2], column)
    for topic in (TRUTH_TIP_WRENCH, REFERENCE_TIP_WRENCH):
        name = _held(recording, topic.name)
        if name and arm.links is not None:
            wrenches = recording.wrenches(name)
            for axis, column in enumerate(estimates.tip_force.T):
                found[f'{topic.name}.{"xyz"[axis]}'] = KnownSignal(
                    wrenches.stamps, wrenches.force[:, axis], column)
    return found


def references_of(recording: Recording, labels: Sequence[str]) -> dict[str, WrenchSamples]:
    """Return the reference torques that a bag holds, by joint."""
    topics = {label: _held(recording, reference_joint_torque(label).name) for label in labels}
    return {label: recording.wrenches(topic) for label, topic in topics.items() if topic}


def all_errors(known: dict[str, KnownSignal], estimates: Estimates) -> dict[str, EstimateErrors]:
    """Return the errors of estimates against every known signal."""
    return {name: errors(estimates.stamps, one.estimate, one.stamps, one.values)
            for name, one in known.items()}


def _held(recording: Recording, topic: str) -> str | None:
    return next((name for name in recording.topics if name.strip('/') == topic), None)

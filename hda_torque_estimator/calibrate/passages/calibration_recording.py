"""A recording that is to be calibrated from: its joints, and where their torque is known from."""

from collections.abc import Mapping
from typing import NamedTuple

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.chain_links import ChainLinks
from hda_msgs_json.samples import JointSamples, WrenchSamples
from hda_msgs_json.topics import EXTERNAL_WRENCH, reference_joint_torque, REFERENCE_TIP_WRENCH
import numpy as np
from numpy.typing import NDArray

from .joint_recording import CalibrationError
from .loads import loads
from .passage import Passage, passages
from .stated_conditions import StatedConditions
from .suitability import check_alike
from ...measurements.even_grid import on_grid
from ...measurements.measurement import Measurement
from ...measurements.motion import motion_of
from ...measurements.recording_checks import check_names
from ...measurements.sample_grid import measurement_from
from ...samples.readings import readings

Floats = NDArray[np.float64]
# Choices unless stated otherwise.
FEWEST = 100            # samples from which a motion can be differentiated


class CalibrationRecording(NamedTuple):
    """What a calibration reads of one recording."""

    name: str
    passages: dict[str, Passage]
    stated: StatedConditions
    sensed: frozenset[str]          # joints with a torque sensor
    pushed: bool                    # whether a known force acted on the tip
    weighed: bool                   # whether links have weight as the arm file has them

    def sources(self, label: str) -> list[str]:
        """Return what makes the torque of a joint known, in words."""
        if label in self.sensed:
            return [f'the reference sensor of {label}']
        known = [f'{words} of {self.name}' for words in [self.stated.sentence()] if words]
        known += [f'the known force on the tip in {self.name}'] if self.pushed else []
        return known + (['the weight on the base that stands as in the arm file']
                        if self.weighed and self.stated.tilt is None else [])


def heard(states: JointSamples, wrenches: Mapping[str, WrenchSamples], name: str, arm: Arm,
          known: StatedConditions) -> CalibrationRecording:
    """
    Return a recording of an arm from its joint states, and wrenches by their topics.

    `known` is what is stated of it.

    Raises CalibrationError or GateError naming the recording and what is wrong with it.
    """
    stood = known.on(arm)
    check_names(states, arm, name)
    seen = measurement_from(arm.labels, states, name)
    if len(seen.command) < FEWEST:
        raise CalibrationError(f'{name} is too short: it has {len(seen.command)} samples of all '
                               f'angles and motor torques, at least {FEWEST} are needed')
    seen = on_grid(seen)
    stamps = _grid(states, arm, seen)
    wrench, pushed = _wrench(wrenches, stamps)
    sensed = {label: _interpolated(stamps, sensor, sensor.torque[:, 2])
              for label in arm.labels
              if (sensor := wrenches.get(reference_joint_torque(label).name)) is not None}
    if known != StatedConditions() or pushed:
        own = loads(stood, motion_of(seen, stood), wrench).torque
        for place, label in enumerate(arm.labels):
            if label in sensed:
                check_alike(label, name, sensed[label], own[:, place])
    return CalibrationRecording(name, passages(name, stood, seen, wrench, sensed), known,
                                frozenset(sensed),
                                pushed, arm.base.tilt > 0.0 or isinstance(arm.links, ChainLinks))


def _grid(states: JointSamples, arm: Arm, seen: Measurement) -> NDArray[np.int64]:
    """Return the stamps of a measurement's samples [ns]."""
    known = np.isfinite(readings(arm.labels, states)[:, :, :2]).all(axis=(1, 2))
    first = int(states.stamps[known][0])
    return first + np.round(seen.time * 1e9).astype(np.int64)


def _wrench(wrenches: Mapping[str, WrenchSamples],
            stamps: NDArray[np.int64]) -> tuple[Floats, bool]:
    """Return the known wrench on the tip (k, 6) [N, N*m, base], NaN where unknown; if any acts."""
    sensor = wrenches.get(REFERENCE_TIP_WRENCH.name)
    source = wrenches.get(EXTERNAL_WRENCH.name) if sensor is None else sensor
    if source is None:
        return np.zeros((len(stamps), 6)), False
    columns = np.column_stack([source.force, source.torque])
    wrench = np.stack([_interpolated(stamps, source, column) for column in columns.T], axis=1)
    if sensor is None:                      # a push that was asked for is known to end
        wrench = np.nan_to_num(wrench)
    return wrench, bool(np.nanmax(np.abs(wrench), initial=0.0) > 0.0)


def _interpolated(stamps: NDArray[np.int64], source: WrenchSamples, values: Floats) -> Floats:
    """Return values of a sensor at stamps (k,), NaN beyond its own."""
    begin = int(source.stamps[0])
    return np.interp(stamps - begin, source.stamps - begin, values, np.nan, np.nan)

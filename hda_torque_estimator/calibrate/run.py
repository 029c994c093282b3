"""Calibrate from bags: `hda calibrate BAG... --arm FILE --out FILE`."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.model.writing import write_arm
from hda_msgs_json.bag import open_recording, Recording
from hda_msgs_json.outputs import check_file
from hda_msgs_json.samples import WrenchSamples
from hda_msgs_json.topics import EXTERNAL_WRENCH, reference_joint_torque, REFERENCE_TIP_WRENCH

from .calibration import Calibration
from .ordinary import calibrate_ordinary
from .passages.calibration_recording import CalibrationRecording, heard
from .passages.joint_recording import CalibrationError, Measured, measured
from .passages.passage import Passage
from .passages.stated_conditions import stated, StatedConditions
from .passages.suitability import SHORTEST
from .referenced import calibrate

Words = Sequence[Sequence[str]]


class Sources(NamedTuple):
    """The recordings of a calibration, and what is known of them."""

    bags: Sequence[Path]
    tilts: Words = ()           # of the base in a recording: bag, degrees, direction
    payloads: Words = ()        # that hung at the tip in a recording: bag, kg
    opened: Callable[[Path], Recording] = open_recording
    zero_moves: bool = False    # of each torsion, from recording to recording


def run_calibration(sources: Sources, arm_file: str, out: Path, *,
                    joints: Sequence[str] | None = None, force: bool = False,
                    notify: Callable[[str], None] = lambda text: None) -> Calibration:
    """
    Write the arm that the recordings call for, and return what was found.

    With `joints`, the others stay as they are. `notify` hears what is being done. Raises
    CalibrationError, GateError, BagError, ArmError or OutputError; nothing is written then.
    """
    bags = sources.bags
    places = [bag.resolve() for bag in bags]
    if twice := sorted({str(place) for place in places if places.count(place) > 1}):
        raise CalibrationError(f'{twice[0]} is given twice; each recording counts once')
    check_file(out, force=force, reads=bags)
    arm = read_arm(arm_file)
    chosen = arm.labels if joints is None else [arm.joint(label).label for label in joints]
    known = stated(bags, sources.tilts, sources.payloads)
    recordings = [sources.opened(bag) for bag in bags]
    if arm.links is None or _are_snatches(recordings, chosen):
        calibration = _from_sensors(arm, sources, recordings, chosen, notify)
    elif sources.zero_moves:
        raise CalibrationError('--zero-moves is for recordings with reference torques and an arm '
                               'with links: none; links give the zero themselves')
    else:
        calibration = _from_loads(arm, bags, recordings, known, chosen, notify)
    write_arm(calibration.arm, out, force=force)
    return calibration


def _are_snatches(recordings: Sequence[Recording], labels: Sequence[str]) -> bool:
    """Return whether sensors were recorded, but for too short a time to distinguish laws."""
    sensed = any(_has(recording, reference_joint_torque(label).name)
                 for recording in recordings for label in labels)
    return sensed and sum(recording.duration for recording in recordings) < SHORTEST


def _has(recording: Recording, topic: str) -> bool:
    return topic in (found.strip('/') for found in recording.topics)


def _from_sensors(arm: Arm, sources: Sources, opened: Sequence[Recording],
                  labels: Sequence[str], notify: Callable[[str], None]) -> Calibration:
    """Return the calibration of joints with reference torques, from whatever there is."""
    recordings: dict[str, list[Measured]] = {label: [] for label in labels}
    for bag, recording in zip(sources.bags, opened):
        for label, found in recordings.items():
            found.extend(_measured(recording, bag.name, label))
    return calibrate(arm, recordings, notify, zero_moves=sources.zero_moves)


def _measured(recording: Recording, name: str, label: str) -> list[Measured]:
    """Return what a recording holds of a joint, an empty list if it has no reference of it."""
    topic = reference_joint_torque(label).name
    if not _has(recording, topic):
        return []
    found = measured(name, label, recording.joint_states(), recording.wrenches(topic))
    return [] if found is None else [found]


def _from_loads(arm: Arm, bags: Sequence[Path], opened: Sequence[Recording],
                known: Sequence[StatedConditions], labels: Sequence[str],
                notify: Callable[[str], None]) -> Calibration:
    """Return the calibration of joints whose torque follows from loads, or from sensors."""
    everything: list[CalibrationRecording] = []
    for bag, recording, stated_of_it in zip(bags, opened, known):
        notify(f'reading {bag.name}')
        everything.append(heard(recording.joint_states(), known_wrenches(recording, arm),
                                bag.name, arm, stated_of_it))
    passages: dict[str, list[Passage]] = {
        label: [one.passages[label] for one in everything] for label in labels}
    scales = {label: scale_of(everything, label) for label in labels}
    return calibrate_ordinary(arm, passages, scales, notify)


def known_wrenches(recording: Recording, arm: Arm) -> dict[str, WrenchSamples]:
    """Return what a recording holds of known torques and forces, by topic."""
    topics = [*(reference_joint_torque(label).name for label in arm.labels),
              REFERENCE_TIP_WRENCH.name, EXTERNAL_WRENCH.name]
    found = {topic: recording.wrenches(topic) for topic in topics if _has(recording, topic)}
    return {topic: wrenches for topic, wrenches in found.items() if len(wrenches) > 1}


def scale_of(everything: Sequence[CalibrationRecording], label: str) -> str:
    """Return what fixes the scale of a joint's torque, in words."""
    sources = [source for one in everything for source in one.sources(label)]
    if not sources:
        return ('no independent torque: the inertia of the links in the arm file, so every torque '
                'is as right as that; state a --tilt or a --payload, or record a force')
    return ', '.join(dict.fromkeys(sources))

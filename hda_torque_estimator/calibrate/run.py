"""Calibrate from bags: `hda calibrate BAG... --arm FILE --out FILE`."""

from collections.abc import Sequence
from pathlib import Path

from hda_arm_sim.model.files import read_arm, write_arm
from hda_msgs_json.bag import open_recording, Recording
from hda_msgs_json.topics import reference_joint_torque

from .calibration import calibrate, Calibration
from .measured import CalibrationError, Measured, measured


def run_calibration(bags: Sequence[Path], arm_file: str, out: Path, *,
                    joints: Sequence[str] | None = None) -> Calibration:
    """
    Write the arm that the recordings call for, and return what was found.

    With `joints`, the others stay as they are, as those without a reference torque do anyway.
    Raises CalibrationError, BagError or ArmError; then nothing is written.
    """
    places = [bag.resolve() for bag in bags]
    if twice := sorted({str(place) for place in places if places.count(place) > 1}):
        raise CalibrationError(f'{twice[0]} is given twice; each recording counts once')
    arm = read_arm(arm_file)
    chosen = arm.labels if joints is None else [arm.joint(label).label for label in joints]
    recordings: dict[str, list[Measured]] = {label: [] for label in chosen}
    for bag in bags:
        opened = open_recording(bag)
        for label, found in recordings.items():
            found.extend(_measured(opened, bag.name, label))
    calibration = calibrate(arm, recordings)
    write_arm(calibration.arm, out)
    return calibration


def _measured(recording: Recording, name: str, label: str) -> list[Measured]:
    """Return what a recording holds of a joint, an empty list if it has no reference of it."""
    topic = reference_joint_torque(label).name
    if topic not in (found.strip('/') for found in recording.topics):
        return []
    found = measured(name, label, recording.joint_states(), recording.wrenches(topic))
    return [] if found is None else [found]

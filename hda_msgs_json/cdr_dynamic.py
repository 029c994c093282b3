"""control_msgs/DynamicJointState: joints with interfaces of any names, as columns."""

from collections.abc import Sequence

from hda_msgs_json.cdr_fields import CdrError, FieldReader
from hda_msgs_json.samples import Floats, Stamps
import numpy as np


def decode_dynamic_joint_states(messages: Sequence[bytes]) -> tuple[Stamps, dict[str, Floats]]:
    """
    Return the stamps [ns] (n,) and the columns JOINT.INTERFACE (n,) of messages.

    Raises CdrError for a broken message, or one with other names than the first.
    """
    stamps = np.empty(len(messages), np.int64)
    rows: list[Floats] = []
    names: tuple[str, ...] = ()
    for number, message in enumerate(messages):
        try:
            stamps[number], found, values = _read(message)
            if number and found != names:
                raise CdrError('it names other joints or interfaces than the first')
        except CdrError as error:
            raise CdrError(f'message {number}: {error}') from None
        names = found
        rows.append(values)
    table = np.array(rows).reshape(len(rows), len(names))
    return stamps, {name: table[:, place] for place, name in enumerate(names)}


def _read(message: bytes) -> tuple[int, tuple[str, ...], Floats]:
    """Return stamp [ns], names JOINT.INTERFACE and values of one message."""
    fields = FieldReader(message)
    stamp, _ = fields.stamp(), fields.string('frame_id')
    joints = fields.strings('joint_names')
    if (count := fields.uint32('interface_values')) != len(joints):
        raise CdrError(f'interface_values has {count} entries for {len(joints)} joints')
    names: list[str] = []
    values = [np.empty(0)]
    for joint in joints:
        interfaces = fields.strings('interface_names')
        values.append(fields.values(fields.doubles('values')))
        if len(values[-1]) != len(interfaces):
            raise CdrError(f'values has {len(values[-1])} numbers for {len(interfaces)} '
                           f'interfaces of {joint}')
        names += [f'{joint}.{interface}' for interface in interfaces]
    fields.finish()
    if len(set(names)) < len(names):
        raise CdrError('an interface is named twice')
    return stamp, tuple(names), np.concatenate(values)

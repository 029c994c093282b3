"""What a part of the balances depends on: bytes of the fields of an arm's record that it reads."""

from collections.abc import Callable, Hashable
from typing import Generic, TypeVar

from hda_arm_sim.model.arm import Arm, ArmRecord, JOINT_RECORD
from hda_arm_sim.model.effects import Effect
import numpy as np
from numpy.typing import NDArray

from .recent_cache import RecentCache

Key = TypeVar('Key')
# Numerics; choices unless stated otherwise.
_ARMS = 2               # whose keys are kept: derivatives compare one arm after another to one
# Each number of a joint's record is its own place in it: the record has nothing but numbers.
_PLACES = np.arange(JOINT_RECORD.itemsize // np.dtype(np.float64).itemsize,
                    dtype=np.float64).view(JOINT_RECORD)


def places_of(*fields: str | type[Effect]) -> NDArray[np.intp]:
    """Return where the numbers of these fields, or effects, stand in the record of a joint."""
    names = [field if isinstance(field, str) else field.name for field in fields]
    return np.concatenate([_PLACES[name].copy().view(np.float64).ravel()
                           for name in names]).astype(np.intp)


def key_of(record: ArmRecord, joint: int, places: NDArray[np.intp]) -> bytes:
    """Return these numbers of a joint, to compare them."""
    numbers = record.joints.view(np.float64).reshape(len(record.joints), -1)
    return bytes(numbers[joint, places].tobytes())


class KeysOfArms(Generic[Key]):
    """Keys of the arms that were asked for last, by what they are of: found once for each arm."""

    def __init__(self) -> None:
        """Know nothing yet."""
        self._known = RecentCache[tuple[Arm, dict[Hashable, Key]]](_ARMS)

    def of(self, arm: Arm, what: Hashable, find: Callable[[], Key]) -> Key:
        """Return a key of an arm; who keeps the arm itself keeps its identity from others."""
        keys = self._known.of(id(arm), lambda: (arm, {}))[1]
        if what not in keys:
            keys[what] = find()
        return keys[what]

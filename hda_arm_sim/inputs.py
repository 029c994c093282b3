"""Read what a node is sent; whatever is wrong with a message becomes one refusal."""

from collections.abc import Sequence

from hda_msgs_json.cdr import CdrError, decode_wrench, JointState, JointStateDecoder
from hda_msgs_json.columns import ColumnFinder, LengthsError, NamesError
from hda_msgs_json.topics import BASE_FRAME
import numpy as np

from .foundation.arrays import Array
from .health import Refused

UNREADABLE = (CdrError, LengthsError, NamesError)
_REASONS: dict[type[Exception], str] = {
    CdrError: 'malformed message', LengthsError: 'wrong lengths', NamesError: 'wrong names'}


def refusal(error: Exception) -> Refused:
    """Return the refusal of a message that raised one of `UNREADABLE`."""
    return Refused(_REASONS[type(error)], str(error))


class EffortReader:
    """Read the efforts of given names from one JointState after another."""

    def __init__(self, names: Sequence[str]) -> None:
        """Prepare for these names, which may stand in any order among others."""
        self._decode = JointStateDecoder()
        self._find = ColumnFinder(names, 'effort')

    def __call__(self, message: bytes) -> tuple[int, Array]:
        """Return the stamp [ns] and the efforts (n,) [N*m] of the names; raises Refused."""
        try:
            state: JointState = self._decode(message)
            return state.stamp_ns, state.effort[self._find(state)]
        except UNREADABLE as error:
            raise refusal(error) from None


def tip_force(message: bytes, axes: int = 2) -> Array:
    """
    Return what a WrenchStamped in the base frame does to the tip (axes,), or refuse.

    That is the force in the plane [N], or with 6 axes force and moment [N, N*m].
    """
    try:
        wrench = decode_wrench(message)
    except CdrError as error:
        raise refusal(error) from None
    if wrench.frame_id not in ('', BASE_FRAME):
        raise Refused('wrong frame', f'the frame must be {BASE_FRAME!r}, got {wrench.frame_id!r}')
    return np.concatenate([wrench.force, wrench.torque])[:axes]

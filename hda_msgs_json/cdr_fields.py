"""The fields of a CDR message one after another, with the checks that foreign bytes need."""

from dataclasses import dataclass
import struct

from hda_msgs_json.errors import HdaError
import numpy as np
from numpy.typing import NDArray

LITTLE_ENDIAN = b'\x00\x01\x00\x00'
BIG_ENDIAN = b'\x00\x00'
HEADER_SIZE = 4
NANOSECONDS = 1_000_000_000
MOST_PADDING = 15
"""ROS reserves up to this many bytes behind a message for the alignment of empty sequences."""


class CdrError(HdaError):
    """Raised when bytes are not the message that they should be, or a message has no bytes."""


@dataclass(frozen=True)
class Doubles:
    """Name a run of float64 values in a message: where it starts [bytes] and how many."""

    start: int
    count: int

    @property
    def stop(self) -> int:
        """Return the offset of the first byte after the values."""
        return self.start + 8 * self.count


class FieldReader:
    """
    Read a message field by field; every method raises CdrError where the bytes run out.

    `structure` names the bytes that were read as counts and texts. They are neither time, nor
    numbers, nor the padding, which ROS leaves as it finds it.
    """

    def __init__(self, message: bytes | memoryview) -> None:
        """Check the encapsulation header; big-endian messages are read as well."""
        self._bytes = memoryview(message)
        self._at = HEADER_SIZE
        self.structure = [slice(0, 2)]
        header = bytes(self._bytes[:HEADER_SIZE])
        if len(header) < HEADER_SIZE or header[:2] not in (LITTLE_ENDIAN[:2], BIG_ENDIAN):
            raise CdrError(
                'a CDR message starts with the four bytes 00 01 00 00 (or 00 00 .. ..), '
                f'got {header.hex(" ") or "nothing"}')
        self.order = '>' if header[:2] == BIG_ENDIAN else '<'
        self._uint32 = struct.Struct(self.order + 'I')
        self._stamp = struct.Struct(self.order + 'iI')

    def uint32(self, what: str) -> int:
        """Read a count."""
        start = self._take(4, 4, what)
        self.structure.append(slice(start, self._at))
        return int(self._uint32.unpack_from(self._bytes, start)[0])

    def stamp(self) -> int:
        """Read a time [ns]."""
        seconds, nanoseconds = self._stamp.unpack_from(self._bytes, self._take(4, 8, 'stamp'))
        return int(seconds) * NANOSECONDS + int(nanoseconds)

    def string(self, what: str) -> str:
        """Read a text; an empty one may come without its terminating zero."""
        size = self.uint32(what)
        start = self._take(1, size, what)
        self.structure.append(slice(start, self._at))
        text = bytes(self._bytes[start:start + size])
        if size and text[-1]:
            raise CdrError(f'{what} does not end in a zero byte')
        try:
            return text[:-1].decode()
        except UnicodeDecodeError:
            raise CdrError(f'{what} is not UTF-8 text: {text[:20]!r}') from None

    def strings(self, what: str) -> tuple[str, ...]:
        """Read a sequence of texts."""
        count = self.uint32(what)
        if 4 * count > len(self._bytes) - self._at:
            raise CdrError(f'{what} claims {count} entries, more than the message has room for')
        return tuple(self.string(what) for _ in range(count))

    def doubles(self, what: str, count: int | None = None) -> Doubles:
        """Pass over float64 values; without a count, a sequence that starts with its own."""
        if count is None:
            count = self.uint32(what)
        start = self._take(8, 8 * count, what) if count else self._at
        return Doubles(start, count)

    def values(self, doubles: Doubles) -> NDArray[np.float64]:
        """Return the values that were passed over, as an array of native order."""
        found = np.frombuffer(self._bytes, self.order + 'f8', doubles.count, doubles.start)
        return found.astype(np.float64, copy=False)

    def finish(self) -> None:
        """Raise CdrError if more than padding follows."""
        if (left := len(self._bytes) - self._at) > MOST_PADDING:
            raise CdrError(f'{left} bytes follow the end of the message')

    def _take(self, alignment: int, size: int, what: str) -> int:
        start = self._at + (HEADER_SIZE - self._at) % alignment
        if start + size > len(self._bytes):
            raise CdrError(
                f'{what} needs {size} bytes at offset {start}, the message has '
                f'{len(self._bytes)} in all')
        self._at = start + size
        return start


class FieldWriter:
    """Write a little-endian message field by field."""

    def __init__(self) -> None:
        """Start with the encapsulation header."""
        self._bytes = bytearray(LITTLE_ENDIAN)

    def __bytes__(self) -> bytes:
        """Return the message so far."""
        return bytes(self._bytes)

    def uint32(self, value: int) -> None:
        """Write a count."""
        self._align(4)
        self._bytes += struct.pack('<I', value)

    def stamp(self, stamp_ns: int) -> None:
        """Write a time [ns]; raise CdrError beyond the 68 years that a ROS time holds."""
        self._align(4)
        self._bytes += pack_stamp(stamp_ns)

    def string(self, text: str, what: str) -> None:
        """Write a text; raise CdrError if ROS could not carry it."""
        if '\0' in text:
            raise CdrError(f'{what} must not contain a zero byte, got {text!r}')
        try:
            encoded = text.encode() + b'\0'
        except UnicodeEncodeError:
            raise CdrError(f'{what} must be Unicode text, got {text!r}') from None
        self.uint32(len(encoded))
        self._bytes += encoded

    def doubles(self, values: NDArray[np.float64]) -> None:
        """Write float64 values without a count."""
        if len(values):
            self._align(8)
        self._bytes += values.astype('<f8', copy=False).tobytes()

    def _align(self, alignment: int) -> None:
        self._bytes += bytes((HEADER_SIZE - len(self._bytes)) % alignment)


def pack_stamp(stamp_ns: int) -> bytes:
    """Return the eight bytes of a ROS time; raise CdrError if it does not fit in one."""
    try:
        return struct.pack('<iI', *divmod(stamp_ns, NANOSECONDS))
    except struct.error:
        raise CdrError(f'a stamp must fit in 32 bits of seconds, got {stamp_ns} ns') from None

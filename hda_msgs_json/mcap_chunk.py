"""The compression of MCAP chunks, with bounds on what foreign bytes may grow to."""

from io import BytesIO
from pathlib import Path
import zlib

from hda_msgs_json.cdr_batch import Batch, batch_of
from hda_msgs_json.mcap_records import BagError
import lz4.frame
import numpy as np
import zstandard

SMALL = 16 << 20
"""Any chunk may grow to this many bytes, whatever its ratio."""
LARGEST = 256 << 20
"""No chunk may grow beyond this many bytes."""
STEEPEST = 1000
"""A chunk beyond `SMALL` that claims to grow more than this many times is a bomb."""

COMPRESSIONS = {'zstd': 'zstd', 'lz4': 'lz4', 'none': ''}
"""Names that users give, and those that MCAP gives."""
PIECE = 1 << 16
ZSTD_MAGIC = b'\x28\xb5\x2f\xfd'
"""No CDR message starts like this."""


def compress(content: bytes | memoryview, compression: str, level: int) -> bytes:
    """Return the content of a chunk as it is stored; zstd takes the level."""
    if compression == 'zstd':
        return zstandard.ZstdCompressor(level, write_checksum=True).compress(content)
    if compression == 'lz4':
        return bytes(lz4.frame.compress(content))
    return bytes(content)


def decompress(stored: bytes, compression: str, size: int, crc: int) -> bytes:
    """Return the content of a whole chunk; raise BagError unless it is as its head says."""
    check_growth(len(stored), size)
    try:
        content = _decompress(stored, compression, size)
    except (zstandard.ZstdError, RuntimeError, ValueError, EOFError) as error:
        raise BagError(f'its {compression} data are broken ({_first_line(error)})') from None
    if len(content) != size:
        raise BagError(f'it holds {len(content)} bytes instead of {size}')
    if crc and not _checks_itself(stored, compression) and zlib.crc32(content) != crc:
        raise BagError('its checksum is wrong')
    return content


def salvage(stored: bytes, compression: str, size: int) -> bytes:
    """Return what a chunk that was cut off still gives: the beginning of its content."""
    check_growth(max(len(stored), size // STEEPEST), size)
    if compression == 'zstd':
        return _salvage_zstd(stored, size)
    if compression == 'lz4':
        try:
            return bytes(lz4.frame.LZ4FrameDecompressor().decompress(stored, max_length=size))
        except (RuntimeError, EOFError):
            return b''
    return bytes(stored[:size]) if compression == '' else b''


def expand_file(path: Path, target: Path) -> None:
    """Write what a file that zstd compressed as a whole holds; raise BagError if it cannot."""
    most = max(SMALL, STEEPEST * path.stat().st_size)
    try:
        with path.open('rb') as source, target.open('wb') as stream:
            reader = zstandard.ZstdDecompressor().stream_reader(source)
            while piece := reader.read(PIECE):
                stream.write(piece)
                if stream.tell() > most:
                    raise BagError(f'{path} becomes more than {most} bytes, which is not read')
    except zstandard.ZstdError as error:
        raise BagError(f'{path} is not compressed with zstd: {_first_line(error)}') from None
    except OSError as error:
        raise BagError(f'{path} cannot be expanded: {error.strerror}') from None


def expanded(batch: Batch) -> Batch:
    """Return the messages, those that rosbag2 compressed one by one as they were."""
    messages = np.flatnonzero(batch.sizes >= len(ZSTD_MAGIC))
    if not len(messages) or batch.message(messages[0])[:len(ZSTD_MAGIC)] != ZSTD_MAGIC:
        return batch
    return batch_of([expanded_message(batch.message(n)) for n in range(len(batch.sizes))])


def expanded_message(message: bytes) -> bytes:
    """Return a message that rosbag2 may have compressed on its own; raise BagError."""
    if not message.startswith(ZSTD_MAGIC):
        return message
    try:
        size = zstandard.frame_content_size(message)
        check_growth(len(message), size)
        return bytes(zstandard.ZstdDecompressor().decompress(message, max_output_size=SMALL))
    except zstandard.ZstdError as error:
        raise BagError(f'a compressed message is broken ({_first_line(error)})') from None


def check_growth(stored: int, size: int) -> None:
    """Raise BagError if so many bytes claim to grow beyond bounds."""
    if size > LARGEST or size > max(SMALL, STEEPEST * stored):
        raise BagError(f'{stored} bytes claim to become {size}, which is more than is read')


def _decompress(stored: bytes, compression: str, size: int) -> bytes:
    if compression == '':
        return stored
    if compression == 'zstd':
        # One that names another size in its own head would be believed before `size` is.
        named = zstandard.frame_content_size(stored)
        if named not in (-1, size):
            raise BagError(f'it holds {named} bytes instead of {size}')
        return bytes(zstandard.ZstdDecompressor().decompress(stored, max_output_size=size))
    if compression == 'lz4':
        return bytes(lz4.frame.LZ4FrameDecompressor().decompress(stored, max_length=size))
    raise BagError(f'its compression {compression!r} is not one of zstd, lz4 and none')


def _checks_itself(stored: bytes, compression: str) -> bool:
    """Return whether data carry a checksum that was verified as they were decompressed."""
    return compression == 'zstd' and zstandard.get_frame_parameters(stored).has_checksum


def _salvage_zstd(stored: bytes, size: int) -> bytes:
    content = bytearray()
    reader = zstandard.ZstdDecompressor().stream_reader(BytesIO(stored))
    try:
        while len(content) < size and (piece := reader.read(PIECE)):
            content += piece
    except zstandard.ZstdError:
        pass
    return bytes(content[:size])


def _first_line(error: Exception) -> str:
    return str(error).splitlines()[0] if str(error) else type(error).__name__

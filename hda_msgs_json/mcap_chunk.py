"""The compression of MCAP chunks, with bounds on what foreign bytes may grow to."""

from io import BytesIO
import zlib

from hda_msgs_json.mcap_records import BagError
import lz4.frame
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


def compress(content: bytes, compression: str, level: int) -> bytes:
    """Return the content of a chunk as it is stored; zstd takes the level."""
    if compression == 'zstd':
        return zstandard.ZstdCompressor(level).compress(content)
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
    if crc and zlib.crc32(content) != crc:
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

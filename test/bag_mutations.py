"""Bags that something went wrong with: bits, cuts, records out of place, lies and bombs."""

from collections.abc import Callable
from functools import cache
from pathlib import Path
import random
import struct
from typing import Any

from bag_content import START, write_mcap
from hda_msgs_json.cdr import encode_joint_state, encode_string, encode_wrench
from hda_msgs_json.mcap_walk import record_starts
import lz4.frame
from mcap.opcode import Opcode
from mcap.writer import CompressionType
import zstandard

NAMES = ('joint1', 'joint1_motor', 'joint2', 'joint2_motor')
MAGIC_SIZE = 8
KINDS: dict[str, dict[str, Any]] = {
    'zstd': {'chunk_size': 1500},
    'lz4': {'chunk_size': 1500, 'compression': CompressionType.LZ4},
    'none': {'chunk_size': 1500, 'compression': CompressionType.NONE},
    'unchecked': {'chunk_size': 1500, 'compression': CompressionType.NONE, 'enable_crcs': False},
    'unchunked': {'use_chunking': False},
}
HOSTILE = (0, 1, 8, 255, 2 ** 16, 2 ** 24, 2 ** 31 - 1, 2 ** 32 - 1, 2 ** 40, 2 ** 63, 2 ** 64 - 1)
TYPE_NAMES = (b'sensor_msgs/msg/JointState', b'geometry_msgs/msg/WrenchStamped')
BOMB_SIZE, SWARM_SIZE = 64 << 20, 2 << 20

Mutation = Callable[[bytearray, random.Random], None]


def write_sound(path: Path, kind: str) -> bytes:
    """Write a small bag that can be estimated, and return its bytes."""
    messages = []
    for n in range(30):
        time = START + 1_000_000 * n
        angles = (1e-3 * n, 0.1 * n, -1e-3 * n, -0.1 * n)
        messages.append(('/joint_states', time, encode_joint_state(
            time, 'base', NAMES, angles, (0.0,) * 4, (0.0, 0.1, 0.0, 0.1))))
        messages.append(('/tip/wrench', time, encode_wrench(time, 'base', (n, 0, 1), (0, 0, n))))
        messages.append(('/estimator_state', time, encode_string('x' * (n % 7))))
    write_mcap(path, messages, **KINDS[kind])
    return path.read_bytes()


def mutated(sound: bytes, rng: random.Random) -> bytes:
    """Return a bag after one to four accidents."""
    content = bytearray(sound)
    for _ in range(rng.randint(1, 4)):
        rng.choice(MUTATIONS)(content, rng)
    return bytes(content)


def _place(content: bytearray, rng: random.Random) -> int:
    return rng.randrange(len(content)) if content else 0


def flip(content: bytearray, rng: random.Random) -> None:
    """Flip some bits."""
    for _ in range(rng.choice((1, 1, 3, 30)) if content else 0):
        content[_place(content, rng)] ^= 1 << rng.randrange(8)


def cut(content: bytearray, rng: random.Random) -> None:
    """Leave the end away, or a piece in the middle."""
    at = _place(content, rng)
    del content[at:rng.choice((len(content), at + rng.randrange(1, 300)))]


def lie(content: bytearray, rng: random.Random) -> None:
    """Put a hostile number where a length, a count or an offset may be."""
    at, size = _place(content, rng), rng.choice((2, 4, 8))
    if records := _records(content):
        at = rng.choice((at, rng.choice(records)[0] + rng.choice((1, 9, 13, 25, 33, 37))))
    content[at:at + size] = struct.pack('<Q', rng.choice(HOSTILE))[:size]


def double(content: bytearray, rng: random.Random) -> None:
    """Write a record once more, somewhere between the others."""
    if records := _records(content):
        start, stop = rng.choice(records)
        at = rng.choice(records)[0]
        content[at:at] = content[start:stop]


def swap(content: bytearray, rng: random.Random) -> None:
    """Exchange two records."""
    records = _records(content)
    if len(records) > 1:
        (first, end), (second, stop) = sorted(rng.sample(records, 2))
        content[first:stop] = (
            content[second:stop] + content[end:second] + content[first:end])


def rename(content: bytearray, rng: random.Random) -> None:
    """Give a schema the name of another type, or of none."""
    name = rng.choice(TYPE_NAMES)
    other = rng.choice((rng.choice(TYPE_NAMES), b'made_up/msg/Thing', b'\xff\n\x1b', b''))
    if (at := content.find(name)) >= 0:
        content[at:at + len(name)] = other.ljust(len(name), b'x')[:len(name)]


def bomb(content: bytearray, rng: random.Random) -> None:
    """Add a chunk of a few bytes that becomes very large, whatever its head claims."""
    name = rng.choice((b'zstd', b'lz4'))
    size, stored = rng.choice(_bombs()[name])
    claimed = rng.choice((size, size, 1000 * len(stored), 1 << 20, 100, 2 ** 40))
    body = (struct.pack('<QQQII', START, START, claimed, rng.choice((0, 1)), len(name)) + name
            + struct.pack('<Q', len(stored)) + stored)
    at = rng.choice([start for start, _ in _records(content)] or [MAGIC_SIZE])
    content[at:at] = struct.pack('<BQ', Opcode.CHUNK, len(body)) + body


MUTATIONS: tuple[Mutation, ...] = (flip, flip, cut, lie, lie, double, swap, rename, bomb)


@cache
def _bombs() -> dict[bytes, list[tuple[int, bytes]]]:
    """Return sizes and compressed contents: zeros, or one small record over and over."""
    records = [struct.pack('<BQ', opcode, len(body)) + body for opcode, body in (
        (1, b''), (Opcode.SCHEMA, b''), (Opcode.MESSAGE, b''),
        (Opcode.MESSAGE, struct.pack('<HIQQ', 1, 0, START, START)),
        (Opcode.SCHEMA, struct.pack('<HI1sI1sI', 1, 1, b'a', 1, b'b', 0)),
        (Opcode.CHANNEL, struct.pack('<HHI1sI1sI', 1, 1, 1, b'a', 1, b'b', 0)))]
    contents = [bytes(BOMB_SIZE), *(record * (SWARM_SIZE // len(record)) for record in records)]
    return {b'zstd': [(len(content), zstandard.ZstdCompressor().compress(content))
                      for content in contents],
            b'lz4': [(len(content), bytes(lz4.frame.compress(content))) for content in contents]}


def _records(content: bytearray) -> list[tuple[int, int]]:
    """Return where the records at the top level start and end."""
    starts, end = record_starts(bytes(content[MAGIC_SIZE:]))
    bounds = [MAGIC_SIZE + at for at in [*starts.tolist(), end]]
    return list(zip(bounds[:-1], bounds[1:]))

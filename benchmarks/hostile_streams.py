"""Streams of joint states that no driver should send, each from a moment on."""

from collections.abc import Callable
import math
import random
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_msgs_json.cdr import encode_joint_state

NAMES = ('joint1', 'joint2', 'joint1_motor', 'joint2_motor')
BEGIN = 400             # of what is wrong [samples]
TURN = 2.0 * math.pi
MS = 1_000_000          # [ns]
Angles = list[float]


class Moment(NamedTuple):
    """One sample of the arm, and chance."""

    k: int
    stamp: int                  # [ns]
    reading: Array              # (n, 4)
    chance: random.Random

    @property
    def angles(self) -> Angles:
        """Return the angles of links and shafts."""
        return [*self.reading[:, 1].tolist(), *self.reading[:, 0].tolist()]

    @property
    def rates(self) -> Angles:
        """Return the velocities of links and shafts."""
        return [*self.reading[:, 3].tolist(), *self.reading[:, 2].tolist()]


class Stream:
    """What comes instead of the samples; `stops` says that a single one must stop the motors."""

    def __init__(self, send: Callable[[Moment], list[bytes]], stops: bool = False) -> None:
        """Send the arm's own samples up to BEGIN."""
        self._send, self.stops = send, stops

    def __call__(self, now: Moment) -> list[bytes]:
        """Return the messages that come at a moment."""
        return good(now) if now.k < BEGIN else self._send(now)


def state(stamp: int, angles: Angles, rates: Angles | None = None,
          names: tuple[str, ...] = NAMES) -> bytes:
    """Return a joint state."""
    return encode_joint_state(stamp, '', names, angles, rates or [])


def good(now: Moment) -> list[bytes]:
    """Return the sample as it is."""
    return [state(now.stamp, now.angles, now.rates)]


def one(column: int, law: Callable[[float, Moment], float], *, stops: bool = False) -> Stream:
    """Return a stream in which one angle is another."""
    def send(now: Moment) -> list[bytes]:
        angles = now.angles
        angles[column] = law(angles[column], now)
        return [state(now.stamp, angles, now.rates)]
    return Stream(send, stops)


def stamped(law: Callable[[Moment], int]) -> Stream:
    """Return a stream with other stamps."""
    return Stream(lambda now: [state(law(now), now.angles, now.rates)])


def rated(law: Callable[[Moment], Angles]) -> Stream:
    """Return a stream with other velocities."""
    return Stream(lambda now: [state(now.stamp, now.angles, law(now))])


def named(*names: str, pick: slice = slice(None)) -> Stream:
    """Return a stream in which angles have other names."""
    return Stream(lambda now: [state(now.stamp, now.angles[pick], now.rates[pick], names)])


def also(shift: float, later: int, *, stops: bool = False) -> Stream:
    """Return a stream with a second publisher, its links elsewhere [rad], its stamps later."""
    def send(now: Moment) -> list[bytes]:
        other = [x + shift * ratio for x, ratio in zip(now.angles, (1.0, 1.0, 100.0, 100.0))]
        return [*good(now), state(now.stamp + later, other, now.rates)]
    return Stream(send, stops)


def bytewise(law: Callable[[bytes, random.Random], bytes]) -> Stream:
    """Return a stream whose bytes are spoilt."""
    return Stream(lambda now: [law(good(now)[0], now.chance)])


def _flipped(message: bytes, chance: random.Random) -> bytes:
    spoilt = bytearray(message)
    spoilt[chance.randrange(len(spoilt))] ^= 1 << chance.randrange(8)
    return bytes(spoilt)


def _any(x: float, now: Moment) -> float:
    return now.chance.choice([x, now.chance.uniform(-1e3, 1e3), 1e300, -1e308, math.nan,
                              math.inf, 5e-324])


def _wild(now: Moment) -> list[bytes]:
    return [state(now.stamp, [_any(x, now) for x in now.angles], now.rates)]


def _giant(now: Moment) -> list[bytes]:
    more = 50_000 if now.k == BEGIN else 0
    return [state(now.stamp, now.angles + [0.0] * more, None,
                  NAMES + tuple(f'x{k}' for k in range(more)))]


STREAMS: dict[str, Stream] = {
    'clean': Stream(good),
    'motor NaN': one(2, lambda x, now: math.nan, stops=True),
    'link NaN': one(0, lambda x, now: math.nan, stops=True),
    'motor infinite': one(3, lambda x, now: math.inf, stops=True),
    'NaN now and then': one(2, lambda x, now: math.nan if now.k % 20 == 0 else x),
    'bit flipped': one(2, lambda x, now: 5.39e307, stops=True),
    'bit flipped once': one(2, lambda x, now: 5.39e307 if now.k == BEGIN else x, stops=True),
    'huge, both ways': one(3, lambda x, now: 1.79e308 * (-1.0) ** now.k, stops=True),
    'link beyond its limit': one(0, lambda x, now: 3.3, stops=True),
    'turn of a motor': one(2, lambda x, now: x + TURN, stops=True),
    'turn of a motor, back': one(3, lambda x, now: x - TURN, stops=True),
    'turns of a motor': one(2, lambda x, now: x - 16 * TURN, stops=True),
    'turn of a link': one(1, lambda x, now: x - TURN, stops=True),
    'link 1 rad off': one(0, lambda x, now: x + 1.0, stops=True),
    'wrap of a motor': one(2, lambda x, now: math.remainder(x, TURN), stops=True),
    'runaway': one(2, lambda x, now: x + (now.k - BEGIN) * 2.0, stops=True),
    'creeping apart': one(2, lambda x, now: x + (now.k - BEGIN) * 0.2),
    'noise': one(2, lambda x, now: x + now.chance.gauss(0.0, 3.0)),
    'anything': Stream(_wild),
    'stamps frozen': stamped(lambda now: now.stamp - (now.k - BEGIN) * MS),
    'stamps backwards': stamped(lambda now: now.stamp - 2 * (now.k - BEGIN) * MS),
    'stamps 1 ns apart': stamped(lambda now: now.stamp - (now.k - BEGIN) * (MS - 1)),
    'stamps negative': stamped(lambda now: now.stamp - 10 * 10**9),
    'an hour back': stamped(lambda now: now.stamp - 3600 * 10**9),
    '100 s ahead': stamped(lambda now: now.stamp + 100 * 10**9),
    '13 ms ahead': stamped(lambda now: now.stamp + 13 * MS),
    'silence': Stream(lambda now: [], True),
    'tenth lost': Stream(lambda now: [] if now.chance.random() < 0.1 else good(now)),
    'half lost': Stream(lambda now: [] if now.chance.random() < 0.5 else good(now)),
    'all twice': Stream(lambda now: 2 * good(now)),
    'other names': named('a', 'b', 'c', 'd'),
    'no motors': named(*NAMES[:2], pick=slice(2)),
    'no links': named(*NAMES[2:], pick=slice(2, 4)),
    'joints swapped': Stream(lambda now: [state(
        now.stamp, now.angles, now.rates, ('joint2', 'joint1', 'joint2_motor', 'joint1_motor'))],
        True),
    'motors swapped': Stream(lambda now: [state(
        now.stamp, now.angles, now.rates, ('joint1', 'joint2', 'joint2_motor', 'joint1_motor'))],
        True),
    'no velocities': rated(lambda now: []),
    'velocities NaN': rated(lambda now: [math.nan] * 4),
    'velocities huge': rated(lambda now: [1e308] * 4),
    'second publisher elsewhere': also(0.5, 300_000, stops=True),
    'second publisher, late': also(0.0, -500_000, stops=True),
    'no bytes': Stream(lambda now: [b'']),
    'cut off': bytewise(lambda message, chance: message[:-5]),
    'garbage': bytewise(lambda message, chance: chance.randbytes(chance.randrange(300))),
    'bits flipped': bytewise(_flipped),
    'giant': Stream(_giant),
    'big endian': bytewise(lambda message, chance: b'\0\0' + message[2:]),
}


def mixture(seed: int) -> Stream:
    """Return a stream that takes each sample from one of three others."""
    chosen = random.Random(seed).sample(sorted(STREAMS), 3)
    return Stream(lambda now: STREAMS[now.chance.choice(chosen)](now))

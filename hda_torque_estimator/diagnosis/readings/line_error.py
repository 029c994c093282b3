"""
Find the error of a link encoder that repeats with every line of its scale, and take it out.

What a local polynomial leaves of the readings is folded over the angle for every number of lines
at once. The strongest wave is then fitted by least squares through the same filter. Stretches in
which the samples do not show a whole wave are left aside (`line_alias`).
"""

from collections.abc import Iterator
from dataclasses import replace
import math
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array, Mask
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import CoarseQuantisation, Effect, EncoderInterpolationError
import numpy as np

from .line_alias import agrees, counting, moves, resolved, STRETCHES
from .local_rest import local_rest, local_speed, window_of
from .raw_cause import number, RawCause
from ...measurements.measurement import Measurement
from ...significance import IMMATERIAL, MOSTLY, NORMAL_90, SCORE_BAR

MOTOR, LINK = 0, 1      # sides of a reading
# Numerics; choices unless stated otherwise.
_BINS = 2 ** 18         # of one turn
_FEWEST, _MOST = 1000, 2 ** 16  # lines per turn that are looked for; fewer, the arm may follow
_WHOLE_STEPS = 4.0      # least counts of the encoder in a line
_BAND = 1.4             # from the fewest lines to the most that are looked for in the same rows
_NEAR = 2               # lines about the strongest that are fitted exactly
_ROUNDS = 3             # the angle behind a reading is known better each time
_TRIED = (2500.0, 6000.0, 20000.0)          # lines for which the smallest wave is sought
_INVERSE = 12           # rounds to the angle behind a reading


class LineWave(NamedTuple):
    """A wave over the angle behind the readings, as fitted: what it leaves, how sure it is."""

    effect: EncoderInterpolationError
    before: float           # power of the rest without the wave [rad^2]
    after: float            # and with it
    rows: Mask              # (k,) in which it was fitted
    columns: Array          # (2, m) its sine and cosine there
    spread: Array           # (2,) deviations of amplitude [rad] and lines

    @property
    def score(self) -> float:
        """Return twice the gain of log likelihood."""
        return int(self.rows.sum()) * math.log(self.before / self.after)


def uneven_lines(measurement: Measurement, arm: Arm, seen: Mask) -> Iterator[RawCause]:
    """
    Return the joints whose link encoders err with their lines, from rows `seen` (k,).

    Phases are those at readings of zero.
    """
    for column, (label, joint) in enumerate(zip(arm.labels, arm.joints)):
        motor, link = measurement.reading[:, column].T
        step = arm.effect(CoarseQuantisation.name, label).values()[LINK]
        wave = wave_of(link, measurement.dt, seen, step)
        if wave is not None and wave.before - wave.after >= IMMATERIAL * wave.before \
                and wave.score > SCORE_BAR \
                and _of_one_encoder(wave, motor / joint.ratio, link, measurement.dt, step):
            size, slope = (NORMAL_90 * wave.spread).tolist()
            yield RawCause(wave.effect, label, {
                'amplitude': number(wave.effect, 'amplitude', size),
                'lines': number(wave.effect, 'lines', slope),
                'phase': number(wave.effect, 'phase', size / wave.effect.amplitude),
            }, wave.score, ((column, LINK),))


def _of_one_encoder(wave: LineWave, motor: Array, link: Array, dt: float, step: float) -> bool:
    """Return whether a wave is the link encoder's: no counting, no movement, one phase always."""
    rows = wave.rows
    rest = local_rest(link, dt)[rows]
    return (wave.effect.amplitude > counting(step)
            and not moves(wave.columns, rest, local_rest(motor, dt)[rows])
            and agrees(local_speed(link, dt)[rows], wave.columns, rest))


def smallest_wave(angle: Array, dt: float, seen: Mask, step: float) -> float | None:
    """Return the smallest amplitude of a wave that readings (k,) would show [rad], or None."""
    window, good = window_of(dt), _inner(seen, window_of(dt))
    rest, travel = local_rest(angle, dt), local_speed(angle, dt) * dt
    sizes = [_smallest(rest, local_rest(np.sin(lines * angle), dt),
                       good & resolved(travel, lines, lines, window), window) for lines in _TRIED
             if lines < _most(step)]
    size = max(min(sizes, default=math.inf), counting(step))
    return size if size <= EncoderInterpolationError.declaration('amplitude').high else None


def _smallest(rest: Array, wave: Array, rows: Mask, window: int) -> float:
    """Return how many of a wave (k,) would show beside a rest (k,) in these rows."""
    enough = int(rows.sum()) >= STRETCHES * window
    passed = float(np.mean(wave[rows] ** 2)) if enough else 0.0
    if passed < IMMATERIAL:
        return math.inf
    power = float(np.mean(rest[rows] ** 2))
    needed = max(IMMATERIAL, -math.expm1(-SCORE_BAR / int(rows.sum())))
    return math.sqrt(needed / (1.0 - needed) * power / passed)


def without_waves(measurement: Measurement, causes: list[RawCause],
                  labels: tuple[str, ...]) -> Measurement:
    """Return the measurement as link encoders without these waves would have shown it."""
    if not causes:
        return measurement
    reading = measurement.reading.copy()
    for cause in causes:
        column = labels.index(str(cause.joint))
        reading[:, column, LINK] = _behind(reading[:, column, LINK], cause.effect)
    return replace(measurement, reading=reading)


def wave_of(angle: Array, dt: float, seen: Mask, step: float) -> LineWave | None:
    """Return the strongest wave in readings (k,) of an encoder with this step [rad]."""
    window, travel = window_of(dt), local_speed(angle, dt) * dt
    rest, good = local_rest(angle, dt), _inner(seen, window)
    lines, behind = _strongest(angle, rest, good, travel, window, _most(step)), angle
    if lines is None:
        return None
    rows = good & resolved(travel, lines - _NEAR, lines + _NEAR, window)
    near = range(max(lines - _NEAR, 2), lines + _NEAR + 1)
    best = min((_fitted(behind, rest, dt, rows, trial) for trial in near),
               key=lambda wave: wave.after)
    for _ in range(_ROUNDS):
        behind = _behind(angle, best.effect)
        best = _fitted(behind, rest, dt, rows, round(best.effect.lines))
    return best


def _inner(seen: Mask, window: int) -> Mask:
    """Return rows of `seen` (k,) that are not near the ends."""
    good = seen.copy()
    good[:window], good[-window:] = False, False
    return good


def _most(step: float) -> int:
    """Return the most lines per turn of an encoder with this step [rad] that can be resolved."""
    return _MOST if step <= 0.0 else min(_MOST, int(2.0 * math.pi / step / _WHOLE_STEPS))


def _strongest(angle: Array, rest: Array, good: Mask, travel: Array, window: int,
               most: int) -> int | None:
    """
    Return the lines per turn over which the rest adds up to the largest wave, if to one.

    All are (k,), `travel` from sample to sample [rad]. Each band of lines is folded over the rows
    that resolve it, where these fill a window of each stretch that must agree.
    """
    place = np.floor(angle * (_BINS / (2.0 * math.pi))).astype(np.int64) % _BINS
    best, strongest, fewest = 0.0, None, _FEWEST
    while fewest < most:
        end = min(math.ceil(_BAND * fewest), most)
        rows = good & resolved(travel, fewest, end, window)
        power, count = float(rest[rows] @ rest[rows]), int(rows.sum())
        if power > 0.0 and count >= STRETCHES * window:
            folded = np.abs(np.fft.rfft(np.bincount(place[rows], rest[rows], _BINS))[fewest:end])
            gained = 2.0 * float(folded.max()) ** 2 / power         # share of it, times samples
            if gained > max(MOSTLY * IMMATERIAL * count, best):
                best, strongest = gained, int(np.argmax(folded)) + fewest
        fewest = end
    return strongest


def _fitted(behind: Array, rest: Array, dt: float, rows: Mask, lines: int) -> LineWave:
    """Return the wave of so many lines over the angle behind the readings."""
    turn = lines * behind
    columns = np.stack([local_rest(wave, dt)[rows] for wave in (np.sin(turn), np.cos(turn))])
    normal, power = columns @ columns.T, float(rest[rows] @ rest[rows])
    along, across = np.linalg.solve(normal, columns @ rest[rows])
    left, count = rest[rows] - along * columns[0] - across * columns[1], int(rows.sum())
    highest = EncoderInterpolationError.declaration('amplitude').high
    effect = EncoderInterpolationError(min(math.hypot(along, across), highest), float(lines),
                                       math.atan2(across, along))
    size = math.sqrt(float(left @ left) / count * np.linalg.inv(normal).trace() / 2.0)
    slope = size / max(effect.amplitude, 1e-30) / max(float(behind[rows].std()), 1e-12)
    return LineWave(effect, power, float(left @ left), rows, columns, np.array([size, slope]))


def _behind(angle: Array, wave: Effect) -> Array:
    """Return the angle behind readings (k,) that carry a wave [rad]."""
    behind = angle
    for _ in range(_INVERSE):
        behind = angle - wave(angle=behind)
    return behind

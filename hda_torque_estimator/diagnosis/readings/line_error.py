"""
Find the error of a link encoder that repeats with every line of its scale, and take it out.

What a local polynomial leaves of the readings is folded over the angle for every number of lines
at once. The strongest wave is then fitted by least squares through the same filter, along the
angle that it had (`line_angle`). Stretches in which the samples do not show a whole wave are left
aside (`line_alias`).
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
import math
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array, Mask
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import CoarseQuantisation, EncoderInterpolationError
import numpy as np

from .encoder_steps import SIDES
from .line_alias import agrees, counting, moves, of_codes, resolved, STRETCHES
from .line_angle import angle_behind, errors_at, hidden, turned_by_motor
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
_HARMONICS = (2, 3)     # of a wave whose law has another form


class LineWave(NamedTuple):
    """A wave over the angle behind the readings, as fitted: what it leaves, how sure it is."""

    effect: EncoderInterpolationError
    before: float           # power of the rest without the wave [rad^2]
    after: float            # and with it
    rows: Mask              # (k,) in which it was fitted
    columns: Array          # (2, m) its sine and cosine there
    spread: Array           # (2,) deviations of amplitude [rad] and lines
    forms: tuple[EncoderInterpolationError, ...] = ()       # its harmonics, if it has any

    @property
    def waves(self) -> tuple[EncoderInterpolationError, ...]:
        """Return all of it, harmonics as well."""
        return self.effect, *self.forms

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
        wave = wave_of(link, motor / joint.ratio, measurement.dt, seen, step)
        if wave is not None and wave.before - wave.after >= IMMATERIAL * wave.before \
                and wave.score > SCORE_BAR \
                and _of_one_encoder(wave, motor / joint.ratio, link, measurement.dt, step):
            size, slope = (NORMAL_90 * wave.spread).tolist()
            yield RawCause(wave.effect, label, {
                'amplitude': number(wave.effect, 'amplitude', size),
                'lines': number(wave.effect, 'lines', slope),
                'phase': number(wave.effect, 'phase', size / wave.effect.amplitude),
            }, wave.score, ((column, LINK),), forms=wave.forms)


def is_of_codes(wave: RawCause, coarse: Sequence[RawCause]) -> bool:
    """
    Return whether a wave is how its encoder counts, where that was found to be `coarse`.

    Stated steps are no reason: encoders that interpolate have whole numbers of them in a line.
    """
    lines, amplitude = wave.numbers['lines'], wave.numbers['amplitude'].value
    spread, step = (lines.high - lines.value) / NORMAL_90, SIDES[LINK]
    return any(of_codes(amplitude, lines.value, spread, cause.numbers[step].value)
               for cause in coarse if cause.joint == wave.joint and step in cause.numbers)


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


def without_waves(measurement: Measurement, causes: list[RawCause], arm: Arm) -> Measurement:
    """
    Return the measurement as link encoders without these waves would have shown it.

    Where waves hide the angle it is that of the motor, and nobody knows how the arm moved.
    """
    if not causes:
        return measurement
    reading, dt = measurement.reading.copy(), measurement.dt
    blind = measurement.is_blind.copy()
    for cause in causes:
        column = arm.labels.index(str(cause.joint))
        motor, link = measurement.reading[:, column].T
        waves = [wave for wave in (cause.effect, *cause.forms)
                 if isinstance(wave, EncoderInterpolationError)]
        behind = angle_behind(link, turned_by_motor(motor / arm.joints[column].ratio, dt), dt,
                              waves)
        hides = hidden(behind, dt, waves)
        reading[:, column, LINK] = np.where(hides, behind, link - errors_at(behind, waves))
        blind |= hides
    return replace(measurement, reading=reading, blind=tuple(np.flatnonzero(blind).tolist()))


def wave_of(link: Array, motor: Array, dt: float, seen: Mask, step: float) -> LineWave | None:
    """Return the strongest wave in readings (k,), those of the motor over the ratio beside it."""
    window, turned = window_of(dt), turned_by_motor(motor, dt)
    behind = angle_behind(link, turned, dt)
    travel, rest, good = local_speed(behind, dt) * dt, local_rest(link, dt), _inner(seen, window)
    lines = _strongest(behind, rest, good, travel, window, _most(step))
    if lines is None:
        return None
    rows = good & resolved(travel, lines - _NEAR, lines + _NEAR, window)
    near = range(max(lines - _NEAR, 2), lines + _NEAR + 1)
    best = min((_fitted(behind, rest, dt, rows, float(trial)) for trial in near),
               key=lambda wave: wave.after)
    best = _refined(best, behind, rest, dt)
    for _ in range(_ROUNDS):
        behind = angle_behind(link, turned, dt, best.waves)
        best = _refined(_fitted(behind, rest, dt, rows, best.effect.lines), behind, rest, dt)
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


def _fitted(behind: Array, rest: Array, dt: float, rows: Mask, lines: float) -> LineWave:
    """Return the wave of so many lines over the angle behind the readings."""
    columns = _columns(behind, dt, rows, lines)
    normal, power = columns @ columns.T, float(rest[rows] @ rest[rows])
    numbers, left = _explained(columns, rest[rows])
    effect, count = _wave(numbers, lines), int(rows.sum())
    size = math.sqrt(left / count * np.linalg.inv(normal).trace() / 2.0)
    slope = size / max(effect.amplitude, 1e-30) / max(float(behind[rows].std()), 1e-12)
    return LineWave(effect, power, left, rows, columns, np.array([size, slope]))


def _refined(wave: LineWave, behind: Array, rest: Array, dt: float) -> LineWave:
    """Return a wave stretched as it may be, with its harmonics."""
    return _with_harmonics(_stretched(wave, behind, rest, dt), behind, rest, dt)


def _stretched(wave: LineWave, behind: Array, rest: Array, dt: float) -> LineWave:
    """
    Return a wave with a part of a line per turn more or less, if that is so for certain.

    An encoder whose scale is wrong by a ten thousandth shows ten thousand lines as one more.
    """
    rows, (along, across) = wave.rows, _numbers(wave.effect)
    away = behind - behind[rows].mean()
    sine, cosine = (local_rest(away * column, dt)[rows] for column in _phases(
        behind, wave.effect.lines))
    numbers, _ = _explained(np.stack([*wave.columns, along * cosine - across * sine]), rest[rows])
    other = _fitted(behind, rest, dt, rows, wave.effect.lines + float(numbers[2]))
    gained = int(rows.sum()) * math.log(wave.after / other.after)
    return other if gained > SCORE_BAR else wave


def _with_harmonics(wave: LineWave, behind: Array, rest: Array, dt: float) -> LineWave:
    """Return a wave with its harmonics, if it has any for certain: another form of its law."""
    rows, lines = wave.rows, wave.effect.lines
    orders = [order * lines for order in _HARMONICS]
    columns = np.concatenate([wave.columns, *(
        _columns(behind, dt, rows, order) for order in orders)])
    numbers, left = _explained(columns, rest[rows])
    if int(rows.sum()) * math.log(wave.after / left) < SCORE_BAR:
        return wave
    return wave._replace(effect=_wave(numbers[:2], lines), after=left, forms=tuple(
        _wave(numbers[2 * place:][:2], order) for place, order in enumerate(orders, 1)))


def _columns(behind: Array, dt: float, rows: Mask, lines: float) -> Array:
    """Return what polynomials leave of both phases of a wave in these rows (2, m)."""
    return np.stack([local_rest(wave, dt)[rows] for wave in _phases(behind, lines)])


def _phases(behind: Array, lines: float) -> Iterator[Array]:
    """Yield the sine and the cosine of a wave of so many lines (k,)."""
    yield np.sin(lines * behind)
    yield np.cos(lines * behind)


def _explained(columns: Array, rest: Array) -> tuple[Array, float]:
    """Return the numbers (n,) of columns (n, m) that fit a rest (m,) best, and the power left."""
    numbers = np.linalg.solve(columns @ columns.T, columns @ rest)
    left = rest - numbers @ columns
    return numbers, float(left @ left)


def _wave(numbers: Array, lines: float) -> EncoderInterpolationError:
    """Return a wave by how much it has of its sine and of its cosine (2,) [rad]."""
    along, across = numbers.tolist()
    highest = EncoderInterpolationError.declaration('amplitude').high
    return EncoderInterpolationError(min(math.hypot(along, across), highest), lines,
                                     math.atan2(across, along))


def _numbers(wave: EncoderInterpolationError) -> tuple[float, float]:
    """Return how much a wave has of its sine and of its cosine [rad]."""
    return wave.amplitude * math.cos(wave.phase), wave.amplitude * math.sin(wave.phase)

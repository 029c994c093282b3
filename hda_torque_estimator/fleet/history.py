"""What became of each device: its causes along its own recordings, and how they change."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
import math
from statistics import fmean, pvariance

from .lines import BagLine, NamedCause
from ..significance import NORMAL_90

Place = tuple[str, str | None]

FIRST, NEW, GROWING, SHRINKING, STEADY, GONE, UNSEEN = (
    'first seen', 'new', 'growing', 'shrinking', 'steady', 'gone', 'not seen')
_CERTAIN = 2.576        # deviations of a change that chance makes once in a hundred (choice)
_FOR_SCATTER = 3        # recordings that show how a number differs between any two (choice)
_COMPLETE = ('no_discrepancy', 'explained')      # verdicts by which what is not named is not there


@dataclass(frozen=True)
class SizeInRecording:
    """The size of a cause in one recording, with its 90 % interval."""

    bag: str
    date: str | None
    value: float
    low: float
    high: float

    def deviation(self) -> float:
        """Return one standard deviation of the value."""
        return abs(self.high - self.low) / 2.0 / NORMAL_90


@dataclass(frozen=True)
class CauseHistory:
    """One cause of a device, oldest recording first, and how the latest compares."""

    effect: str
    joint: str | None
    parameter: str
    unit: str
    trend: str
    points: tuple[SizeInRecording, ...]

    def words(self) -> str:
        """Return the cause with its place, size and trend."""
        place = f'{self.effect} at {self.joint or "the arm"}'
        if not self.points:
            return f'{place}, {self.trend}'
        last = self.points[-1].value
        return f'{place}: {self.parameter} {last:.3g} {self.unit}'.rstrip('1 ') + f', {self.trend}'


@dataclass(frozen=True)
class Device:
    """The recordings of one device, oldest first."""

    name: str
    lines: tuple[BagLine, ...]

    @property
    def latest(self) -> BagLine:
        """Return the latest recording that could be diagnosed, the latest of all if none was."""
        return next((line for line in reversed(self.lines) if line.error is None),
                    self.lines[-1])

    def courses(self) -> tuple[CauseHistory, ...]:
        """Return what was ever named, the causes of the latest recording first."""
        diagnosed = [line for line in self.lines if line.error is None]
        places: dict[Place, None] = {}
        for line in reversed(diagnosed):
            places.update(dict.fromkeys((cause.effect, cause.joint) for cause in line.findings))
        return tuple(_course(place, diagnosed) for place in places)


def devices(lines: Iterable[BagLine]) -> tuple[Device, ...]:
    """Return the devices of a fleet, what needs a look first: the most severe, then failures."""
    by_name: dict[str, list[BagLine]] = {}
    for line in lines:
        by_name.setdefault(line.device, []).append(line)
    found = [Device(name, tuple(sorted(own, key=lambda line: (line.date or '', line.directory))))
             for name, own in by_name.items()]
    return tuple(sorted(found, key=lambda device: (_rank(device.latest), device.name)))


def _rank(line: BagLine) -> tuple[int, float]:
    """Return where a recording stands: healthy ones last, the worst of the others first."""
    group = 2 if line.verdict == 'no_discrepancy' else 1 if line.severity is None else 0
    return group, -(line.severity or 0.0)


def _course(place: Place, lines: Sequence[BagLine]) -> CauseHistory:
    named = [(line, cause) for line in lines for cause in line.findings
             if (cause.effect, cause.joint) == place]
    _, last = named[-1]
    points = tuple(_point(line, cause) for line, cause in named
                   if cause.value is not None and cause.parameter == last.parameter)
    return CauseHistory(*place, last.parameter, last.unit, _trend(lines, named[-1][0], points,
                                                                  len(named)), points)


def _point(line: BagLine, cause: NamedCause) -> SizeInRecording:
    return SizeInRecording(line.bag, line.date, *(
        math.nan if number is None else number for number in (cause.value, cause.low, cause.high)))


def _trend(lines: Sequence[BagLine], named: BagLine, points: Sequence[SizeInRecording],
           times: int) -> str:
    """Return in a word how a cause of the latest recording compares with the earlier ones."""
    if lines[-1] is not named:
        return GONE if lines[-1].verdict in _COMPLETE else UNSEEN
    if times == 1:
        return NEW if any(line.verdict in _COMPLETE for line in lines[:-1]) else FIRST
    change = _change(points)
    if abs(change) < _CERTAIN or not math.isfinite(change):
        return STEADY
    return GROWING if change > 0.0 else SHRINKING


def _change(points: Sequence[SizeInRecording]) -> float:
    """Return by how many deviations the last size differs from the mean of those before."""
    if len(points) < 2:
        return 0.0
    *before, last = points
    sizes = [abs(point.value) for point in before]
    own = fmean(point.deviation() ** 2 for point in before)
    scatter = max(pvariance(sizes) - own, 0.0) if len(before) >= _FOR_SCATTER else 0.0
    variance = last.deviation() ** 2 + scatter + (own + scatter) / len(before)
    return (abs(last.value) - fmean(sizes)) / math.sqrt(variance) if variance > 0.0 else 0.0

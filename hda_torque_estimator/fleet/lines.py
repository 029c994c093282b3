"""One recording of a fleet in one line: whose it is, what was found, how much, how bad."""

from dataclasses import dataclass
import math
from typing import Any

from hda_arm_sim.model.effects import effect_named
from hda_msgs_json.printable import printable

FAILED = 'not diagnosed'


@dataclass(frozen=True)
class NamedCause:
    """
    A cause that one diagnosis names, and the share of the excess error that it removes.

    Beside it the number that is its size, with its 90 % interval.
    """

    effect: str
    joint: str | None
    removed: float | None
    parameter: str = ''
    value: float | None = None
    low: float | None = None
    high: float | None = None
    unit: str = ''

    def place(self) -> str:
        """Return where the cause is."""
        return f'{self.effect} at {self.joint or "the arm"}'


@dataclass(frozen=True)
class BagLine:
    """
    The diagnosis of one bag; one that could not be diagnosed has an error and no verdict.

    `date` is the start of the recording (UTC, ISO 8601), None where its clock has none.
    `severity` says how many times what noise leaves the simulation errs, 1 if healthy. `state` is
    a digest of all that the diagnosis depends on.
    """

    bag: str
    directory: str
    verdict: str | None
    findings: tuple[NamedCause, ...] = ()
    seconds: float = 0.0
    error: str | None = None
    device: str = ''
    date: str | None = None
    severity: float | None = None
    arm: str = ''
    state: str = ''

    def sentence(self) -> str:
        """Return the line for people."""
        if self.error is not None:
            return f'{printable(self.directory)}: {FAILED}: {self.error}'
        places = ', '.join(cause.place() for cause in self.findings)
        return f'{printable(self.directory)}: {(self.verdict or "").replace("_", " ")}' + (
            f': {places}' if places else '')


def line_of(bag: str, directory: str, report: dict[str, Any]) -> BagLine:
    """Return the line of a diagnosis from its report."""
    causes = tuple(_cause(found) for found in report['findings'])
    return BagLine(bag, directory, report['verdict'], causes, report['seconds'],
                   severity=_severity(report.get('gain') or {}))


def line_from(document: dict[str, Any]) -> BagLine:
    """Return a line of a fleet.json; raises KeyError or TypeError where it is damaged."""
    return BagLine(**{**document,
                      'findings': tuple(NamedCause(**cause) for cause in document['findings'])})


def _cause(found: dict[str, Any]) -> NamedCause:
    name = _size_name(found['effect'], found.get('parameters') or {})
    size = (found.get('parameters') or {}).get(name, {})
    return NamedCause(found['effect'], found['joint'], found['gain']['removed'], name,
                      size.get('value'), size.get('low'), size.get('high'), size.get('unit', ''))


def _size_name(effect: str, parameters: dict[str, Any]) -> str:
    """Return the number that is the size of an effect: the first by which it acts."""
    acting = [name for name in effect_named(effect).acts if name in parameters]
    return next(iter([*acting, *parameters]), '')


def _severity(gain: dict[str, Any]) -> float | None:
    """Return how many times the rms of noise a simulation errs, from mean squares."""
    before, floor = gain.get('before'), gain.get('floor')
    if before is None or not floor:
        return None
    severity = math.sqrt(max(before, 0.0) / floor)
    return severity if math.isfinite(severity) else None

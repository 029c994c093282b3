"""What a fleet's diagnoses say side by side: JSON for machines, lines and a page for people."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from html import escape
from typing import Any
from urllib.parse import quote

from hda_msgs_json.printable import printable

from ..pages.document import code, document, figure, section, table

SCHEMA = 'hda.fleet/1'
FAILED = 'not diagnosed'


@dataclass(frozen=True)
class Cause:
    """A cause that one diagnosis names, and the share of the excess error that it removes."""

    effect: str
    joint: str | None
    removed: float | None

    def place(self) -> str:
        """Return where the cause is."""
        return f'{self.effect} at {self.joint or "the arm"}'


@dataclass(frozen=True)
class Line:
    """The diagnosis of one bag; one that could not be diagnosed has an error and no verdict."""

    bag: str
    directory: str
    verdict: str | None
    findings: tuple[Cause, ...] = ()
    seconds: float = 0.0
    error: str | None = None

    def sentence(self) -> str:
        """Return the line for people."""
        if self.error is not None:
            return f'{printable(self.directory)}: {FAILED}: {self.error}'
        told = ', '.join(cause.place() for cause in self.findings)
        return f'{printable(self.directory)}: {(self.verdict or "").replace("_", " ")}' + (
            f': {told}' if told else '')


def line_of(bag: str, directory: str, report: dict[str, Any]) -> Line:
    """Return the line of a diagnosis from its report."""
    causes = tuple(Cause(found['effect'], found['joint'], found['gain']['removed'])
                   for found in report['findings'])
    return Line(bag, directory, report['verdict'], causes, report['seconds'])


def fleet_document(lines: Sequence[Line], arm: str, version: str) -> dict[str, Any]:
    """Return the JSON document of a fleet."""
    return {'schema': SCHEMA, 'arm': arm, 'version': version,
            'verdicts': dict(sorted(_verdicts(lines).items())),
            'effects': [{'effect': effect, 'joint': joint, 'bags': count}
                        for (effect, joint), count in _causes(lines)],
            'bags': [{**asdict(line), 'findings': [asdict(cause) for cause in line.findings]}
                     for line in lines]}


def _verdicts(lines: Sequence[Line]) -> Counter[str]:
    return Counter(line.verdict or FAILED for line in lines)


def _causes(lines: Sequence[Line]) -> list[tuple[tuple[str, str | None], int]]:
    """Return every named cause with the number of bags that show it, the most first."""
    found = Counter((cause.effect, cause.joint) for line in lines for cause in line.findings)
    return sorted(found.items(), key=lambda item: (-item[1], item[0][0], item[0][1] or ''))


def fleet_page(lines: Sequence[Line], arm: str, version: str) -> str:
    """Return the page of a fleet, with links to the pages of its diagnoses."""
    counts = ', '.join(f'{count} {name.replace("_", " ")}'
                       for name, count in _verdicts(lines).most_common())
    parts = [f'<h1>{len(lines)} recordings</h1>', f'<p class="lead">{escape(counts)}.</p>',
             section('Recordings', table(
                 ('recording', 'verdict', 'causes, excess error removed', 'seconds'),
                 [_row(line) for line in lines])), _shared(lines),
             f'<p>Arm {code(arm)}, version {escape(version)}.</p>']
    return document('Diagnoses of a fleet', parts)


def _row(line: Line) -> list[str]:
    if line.error is not None:
        return [code(printable(line.bag)), FAILED, escape(line.error), '']
    causes = '<br>'.join(
        f'{code(cause.effect)} at {escape(cause.joint or "the arm")}'
        + ('' if cause.removed is None else f', {100.0 * cause.removed:.1f} %')
        for cause in line.findings)
    # Relative and percent-encoded, or a name such as `javascript:...` or `a#b` is no directory.
    place = quote(line.directory, safe='', errors='surrogateescape')
    return [f'<a href="./{place}/report.html">{code(printable(line.bag))}</a>',
            escape((line.verdict or '').replace('_', ' ')), causes, figure(line.seconds)]


def _shared(lines: Sequence[Line]) -> str:
    rows = [[code(effect), escape(joint or 'the arm'), str(count)]
            for (effect, joint), count in _causes(lines)]
    return section('Causes over the fleet', table(('effect', 'where', 'recordings'), rows)
                   ) if rows else ''

"""The page of a fleet: devices by severity with their history, and every recording."""

from collections.abc import Sequence
import math
from urllib.parse import quote

from hda_msgs_json.printable import printable

from .fleet_report import causes_of, verdicts
from .history import CauseHistory, Device, devices
from .lines import BagLine, FAILED, NamedCause
from ..diagnosis.findings.report import FittedNumber
from ..diagnosis.reporting.summary import cause_sentence
from ..pages.badge import Badge, badge_of
from ..pages.render import render
from ..pages.wording import capital

_WIDE, _HIGH, _EDGE = 80.0, 18.0, 3.0       # of the small picture of a course (layout)


def fleet_page(lines: Sequence[BagLine], arm: str, version: str,
               skipped: Sequence[str] = ()) -> str:
    """
    Return the page of a fleet, with links to the pages of its diagnoses.

    `skipped` are the folders that hold no recording, in words.
    """
    counted, found = verdicts(lines), devices(lines)
    wrong = _wrong(found)
    return render(
        'fleet.html', title='Diagnoses of a fleet', badge=_worst(found), lines=lines, arm=arm,
        version=version, shared=causes_of(lines), badge_of=badge_of, printable=printable,
        devices=found, headline=_headline(found, wrong), wrong=wrong, failed=counted[FAILED],
        place=_place, said=_said, said_of=_said_of, drawn=drawn,
        skipped=[printable(words) for words in skipped],
        counts=[(badge_of(None if name == FAILED else name), count)
                for name, count in counted.most_common()])


def _wrong(found: Sequence[Device]) -> list[Device]:
    """Return the devices whose latest recording shows something wrong, in their order."""
    return [device for device in found if device.latest.verdict not in (
        None, 'no_discrepancy', 'insufficient_excitation')]


def _headline(found: Sequence[Device], wrong: Sequence[Device]) -> str:
    """Return how many devices show something, and what the worst of them has, in a sentence."""
    if not wrong:
        return f'None of {_counted(len(found))} shows anything wrong.'
    first, latest = wrong[0], wrong[0].latest
    what = '' if not latest.findings else f': {_said(latest.findings[0])}'
    name = printable(first.name) or printable(latest.directory)
    return (f'{len(wrong)} of {_counted(len(found))} {"show" if len(wrong) > 1 else "shows"} '
            f'something wrong. The worst is {name}{what}.')


def _counted(count: int) -> str:
    return f'{count} device{"s" * (count != 1)}'


def _worst(found: Sequence[Device]) -> Badge:
    return badge_of(found[0].latest.verdict) if found else badge_of(None)


def _said(cause: NamedCause) -> str:
    """Return a cause with its size, in words."""
    return cause_sentence(cause.effect, cause.joint, _numbers(
        cause.parameter, cause.value, cause.unit, cause.low, cause.high))


def _said_of(course: CauseHistory) -> str:
    """Return what became of a cause, with its last size in words."""
    last = course.points[-1] if course.points else None
    size = {} if last is None else _numbers(course.parameter, last.value, course.unit, last.low,
                                            last.high)
    return f'{capital(cause_sentence(course.effect, course.joint, size))}: {course.trend}'


def _numbers(name: str, value: float | None, unit: str, low: float | None,
             high: float | None) -> dict[str, FittedNumber]:
    if not name or value is None:
        return {}
    return {name: FittedNumber(value, unit, value if low is None else low,
                               value if high is None else high)}


def drawn(course: CauseHistory) -> str:
    """Return the sizes of a cause along its recordings as the points of a line, '' for one."""
    values = [abs(point.value) for point in course.points if math.isfinite(point.value)]
    most = max(values, default=0.0)
    if len(values) < 2 or most == 0.0:
        return ''
    step = (_WIDE - 2.0 * _EDGE) / (len(values) - 1)
    return ' '.join(f'{_EDGE + step * place:.1f},'
                    f'{_HIGH - _EDGE - (_HIGH - 2.0 * _EDGE) * value / most:.1f}'
                    for place, value in enumerate(values))


def _place(line: BagLine) -> str:
    """
    Return the address of a diagnosis, relative and percent-encoded.

    Otherwise a name such as `javascript:...` or `a#b` is no directory.
    """
    return f'./{quote(line.directory, safe="/", errors="surrogateescape")}/report.html'

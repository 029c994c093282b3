"""The page of a diagnosis: one HTML file that needs no network and no other file."""

from collections.abc import Iterable, Mapping
import math
from typing import Any

from hda_arm_sim.model.effects import EFFECTS

from . import summary
from .curves import charts, made_of, rest_charts
from .detectability_chart import by_site
from .exhibits import Exhibits
from ..findings.origin import RecordingPart
from ..findings.report import Diagnosis, FittedNumber
from ...pages.badge import badge_of
from ...pages.render import render
from ...pages.wording import figure, spoken

MOTOR_CAPTION = (
    'A motor alone. Left: its torque over a held-out stretch, measured, and as load, friction and '
    'the lines found call for it. Right: what load and friction leave, over the turn of the '
    'motor; with the lines it should be flat.')
_MEANINGS = {(effect.name, rule.name): rule.meaning
             for effect in EFFECTS for rule in effect.declarations()}


def page(diagnosis: Diagnosis, figures: Mapping[str, str],
         exhibits: Exhibits | None = None) -> str:
    """
    Return a diagnosis as one HTML document.

    `exhibits` become plots. `figures` are SVG elements by name, for what has no plots. They go in
    as they are; all other text is escaped.
    """
    drawn = {} if exhibits is None else charts(diagnosis, exhibits)
    followed = [] if exhibits is None else rest_charts(diagnosis, exhibits)[0]
    return render(
        'diagnosis.html', title=f'Diagnosis: {diagnosis.verdict.replace("_", " ")}',
        badge=badge_of(diagnosis.verdict), charts=drawn, found=diagnosis, summary=summary,
        figures={name: (svg, _caption(name)) for name, svg in figures.items()},
        followed=followed, marks=summary.marks(diagnosis), labels=labels_of(diagnosis),
        numbers=numbers_of, made=made_of(diagnosis), stirred=by_site(diagnosis.excitation),
        facts=_facts(diagnosis))


def labels_of(diagnosis: Diagnosis) -> list[str]:
    """Return the joints of an arm, as far as its diagnosis names them."""
    named = [*(row.joint for row in diagnosis.residuals),
             *(row.joint for row in diagnosis.excitation),
             *(found.joint for found in diagnosis.findings)]
    return sorted({label for label in named if label is not None}, key=_in_order)


def _in_order(label: str) -> tuple[str, int]:
    stem = label.rstrip('0123456789')
    return stem, int(label[len(stem):] or 0)


def numbers_of(effect: str, parameters: Mapping[str, FittedNumber]) -> list[dict[str, Any]]:
    """Return the rows of a table of parameters: name, meaning, value, interval, unit."""
    return [{'name': name, 'meaning': _MEANINGS.get((effect, name), ''), 'number': number}
            for name, number in parameters.items()]


def _caption(name: str) -> str:
    return MOTOR_CAPTION if name.startswith('motor') else f'Figure {spoken(name)}.'


def _facts(diagnosis: Diagnosis) -> list[tuple[str, str]]:
    """Return where a diagnosis comes from, a name and a text each."""
    facts = diagnosis.recording
    return [('duration', f'{figure(facts.duration)} s'), ('samples', f'{facts.samples:,}'),
            ('rate', f'{figure(facts.rate)} Hz'), *_bags(facts.bags),
            ('fitted to', spans(facts.training)), ('held out', spans(facts.held_out)),
            ('arm', diagnosis.arm), ('version', diagnosis.version),
            ('time taken', f'{figure(diagnosis.seconds)} s')]


def _bags(bags: Iterable[RecordingPart]) -> list[tuple[str, str]]:
    """Return the rows of several recordings."""
    return [(f'recording {place}', f'{part.bag}, from {figure(part.begin)} s of the running '
             'clock') for place, part in enumerate(bags, 1)]


def spans(stretches: Iterable[tuple[float, float]]) -> str:
    """Return stretches of time, those that touch as one."""
    joined: list[tuple[float, float]] = []
    for begin, end in stretches:
        if joined and math.isclose(joined[-1][1], begin):
            begin = joined.pop()[0]
        joined.append((begin, end))
    total = sum(end - begin for begin, end in joined)
    listed = ', '.join(f'{figure(begin)} to {figure(end)}' for begin, end in joined)
    return f'{figure(total)} s: {listed} s' if joined else 'nothing'

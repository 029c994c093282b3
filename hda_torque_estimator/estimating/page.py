"""The page of an estimate: one HTML file that needs no network and no other file."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from .accuracy import EstimateErrors
from .curves import charts, ReferenceSignal
from .estimates import Estimates
from ..pages.badge import Badge
from ..pages.render import render
from ..pages.wording import figure, short, spoken

BELIEVED = Badge('healthy', 'Believed', 'nothing speaks against the estimates')
DOUBTED = Badge('ambiguous', 'Doubted', 'something speaks against part of the estimates')
_APART = 2              # joints that have a clause each in a sentence (choice)


class About(NamedTuple):
    """What estimates rest on: texts for the page, and what speaks against them."""

    labels: Sequence[str]
    source: str
    arm: str
    version: str
    refused: int
    doubts: Mapping[str, float]         # sentences, and the share of samples that they are said of
    errors: Mapping[str, EstimateErrors]        # by topic
    zero: str                           # of a tare, '' for none


def page(found: Estimates, about: About,
         beside: Mapping[str, Mapping[str, ReferenceSignal]]) -> str:
    """Return estimates as one HTML document; `beside` are known signals by joint or axis."""
    return render(
        'estimation.html', title=f'Estimate: {about.source}',
        badge=DOUBTED if about.doubts else BELIEVED,
        charts=charts(about.labels, found, beside), headline=_headline(found, about),
        about=about, rows=_errors(about.errors), facts=_facts(found, about))


def _headline(found: Estimates, about: About) -> str:
    """Return the largest torque of each joint in one sentence, of many joints in a row."""
    size = np.abs(found.torque)
    largest = np.where(np.isfinite(size), size, 0.0).max(axis=0, initial=0.0)
    if len(about.labels) > _APART:
        *most, last = [short(float(value)) for value in largest]
        return (f'From {spoken(about.labels[0])} to {spoken(about.labels[-1])} the torques went '
                f'up to {", ".join(most)} and {last} N·m.')
    loads = [f'{spoken(label)} carried up to {short(float(value))} N·m'
             for label, value in zip(about.labels, largest)]
    sentence = ', '.join(loads)
    return f'{sentence[:1].upper()}{sentence[1:]}.'


def _errors(errors: Mapping[str, EstimateErrors]) -> list[tuple[str, str, list[str]]]:
    return [(name, 'N' if 'tip/' in name else 'N·m', [
        figure(value) for value in (one.rms, one.rms_without_mean, one.largest)])
        for name, one in errors.items()]


def _facts(found: Estimates, about: About) -> list[tuple[str, Any]]:
    seconds = float(found.stamps[-1] - found.stamps[0]) * 1e-9 if len(found.stamps) else 0.0
    return [('recording', about.source), ('duration', f'{figure(seconds)} s'),
            ('samples', f'{len(found.stamps):,}'), ('refused', f'{about.refused:,}'),
            ('arm', about.arm), ('version', about.version)]

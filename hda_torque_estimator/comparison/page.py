"""The page of a comparison: one HTML file that needs no network, no script and no other file."""

from collections.abc import Mapping
from html import escape

from .compare import Comparison, Difference
from .report import (clock_sentence, doubts, drawn, headline, lines_text, share_text,
                     start_text)
from ..pages.document import captioned, code, document, figure, section, table, unit

_CAPTION = ('{}: both bags on common times, what the second has more than the first, and the '
            'spectrum of that. {} Dashed: twice the noise, which is what changes within 40 ms.')


def page(found: Comparison, version: str, figures: Mapping[str, str]) -> str:
    """
    Return a comparison as one HTML document.

    `figures` are SVG elements, one for each of `report.drawn`. They go in as they are; all other
    text is escaped.
    """
    parts = [f'<h1>{escape(headline(found))}</h1>', *_lead(found), _signals(found),
             _figures(found, figures), _lists(found), _sampling(found), _made(found, version)]
    return document(f'Comparison: {headline(found)}', parts)


def _lead(found: Comparison) -> list[str]:
    said = [f'First: {found.first.source}. Second: {found.second.source}.',
            clock_sentence(found).replace('+-', '±'), *doubts(found.alignment)]
    return [f'<p class="lead">{escape(sentence)}</p>' for sentence in said]


def _signals(found: Comparison) -> str:
    return section('Signals, those that differ beyond noise first', table(
        ('signal', 'unit', 'rms', 'largest', 'mean', 'rms of motion', 'noise', 'starts',
         'lines'), map(_row, found.differences)))


def _row(found: Difference) -> list[str]:
    numbers = [f'{value:.3g}' for value in (found.rms, found.largest, found.mean)]
    texts = [*numbers, share_text(found), f'{found.noise:.3g}', start_text(found)]
    return [code(found.name), escape(unit(found.unit)),
            *(f'<span class="number">{text}</span>' for text in texts), lines_text(found)]


def _figures(found: Comparison, inline: Mapping[str, str]) -> str:
    return section('What differs', ''.join(
        captioned(svg, _caption(each)) for each, svg in zip(drawn(found), inline.values())))


def _caption(found: Difference) -> str:
    starts = 'It does not leave the noise for good.' if found.start is None else \
        f'It leaves the noise at {start_text(found)}.'
    return _CAPTION.format(found.name, starts)


def _lists(found: Comparison) -> str:
    rows = [[code(name), where] for where, names in (
        ('only in the first', found.only_first), ('only in the second', found.only_second),
        ('in both, but never at the same time', found.apart)) for name in names]
    return section('Not compared', table(('signal', 'where'), rows)) if rows else ''


def _sampling(found: Comparison) -> str:
    rows = [[which, code(topic), figure(facts.rate), f'{facts.samples:,}',
             f'{facts.lost:,}', figure(1e3 * facts.longest_gap)]
            for which, bag in (('first', found.first), ('second', found.second))
            for topic, facts in bag.sampling.items()]
    return section('Sampling', table(
        ('bag', 'topic', 'rate [Hz]', 'samples', 'lost', 'longest gap [ms]'), rows))


def _made(found: Comparison, version: str) -> str:
    return (f'<p>Aligned by <code>--align {escape(found.alignment.mode)}</code>, version '
            f'{escape(version)}. Times count from the start of the first bag.</p>')

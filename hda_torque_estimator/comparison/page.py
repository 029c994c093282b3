"""The page of a comparison: one HTML file that needs no network and no other file."""

from .compare import Comparison, Difference
from .curves import charts
from .report import clock_sentence, doubts, headline, share_text, start_text
from ..pages.badge import Badge
from ..pages.render import render
from ..pages.wording import in_unit

ALIKE = Badge('healthy', 'Alike', 'nothing differs beyond noise')
DIFFERENT = Badge('explained', 'Different', 'signals differ beyond noise')


def page(found: Comparison, version: str) -> str:
    """Return a comparison as one HTML document; all text in it is escaped."""
    differs = any(each.is_significant for each in found.differences)
    lists = [(name, where) for where, names in (
        ('only in the first', found.only_first), ('only in the second', found.only_second),
        ('in both, but never at the same time', found.apart)) for name in names]
    return render(
        'comparison.html', title=f'Comparison: {headline(found)}',
        badge=DIFFERENT if differs else ALIKE, charts=charts(found), found=found,
        headline=headline(found), clock=_clock(found),
        doubts=doubts(found.alignment), lists=lists, version=version,
        texts={'share': share_text, 'start': start_text, 'lines': _lines})


def _clock(found: Comparison) -> str:
    """Return the sentence on both clocks in the letters of a page."""
    return clock_sentence(found).replace('+-', '±').replace(' us ', ' µs ')


def _lines(found: Difference) -> str:
    """Return the strongest lines of a difference, with their amplitudes in handy units."""
    lines = [(line.frequency, *in_unit([line.amplitude], found.unit))
             for line in found.spectrum.lines]
    return ', '.join(f'{frequency:.2f} Hz ({size} {scale})' for frequency, (size,), scale in lines)

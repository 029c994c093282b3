"""The page of a comparison: one HTML file that needs no network and no other file."""

from .compare import Comparison
from .curves import charts
from .report import clock_sentence, doubts, headline, lines_text, share_text, start_text
from ..pages.badge import Badge
from ..pages.render import render

ALIKE = Badge('healthy', 'Alike', 'nothing differs beyond noise')
DIFFERENT = Badge('explained', 'Different', 'signals differ beyond noise')


def page(found: Comparison, version: str) -> str:
    """Return a comparison as one HTML document; all text in it is escaped."""
    told = any(each.is_told for each in found.differences)
    lists = [(name, where) for where, names in (
        ('only in the first', found.only_first), ('only in the second', found.only_second),
        ('in both, but never at the same time', found.apart)) for name in names]
    return render(
        'comparison.html', title=f'Comparison: {headline(found)}',
        badge=DIFFERENT if told else ALIKE, charts=charts(found), found=found,
        headline=headline(found), clock=clock_sentence(found).replace('+-', '±'),
        doubts=doubts(found.alignment), lists=lists, version=version,
        texts={'share': share_text, 'start': start_text, 'lines': lines_text})

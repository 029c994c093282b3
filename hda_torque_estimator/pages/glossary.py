"""The terms that a page uses, as the glossary explains them."""

from collections.abc import Mapping
import re
from typing import NamedTuple

_ENTRY = re.compile(r'^- \*\*(.+?)\*\*: (.+)$', re.MULTILINE)
_LINK = re.compile(r'\[([^\]]*)\]\([^)]*\)')
_MARKS = re.compile(r'[$`]|\\text|[{}]')
_SYMBOLS = {r'\theta': 'θ', r'\tau': 'τ', r'\Delta': 'Δ', r'\sigma': 'σ', r'\sin': 'sin'}


class GlossaryTerm(NamedTuple):
    """A term and its meaning in plain words."""

    name: str
    meaning: str


def terms_in(text: str, glossary: str) -> tuple[GlossaryTerm, ...]:
    """Return the entries of a glossary (Markdown) whose terms stand in a plain text."""
    words = text.lower()
    return tuple(GlossaryTerm(name, _plain(meaning)) for name, meaning in _ENTRY.findall(glossary)
                 if _stands(name.lower(), words))


def named_in(text: str, meanings: Mapping[str, str]) -> tuple[GlossaryTerm, ...]:
    """Return the terms that stand in a plain text, of `meanings` by name."""
    words = text.lower()
    return tuple(GlossaryTerm(name, f'{meaning}.') for name, meaning in meanings.items()
                 if _stands(name.lower(), words))


def _stands(name: str, words: str) -> bool:
    """Return whether a term, or its plural, is a word of a text."""
    return re.search(rf'(?<![\w-]){re.escape(name)}s?(?![\w-])', words) is not None


def _plain(meaning: str) -> str:
    """Return Markdown without its marks; formulas keep their letters."""
    text = _LINK.sub(r'\1', meaning)
    for typed, letter in _SYMBOLS.items():
        text = text.replace(typed, letter)
    return _MARKS.sub('', text)

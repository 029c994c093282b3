"""Split pages and docstrings into sentences and count their words."""

import re

LONGEST = 25

_NO_PROSE = re.compile(r'^(```|~~~).*?^\1[^\n]*$|\$\$.*?\$\$|^(?: {4}|\|).*?$',
                       re.MULTILINE | re.DOTALL)
_ONE_WORD = re.compile(r'`+[^`]*`+|\$[^$]+\$|https?://\S+')
_TARGET = re.compile(r'(?<=\])\([^)]*\)')
_BLOCK = re.compile(r'\n\s*\n|\n(?=\s*(?:[-*#>]|\d+\.)\s)')
_END = re.compile(r'(?<=[.!?])[)"*\']*\s+(?=[("*\']*(?:[A-Z0-9\[]|eq:))')
_WORD = re.compile(r'[^\W_][\w\'’.,/*^=<>-]*')


def of_page(text: str) -> list[str]:
    """Return the sentences of a page of Markdown; code, tables and formulas are none."""
    text = _TARGET.sub('', _ONE_WORD.sub('X', _NO_PROSE.sub('\n\n', text)))
    return [' '.join(part.split()) for block in _BLOCK.split(text)
            for part in _END.split(block.strip()) if _WORD.search(part)]


def words(sentence: str) -> int:
    """Return how many words a sentence has; a formula or a piece of code is one."""
    return len(_WORD.findall(sentence))

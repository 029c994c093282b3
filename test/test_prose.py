"""Sentences of pages and public docstrings are short enough to be read once."""

import ast
from collections.abc import Iterator
from pathlib import Path

from project_files import files, PACKAGES, ROOT
import prose
import pytest

PAGES = [ROOT / 'README.md', ROOT / 'CONTRIBUTING.md', *files('*.md', ROOT / 'docs')]
DEFINITIONS = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


def docstrings(path: Path) -> Iterator[str]:
    """Yield the docstrings of a module and of what is public in it."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, DEFINITIONS) and not getattr(node, 'name', '').startswith('_'):
            yield ast.get_docstring(node) or ''


def too_long(texts: Iterator[str] | list[str]) -> list[tuple[int, str]]:
    """Return the sentences that have too many words, the longest first."""
    counted = {(prose.words(sentence), sentence)
               for text in texts for sentence in prose.of_page(text)}
    return sorted((found for found in counted if found[0] > prose.LONGEST), reverse=True)


@pytest.mark.parametrize('page', PAGES, ids=lambda page: page.stem)
def test_sentences_of_a_page_are_short(page):
    assert too_long([page.read_text()]) == []


@pytest.mark.parametrize('package', PACKAGES)
def test_sentences_of_docstrings_are_short(package):
    assert too_long(text for path in files('*.py', ROOT / package)
                    for text in docstrings(path)) == []


def test_sentences_are_split_and_counted():
    text = ('# Title\n\nOne [link](a.md) and `some code`. Two: $a + b$; three.\n'
            '- Four.\n\n| a | table |\n\n```sh\nno prose\n```\n')
    assert [(prose.words(sentence), sentence) for sentence in prose.of_page(text)] == [
        (1, '# Title'), (4, 'One [link] and X.'), (3, 'Two: X; three.'), (1, '- Four.')]

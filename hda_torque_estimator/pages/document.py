"""The parts of a report's page: one HTML file that needs no network, no script, no other file."""

from collections.abc import Iterable
from html import escape
import math

from .style_sheet import STYLE_SHEET


def document(title: str, parts: Iterable[str], kind: str = '') -> str:
    """
    Return an HTML document of parts that are HTML already; empty parts are left out.

    `kind` is the class of its body, by which the style sheet chooses a mark.
    """
    body = f'<body class="{escape(kind)}">' if kind else '<body>'
    return ('<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
            '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
            f'<title>{escape(title)}</title>\n'
            f'<style>\n{STYLE_SHEET}</style>\n</head>\n{body}\n<main>\n'
            + '\n'.join(filter(None, parts)) + '\n</main>\n</body>\n</html>\n')


def section(title: str, content: str) -> str:
    """Return a section of content that is HTML already under a plain title."""
    return f'<section>\n<h2>{escape(title)}</h2>\n{content}</section>'


def table(heads: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """Return a table of plain heads and of cells that are HTML already."""
    top = ''.join(f'<th scope="col">{escape(head)}</th>' for head in heads)
    body = ''.join('<tr>' + ''.join(f'<td>{cell}</td>' for cell in row) + '</tr>\n'
                   for row in rows)
    return (f'<div class="wide"><table><thead><tr>{top}</tr></thead>\n'
            f'<tbody>\n{body}</tbody></table></div>\n')


def captioned(svg: str, caption: str) -> str:
    """Return an SVG element as a figure with its plain caption."""
    return (f'<figure>\n<div aria-hidden="true">{svg}</div>\n'
            f'<figcaption>{escape(caption)}</figcaption></figure>\n')


def code(name: str) -> str:
    """Return a name as it is typed."""
    return f'<code>{escape(name)}</code>'


def figure(value: float) -> str:
    """Return a number with four figures."""
    return f'{value:.4g}' if math.isfinite(value) else 'unknown'


def unit(name: str) -> str:
    """Return a unit as people write it; a pure number has none."""
    return '' if name == '1' else name.replace('*', '\N{MIDDLE DOT}')

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
    page = ('<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
            '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
            f'<title>{escape(title)}</title>\n'
            f'<style>\n{STYLE_SHEET}</style>\n</head>\n{body}\n<main>\n'
            + '\n'.join(filter(None, parts)) + '\n</main>\n</body>\n</html>\n')
    return page.encode(errors='backslashreplace').decode()      # file names may be no UTF-8


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


def facts_table(rows: Iterable[tuple[str, str]]) -> str:
    """Return a table of plain names and what they are, HTML already, a row for each."""
    body = ''.join(f'<tr><th scope="row">{escape(name)}</th><td>{value}</td></tr>\n'
                   for name, value in rows)
    return f'<div class="wide"><table class="facts"><tbody>\n{body}</tbody></table></div>\n'


def card(title: str, content: str) -> str:
    """Return a framed part of a section; title and content are HTML already."""
    return f'<article>\n<h3>{title}</h3>\n{content}\n</article>\n'


def captioned(svg: str, caption: str) -> str:
    """Return an SVG element as a figure with its plain caption."""
    return (f'<figure>\n<div aria-hidden="true">{svg}</div>\n'
            f'<figcaption>{escape(caption)}</figcaption></figure>\n')


def code(name: str) -> str:
    """Return a name as it is typed; the style sheet lets lines break within it."""
    return f'<code>{escape(name)}</code>'


def figure(value: float) -> str:
    """Return a number with four figures."""
    return f'{value:.4g}' if math.isfinite(value) else 'unknown'


def number(value: float, scale: str = '') -> str:
    """Return a number and its unit as a cell of a table that no line break cuts."""
    return f'<span class="number">{figure(value)} {escape(unit(scale))}'.rstrip() + '</span>'


def unit(name: str) -> str:
    """Return a unit as people write it; a pure number has none."""
    return '' if name == '1' else name.replace('*', '\N{MIDDLE DOT}')

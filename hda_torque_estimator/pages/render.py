"""Fill the templates of all pages: one HTML file that needs no network and no other file."""

import base64
from collections.abc import Mapping
from functools import cache
import hashlib
from html import escape, unescape
from importlib.resources import files
import json
import re
from typing import Any, NamedTuple

from hda_arm_sim.model.effects import EFFECTS
from jinja2 import Environment, PackageLoader, StrictUndefined

from . import wording
from .badge import Badge, BADGES, DONE
from .glossary import GlossaryTerm, named_in, terms_in
from .plot import documents, PlotGroup

ASSETS = files('hda_torque_estimator.pages') / 'assets'
_SECTION = re.compile(r'<(?:section|details)[^>]* id="([^"]+)"[^>]*>\s*<(?:h2|summary)>([^<]+)')
FILTERS = {name: getattr(wording, name)
           for name in ('capital', 'figure', 'handy', 'percent', 'short', 'spoken', 'unbroken',
                        'unit')}


class Section(NamedTuple):
    """A part of a page that its list of contents leads to."""

    name: str
    title: str


def render(template: str, *, title: str, badge: Badge = DONE,
           charts: Mapping[str, PlotGroup] | None = None, **content: Any) -> str:
    """
    Return the page of a template.

    `charts` are the plots by the name under which the template places them. All text is escaped.
    A page without charts has no script.
    """
    charts = charts or {}
    plots, columns = documents(charts)
    page = _environment().get_template(template)
    scripts = [_library(), asset('page.js')] if plots else []
    content |= {'title': title, 'badge': badge, 'charts': charts, 'plots': plots,
                'columns': columns,
                'scripts': scripts, 'policy': _policy(scripts), 'style': _style(bool(plots))}
    bare = page.render(content, terms=(), sections=())
    terms = _terms(bare)
    text = page.render(content, terms=terms, sections=_sections(bare, bool(terms)))
    return text.encode(errors='backslashreplace').decode()      # file names may be no UTF-8


@cache
def _environment() -> Environment:
    made = Environment(loader=PackageLoader('hda_torque_estimator.pages'), autoescape=True,
                       undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    made.filters |= FILTERS | {'json': _json, 'breakable': breakable}
    made.globals |= {'BADGES': BADGES, 'in_unit': wording.in_unit}
    return made


@cache
def asset(name: str) -> str:
    """Return a file of the package that goes into pages as it is."""
    return ASSETS.joinpath(name).read_text(encoding='utf-8')


def breakable(name: str) -> str:
    """Return a name as HTML; a line may end where its parts do, those of a path if it is one."""
    ends = '/' if '/' in name[:-1] else '._'
    return '<wbr>'.join(map(escape, re.split(f'(?<=[{ends}])(?=.)', name)))


def _library() -> str:
    """Return the library of the plots, with its licence, which every copy of it must carry."""
    return f'/*\n{asset("uplot/LICENSE")}*/\n{asset("uplot/uPlot.iife.min.js")}'


def _style(plotted: bool) -> str:
    return '\n'.join([*([asset('uplot/uPlot.min.css')] if plotted else []), asset('style.css')])


def _json(value: Any) -> str:
    """Return a value as JSON in which nothing ends the element that holds it."""
    text = json.dumps(value, allow_nan=False, separators=(',', ':'))
    return text.replace('<', '\\u003c').replace('&', '\\u0026')


def _policy(scripts: list[str]) -> str:
    """Return what a browser may do with a page: run these scripts, and load nothing at all."""
    known = ' '.join(f"'sha256-{_digest(script)}'" for script in scripts) or "'none'"
    return (f"default-src 'none'; script-src {known}; style-src 'unsafe-inline'; "
            "img-src data:; base-uri 'none'; form-action 'none'")


def _digest(script: str) -> str:
    return base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()


def _sections(page: str, glossary: bool) -> tuple[Section, ...]:
    """Return what a page has a name and a heading for, in order, the glossary last."""
    found = [Section(name, unescape(title).strip()) for name, title in _SECTION.findall(page)]
    return (*found, *([Section('glossary', 'Glossary')] if glossary else []))


def _terms(page: str) -> tuple[GlossaryTerm, ...]:
    """Return the terms of the glossary and the effects that a page uses, in their order."""
    main = page[page.index('<main'):page.index('</main>')].replace('<wbr>', '')
    shown = ' '.join(unescape(re.sub(r'<[^>]+>', ' ', main)).replace('_', ' ').split())
    words = terms_in(shown, asset('glossary.md'))
    effects = named_in(shown, {wording.spoken(one.name): one.cause for one in EFFECTS})
    known = {one.name for one in words}
    return tuple(sorted((*words, *(one for one in effects if one.name not in known)),
                        key=lambda term: term.name.lower()))

"""How `make docs` makes the manual of the pages beside this file; Sphinx reads these names."""

from importlib.util import find_spec
from pathlib import Path

from sphinx.application import Sphinx
from sphinx.util.fileutil import copy_asset_file

project = 'hda_torque_estimator'
author = 'The hda_torque_estimator authors'
project_copyright = author
extensions = ['myst_parser', 'sphinx.ext.mathjax', 'sphinx_copybutton']
myst_enable_extensions = ['dollarmath']
myst_heading_anchors = 4
exclude_patterns = ['_static']
html_theme = 'furo'
html_title = 'HDA torque estimator'
smartquotes = False
html_static_path = ['_static']
html_css_files = ['manual.css']
html_copy_source = html_show_sourcelink = False
html_show_sphinx = False
html_show_search_summary = False    # a page that is opened from a file may not read others
pygments_style, pygments_dark_style = 'friendly', 'monokai'
copybutton_selector = 'div.highlight-sh pre, div.highlight-yaml pre'
mathjax_path = 'tex-svg.js'         # one file, glyphs included: no network, no fonts

# Pages outside this folder, and where the manual has them.
ELSEWHERE = {'](../CONTRIBUTING.md': '](contributing.md', '](../README.md': '](index.md'}


def point_inside(_: Sphinx, __: str, source: list[str]) -> None:
    """Let links that are right in the repository be right in the manual."""
    for path, page in ELSEWHERE.items():
        source[0] = source[0].replace(path, page)


def add_formulas(app: Sphinx, error: Exception | None) -> None:
    """Put MathJax beside the pages."""
    if error is None:
        wheel = find_spec('sphinx-mathjax-offline')
        assert wheel is not None and wheel.submodule_search_locations is not None
        carried = Path(wheel.submodule_search_locations[0], 'static', 'mathjax', mathjax_path)
        copy_asset_file(str(carried), str(app.outdir / '_static'))


def setup(app: Sphinx) -> None:
    """Hang both onto the build."""
    app.connect('source-read', point_inside)
    app.connect('build-finished', add_formulas)

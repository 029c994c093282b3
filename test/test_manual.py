"""The manual: its reference is that of the source, and its pages need no network."""

import asyncio
from pathlib import Path
import re
import subprocess
import sys

from browser import CHROMIUM
from driven_browser import browser
from hda_arm_sim.model.effects import EFFECTS
from hda_torque_estimator import cli
from project_files import files, ROOT
import pytest
import reference_pages

DOCS = ROOT / 'docs'
LOADED = re.compile(r'<(?:script|img|iframe)[^>]*\bsrc="([^"]*)"|<link[^>]*\bhref="([^"]*)"')
FENCED = re.compile(r'^```.*?^```', re.MULTILINE | re.DOTALL)


@pytest.fixture(scope='module')
def built(tmp_path_factory) -> Path:
    """Build the manual as `make docs` does; a warning is an error."""
    folder = tmp_path_factory.mktemp('manual')
    done = subprocess.run(
        [sys.executable, '-m', 'sphinx', '-qEW', '--keep-going', '-b', 'html', '-d',
         folder / 'cache', DOCS, folder / 'html'], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return folder / 'html'


@pytest.mark.parametrize('name', reference_pages.PAGES)
def test_the_reference_is_that_of_the_source(name):
    written = (reference_pages.FOLDER / f'{name}.md').read_text()
    assert written == reference_pages.PAGES[name](), 'run make docs'


def test_the_reference_has_only_pages_that_are_written():
    assert {page.stem for page in reference_pages.FOLDER.iterdir()} == set(reference_pages.PAGES)


def test_the_reference_knows_all_commands_nodes_and_effects():
    reported = {name: page() for name, page in reference_pages.PAGES.items()}
    assert all(f'## `hda {name}`' in reported['options'] for name in cli.COMMANDS)
    assert all(f'## `{effect.name}`' in reported['effects'] for effect in EFFECTS)
    nodes = re.findall(r'^\| `(\w+)` \|', reported['topics'].partition('## Who')[2], re.MULTILINE)
    assert set(nodes) == set(reference_pages.NODES)


def test_an_error_of_every_room_is_found():
    names = {name for name, _, _ in reference_pages.error_classes()}
    assert {'HdaError', 'ArmError', 'BagError', 'PlanError'} <= names


def test_bars_and_stars_in_cells_mean_themselves():
    assert reference_pages.table(('a',), [('N*m*s | `N*m`',)]).endswith(
        '| N\\*m\\*s \\| `N*m` |\n')


@pytest.mark.xdist_group('manual')
def test_every_page_is_in_the_manual(built):
    missing = [page for page in files('*.md', DOCS)
               if not (built / page.relative_to(DOCS)).with_suffix('.html').is_file()]
    assert missing == []


@pytest.mark.xdist_group('manual')
def test_the_manual_needs_no_network(built):
    asked = {(page.name, first or second) for page in built.rglob('*.html')
             for first, second in LOADED.findall(page.read_text())}
    assert {target for _, target in asked if '//' in target} == set()
    assert [target for name, target in asked if name == 'index.html'
            and not (built / target.partition('?')[0]).exists()
            and not target.endswith('.html') and '#' not in target] == []
    assert '"flexsplin"' in (text := (built / 'searchindex.js').read_text()) or \
        'flexsplin:' in text


@pytest.mark.xdist_group('manual')
def test_formulas_are_set_by_what_comes_with_the_manual(built):
    assert '<script' in (text := (built / 'model.html').read_text())
    assert re.search(r'src="_static/tex-svg\.js', text)
    assert '(eq:flexspline)' in text
    assert (built / '_static' / 'tex-svg.js').stat().st_size > 1_000_000


@pytest.mark.xdist_group('manual')
@pytest.mark.skipif(CHROMIUM is None, reason='no Chromium is installed here')
def test_the_manual_is_searched_and_read_from_a_file(built):
    """In a browser without a server: pages are found, formulas are set, nothing is too wide."""
    async def read():
        async with browser() as page:
            await page.visit((built / 'search.html').as_uri() + '?q=flexspline')
            await page.until("document.querySelectorAll('#search-results li a').length > 5")
            await page.visit((built / 'model.html').as_uri(), width=360)
            await page.until("document.querySelectorAll('mjx-container svg').length > 100")
            bad = await page.ask("document.querySelectorAll('[data-mml-node=merror]').length")
            over = await page.ask('document.documentElement.scrollWidth - innerWidth')
            return bad, over, page.complaints

    assert asyncio.run(read()) == (0, 0, [])


def test_the_style_page_has_ten_pairs():
    rows = (DOCS / 'style.md').read_text().partition('## Ten sentences')[2]
    assert len(re.findall(r'^\| [a-z]', rows, re.MULTILINE)) == 10


def test_no_page_but_the_index_has_a_navigation_of_its_own():
    assert [page.name for page in files('*.md', DOCS)
            if '{toctree}' in ''.join(FENCED.findall(page.read_text()))] == ['index.md']

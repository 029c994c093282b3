"""No page is wider than its screen: tables fit, or scroll within a box of their own."""

from collections.abc import Iterator
from dataclasses import replace
from html.parser import HTMLParser
import json
from pathlib import Path
import re
import shutil
import subprocess

from hda_arm_sim.model.effects import EFFECTS
from hda_torque_estimator.diagnosis.findings.report import Candidate, Finding, Number
from hda_torque_estimator.diagnosis.telling.page import page
from hda_torque_estimator.fleet.fleet_report import Cause, fleet_page, Line
from hda_torque_estimator.pages.style_sheet import STYLE_SHEET
import pytest
from test_page import diagnosis

CHROMIUM = next(filter(None, map(shutil.which, (
    'chromium', 'chromium-browser', 'google-chrome'))), None)
FLAGS = ('--headless', '--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run',
         '--disable-background-networking', '--disable-component-update', '--disable-sync')
WIDTHS = (360, 1280, 1920)
PHONE = 640             # screens narrower than this may scroll within a table's box [px]
MEASURE = """<script>
const wide = [...document.querySelectorAll('table')].map(table => {
  const box = table.parentElement, style = getComputedStyle(box).overflowX;
  return {over: table.offsetWidth - box.clientWidth, scrolls: style};
});
document.title = JSON.stringify({
  page: document.documentElement.scrollWidth - window.innerWidth, tables: wide});
</script>"""


def everything(effect: str) -> Finding:
    """Return a finding that tells every parameter of an effect in the most figures."""
    kind = next(kind for kind in EFFECTS if kind.name == effect)
    numbers = {rule.name: Number(-1.2345e-11, rule.unit, -1.2456e-11, -1.2234e-11)
               for rule in kind.declarations()}
    return replace(diagnosis().findings[0], effect=effect, cause=kind.cause, parameters=numbers)


def full_page() -> str:
    """Return the page of a diagnosis with the longest names and the most numbers."""
    told = diagnosis('ambiguous')
    found = tuple(everything(name) for name in (
        'kinematic_error', 'motor_cogging', 'position_dependent_friction', 'base_vibration'))
    pair = replace(told.ambiguous[0], candidates=tuple(
        Candidate(one.effect, 'joint1', one.parameters, one is found[0]) for one in found[:2]))
    return page(replace(told, findings=found, ambiguous=(pair,),
                        arm='/a/very/long/path/' + 'of_an_arm/' * 9 + 'arm.yaml'), {})


def whole_fleet() -> str:
    """Return the page of a fleet with long names."""
    causes = tuple(Cause(name, 'joint1', 0.991) for name in (
        'position_dependent_friction', 'nonlinear_viscous_friction'))
    return fleet_page([Line('recordings/of/a/long/day/' * 3 + 'bag', 'bag', 'explained', causes),
                       Line('bag2', 'bag2', None, error='no joint states in this bag ' * 4)],
                      'hda_arm.yaml', '0.1.0')


PAGES = {'diagnosis': full_page, 'fleet': whole_fleet}


class Tables(HTMLParser):
    """Takes down in which box each table of a page stands."""

    def __init__(self, text: str) -> None:
        """Read a whole page."""
        super().__init__()
        self.open: list[str] = []
        self.boxes: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        """Note a table's box."""
        if tag == 'table':
            self.boxes.append(self.open[-1])
        if tag not in ('meta', 'br', 'wbr'):
            self.open.append(dict(attrs).get('class') or tag)

    def handle_endtag(self, tag):
        """Leave an element."""
        self.open.pop()


@pytest.mark.parametrize('made', PAGES.values(), ids=PAGES)
def test_every_table_stands_in_a_box_that_scrolls(made):
    assert set(Tables(made()).boxes) == {'wide'}
    assert re.search(r'\.wide \{[^}]*overflow-x: auto', STYLE_SHEET)


def measured(text: str, folder: Path, width: int) -> dict[str, object]:
    """Return how far a page and its tables stick out of a screen of this width [px]."""
    path = folder / 'page.html'
    path.write_text(text.replace('</body>', f'{MEASURE}</body>'), encoding='utf-8')
    shown = subprocess.run(
        [str(CHROMIUM), *FLAGS, f'--user-data-dir={folder / "profile"}',
         f'--window-size={width},1200', '--dump-dom', path.as_uri()],
        capture_output=True, text=True, timeout=120).stdout
    return json.loads(re.search(r'<title>(.*?)</title>', shown, re.DOTALL)[1])


@pytest.fixture(scope='module', params=[
    pytest.param((name, width), id=f'{name}-{width}') for name in PAGES for width in WIDTHS])
def screen(request, tmp_path_factory) -> Iterator[tuple[int, dict[str, object]]]:
    """Return a width and what a browser of this width measures of a page."""
    if CHROMIUM is None:
        pytest.skip('there is no Chromium')
    name, width = request.param
    yield width, measured(PAGES[name](), tmp_path_factory.mktemp('screen'), width)


def test_a_page_is_no_wider_than_its_screen(screen):
    width, found = screen
    assert found['page'] <= 0
    assert found['tables']
    assert {one['scrolls'] for one in found['tables'] if one['over'] > 0} <= {'auto'}


def test_nothing_is_cut_off_on_a_wide_screen(screen):
    width, found = screen
    if width > PHONE:
        assert [one['over'] for one in found['tables'] if one['over'] > 0] == []

"""Every page in a browser, at three widths: nothing sticks out, no complaint, plots are drawn."""

import asyncio
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
import re
from typing import Any

from browser import CHROMIUM, Shown, shown
from driven_browser import browser
from hda_arm_sim.model.effects import EFFECTS
from hda_msgs_json.samples import JointSamples
from hda_torque_estimator.calibrate.calibration import Calibration
from hda_torque_estimator.calibrate.fitting.arm_numbers import ArmNumber
from hda_torque_estimator.calibrate.page import page as calibration_page
from hda_torque_estimator.calibrate.referenced import JointCalibration
from hda_torque_estimator.comparison.compare import compare
from hda_torque_estimator.comparison.page import page as comparison_page
from hda_torque_estimator.comparison.signals import bag_of
from hda_torque_estimator.diagnosis.findings.report import (Candidate, Finding, FittedNumber,
                                                            VERDICTS)
from hda_torque_estimator.diagnosis.reporting.page import page
from hda_torque_estimator.estimating.accuracy import EstimateErrors
from hda_torque_estimator.estimating.curves import ReferenceSignal
from hda_torque_estimator.estimating.estimates import Estimates
from hda_torque_estimator.estimating.laws import layout
from hda_torque_estimator.estimating.page import About
from hda_torque_estimator.estimating.page import page as estimation_page
from hda_torque_estimator.fleet.fleet_page import fleet_page
from hda_torque_estimator.fleet.lines import BagLine, NamedCause
from hda_torque_estimator.pages.render import asset
from hda_torque_estimator.reproduction.page import page as reproduction_page
from hda_torque_estimator.reproduction.rig.exhibit import Exhibit, PaperNumber
import numpy as np
import pytest
from test_page import diagnosis
from test_page_plots import shown_diagnosis, shown_exhibits

WIDTHS = (360, 1280, 1920)
PHONE = 640             # screens narrower than this may scroll within a table's box [px]
FIRST_SCREEN = 1200     # height of the window [px]
TIME = np.arange(3000) / 500.0


def everything(effect: str) -> Finding:
    """Return a finding that states every parameter of an effect in the most figures."""
    kind = next(kind for kind in EFFECTS if kind.name == effect)
    numbers = {rule.name: FittedNumber(-1.2345e-11, rule.unit, -1.2456e-11, -1.2234e-11)
               for rule in kind.declarations()}
    return replace(diagnosis().findings[0], effect=effect, cause=kind.cause, parameters=numbers)


def full_page() -> str:
    """Return the page of a diagnosis with the longest names and the most numbers."""
    judged = diagnosis('ambiguous')
    found = tuple(everything(name) for name in (
        'kinematic_error', 'motor_cogging', 'position_dependent_friction', 'base_vibration'))
    pair = replace(judged.ambiguous[0], candidates=tuple(
        Candidate(one.effect, 'joint1', one.parameters, one is found[0]) for one in found[:2]))
    return page(replace(judged, findings=found, ambiguous=(pair,),
                        arm='/a/very/long/path/' + 'of_an_arm/' * 9 + 'arm.yaml'), {})


def plotted(verdict: str) -> str:
    """Return the page of a diagnosis with plots."""
    return page(shown_diagnosis(verdict), {}, shown_exhibits())


def whole_fleet() -> str:
    """Return the page of a fleet with long names."""
    causes = tuple(NamedCause(name, 'joint1', 0.991) for name in (
        'position_dependent_friction', 'nonlinear_viscous_friction'))
    play = [NamedCause('backlash', 'joint1', 0.99, 'half_width', size, 0.9 * size, 1.1 * size,
                       'rad')
            for size in (1e-4, 2e-4)]
    return fleet_page([
        BagLine('recordings/of/a/long/day/' * 3 + 'bag', 'bag', 'explained', causes),
        *(BagLine(f'{day}', f'{day}', 'explained', (cause,), device='arm 7', severity=9.0,
                  date=f'2026-01-0{day}') for day, cause in enumerate(play, 1)),
        BagLine('bag2', 'bag2', None, error='no joint states in this bag ' * 4, device='b')],
        'hda_arm.yaml', '0.1.0', ['bags/old: no recording in it'])


def compared() -> str:
    """Return the page of two bags that differ."""
    stamps = np.round(1e9 * TIME).astype(np.int64)
    bags = [bag_of(name, {'joint_states': JointSamples(
        stamps, ('a_joint_with_a_long_name',), scale * np.sin(3.0 * TIME)[:, None],
        *np.full((2, len(TIME), 1), np.nan))}) for name, scale in (('one', 1.0), ('two', 1.1))]
    return comparison_page(compare(*bags, 'none'), '0.1.0')


def estimated() -> str:
    """Return the page of estimates of two joints and a tip, with a truth and a doubt."""
    random = np.random.default_rng(0)
    joints = random.normal(size=(len(TIME), 2, layout.RESULTS))
    tip = np.abs(random.normal(size=(len(TIME), layout.TIP_RESULTS)))
    stamps = np.round(1e9 * TIME).astype(np.int64)
    found = Estimates(stamps, joints, tip, np.empty(0, np.int64))
    about = About(('joint1', 'joint2'), 'a_bag', 'hda_arm.yaml', '0.1.0', 3, {'joint1: <b>': 0.1},
                  {'truth/joint1/torque': EstimateErrors(0.1, 0.1, 0.1, 0.2)}, '')
    return estimation_page(found, about,
                           {'joint1': {'truth': ReferenceSignal(stamps, np.sin(TIME))}})


def calibrated() -> str:
    """Return the page of a calibration of one joint, another of which nothing is known."""
    number = ArmNumber('torsion.flexspline_stiffness', 1.2345e4, 1.2e4, 1.3e4, 'N*m/rad', True)
    joints = (JointCalibration('joint1', ('a',), '', (number,), 3.0, 0.8, 0.3, True),
              JointCalibration('joint2', (), 'its reference torque never changes'))
    return calibration_page(Calibration(None, joints), out='new.yaml', arm='hda_arm.yaml',
                            bags=['a'], version='0.1.0')


def reproduced() -> str:
    """Return the page of a reproduction with a table of long names."""
    numbers = (PaperNumber('natural frequency of the joint', 'rad/s', 1.0, 2.0, 1e6, 'a remark'),)
    made = Exhibit(numbers=numbers, findings=('It is so.',))
    return reproduction_page({'fig2': made}, {}, '0.1.0')


PAGES = {'diagnosis': full_page, 'fleet': whole_fleet, 'comparison': compared,
         'estimation': estimated, 'calibration': calibrated, 'reproduction': reproduced,
         **{verdict: (lambda verdict=verdict: plotted(verdict)) for verdict in VERDICTS}}
PLOTTED = {'comparison', 'estimation', *VERDICTS}


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
    assert set(Tables(made()).boxes) <= {'wide'}
    assert re.search(r'\.wide \{[^}]*overflow-x: auto', asset('style.css'))


@pytest.mark.parametrize('made', PAGES.values(), ids=PAGES)
def test_the_list_of_contents_leads_to_every_part(made):
    text = made()
    names = re.findall(r'<(?:section|details)[^>]* id="([^"]+)"', text)
    led = re.findall(r'<a href="#([^"]+)"', text)
    assert len(set(names)) == len(names)
    assert led == (names if len(names) > 2 else [])
    assert text.count('<section>') == text.count('<details class="fold">') == 0


@pytest.fixture(scope='module', params=PAGES)
def screens(request, tmp_path_factory) -> tuple[str, Shown]:
    """Return a page's name, and what a browser measures of it at all widths."""
    if CHROMIUM is None:
        pytest.skip('there is no Chromium')
    name = request.param
    found = shown(PAGES[name](), tmp_path_factory.mktemp('screen'), WIDTHS)
    assert set(found.measured) == set(WIDTHS)
    return name, found


def test_a_page_is_no_wider_than_its_screen(screens):
    for width, found in screens[1].measured.items():
        assert found['page'] <= 0, width
        over = [one for one in found['tables'] if one['over'] > 0]
        assert {one['scrolls'] for one in over} <= {'auto'}
        assert not over or width < PHONE        # nothing is cut off on a wide screen


def test_a_browser_complains_of_nothing(screens):
    assert screens[1].complaints == []


def test_the_first_screen_holds_the_sentence(screens):
    name, found = screens
    for one in found.measured.values():
        assert one['headline'].strip()
        assert 0.0 < one['bottom'] < FIRST_SCREEN
        if name == 'explained':
            assert 'transmission error of 0.12 mrad (0.42 arcmin)' in one['headline']
        if name == 'fleet':
            assert ('The worst is arm 7: joint 1 has 0.4 mrad (1.4 arcmin) of play.'
                    in one['headline'].replace('\N{NO-BREAK SPACE}', ' '))


def test_every_plot_is_drawn_and_answers(screens):
    name, found = screens
    for one in found.measured.values():
        assert (one['plots'] > 0) == (name in PLOTTED)
        assert one['drawn'] == one['plots']
        assert one['pressed']


def test_a_browser_shows_what_is_wrong(tmp_path):
    """The measure itself: a page that is too wide and loads something is found out."""
    if CHROMIUM is None:
        pytest.skip('there is no Chromium')
    bad = calibrated().replace('</main>', '<div style="width: 3000px">x</div>'
                               '<img src="https://example.org/x.png" alt=""></main>')
    found = shown(bad, tmp_path, WIDTHS)
    assert all(one['page'] > 0 for one in found.measured.values())
    assert found.complaints


# What stands on paper: the heights of what folds [px], and of each chart how many plots it has,
# how many of them are drawn, and under which names.
ON_PAPER = """
const tall = one => one.checkVisibility() ? one.getBoundingClientRect().height : 0;
window.paper = null;
addEventListener('beforeprint', () => queueMicrotask(() => {
  window.paper = [...document.querySelectorAll('.chart')].map(chart => ({
    choices: Math.max(1, chart.querySelectorAll('[data-choice]').length),
    widths: [...chart.querySelectorAll('.plot canvas')].map(one => one.width),
    names: [...chart.querySelectorAll('.choice')].map(one => one.textContent)}));
}));
"""
HEIGHTS = ("""[...document.querySelectorAll('.fold > :not(summary), .numbers > :not(summary)')]"""
           '.map(tall)')


async def printed(text: str, folder: Path) -> tuple[list[int], list[dict[str, Any]], list[str]]:
    """Print a page in the dark, and return what stands on paper, and complaints."""
    (folder / 'page.html').write_text(text, encoding='utf-8')
    async with browser() as page:
        await page.visit((folder / 'page.html').as_uri(), width=390)
        await page.call('Emulation.setEmulatedMedia', media='print', features=[
            {'name': 'prefers-color-scheme', 'value': 'dark'}])
        await page.ask(ON_PAPER)
        heights = await page.ask(HEIGHTS)
        looks = await page.ask('getComputedStyle(document.body).colorScheme + " "'
                               ' + getComputedStyle(document.body).backgroundColor')
        assert looks == 'light rgb(255, 255, 255)'          # no light hues on white paper
        await page.call('Emulation.setEmulatedMedia', media='')
        shown_before = await page.ask('document.querySelectorAll(".chart *").length')
        await page.call('Page.printToPDF')
        assert await page.ask('document.querySelectorAll(".chart *").length') == shown_before
        return heights, await page.ask('window.paper'), page.complaints


@pytest.mark.parametrize('made', (calibrated, whole_fleet, reproduced, estimated,
                                  lambda: plotted('explained')))
def test_on_paper_all_folds_are_open_and_all_choices_of_a_plot_are_drawn(made, tmp_path):
    """The folds also where a page has no script to open them."""
    if CHROMIUM is None:
        pytest.skip('there is no Chromium')
    heights, charts, complaints = asyncio.run(printed(made(), tmp_path))
    assert heights and min(heights) > 0.0
    for chart in charts:
        assert len(chart['widths']) == chart['choices']
        assert len({*chart['names']}) == (chart['choices'] if chart['choices'] > 1 else 0)
        assert len({*chart['widths']}) == 1 and chart['widths'][0] > 390    # of the sheet
    assert max((chart['choices'] for chart in charts), default=2) > 1
    assert complaints == []

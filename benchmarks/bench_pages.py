"""
Measure every page that `hda` writes, in a headless Chromium, as Lighthouse would.

A minute of two joints is simulated, and each command writes its page: size, first paint, and what
is wider than the screen at three widths, light and dark. The least contrast of any text and what a
screen reader cannot name are taken from the page itself. Bars: 3 MB, nothing too wide, contrast
4.5 to 1 (WCAG 2, AA), nothing without a name, no complaint. Times are those of this machine.
"""

import asyncio
from collections.abc import Iterator
import importlib
from pathlib import Path
import subprocess
import sys
import tempfile
from typing import Any, NamedTuple

from size import parser, verdict

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / 'test'))
driven = importlib.import_module('driven_browser')

WIDTHS = (360, 1280, 1920)      # a phone, a laptop, a desk [px]
THEMES = ('light', 'dark')
LARGEST = 3.0                   # of a page [MB] (source: issue "For people")
LEAST_CONTRAST = 4.5            # of text (source: WCAG 2.2, 1.4.3, level AA)
PLAY = '- {effect: backlash, joint: joint1, parameters: {half_width: 1.0e-4}}\n'
WEDGE = '- {effect: base_tilt, parameters: {tilt: 0.4363323, direction: 0.0}}\n'
MOTION = 'simulate --arm hda_arm.yaml --motion rich --duration {} --seed {} --out {}'
COMMANDS = (
    (MOTION.format(60, 4, 'bags/worn/one') + ' --effects play.yaml', ''),
    (MOTION.format(60, 4, 'bags/new/one'), ''),
    (MOTION.format(30, 3, 'wedge') + ' --effects wedge.yaml', ''),
    ('diagnose bags/worn/one --arm hda_arm.yaml --out found', 'found/report.html'),
    ('diagnose bags/new/one --arm hda_arm.yaml --out healthy', 'healthy/report.html'),
    ('diagnose --each bags --arm hda_arm.yaml --out fleet', 'fleet/fleet.html'),
    ('compare bags/new/one bags/worn/one --out differ', 'differ/compare.html'),
    ('estimate bags/worn/one --arm hda_arm.yaml --out torques --page estimates.html',
     'estimates.html'),
    ('calibrate bags/new/one wedge --arm hda_arm.yaml --tilt wedge 25 0 --out mine.yaml '
     '--page calibration.html', 'calibration.html'),
    ('reproduce fig7 table1 --out paper', 'paper/paper.html'))
TINY = (
    (MOTION.format(2, 1, 'bag'), ''),
    ('estimate bag --arm hda_arm.yaml --out torques --page estimates.html', 'estimates.html'))

MEASURE = """(() => {
  document.querySelectorAll('details').forEach(one => { one.open = true; });
  const seen = document.createElement('canvas').getContext('2d', {willReadFrequently: true});
  const rgba = colour => {
    seen.clearRect(0, 0, 1, 1);
    seen.fillStyle = colour;
    seen.fillRect(0, 0, 1, 1);
    return [...seen.getImageData(0, 0, 1, 1).data];
  };
  const light = colour => {
    const [r, g, b] = colour.slice(0, 3).map(part => part / 255).map(
      part => part <= 0.04045 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4);
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const ground = element => {
    for (let at = element; at; at = at.parentElement) {
      const colour = rgba(getComputedStyle(at).backgroundColor);
      if (colour[3] === 255) return colour;
    }
    return [255, 255, 255, 255];
  };
  const words = [...document.querySelectorAll('body *')].filter(element =>
    element.checkVisibility() && !element.closest('script, style, noscript, [aria-hidden=true]') &&
    [...element.childNodes].some(node => node.nodeType === 3 && node.data.trim()));
  const least = words.map(element => {
    const style = getComputedStyle(element);
    const ink = element.namespaceURI.endsWith('svg') ? style.fill : style.color;
    const [high, low] = [light(rgba(ink)), light(ground(element))].sort((a, b) => b - a);
    return {ratio: (high + 0.05) / (low + 0.05), text: element.textContent.trim().slice(0, 40)};
  }).sort((a, b) => a.ratio - b.ratio)[0] ?? {ratio: 21, text: ''};
  const controls = [...document.querySelectorAll(
    'button, a, summary, input, [tabindex], svg[role], [role=img]')];
  const paint = performance.getEntriesByName('first-contentful-paint')[0];
  const [load] = performance.getEntriesByType('navigation');
  return {
    over: document.documentElement.scrollWidth - innerWidth, least,
    unnamed: controls.filter(
      one => !(one.textContent.trim() || one.ariaLabel || one.title)).length,
    paint: paint?.startTime ?? null, loaded: load?.loadEventEnd ?? null};
})()"""


class Page(NamedTuple):
    """What was measured of a page: size [MB], times [ms], and the worst of widths and themes."""

    name: str
    size: float
    paint: float
    loaded: float
    over: int               # wider than the screen [px]
    contrast: float
    faintest: str           # the text that has it
    unnamed: int
    complaints: int

    def is_good(self) -> bool:
        """Return whether a page keeps all bars."""
        return (self.size <= LARGEST and self.over <= 0 and self.contrast >= LEAST_CONTRAST
                and not self.unnamed and not self.complaints)


def made(folder: Path, commands: tuple[tuple[str, str], ...]) -> Iterator[Path]:
    """Run the commands in a folder, and yield the pages that they wrote."""
    (folder / 'play.yaml').write_text(PLAY, encoding='utf-8')
    (folder / 'wedge.yaml').write_text(WEDGE, encoding='utf-8')
    for words, page in commands:
        subprocess.run([sys.executable, '-m', 'hda_torque_estimator.cli', *words.split()],
                       cwd=folder, stdout=subprocess.DEVNULL, check=True)
        if page:
            yield folder / page


async def measured(pages: list[Path], folder: Path) -> list[Page]:
    """Return what one browser measures of all pages."""
    async with driven.browser() as browser:
        return [await _measured(browser, page, str(page.relative_to(folder))) for page in pages]


async def _measured(browser: Any, page: Path, name: str) -> Page:
    before = len(browser.complaints)
    await browser.visit(page.as_uri())
    await browser.until("performance.getEntriesByName('first-contentful-paint').length > 0")
    first, found = await browser.ask(MEASURE), []
    for theme in THEMES:
        await browser.call('Emulation.setEmulatedMedia', features=[
            {'name': 'prefers-color-scheme', 'value': theme}])
        for width in WIDTHS:
            await browser.resize(width, 800)
            found.append(await browser.ask(MEASURE))
    worst = min((one['least'] for one in found), key=lambda least: least['ratio'])
    return Page(name, page.stat().st_size / 1e6, first['paint'], first['loaded'],
                max(one['over'] for one in found), worst['ratio'], worst['text'],
                max(one['unnamed'] for one in found), len(browser.complaints) - before)


def table(pages: list[Page]) -> str:
    """Return the pages as a table of Markdown."""
    lines = ['| page | size [MB] | first paint [ms] | loaded [ms] | too wide [px] '
             '| least contrast | no name | complaints |', f'|{" --- |" * 8}']
    lines += [f'| `{page.name}` | {page.size:.2f} | {page.paint:.0f} | {page.loaded:.0f} '
              f'| {max(page.over, 0)} | {page.contrast:.1f} | {page.unnamed} '
              f'| {page.complaints} |' for page in pages]
    return '\n'.join(lines)


def main() -> int:
    """Print the table, and return whether all bars are kept."""
    quick = parser(__doc__).parse_args().quick
    if driven.CHROMIUM is None:
        print('there is no Chromium: nothing is measured')
        return 0
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        pages = asyncio.run(measured(list(made(folder, TINY if quick else COMMANDS)), folder))
    print(table(pages))
    for page in pages:
        if page.contrast < LEAST_CONTRAST:
            print(f'{page.name}: "{page.faintest}" has a contrast of {page.contrast:.2f}')
    return verdict('pages keep their bars', all(page.is_good() for page in pages), quick=quick)


if __name__ == '__main__':
    sys.exit(main())

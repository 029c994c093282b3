"""Pages in a headless Chromium: what it complains of, and how wide everything becomes."""

from base64 import b64encode
from collections.abc import Iterable
from hashlib import sha256
from html import unescape
import json
from pathlib import Path
import re
import shutil
import subprocess
from typing import Any, NamedTuple

CHROMIUM = next(filter(None, map(shutil.which, (
    'chromium', 'chromium-browser', 'google-chrome'))), None)
FLAGS = ('--headless', '--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run',
         '--disable-background-networking', '--disable-component-update', '--disable-sync',
         '--enable-logging=stderr', '--virtual-time-budget=4000')
POLICY = re.compile(r"script-src '[^;]*")
# What is open takes room, so all that folds is opened before anything is measured. The plots
# have drawn when their canvases have a size.
MEASURE = """
document.querySelectorAll('details').forEach(one => { one.open = true; });
setTimeout(() => {
  const wide = [...document.querySelectorAll('table:not(.u-legend)')].map(table => {
    const box = table.parentElement, style = getComputedStyle(box).overflowX;
    return {over: table.offsetWidth - box.clientWidth, scrolls: style};
  });
  const plots = [...document.querySelectorAll('.plot')];
  const first = plots.find(one => one.querySelector('canvas'));
  const buttons = [...document.querySelectorAll('.chart [data-choice]')];
  const other = buttons.find(one => one.getAttribute('aria-pressed') === 'false');
  if (other) other.click();
  if (first) first.dispatchEvent(new KeyboardEvent('keydown', {key: '+'}));
  parent.postMessage({name: location.hash,
    page: document.documentElement.scrollWidth - window.innerWidth, tables: wide,
    headline: document.querySelector('h1').textContent,
    bottom: document.querySelector('h1').getBoundingClientRect().bottom,
    plots: plots.length,
    drawn: plots.filter(one => (one.querySelector('canvas') || {}).width > 0).length,
    pressed: !other || other.getAttribute('aria-pressed') === 'true'}, '*');
}, 500);
"""


# All widths at once, each in a frame of its own.
FRAMES = """<!DOCTYPE html><title>{}</title><script>
const sizes = {};
addEventListener('message', event => {
  sizes[event.data.name.slice(1)] = event.data;
  document.title = JSON.stringify(sizes);
});
</script>"""
FRAME = '<iframe src="page.html#%d" style="width: %dpx; height: 1200px; border: 0"></iframe>'


class Shown(NamedTuple):
    """What a browser measures of a page, by the width of its screen [px], and its complaints."""

    measured: dict[int, dict[str, Any]]
    complaints: list[str]


def shown(text: str, folder: Path, widths: Iterable[int]) -> Shown:
    """
    Return how far a page sticks out of screens of these widths [px], and whether it lives.

    The measuring script is added to those that the policy of the page lets run.
    """
    digest = b64encode(sha256(MEASURE.encode()).digest()).decode()
    text = POLICY.sub(lambda found: f"script-src 'sha256-{digest}' " + found[0].removeprefix(
        'script-src ').replace("'none'", ''), text, count=1)
    (folder / 'page.html').write_text(
        text.replace('</body>', f'<script>{MEASURE}</script></body>'), encoding='utf-8')
    frames = folder / 'frames.html'
    frames.write_text(FRAMES + ''.join(FRAME % (width, width) for width in widths),
                      encoding='utf-8')
    done = subprocess.run(
        [str(CHROMIUM), *FLAGS, f'--user-data-dir={folder / "profile"}',
         '--window-size=2000,1200', '--dump-dom', frames.as_uri()],
        capture_output=True, text=True, timeout=300, check=False)
    report = json.loads(unescape(re.search(r'<title>(.*?)</title>', done.stdout, re.DOTALL)[1]))
    return Shown({int(width): found for width, found in report.items()},
                 [line for line in done.stderr.splitlines() if 'CONSOLE' in line])

"""Plots in a page: packed, thinned without a loss that a screen shows, and each column once."""

import asyncio
import base64
from collections import Counter
import json
import math
from typing import Any

from browser import CHROMIUM
from driven_browser import browser
from hda_torque_estimator.estimating.page import About
from hda_torque_estimator.pages.badge import DONE
from hda_torque_estimator.pages.columns import column, written
from hda_torque_estimator.pages.plot import documents, MOST, Plot, PlotGroup, PlotLine, thinned
from hda_torque_estimator.pages.render import render
import numpy as np
import pytest


def unpacked(shown: Any, count: int) -> np.ndarray:
    """Return the numbers (k,) of a column, as the script of a page finds them."""
    if isinstance(shown, dict):
        kind = np.dtype(f'<u{shown["bytes"]}')
        levels = np.frombuffer(base64.b64decode(shown['data']), kind)
        values = shown['low'] + shown['step'] * levels
        return np.where(levels == np.iinfo(kind).max, np.nan, values)
    if isinstance(shown, list):
        return np.array([math.nan if value is None else value for value in shown])
    return np.full(count, shown)


def test_no_spike_is_lost_where_a_plot_is_thinned():
    time = np.arange(60001) / 1000.0
    values = np.sin(time)
    values[31234], values[31240] = 40.0, -50.0
    x, (thin,) = thinned(time, [values])
    assert len(x) == len(thin) == MOST
    assert (np.diff(x) > 0.0).all()
    assert (thin.max(), thin.min()) == (40.0, -50.0)
    assert abs(x[np.argmax(thin)] - time[31234]) < 60.0 / (MOST / 2)


def test_gaps_stay_gaps_and_numbers_keep_their_figures():
    values = np.where(np.arange(60000) // 20000 == 1, np.nan, 1.0)
    _, (thin,) = thinned(np.arange(60000.0), [values])
    assert np.isnan(thin[MOST // 2]) and np.isfinite(thin[[0, -1]]).all()
    assert written(np.array([math.nan, 12345.6, 0.00123])) == [None, 12346.0, 0.00123]
    assert written(np.array([1.23456789e-7])) == [1.2346e-7]
    assert written(np.zeros(2)) == [0.0, 0.0]


def test_a_packed_column_is_the_column_to_a_screen_and_gaps_stay_gaps():
    random = np.random.default_rng(0)
    values = random.normal(size=5000)
    values[100:200] = math.nan
    found = unpacked(column(values), 5000)
    np.testing.assert_allclose(found, values, atol=np.nanmax(np.abs(np.diff(found))) / 2.0 ** 14)
    np.testing.assert_array_equal(np.isnan(found), np.isnan(values))
    time = np.arange(8000) / 125.0
    np.testing.assert_allclose(unpacked(column(time, is_axis=True), 8000), time, atol=1e-7)
    assert column(np.full(500, 0.25)) == 0.25
    assert (unpacked(column(np.full(500, 0.25)), 500) == 0.25).all()
    assert np.isnan(unpacked(column(np.full(500, math.nan)), 500)).all()


def test_what_is_shown_by_decades_keeps_its_small_numbers():
    """Levels, and decimals of the largest, would make nothing of what is a millionth of it."""
    density = np.geomspace(1e-9, 1.0, 600)
    plot = Plot('frequency [Hz]', 'density', np.geomspace(0.1, 500.0, 600), [
        PlotLine('density', density, 'after')], 'log')
    np.testing.assert_allclose(plot.document()['lines'][0]['y'], density, rtol=1e-4)


def test_a_column_stands_once_however_many_plots_show_it():
    time, values = np.arange(1000) / 125.0, np.sin(np.arange(1000.0))
    plot = Plot('time [s]', 'torque', time, [PlotLine('measured', values, 'measured')], 'time')
    charts = {name: PlotGroup(name, '', {'joint 1': plot, 'joint 2': plot}) for name in ('a', 'b')}
    shown, columns = documents(charts)
    assert len(columns) == 2
    assert shown['a'] == shown['b']
    line = shown['b']['joint 2']['lines'][0]
    np.testing.assert_allclose(unpacked(columns[line['y']['at']], 1000), values, atol=1e-4)


def test_a_plot_says_how_it_is_thinned():
    def said(count: int) -> str:
        line = PlotLine('', np.zeros(count), 'after')
        plot = Plot('', '', np.arange(float(count)), [line], 'time')
        return PlotGroup('', '', {'': plot}).thinning
    assert said(MOST) == ''
    assert said(60000) == 'Of every 15 samples the least and the largest are drawn.'


def test_a_plot_is_strict_json_with_its_bands():
    ends = np.array([1.0, math.inf])
    plot = Plot('x', 'y', np.arange(2.0), [PlotLine('a', ends, 'after', ends - 1.0, ends)],
                focus=(0.0, 1.0))
    shown = json.loads(json.dumps(plot.document(), allow_nan=False))
    assert shown['lines'] == [{'name': 'a', 'look': 'after', 'y': [1.0, None],
                              'low': [0.0, None], 'high': [1.0, None]}]


def wave_page() -> str:
    """Return a page of one long wave with a gap, beside a level, within a band."""
    time = np.arange(5000) / 125.0
    values = np.where((time > 10.0) & (time < 12.0), np.nan, 3.0 * np.sin(time))
    lines = [PlotLine('wave', values, 'after', values - 0.5, values + 0.5),
             PlotLine('level', np.full(5000, 1.25), 'floor')]
    whole = Plot('time [s]', 'y', time, lines, 'time')
    few = Plot('time [s]', 'y', time[:40], [PlotLine('few', time[:40], 'after')], 'time')
    return render('estimation.html', title='t', badge=DONE, headline='h', rows=[], facts=[],
                  about=About(('joint1',), 's', 'a', '0', 0, {}, {}, ''), charts={
                      'a': PlotGroup('A', 'c', {'one': whole, 'two': few})})


@pytest.mark.skipif(CHROMIUM is None, reason='no Chromium is installed here')
def test_a_browser_reads_the_numbers_zooms_by_keys_and_switches(tmp_path):
    (tmp_path / 'page.html').write_text(wave_page(), encoding='utf-8')

    async def hovered(page, share: float) -> list[str]:
        """Return what the legend says where the mouse stands, by its share of the width."""
        box = await page.ask('(() => { const one = document.querySelector(".u-over").'
                             'getBoundingClientRect(); return [one.x, one.y, one.width, '
                             'one.height]; })()')
        await page.call('Input.dispatchMouseEvent', type='mouseMoved',
                        x=box[0] + share * box[2], y=box[1] + 0.5 * box[3])
        await page.until('document.querySelector(".u-value").textContent !== "–"')
        await asyncio.sleep(0.3)
        return await page.ask('[...document.querySelectorAll(".u-series:not([hidden]) '
                              '.u-value")].map(one => one.textContent)')

    async def look() -> tuple[list[list[str]], list[str], list[str]]:
        async with browser() as page:
            await page.visit((tmp_path / 'page.html').as_uri())
            await page.until('document.querySelector("canvas").width > 0')
            await page.ask('document.querySelector(".plot").scrollIntoView({block: "center"})')
            shown = [await hovered(page, share) for share in (0.2, 0.275, 0.9)]
            await page.ask('document.querySelector(".plot").focus()')
            for key in ('+', 'ArrowRight'):
                await page.call('Input.dispatchKeyEvent', type='keyDown', key=key, text=key[:1])
            await asyncio.sleep(0.3)
            shown.append(await hovered(page, 0.21))
            await page.ask('document.querySelectorAll("[data-choice]")[1].click()')
            return shown, await hovered(page, 0.5), page.complaints
    (*seen, zoomed), few, complaints = asyncio.run(look())
    assert complaints == []
    for time, wave, level in seen:
        gap = 10.0 < float(time) < 12.0
        assert (wave == '–') == gap
        assert level == '1.25'
        assert gap or float(wave) == pytest.approx(3.0 * math.sin(float(time)), abs=0.02)
    assert [round(float(time)) for time, *_ in seen] == [8, 11, 36]
    # Half of 40 s, moved on by 0.3 of it: from 16 s to 36 s.
    assert float(zoomed[0]) == pytest.approx(16.0 + 0.21 * 20.0, abs=0.2)
    assert float(few[1]) == pytest.approx(float(few[0]))


WRITES_DOWN = """
window.written = [];
const write = CanvasRenderingContext2D.prototype.fillText;
CanvasRenderingContext2D.prototype.fillText = function (text, ...place) {
  window.written.push([text, this.measureText(text).width / devicePixelRatio]);
  return write.call(this, text, ...place);
};
"""


@pytest.mark.skipif(CHROMIUM is None, reason='no Chromium is installed here')
def test_labels_fit_a_phone_and_small_numbers_differ_at_their_axis(tmp_path):
    label = 'motor angle in its wave, 42 per turn [rad]'
    x = np.linspace(0.0, 0.15, 100)
    plot = Plot(label, 'residual of the balance, output [N·m]', x, [
        PlotLine('rest', 1.4e-3 * np.sin(40.0 * x), 'after')])
    (tmp_path / 'page.html').write_text(render(
        'estimation.html', title='t', badge=DONE, headline='h', rows=[], facts=[],
        about=About(('joint1',), 's', 'a', '0', 0, {}, {}, ''),
        charts={'a': PlotGroup('A', 'c', {'one': plot})}), encoding='utf-8')

    async def look() -> tuple[list[tuple[str, float]], float]:
        async with browser() as page:
            await page.call('Page.enable')
            await page.call('Page.addScriptToEvaluateOnNewDocument', source=WRITES_DOWN)
            await page.visit((tmp_path / 'page.html').as_uri(), 360)
            await page.until('window.written.length > 4')
            return (await page.ask('window.written'), await page.ask(
                'document.querySelector(".u-over").getBoundingClientRect().width'))
    written_down, room = asyncio.run(look())
    sizes = dict(written_down)
    assert sizes[label] <= room + 1.0
    times = Counter(text for text, _ in written_down if text not in (label, plot.y_label, '0'))
    assert {'0.001', '-0.001', '0.05'} <= times.keys()
    assert len(set(times.values())) == 1            # as often as the plot was drawn, each

"""The live page shows what is heard, only to whom it may, and bears nodes that come and go."""

import asyncio
from collections.abc import Iterator
from contextlib import suppress
import json
import os
from pathlib import Path
import re
import signal
import subprocess
import sys
import time

import aiohttp
from browser import CHROMIUM
from driven_browser import browser
from hda_arm_sim.model.files import read_arm
from hda_msgs_json.bag import open_recording
from hda_msgs_json.cdr import encode_joint_state, encode_string, encode_wrench
from hda_msgs_json.mcap_records import BagError
from hda_msgs_json.topics import ESTIMATOR_STATE, EXTERNAL_WRENCH, JOINT_STATES, TIP_WRENCH
from hda_torque_estimator.cli import main
from hda_torque_estimator.estimating.live_estimator import LiveEstimator
from hda_torque_estimator.live.access import Access
from hda_torque_estimator.live.recorder import Recorder
from hda_torque_estimator.live.requests import Action, Done, Requests
from hda_torque_estimator.live.scene import FORGOTTEN, NodeHealth, Scene, SILENCE
from hda_torque_estimator.live.server import MOST_WATCHERS, Server, ServerError
from hda_torque_estimator.live.skeleton import stance
from hda_torque_estimator.samples.readings import reading_names
from node_processes import MODULES, PATIENCE, Process, running, watching
import pytest

ARM = read_arm('hda_arm.yaml')
SAMPLE = encode_joint_state(10**9, '', reading_names(ARM.labels), [30.0, 0.3, 120.0, 1.2])
MODULES['live_view'] = 'hda_torque_estimator.live.live_node'


def heard() -> Scene:
    """Return a scene that has heard a sample and its estimates at 1 s."""
    scene, answer = Scene(ARM), LiveEstimator(ARM)(SAMPLE)
    scene.hear(JOINT_STATES, SAMPLE, 1.0)
    scene.hear(ESTIMATOR_STATE, answer.state, 1.0)
    scene.hear(TIP_WRENCH, encode_wrench(10**9, 'base', [3.0, -4.0, float('nan')], [0.0] * 3), 1.0)
    return scene


def test_the_stance_is_that_of_the_simulated_tip():
    pieces = stance(ARM, [0.3, 1.2])
    assert pieces[0][0] == (0.0, 0.0, 0.0)
    assert pieces[0][1] == pieces[1][0]
    from hda_arm_sim.foundation.rigid import tip_position
    tip = tip_position(ARM.links.length1, ARM.links.length2, 0.3, 1.2)
    assert pieces[1][1] == pytest.approx((*tip, 0.0))


def test_nothing_is_claimed_before_anything_is_heard():
    picture = Scene(ARM).picture(5.0)
    assert picture['age'] is None
    assert picture['pieces'] is None
    assert picture['estimate'] is None
    assert picture['nodes'] == []
    json.dumps(picture, allow_nan=False)


def test_a_picture_shows_the_last_sample_and_its_estimates():
    picture = heard().picture(1.5)
    assert picture['age'] == 0.5
    assert picture['angles'] == pytest.approx([0.3, 1.2])
    assert picture['tip_force'] == [3.0, -4.0, None]
    assert len(picture['estimate']['torque']) == 2
    json.dumps(picture, allow_nan=False)


def test_an_estimator_that_is_silent_is_not_shown_as_if_it_spoke():
    picture = heard().picture(1.0 + SILENCE + 0.1)
    assert picture['estimate'] is None
    assert picture['tip_force'] is None
    assert picture['pieces'] is not None


@pytest.mark.parametrize('topic, message', [
    (JOINT_STATES, b'\0\1\0\0'), (ESTIMATOR_STATE, b''), (TIP_WRENCH, b'\0' * 9),
    (ESTIMATOR_STATE, encode_string('{"schema": "hda.other/1"}')),
    (JOINT_STATES, encode_joint_state(1, '', ['joint1'], [float('nan')]))])
def test_what_cannot_be_read_is_unknown(topic, message):
    scene = heard()
    scene.hear(topic, message, 1.0)
    json.dumps(scene.picture(1.0), allow_nan=False)


def test_a_node_that_does_not_report_is_gone_and_may_come_back():
    scene = Scene(ARM)
    scene.hear_health(NodeHealth('arm_sim', 0, '1000 Hz', 1.0))
    assert not scene.picture(2.0)['nodes'][0]['gone']
    assert scene.picture(1.1 + FORGOTTEN)['nodes'][0]['gone']
    scene.hear_health(NodeHealth('arm_sim', 1, 'late', 9.0))
    assert scene.picture(9.0)['nodes'] == [
        {'name': 'arm_sim', 'level': 1, 'message': 'late', 'gone': False}]


def test_who_may_see_the_page():
    access = Access(4000)
    here = {'Host': '127.0.0.1:4000'}
    assert access.refusal(here, access.token) is None
    assert access.refusal({**here, 'Origin': 'http://localhost:4000'}, access.token) is None
    assert 'token' in access.refusal(here, None)
    wrong = access.token[:-1] + ('x' if access.token[-1] != 'x' else 'y')
    assert 'token' in access.refusal(here, wrong)
    assert 'token' in access.refusal(here, '\N{EURO SIGN}')
    assert 'other pages' in access.refusal({**here, 'Origin': 'http://evil.org'}, access.token)
    assert 'this machine' in access.refusal({'Host': 'evil.org:4000'}, access.token)
    assert Access(4000).token != access.token


@pytest.fixture
def served() -> Iterator[Server]:
    """Have a server whose pictures are small, and whose actions all succeed."""
    requests = Requests()
    server = Server(0, lambda: {'seen': 1}, requests)
    server.start()
    server.requests = requests                          # for the tests to answer
    yield server
    server.stop()


def test_pages_buttons_and_pictures_need_the_token(served):
    address = served.access.url.partition('?')[0]

    async def statuses(**how):
        async with aiohttp.ClientSession(**how) as session:
            return [(await session.get(address)).status,
                    (await session.get(address + 'live.js')).status,
                    (await session.get(address + 'pictures')).status,
                    (await session.post(address + 'do/tare')).status]
    assert asyncio.run(statuses()) == [403] * 4
    foreign = {'Cookie': f'{served.access.cookie}={served.access.token}',
               'Origin': 'http://evil.org'}
    assert asyncio.run(statuses(headers=foreign)) == [403] * 4


def test_the_address_opens_everything(served):
    async def visit():
        jar = aiohttp.CookieJar(unsafe=True)            # keeps cookies of numbers as well
        async with aiohttp.ClientSession(cookie_jar=jar) as session:
            page = await session.get(served.access.url)
            address = served.access.url.partition('?')[0]
            assert "default-src 'none'" in page.headers['Content-Security-Policy']
            names = set(re.findall(r'(?:src|href)="([^":]+)"', await page.text()))
            for name in names:
                assert (await session.get(address + name)).status == 200, name
            assert (await session.get(address + '../access.py')).status == 404
            assert (await session.post(address + 'do/harm')).status == 404
            async with session.ws_connect(address + 'pictures') as socket:
                assert (await socket.receive_json()) == {'seen': 1}
            asked = asyncio.create_task(session.post(address + 'do/tare'))
            while not (waiting := served.requests.take()):
                await asyncio.sleep(0.01)
            assert waiting[0].action is Action.TARE
            waiting[0].answer.set_result(Done(True, 'done'))
            assert await (await asked).json() == {'success': True, 'message': 'done'}
    asyncio.run(visit())


def test_too_many_pages_are_refused(served):
    async def visit():
        jar = aiohttp.CookieJar(unsafe=True)
        async with aiohttp.ClientSession(cookie_jar=jar) as session:
            await session.get(served.access.url)
            address = served.access.url.partition('?')[0] + 'pictures'
            kept = [await session.ws_connect(address) for _ in range(MOST_WATCHERS)]
            assert (await session.get(address)).status == 503
            for socket in kept:
                await socket.close()
    asyncio.run(visit())


def test_a_port_that_is_taken_is_reported(served):
    with pytest.raises(ServerError, match='cannot be served'):
        Server(int(served.access.url.split(':')[2].split('/')[0]), dict, Requests())


def test_a_recorder_that_cannot_write_is_reported(tmp_path):
    (tmp_path / 'file').touch()
    done = Recorder(tmp_path / 'file' / 'folder', 'hda_arm.yaml').start()
    assert not done.success
    assert 'cannot be written' in done.message
    assert Recorder(tmp_path, '').stop() == Done(False, 'nothing is being recorded')


@pytest.mark.xdist_group('nodes')
def test_a_wrong_arm_is_one_line(capfd):
    done = subprocess.run(
        [sys.executable, '-m', 'hda_torque_estimator.cli', 'live', '--arm', 'none.yaml'],
        capture_output=True, text=True)
    assert done.returncode == 2
    assert 'Traceback' not in done.stderr
    assert "no arm file 'none.yaml'" in done.stderr


def test_what_is_not_installed_is_named(monkeypatch, capsys):
    monkeypatch.setattr('hda_torque_estimator.commands.live_command.find_spec', lambda name: None)
    assert main(['live']) == 2
    assert 'rclpy is not installed' in capsys.readouterr().err


@pytest.mark.xdist_group('nodes')
@pytest.mark.skipif(CHROMIUM is None, reason='no Chromium is installed here')
def test_the_page_shows_nodes_that_run_die_and_come_back(tmp_path):
    with watching() as watcher, running(
            tmp_path, live_view=(f'folder:={tmp_path / "bags"}',), arm_sim=('rate:=500',),
            torque_estimator=()) as nodes:
        watcher.until(lambda: 'shown at' in nodes['live_view'].said, 'the page')
        url = re.search(r'http://\S+', nodes['live_view'].said)[0]
        push = watcher.send(EXTERNAL_WRENCH, readers=1)
        asyncio.run(visit(url, nodes, push, tmp_path))
    bag, = (tmp_path / 'bags').iterdir()
    assert open_recording(bag).topics['/joint_states'].count > 0


async def until_recorded(bags: Path) -> None:
    """Wait until a recorder that was just started has heard joint states."""
    end = time.monotonic() + PATIENCE
    while True:
        with suppress(BagError, ValueError):
            bag, = bags.iterdir()
            if '/joint_states' in open_recording(bag).topics:
                return
        assert time.monotonic() < end, 'waited in vain for a recording'
        await asyncio.sleep(0.1)


async def visit(url, nodes, push, folder: Path) -> None:
    """Look at the page while nodes run, are pushed, die and come back."""
    def state(kind: str) -> str:
        return f'document.getElementById("state")?.className === "{kind}"'

    def answered(words: str) -> str:
        return f'document.getElementById("answer").textContent.includes("{words}")'

    def press(name: str) -> str:
        return f'document.querySelector("[data-do={name}]").click()'
    async with browser() as page:
        await page.visit(url, 360)      # few dots: no graphics card need draw them
        await page.until(state('well'))
        push(encode_wrench(0, 'base', [0.0, 20.0, 0.0], [0.0] * 3))
        await page.until('document.getElementById("contact").className !== "free"')
        await page.until('/^x -?\\d+\\.\\d, y -?\\d+\\.\\d N$/.test('
                         'document.getElementById("tip").textContent)')
        for width in (1280, 1920, 360):
            await page.resize(width, 800)
            assert await page.ask('document.documentElement.scrollWidth') <= width
            assert await page.ask('document.querySelector("table").getBoundingClientRect().right '
                                  '- document.getElementById("tip").getBoundingClientRect().right'
                                  ) < 1.0               # the table keeps the margin of all else
            await page.picture(folder / f'live_{width}.png')
        await page.ask(press('tare'))
        await page.until(answered('becomes zero'))
        await page.ask(press('reset'))
        await page.until(answered('are forgotten'))
        await page.ask(press('record'))
        await page.until('document.getElementById("record").dataset.do === "stop"')
        await until_recorded(folder / 'bags')
        await page.ask(press('stop'))
        await page.until(answered('holds the recording'))
        os.kill(nodes['torque_estimator'].pid, signal.SIGKILL)
        await page.until(state('waiting'))
        await page.ask(press('tare'))
        await page.until(answered('estimator'))         # is asked: its end may be news to ROS
        nodes['torque_estimator'] = Process('torque_estimator', folder)
        await page.until(state('well'))
        os.kill(nodes['arm_sim'].pid, signal.SIGKILL)
        await page.until(state('lost'))
        assert page.complaints == []

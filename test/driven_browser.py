"""A headless Chromium that a test drives: it opens a page, asks it, and sees its complaints."""

import asyncio
import base64
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
import itertools
import json
from pathlib import Path
import re
import subprocess
import tempfile
from typing import Any

import aiohttp
from browser import CHROMIUM

FLAGS = ('--headless=new', '--no-sandbox', '--disable-quic', '--no-first-run',
         '--disable-background-networking', '--disable-component-update', '--disable-sync',
         '--enable-unsafe-swiftshader', '--remote-debugging-port=0')
PATIENCE = 240.0        # until something must have happened: nothing is measured by it [s]


class Page:
    """One page of the browser, spoken to in the protocol of its developer tools."""

    def __init__(self, socket: aiohttp.ClientWebSocketResponse) -> None:
        """Speak over a connection."""
        self._socket, self._numbers = socket, itertools.count(1)
        self.complaints: list[str] = []

    async def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        """Have a command done, and return its result."""
        number = next(self._numbers)
        await self._socket.send_json({'id': number, 'method': method, 'params': parameters})
        while True:
            message = json.loads((await self._socket.receive(PATIENCE)).data)
            self._note(message)
            if message.get('id') == number:
                assert 'error' not in message, message['error']
                return message['result']

    def _note(self, message: dict[str, Any]) -> None:
        """Keep errors that the page or its console reports."""
        reported = message.get('params', {})
        if message.get('method') == 'Runtime.exceptionThrown':
            details = reported['exceptionDetails']
            self.complaints.append(
                details.get('exception', {}).get('description') or details['text'])
        if message.get('method') == 'Log.entryAdded' and reported['entry']['level'] == 'error':
            self.complaints.append(reported['entry']['text'])
        if message.get('method') == 'Runtime.consoleAPICalled' and reported['type'] == 'error':
            self.complaints.append(str(reported['args']))

    async def visit(self, url: str, width: int = 1280, height: int = 800) -> None:
        """Open an address on a screen of this size [px]."""
        for domain in ('Runtime', 'Log', 'Page'):
            await self.call(f'{domain}.enable')
        await self.resize(width, height)
        await self.call('Page.navigate', url=url)
        await self.until('document.readyState === "complete"')

    async def resize(self, width: int, height: int) -> None:
        """Give the page another size [px]."""
        await self.call('Emulation.setDeviceMetricsOverride', width=width, height=height,
                        deviceScaleFactor=1, mobile=width < 600)

    async def ask(self, expression: str) -> Any:
        """Return what an expression is on the page."""
        answer = await self.call('Runtime.evaluate', expression=expression, returnByValue=True,
                                 awaitPromise=True)
        assert 'exceptionDetails' not in answer, answer
        return answer['result'].get('value')

    async def until(self, expression: str) -> None:
        """Wait until an expression is true on the page, and fail if it never is."""
        end = asyncio.get_running_loop().time() + PATIENCE
        while not await self.ask(expression):
            shown = await self.ask('document.body?.innerText')
            assert asyncio.get_running_loop().time() < end, f'never: {expression}\n{shown}'
            await asyncio.sleep(0.1)

    async def picture(self, path: Path) -> None:
        """Save what is on the screen as a PNG."""
        taken = await self.call('Page.captureScreenshot')
        path.write_bytes(base64.b64decode(taken['data']))


@asynccontextmanager
async def browser() -> AsyncIterator[Page]:
    """Have a new page in a browser of its own for a while."""
    assert CHROMIUM
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        process = subprocess.Popen(
            [CHROMIUM, *FLAGS, f'--user-data-dir={profile}', 'about:blank'],
            stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True,
            start_new_session=True)
        try:
            address = await asyncio.to_thread(_address, process)
            async with aiohttp.ClientSession() as session:
                found = await (await session.get(f'http://{address}/json')).json()
                target = next(each for each in found if each['type'] == 'page')
                async with session.ws_connect(
                        target['webSocketDebuggerUrl'], max_msg_size=1 << 26) as socket:
                    yield Page(socket)
        finally:
            process.kill()
            process.communicate()


def _address(process: 'subprocess.Popen[str]') -> str:
    """Return where the browser listens."""
    assert process.stderr
    for line in process.stderr:
        if reported := re.search(r'DevTools listening on ws://([^/]+)/', line):
            return reported[1]
    raise AssertionError('the browser ended before it listened')

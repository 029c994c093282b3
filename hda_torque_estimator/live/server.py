"""The server of the live page: on this machine only, in a thread beside the node."""

import asyncio
from collections.abc import Callable
import contextlib
from importlib.resources import files
import json
import secrets
import socket
from threading import Event, Thread
from typing import Any

from aiohttp import web, WSMsgType
from hda_msgs_json.errors import HdaError

from .access import Access, HOST
from .requests import Action, Requests

PICTURES = 30.0         # a second, as many as move smoothly: a choice [Hz]
PATIENCE = 10.0         # with an action that a node does not answer [s]
MOST_WATCHERS = 8       # pages that are served at the same time
PAGE = files('hda_torque_estimator.live').joinpath('page')
PLOTS = files('hda_torque_estimator.pages').joinpath('assets').joinpath('uplot')
KINDS = {'.js': 'text/javascript', '.css': 'text/css'}
ASSETS = ('live.js', 'arm.js', 'traces.js', 'live.css', 'vendor/three.module.min.js',
          'vendor/three.core.min.js', 'vendor/OrbitControls.js', 'uPlot.iife.min.js',
          'uPlot.min.css')
HEADERS = {'X-Content-Type-Options': 'nosniff', 'X-Frame-Options': 'DENY',
           'Referrer-Policy': 'no-referrer', 'Cache-Control': 'no-store'}


class ServerError(HdaError):
    """A port that cannot be had."""


class Server:
    """Serve pictures of the arm, and take what is asked of it."""

    def __init__(self, port: int, picture: Callable[[], dict[str, Any]],
                 requests: Requests) -> None:
        """Take the port, 0 for any that is free; raises ServerError."""
        try:
            self._socket = socket.create_server((HOST, port))
        except OSError as error:
            raise ServerError(f'port {port} cannot be served: {error.strerror}; '
                              'port 0 takes one that is free') from None
        self.access = Access(self._socket.getsockname()[1])
        self._picture, self._requests = picture, requests
        self._watchers: set[web.WebSocketResponse] = set()
        self._ended = Event()
        self._thread = Thread(target=lambda: asyncio.run(self._serve()), name='live page',
                              daemon=True)

    def start(self) -> str:
        """Begin to serve, and return the address that has the token."""
        self._thread.start()
        return self.access.url

    def stop(self) -> None:
        """End all connections and the thread."""
        self._ended.set()
        self._thread.join()
        self._socket.close()

    async def _serve(self) -> None:
        app = web.Application(middlewares=[self._guard], client_max_size=1024)
        app.add_routes([
            web.get('/', self._page), web.get('/pictures', self._pictures),
            web.post('/do/{action}', self._do),
            *(web.get(f'/{name}', self._asset) for name in ASSETS)])
        runner = web.AppRunner(app, access_log=None, shutdown_timeout=1.0)
        await runner.setup()
        await web.SockSite(runner, self._socket).start()
        await asyncio.to_thread(self._ended.wait)
        for watcher in set(self._watchers):
            await watcher.close(code=1001, message=b'the view has ended')
        await runner.cleanup()

    @web.middleware
    async def _guard(self, request: web.Request, handler: Any) -> web.StreamResponse:
        """Refuse who may not see the page; the address sets a cookie for what it loads."""
        token = request.query.get('token') or request.cookies.get(self.access.cookie)
        if (refused := self.access.refusal(request.headers, token)) is not None:
            return web.Response(status=403, text=refused + '\n', headers=HEADERS)
        response: web.StreamResponse = await handler(request)
        if not response.prepared:
            response.headers.update(HEADERS)
            response.set_cookie(self.access.cookie, self.access.token, httponly=True,
                                samesite='Strict')
        return response

    async def _page(self, request: web.Request) -> web.Response:
        nonce = secrets.token_urlsafe()
        text = PAGE.joinpath('index.html').read_text('utf-8').replace('NONCE', nonce)
        policy = (f"default-src 'none'; script-src 'self' 'nonce-{nonce}'; style-src 'self' "
                  f"'unsafe-inline'; img-src 'self' data:; connect-src 'self'")
        return web.Response(text=text, content_type='text/html',
                            headers={'Content-Security-Policy': policy})

    async def _asset(self, request: web.Request) -> web.Response:
        name = request.path.lstrip('/')
        kind = next(kind for suffix, kind in KINDS.items() if name.endswith(suffix))
        folder = PLOTS if name.startswith('uPlot') else PAGE
        for part in name.split('/'):
            folder = folder.joinpath(part)
        return web.Response(body=folder.read_bytes(), content_type=kind)

    async def _pictures(self, request: web.Request) -> web.StreamResponse:
        """Send pictures until the page is closed; a slow one gets fewer."""
        if len(self._watchers) >= MOST_WATCHERS:
            return web.Response(status=503, text=f'{MOST_WATCHERS} pages are open already\n')
        watcher = web.WebSocketResponse(heartbeat=10.0, max_msg_size=1024)
        await watcher.prepare(request)
        self._watchers.add(watcher)
        sending = asyncio.create_task(self._send(watcher))
        try:
            async for message in watcher:
                if message.type is not WSMsgType.PING:
                    break                               # the page has nothing to say here
        finally:
            self._watchers.discard(watcher)
            sending.cancel()
            with contextlib.suppress(asyncio.CancelledError, ConnectionError):
                await sending
        return watcher

    async def _send(self, watcher: web.WebSocketResponse) -> None:
        while not watcher.closed:
            await watcher.send_str(json.dumps(self._picture(), allow_nan=False))
            await asyncio.sleep(1.0 / PICTURES)

    async def _do(self, request: web.Request) -> web.Response:
        """Have an action done, and answer with what came of it."""
        try:
            action = Action(request.match_info['action'])
        except ValueError:
            return web.Response(status=404, text='there is no such action\n')
        try:
            done = await asyncio.wait_for(
                asyncio.wrap_future(self._requests.put(action)), PATIENCE)
        except asyncio.TimeoutError:                    # of its own kind before Python 3.11
            return web.json_response(
                {'success': False, 'message': 'nobody answered: is the estimator running?'})
        return web.json_response(done._asdict())

"""Serves the page and pushes to every browser what is new, at most ten times a second. Nothing can be changed here."""

import asyncio
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, closing, suppress
from importlib.resources import files
from os import strerror
from pathlib import Path

from aiohttp import WSMsgType, web

from brake_monitor.dashboard.fleet import Fleet
from brake_monitor.dashboard.views import Viewer
from brake_monitor.dashboard.visitors import HEADERS, careful, is_own_page
from brake_monitor.desk.watched import LONGEST_NAME
from brake_monitor.errors import WorkError

PUSH_S = {"wagon": 0.1, "fleet": 0.2}
MOST_BROWSERS = 50
MOST_CONNECTIONS = 8 * MOST_BROWSERS  # a browser opens up to six for the files of a page, beside its live one
IDLE_S = 15.0  # a connection on which nothing is asked for longer is closed
HEARTBEAT_S = 5.0  # a browser that does not answer for longer is gone
LARGEST_QUESTION = 1024  # bytes of what a browser sends; it has nothing to say

KINDS = {".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml"}


def page_files() -> dict[str, tuple[bytes, str]]:
    """Path → content and media type of everything that is served, read once."""
    static = files("brake_monitor.dashboard") / "static"
    found = {}
    for prefix, folder in (("/", static), ("/vendor/", static / "vendor")):
        for entry in folder.iterdir():
            kind = KINDS.get(Path(entry.name).suffix)
            if entry.is_file() and kind is not None:
                found[prefix + entry.name] = (entry.read_bytes(), kind)
    found["/"] = found.pop("/index.html")
    return found


async def _listening(server: web.Server, host: str, port: int) -> asyncio.Server:
    """Accept connections, as many as there may be. WorkError when the address is taken or not ours."""

    def accepted() -> asyncio.Protocol:
        return server() if len(server.connections) < MOST_CONNECTIONS else _Refused()

    try:
        return await asyncio.get_running_loop().create_server(accepted, host, port)
    except OSError as error:
        # asyncio's own words for an address that is taken are long-winded; an unknown name has no errno.
        number = error.errno or 0
        reason = strerror(number) if number > 0 else error.strerror or error
        raise WorkError(f"--listen {host}:{port}: {reason}") from None


class _Refused(asyncio.Protocol):
    """A connection that is one too many."""

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Close it at once."""
        transport.close()


class Server:
    """The web server of one fleet."""

    def __init__(self, fleet: Fleet, names: frozenset[str]) -> None:
        """`names` are those, besides IP addresses, that browsers may call us by."""
        self._fleet = fleet
        self._names = names
        self._pages = page_files()
        self._browsers = 0

    @asynccontextmanager
    async def serving(self, host: str, port: int) -> AsyncIterator[int]:
        """Serve until the block ends; gives the port. WorkError when the address is taken or not ours."""
        application = web.Application(middlewares=[careful(self._names)])
        application.router.add_get("/live", self._live)
        for path in self._pages:
            application.router.add_get(path, self._page)
        runner = web.AppRunner(application, access_log=None, shutdown_timeout=0.5, keepalive_timeout=IDLE_S)
        await runner.setup()
        try:
            assert runner.server is not None
            with closing(await _listening(runner.server, host, port)) as listening:
                yield listening.sockets[0].getsockname()[1]
        finally:
            await runner.cleanup()

    async def _page(self, request: web.Request) -> web.Response:
        content, kind = self._pages[request.path]
        return web.Response(body=content, content_type=kind, charset="utf-8")

    async def _live(self, request: web.Request) -> web.StreamResponse:
        """A web socket that tells of the fleet, or of the wagon asked for."""
        if not is_own_page(request):
            raise web.HTTPForbidden(text="Only our own page may listen here.\n")
        wagon = request.query.get("wagon")
        if wagon is not None and len(wagon) > LONGEST_NAME:
            raise web.HTTPBadRequest(text="No wagon has so long a name.\n")
        if self._browsers >= MOST_BROWSERS:
            raise web.HTTPServiceUnavailable(text="Too many browsers look on already.\n")
        socket = web.WebSocketResponse(heartbeat=HEARTBEAT_S, max_msg_size=LARGEST_QUESTION)
        socket.headers.update(HEADERS)
        await socket.prepare(request)
        self._browsers += 1
        pushing = asyncio.create_task(self._push(socket, wagon))
        try:
            async for message in socket:
                if message.type in (WSMsgType.TEXT, WSMsgType.BINARY):
                    break  # our page never sends anything
        finally:
            self._browsers -= 1
            pushing.cancel()
            with suppress(asyncio.CancelledError, ConnectionError):
                await pushing
            await socket.close()
        return socket

    async def _push(self, socket: web.WebSocketResponse, wagon: str | None) -> None:
        """Tell what is new; a slow browser is told less often, and then of all that happened meanwhile."""
        viewer = Viewer(self._fleet, wagon)
        pause_s = PUSH_S["fleet" if wagon is None else "wagon"]
        with suppress(ConnectionError):
            while not socket.closed:
                await socket.send_str(viewer.news(time.monotonic()).decode())
                await asyncio.sleep(pause_s)

"""The web application, and the server that runs it inside the daemon."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import AsyncIterator
from concurrent.futures import ThreadPoolExecutor
from typing import Final
from urllib.parse import quote

from aiohttp import WSCloseCode, web

from hawk.web import api, video
from hawk.web.counters import COUNTERS, Counters
from hawk.web.heartbeat import SharedHeartbeat
from hawk.web.security import Guard, add_headers, check_binding
from hawk.web.services import SERVICES, WebServices
from hawk.web.static import Page
from hawk.web.ws import SHARED, SOCKETS, HeartbeatPace, command_socket

LOG = logging.getLogger(__name__)

SHUTDOWN_S: Final = 1.0
"""Real seconds that open requests get when the server stops."""
REQUEST_LIMIT_BYTES: Final = 64 * 1024


def create_app(services: WebServices, page: Page) -> web.Application:
    """Return the application. Raises InsecureBindingError off loopback without a token."""
    check_binding(services.web)
    app = web.Application(middlewares=[Guard(services.web).middleware()], client_max_size=REQUEST_LIMIT_BYTES)
    app[SERVICES] = services
    app[SHARED] = SharedHeartbeat()
    app[SOCKETS] = set()
    app[COUNTERS] = Counters()
    app.on_response_prepare.append(add_headers)
    app.on_shutdown.append(_close_sockets)
    app.cleanup_ctx.extend((_heartbeats, _exporter))
    app.router.add_get("/ws", command_socket)
    app.router.add_get("/video", video.video_socket)
    app.router.add_get("/stream.mjpg", video.stream)
    app.router.add_get("/snapshot.jpg", video.snapshot)
    api.add_routes(app)
    app.router.add_get("/{path:.*}", page.handle)
    return app


class WebServer:
    """`start`, then `port` and `url`, then `close`."""

    def __init__(self, services: WebServices, page: Page | None = None) -> None:
        """Reads the page: make it before the loop is busy. Raises InsecureBindingError."""
        self._settings = services.web
        page = page or Page.load()
        if not page.is_built:
            LOG.warning("the operator page is not built; run: make page")
        self._runner = web.AppRunner(
            create_app(services, page), access_log=None, shutdown_timeout=SHUTDOWN_S, handle_signals=False
        )
        self._port = services.web.port

    async def start(self) -> None:
        """Listen. Raises OSError when the address is taken."""
        await self._runner.setup()
        site = web.TCPSite(self._runner, self._settings.host, self._settings.port)
        try:
            await site.start()
        except OSError:
            await self._runner.cleanup()
            raise
        self._port = self._runner.addresses[0][1]

    @property
    def port(self) -> int:
        """The port that it listens on."""
        return self._port

    @property
    def url(self) -> str:
        """Address of the page without the token."""
        host = {"0.0.0.0": "127.0.0.1", "::": "[::1]"}.get(self._settings.host, self._settings.host)  # noqa: S104
        if ":" in host and not host.startswith("["):
            host = f"[{host}]"
        return f"http://{host}:{self._port}/"

    @property
    def page_url(self) -> str:
        """Address to open, with the token when there is one."""
        return self.url if self._settings.token is None else f"{self.url}?token={quote(self._settings.token, safe='')}"

    async def close(self) -> None:
        """Close every connection and stop listening."""
        await self._runner.cleanup()


async def _heartbeats(app: web.Application) -> AsyncIterator[None]:
    services = app[SERVICES]
    stop = services.status.listen(HeartbeatPace(services).on_status)
    yield
    stop()


async def _exporter(app: web.Application) -> AsyncIterator[None]:
    with ThreadPoolExecutor(1, thread_name_prefix="web-export") as executor:
        app[api.EXPORTER] = executor
        yield


async def _close_sockets(app: web.Application) -> None:
    sockets: set[web.WebSocketResponse] = app[SOCKETS]
    closing = (s.close(code=WSCloseCode.GOING_AWAY, message=b"the drone's server stops") for s in set(sockets))
    await asyncio.gather(*closing, return_exceptions=True)

"""The web application, the server that runs it inside the daemon, and the built page that it serves.

The page is served from memory: nothing is read while the drone flies, and no file name comes from a request.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Final
from urllib.parse import quote

from aiohttp import WSCloseCode, web

from hawk.web import api, area_file, background, downloads
from hawk.web.access.access import BOOK, KEEPER, OPEN, AccessBook, AccessKeeper, OpenConnections, access_of, keep_access
from hawk.web.access.admission import Admission
from hawk.web.access.guesses import GUESSES, LINK_GUESSES, TokenGuesses
from hawk.web.access.login_page import PUBLIC, LoginPage
from hawk.web.access.logins import HOUR_S, Login, Logins
from hawk.web.access.paced_log import PacedLog
from hawk.web.access.tokens import TOKEN_FILE, Tokens, read_tokens, with_configured
from hawk.web.documentation import Asset, Documentation, make_asset, page_asset
from hawk.web.door import DOOR, Door, Places, attend, descriptor_limit
from hawk.web.listener import Listener
from hawk.web.security import RequestCheck, check_binding, headers_adder
from hawk.web.services import COUNTERS, SERVICES, Counters, WebServices
from hawk.web.v1 import routes as v1
from hawk.web.v1.answers import problems
from hawk.web.v1.desk.arrivals import note_refusals
from hawk.web.v1.links import LINK_LOG
from hawk.web.video import video
from hawk.web.ws import SOCKETS, HeartbeatPace, command_socket, keeps_place


def make_access(services: WebServices) -> tuple[AccessBook, AccessKeeper]:
    """Return tokens and logins, and what keeps them in step with their files; reads both files.

    Raises:
        InsecureBindingError: The address can be reached by others, and there is no operator's token.
        TokensError: The token file cannot be used.
    """

    def joined(kept: Tokens) -> Tokens:
        return with_configured(kept, services.web.token, services.cookie_secret)

    folder = services.folder
    tokens = joined(Tokens() if folder is None else read_tokens(folder / TOKEN_FILE))
    check_binding(services.web, tokens, (folder or Path("var")).resolve())
    logins = Logins(services.web, services.monotonic, services.cookie_secret)
    desk = services.side.desk

    def has_control(login: Login) -> bool:
        return desk.keeps_login(logins.control_secret(login))

    logins.has_control = has_control
    book = AccessBook(tokens, logins)
    keeper = AccessKeeper(folder, book, OpenConnections(book), joined, services.wall)
    keeper.restore()
    return book, keeper


LOG = logging.getLogger(__name__)

LINGER_S: Final = 2.0
"""Real seconds in which the rest of a request that was answered already is read."""
SHUTDOWN_S: Final = 1.0
"""Real seconds that open requests get when the server stops."""
REQUEST_LIMIT_BYTES: Final = 64 * 1024
PAGE_DIRECTORY: Final = Path(__file__).parent / "static"
INDEX: Final = "index.html"
LOTS: Final = "lots.html"
"""The page of a role that is for some lots: it asks for nothing of a drone."""
SHARED: Final = "shared.html"
"""The page for who has a link's token, which stands behind the address's "#"."""

NOT_BUILT: Final = """<!doctype html>
<html lang="en"><meta charset="utf-8"><title>hawk: the page is not built</title>
<h1>The page is not built</h1>
<p>The drone's server runs, but this checkout has no operator page yet. Build it with</p>
<pre>make page</pre>
<p>or <code>python packaging/build_page.py</code>, then start again. The picture is at
<a href="/stream.mjpg">/stream.mjpg</a>, the messages are described at
<a href="/api/schema.json">/api/schema.json</a>.</p></html>
"""


def create_app(services: WebServices, page: Page, documentation: Documentation | None = None) -> web.Application:
    """Return the application. Raises InsecureBindingError off loopback without a token, TokensError."""
    guesses = TokenGuesses(services.monotonic)
    book, keeper = make_access(services)
    log = PacedLog(LOG, services.monotonic)
    admission = Admission(book, guesses, log, keeps_place, services.web.session_limit_h * HOUR_S)
    login_page = LoginPage(admission)
    check = RequestCheck(services.web, admission, login_page)
    app = web.Application(
        middlewares=[problems, note_refusals, check.middleware, attend(keeps_place, PUBLIC)],
        client_max_size=REQUEST_LIMIT_BYTES,
    )
    app[SERVICES] = services
    app[DOOR] = Door(Places.within(descriptor_limit(), services.web.maximum_clients), services.monotonic)
    app[GUESSES], app[LINK_GUESSES] = guesses, TokenGuesses(services.monotonic)
    app[LINK_LOG] = log
    app[BOOK] = book
    app[OPEN] = keeper.connections
    app[KEEPER] = keeper
    app[SOCKETS] = set()
    app[COUNTERS] = Counters()
    app.on_response_prepare.append(headers_adder(services.tls))
    app.on_shutdown.append(_close_sockets)
    app.cleanup_ctx.extend((_heartbeats, _viewers, keep_access))
    app.router.add_get("/ws", command_socket)
    app.router.add_get("/video", video.video_socket)
    app.router.add_get("/stream.mjpg", video.stream)
    app.router.add_get("/snapshot.jpg", video.snapshot)
    api.add_routes(app)
    downloads.add_routes(app)
    login_page.add_routes(app)
    background.add_routes(app)
    area_file.add_routes(app)
    v1.add_routes(app)
    (documentation or Documentation.load()).add_routes(app)
    app.router.add_get("/shared", page.shared)
    app.router.add_get("/{path:.*}", page.handle)
    return app


class WebServer:
    """`start`, then `port` and `url`, then `close`."""

    def __init__(self, services: WebServices, page: Page | None = None) -> None:
        """Reads the page and the tokens: make it before the loop is busy. Raises InsecureBindingError, TokensError."""
        self._settings = services.web
        self._tls = services.tls
        page = page or Page.load()
        if not page.is_built:
            LOG.warning("the operator page is not built; run: make page")
        app = create_app(services, page)
        self._book = app[BOOK]
        self.door = app[DOOR]
        """Connections that it has."""
        self._log = PacedLog(LOG, services.monotonic)
        self._runner = web.AppRunner(
            app,
            access_log=None,
            logger=PacedLog(LOG, services.monotonic),
            shutdown_timeout=SHUTDOWN_S,
            handle_signals=False,
            lingering_time=LINGER_S,
            auto_decompress=False,  # no request has a body, so none is unpacked
        )
        self._listener: Listener | None = None
        self.port = services.web.port
        """Port that it listens on."""

    async def start(self) -> None:
        """Listen. Raises OSError when the address is in use."""
        _warn_of_few_descriptors(self.door.places)
        await self._runner.setup()
        make = self._runner.server
        assert make is not None  # noqa: S101 - it was set up
        self._listener = Listener(self.door, make, self._log, None if self._tls is None else self._tls.context)
        try:
            await self._listener.start(self._settings.host, self._settings.port)
        except OSError:
            await self._runner.cleanup()
            raise
        self.port = self._listener.port

    @property
    def url(self) -> str:
        """Address of the page without the token."""
        host = {"0.0.0.0": "127.0.0.1", "::": "[::1]"}.get(self._settings.host, self._settings.host)  # noqa: S104
        if ":" in host and not host.startswith("["):
            host = f"[{host}]"
        return f"{'http' if self._tls is None else 'https'}://{host}:{self.port}/"

    @property
    def asks_for_token(self) -> bool:
        """True when somebody who opens the page has to log in."""
        return bool(self._book.tokens)

    @property
    def page_url(self) -> str:
        """Address to open, with the configured token when there is one: others are kept as hashes only."""
        configured = self._settings.token
        token = None if configured is None else configured.get_secret_value()
        is_in_use = token is not None and self._book.tokens.role_of(token) is not None
        return self.url if token is None or not is_in_use else f"{self.url}?token={quote(token, safe='')}"

    async def close(self) -> None:
        """Close every connection and stop listening."""
        if self._listener is not None:
            await self._listener.close()
        await self._runner.cleanup()


def _warn_of_few_descriptors(places: Places) -> None:
    limit = descriptor_limit()
    if limit < places.descriptors:
        LOG.warning(
            "this process may open %d files; web.maximum_clients needs %d: raise LimitNOFILE (ulimit -n) or lower it",
            limit,
            places.descriptors,
        )


async def _heartbeats(app: web.Application) -> AsyncIterator[None]:
    services = app[SERVICES]
    stop = services.status.listen(HeartbeatPace(services).on_status)
    yield
    stop()


async def _viewers(app: web.Application) -> AsyncIterator[None]:
    viewers = app[video.VIEWERS] = video.make_viewers(app)
    viewers.start()
    yield
    viewers.close()


async def _close_sockets(app: web.Application) -> None:
    app[video.VIEWERS].end_streams()
    sockets: set[web.WebSocketResponse] = app[SOCKETS]
    closing = (s.close(code=WSCloseCode.GOING_AWAY, message=b"the drone's server stops") for s in set(sockets))
    await asyncio.gather(*closing, return_exceptions=True)


class Page:
    """All files of the built page by path."""

    def __init__(self, assets: dict[str, Asset]) -> None:
        self._assets = assets

    @classmethod
    def load(cls, directory: Path = PAGE_DIRECTORY) -> Page:
        """Read the page (before the loop runs); without a built page, a note on how to build it."""
        files = sorted(p for p in directory.rglob("*") if p.is_file() and p.suffix not in (".br", ".gz"))
        assets = {path.relative_to(directory).as_posix(): page_asset(path) for path in files}
        if INDEX not in assets:
            assets = {INDEX: make_asset("text/html; charset=utf-8", NOT_BUILT.encode())}
        return cls(assets)

    @property
    def is_built(self) -> bool:
        """True when the page was built."""
        return self._assets[INDEX].encodings["identity"] != NOT_BUILT.encode()

    async def handle(self, request: web.Request) -> web.StreamResponse:
        """Serve a file of the page."""
        access = access_of(request)
        first = INDEX if access is None or access.lots is None or not self.is_built else LOTS
        return self._answer(request, request.match_info.get("path", "") or first)

    async def shared(self, request: web.Request) -> web.StreamResponse:
        """Serve the page of a lot that is shared."""
        return self.named(request, SHARED)

    def named(self, request: web.Request, name: str) -> web.StreamResponse:
        """Serve a page of its own by the name of its file."""
        return self._answer(request, name if self.is_built else INDEX)

    def _answer(self, request: web.Request, name: str) -> web.StreamResponse:
        asset = self._assets.get(name)
        if asset is None:
            raise web.HTTPNotFound(text="There is nothing at this address.")
        return asset.response(request)

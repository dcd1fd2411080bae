"""Access to the server: host names, origins, and the headers that restrict a browser.

Only this server's own page may reach the drone. The Origin check stops a page from elsewhere. The Host check stops DNS
rebinding: a bare address cannot be rebound, and every name has to be ours.
"""

from __future__ import annotations

import ipaddress
import re
from collections.abc import Awaitable, Callable
from http import HTTPStatus
from pathlib import Path
from typing import Final
from urllib.parse import urlsplit

from aiohttp import HttpVersion10, HttpVersion11, hdrs, web
from aiohttp.typedefs import Handler

from hawk.comm.protocol.authority import Role
from hawk.config.sections import WebSettings
from hawk.web.access.access import access_of
from hawk.web.access.admission import TOKEN_PARAMETER, Admission
from hawk.web.access.login_page import LOGIN, PUBLIC, WRONG, LoginPage
from hawk.web.access.proxied import forwarding_header, is_secure, place
from hawk.web.access.tls import Tls
from hawk.web.access.tokens import TOKEN_FILE, Tokens
from hawk.web.api import is_for_everybody_here
from hawk.web.v1.bounds import check_reach
from hawk.web.v1.desk.documents import FOR_DRONES_ALONE, is_for_drones
from hawk.web.v1.links import is_for_links

SAFE_METHODS: Final = frozenset({hdrs.METH_GET, hdrs.METH_HEAD, hdrs.METH_OPTIONS})
_HOST: Final = re.compile(r"[A-Za-z0-9._:%\[\]-]+")
"""Characters of host names, addresses and ports."""
HSTS_S: Final = 30 * 86_400
"""Seconds for which a browser asks this host by HTTPS only, once it saw a certificate of an authority."""


DOCS: Final = "/docs"
"""Address of the documentation: a browser without a login is shown the login page there, as at the page's."""


class InsecureBindingError(Exception):
    """The address can be reached by others and there is no operator's token."""


def check_binding(settings: WebSettings, tokens: Tokens, folder: Path) -> None:
    """Refuse to serve beyond this computer without an operator's token: by an address, or by a name for a proxy.

    Raises InsecureBindingError naming the remedy.

    Args:
        settings: Address of the server.
        tokens: The tokens of all roles.
        folder: Folder of the token file.
    """
    command = f"hawk-drone tokens rotate operator --store {folder}"
    if Role.OPERATOR in tokens.by_role:
        return
    if tokens:
        raise InsecureBindingError(f"{folder / TOKEN_FILE}: has no operator's token; make one with: {command}")
    if not is_loopback(settings.host):
        raise InsecureBindingError(
            f"web.host: {settings.host!r} can be reached from other machines and there is no operator's token; make "
            f"one with: {command} (or set web.token, or web.host to 127.0.0.1)"
        )
    others = [name for name in settings.allowed_hosts if not is_loopback(name)]
    if others:
        raise InsecureBindingError(
            f"web.allowed_hosts: {others[0]!r} can be reached from other machines by a proxy, and there is no "
            f"operator's token; make one with: {command} (or set web.token, or leave web.allowed_hosts empty)"
        )


def is_loopback(host: str) -> bool:
    """Return True when only this machine can reach that address; a name other than localhost may lead anywhere."""
    address = _address(host)
    return host.lower() == "localhost" or (address is not None and address.is_loopback)


class RequestCheck:
    """Checks every request before it reaches a handler."""

    def __init__(self, settings: WebSettings, admission: Admission, login_page: LoginPage) -> None:
        """Keep what is compared.

        Args:
            settings: Address and names of this server.
            admission: Looks at cookies and tokens.
            login_page: Shown in place of the page to one who is not logged in.
        """
        self._names = {"localhost", settings.host.lower(), *(name.lower() for name in settings.allowed_hosts)}
        self._admission = admission
        self._login_page = login_page

    @web.middleware
    async def middleware(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        """Answer a request that fails a check, and close its connection; pass every other one on."""
        try:
            self._check_version(request)
            self._check_host(request)
            self._check_nearness(request)
            self._check_origin(request)
            is_open = request.path in PUBLIC or is_for_everybody_here(request) or is_for_links(request)
            answer = None if is_open else self._admit(request)
        except web.HTTPException as refusal:
            refusal.force_close()
            raise
        return answer if answer is not None else await handler(request)

    def _admit(self, request: web.Request) -> web.StreamResponse | None:
        """Return None for a request that may go on, else its answer; a browser is shown the login page."""
        try:
            answer = self._admission.admit(request)
            _check_drone(request)
            check_reach(request)
            return answer
        except (web.HTTPUnauthorized, web.HTTPTooManyRequests) as refusal:
            is_page = request.method == hdrs.METH_GET and (request.path == "/" or request.path.startswith(DOCS))
            if not is_page or "text/html" not in request.headers.get(hdrs.ACCEPT, ""):
                if is_page and request.path == "/" and refusal.status == HTTPStatus.UNAUTHORIZED:
                    # BlueOS looks for a page here before it asks for a name, and follows this whatever the status
                    refusal.headers[hdrs.LOCATION] = place(request, LOGIN)
                raise
            message = WRONG if request.query.get(TOKEN_PARAMETER) else ""
            if refusal.status == HTTPStatus.TOO_MANY_REQUESTS:
                message = refusal.text or ""
            answer = self._login_page.answer(request, refusal.status, message)
            answer.force_close()
            return answer

    @staticmethod
    def _check_version(request: web.Request) -> None:
        if request.version not in (HttpVersion10, HttpVersion11):
            raise web.HTTPVersionNotSupported(text="HTTP: send version 1.1 or 1.0")

    def _check_host(self, request: web.Request) -> None:
        hosts = request.headers.getall(hdrs.HOST, [])
        name = _hostname(hosts[0]) if len(hosts) == 1 else None
        if name is None:
            raise web.HTTPBadRequest(text="Host: send exactly one host name")
        if name not in self._names and _address(name) is None:
            raise web.HTTPForbidden(text=f"Host: {name} is not a name of this server; add it to web.allowed_hosts")

    def _check_nearness(self, request: web.Request) -> None:
        """Without tokens, refuse what came through a proxy or a tunnel: from loopback, but not from this computer."""
        if self._admission.asks_for_token:
            return
        header = forwarding_header(request)
        name = _hostname(request.headers[hdrs.HOST]) or ""
        if header is not None or not is_loopback(name):
            proof = f"Host: {name}" if header is None else header
            raise web.HTTPForbidden(
                text=f"{proof}: this came from another computer, through a proxy or a tunnel, and this drone has no "
                "operator's token; make one with: hawk-drone tokens rotate operator"
            )

    @staticmethod
    def _check_origin(request: web.Request) -> None:
        """Refuse a foreign Origin: browsers send it with every WebSocket and POST, tools send none.

        With TLS a page without TLS is foreign too: somebody on the path could have written it.
        """
        if request.method in SAFE_METHODS and hdrs.UPGRADE not in request.headers:
            return
        for origin in request.headers.getall(hdrs.ORIGIN, []):
            parts = urlsplit(origin)
            schemes = ("https",) if is_secure(request) else ("http", "https")
            if parts.scheme not in schemes or parts.netloc.lower() != request.headers[hdrs.HOST].lower():
                raise web.HTTPForbidden(
                    text="Origin: only the page of this server may do that; a proxy must pass the header Host on"
                )


def _check_drone(request: web.Request) -> None:
    """Refuse a drone's token everywhere but at the addresses for drones. Raises HTTPForbidden."""
    access = access_of(request)
    if access is not None and access.drone and not is_for_drones(request):
        raise web.HTTPForbidden(text=FOR_DRONES_ALONE)


def headers_adder(tls: Tls | None) -> Callable[[web.Request, web.StreamResponse], Awaitable[None]]:
    """Return the signal ``on_response_prepare``.

    A certificate of an authority is remembered by the browser as HTTPS only (HSTS, RFC 6797); a self-signed one is not,
    because a browser then offers no exception from its warning.
    """

    async def add(request: web.Request, response: web.StreamResponse) -> None:
        await add_headers(request, response)
        if tls is not None and not tls.is_self_signed:
            response.headers.setdefault("Strict-Transport-Security", f"max-age={HSTS_S}")

    return add


async def add_headers(request: web.Request, response: web.StreamResponse) -> None:
    """Add the headers of every answer."""
    host = request.headers.get(hdrs.HOST, "")
    plain = "" if is_secure(request) else f" ws://{host}"
    sockets = f"{plain} wss://{host}" if _hostname(host) else ""
    response.headers.setdefault(
        "Content-Security-Policy",
        "default-src 'self'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; "
        f"connect-src 'self'{sockets}; worker-src 'self'; object-src 'none'; base-uri 'none'; form-action 'none'; "
        "frame-ancestors 'none'",
    )
    response.headers.setdefault("X-Content-Type-Options", "nosniff")
    response.headers.setdefault("X-Frame-Options", "DENY")
    response.headers.setdefault("Referrer-Policy", "no-referrer")
    response.headers.setdefault("Cross-Origin-Resource-Policy", "same-origin")
    response.headers.setdefault("Cross-Origin-Opener-Policy", "same-origin")
    response.headers.setdefault(hdrs.CACHE_CONTROL, "no-store")


def _hostname(host: str) -> str | None:
    """Return the name in a Host header in lower case, None when the header is malformed."""
    try:
        parts = urlsplit(f"//{host}")
        _ = parts.port
    except ValueError:
        return None
    plain = parts.path == parts.query == parts.fragment == "" and _HOST.fullmatch(host) is not None
    return (parts.hostname or None) if plain else None


def _address(name: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address | None:
    try:
        return ipaddress.ip_address(name)
    except ValueError:
        return None

"""Access to the server: host names, origins, the token, and the headers that restrict a browser.

Only this server's own page may reach the drone. The Origin check stops a page from elsewhere. The Host check stops DNS
rebinding: a bare address cannot be rebound, and every name has to be ours.
"""

from __future__ import annotations

import hashlib
import hmac
import ipaddress
import math
import re
from collections.abc import Callable
from typing import Final
from urllib.parse import urlsplit

from aiohttp import HttpVersion10, HttpVersion11, hdrs, web
from aiohttp.typedefs import Handler

from hawk.config import WebSettings
from hawk.web.guesses import TokenGuesses, network_of
from hawk.web.paced_log import PacedLog

SAFE_METHODS: Final = frozenset({hdrs.METH_GET, hdrs.METH_HEAD, hdrs.METH_OPTIONS})
_HOST: Final = re.compile(r"[A-Za-z0-9._:%\[\]-]+")
"""Characters of host names, addresses and ports."""
TOKEN_PARAMETER: Final = "token"  # noqa: S105 - the parameter's name


class InsecureBindingError(Exception):
    """The address can be reached by others and there is no token."""


def check_binding(settings: WebSettings) -> None:
    """Refuse to serve beyond loopback without a token. Raises InsecureBindingError naming the remedy."""
    if settings.token is None and not is_loopback(settings.host):
        raise InsecureBindingError(
            f"web.host: {settings.host!r} can be reached from other machines and web.token is not set; "
            "set web.token to a secret of at least 16 characters, or web.host to 127.0.0.1"
        )


def is_loopback(host: str) -> bool:
    """Return True when only this machine can reach that address; a name other than localhost may lead anywhere."""
    address = _address(host)
    return host.lower() == "localhost" or (address is not None and address.is_loopback)


def cookie_name(request: web.BaseRequest, purpose: str) -> str:
    """Return a cookie name of this server alone: cookies are shared by all ports of a host."""
    return f"hawk_{purpose}_{_port(request.headers.get(hdrs.HOST, ''))}"


class RequestCheck:
    """Checks every request before it reaches a handler."""

    def __init__(
        self,
        settings: WebSettings,
        cookie_secret: bytes,
        guesses: TokenGuesses,
        log: PacedLog,
        keeps_place: Callable[[web.Request], bool],
    ) -> None:
        """Keep what is compared.

        Args:
            settings: Address, token and names of this server.
            cookie_secret: Key of the cookie: who guesses tokens cannot make one, so it is looked at in any case.
            guesses: Wrong tokens so far.
            log: Log of wrong tokens.
            keeps_place: Returns True for the operator in control, whose token is looked at in any case.
        """
        self._names = {"localhost", settings.host.lower(), *(name.lower() for name in settings.allowed_hosts)}
        self._token = settings.token
        self._cookie_secret = cookie_secret
        self._guesses = guesses
        self._log = log
        self._keeps_place = keeps_place

    @web.middleware
    async def middleware(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        """Answer a request that fails a check, and close its connection; pass every other one on."""
        try:
            self._check_version(request)
            self._check_host(request)
            self._check_origin(request)
            answer = self._check_token(request)
        except web.HTTPException as refusal:
            refusal.force_close()
            raise
        return answer if answer is not None else await handler(request)

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

    @staticmethod
    def _check_origin(request: web.Request) -> None:
        """Refuse a foreign Origin: browsers send it with every WebSocket and POST, tools send none."""
        if request.method in SAFE_METHODS and hdrs.UPGRADE not in request.headers:
            return
        for origin in request.headers.getall(hdrs.ORIGIN, []):
            parts = urlsplit(origin)
            if parts.scheme not in ("http", "https") or parts.netloc.lower() != request.headers[hdrs.HOST].lower():
                raise web.HTTPForbidden(text="Origin: only the page of this server may do that")

    def _check_token(self, request: web.Request) -> web.StreamResponse | None:
        """Return None when the request may go on, else the answer. Raises 401 and 429."""
        if self._token is None:
            return None
        cookie = request.cookies.get(cookie_name(request, "token"))
        if cookie is not None and _same(cookie, self._cookie_value()):
            return self._without_token(request) if TOKEN_PARAMETER in request.query and _is_page(request) else None
        scheme, _, bearer = request.headers.get(hdrs.AUTHORIZATION, "").partition(" ")
        given = [bearer.strip()] if scheme.lower() == "bearer" else []
        given += [request.query[TOKEN_PARAMETER]] if request.query.get(TOKEN_PARAMETER) else []
        if not given or not self._is_right(request, given):
            raise web.HTTPUnauthorized(
                text="This drone asks for a token: open the address that it printed when it started "
                "(http://HOST:PORT/?token=...), or send the header Authorization: Bearer TOKEN.",
                headers={hdrs.WWW_AUTHENTICATE: 'Bearer realm="hawk"'},
            )
        return self._without_token(request) if TOKEN_PARAMETER in request.query and _is_page(request) else None

    def _is_right(self, request: web.Request, given: list[str]) -> bool:
        """Look at the tokens of a request, unless its address guessed too often. Raises 429."""
        assert self._token is not None  # noqa: S101 - narrows for the type checker
        address = network_of(request.remote)
        wait = self._guesses.wait_s(address)
        if wait > 0 and not self._keeps_place(request):
            raise web.HTTPTooManyRequests(
                text=f"Too many wrong tokens came from your address: wait {math.ceil(wait)} s, send the right one.",
                headers={hdrs.RETRY_AFTER: str(math.ceil(wait))},
            )
        if any(_same(each, self._token) for each in given):
            self._guesses.right(address)
            return True
        self._log.warning("wrong token from %s, its %d.", address, self._guesses.wrong(address))
        return False

    def _without_token(self, request: web.Request) -> web.StreamResponse:
        """Send the browser to the same place without the token in the address, which ends up in histories."""
        query = {name: value for name, value in request.query.items() if name != TOKEN_PARAMETER}
        response = web.Response(status=303, headers={hdrs.LOCATION: str(request.rel_url.with_query(query))})
        set_strict_cookie(request, response, "token", self._cookie_value())
        return response

    def _cookie_value(self) -> str:
        """Return a keyed hash of the token: it proves the token, and stays the same after a restart."""
        assert self._token is not None  # noqa: S101 - narrows for the type checker
        return hmac.new(self._cookie_secret, self._token.encode(), hashlib.sha256).hexdigest()


def set_strict_cookie(request: web.BaseRequest, response: web.StreamResponse, purpose: str, value: str) -> None:
    """Set a cookie that no script can read and no other site can send."""
    response.set_cookie(
        cookie_name(request, purpose), value, httponly=True, samesite="Strict", path="/", secure=request.secure
    )


async def add_headers(request: web.Request, response: web.StreamResponse) -> None:
    """Signal ``on_response_prepare``: headers of every answer."""
    host = request.headers.get(hdrs.HOST, "")
    sockets = f" ws://{host} wss://{host}" if _hostname(host) else ""
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


def _same(given: str, wanted: str) -> bool:
    return hmac.compare_digest(given.encode("utf-8", "surrogateescape"), wanted.encode())


def _is_page(request: web.Request) -> bool:
    return request.method == hdrs.METH_GET and request.path == "/"


def _hostname(host: str) -> str | None:
    """Return the name in a Host header in lower case, None when the header is malformed."""
    try:
        parts = urlsplit(f"//{host}")
        _ = parts.port
    except ValueError:
        return None
    plain = parts.path == parts.query == parts.fragment == "" and _HOST.fullmatch(host) is not None
    return (parts.hostname or None) if plain else None


def _port(host: str) -> int:
    try:
        return urlsplit(f"//{host}").port or 80
    except ValueError:
        return 80


def _address(name: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address | None:
    try:
        return ipaddress.ip_address(name)
    except ValueError:
        return None

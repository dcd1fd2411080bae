"""Requests that a proxy passed on: how they are recognised, and what its headers say of the browser's side.

A connection from loopback is no proof of nearness: it may be a proxy's or a tunnel's. What a browser sent to a proxy
changes only the answer to that request: the scheme and the path under which it sees this server.
"""

from __future__ import annotations

import re
from typing import Final

from aiohttp import hdrs, web

PREFIX_HEADER: Final = "X-Forwarded-Prefix"
_SCHEME_HEADER: Final = "X-Forwarded-Proto"
_FAMILIES: Final = (
    "x-forwarded-",
    "x-original-",
    "x-envoy-",
    "x-amzn-",
    "x-azure-",
    "cf-",
    "tailscale-",
    "x-appengine-",
)
"""Beginnings of headers that proxies, tunnels and content networks add, in small letters."""
_NAMES: Final = frozenset(
    {
        "forwarded",  # RFC 7239
        "via",  # RFC 9110, 7.6.3
        "x-forwarded",
        "x-real-ip",
        "x-real-port",
        "x-client-ip",
        "x-cluster-client-ip",
        "x-proxyuser-ip",
        "x-remote-ip",
        "x-remote-addr",
        "x-host",
        "x-scheme",
        "x-script-name",
        "x-proxied",
        "true-client-ip",
        "client-ip",
        "fastly-client-ip",
        "fly-client-ip",
        "cdn-loop",  # RFC 8586
        "front-end-https",
        "proxy-connection",
    }
)
_PREFIX: Final = re.compile(r"(?:/[A-Za-z0-9._~-]+)+")
_DOTS: Final = frozenset({".", ".."})
_PROTOCOL: Final = re.compile(r'(?:^|;)\s*proto="?(https?)"?\s*(?:;|$)', re.IGNORECASE)


def forwarding_header(request: web.BaseRequest) -> str | None:
    """Return the name of a header by which a proxy or tunnel gives itself away, None where there is none."""
    for name in request.headers:
        small = name.lower()
        if small in _NAMES or small.startswith(_FAMILIES):
            return name
    return None


def is_secure(request: web.BaseRequest) -> bool:
    """Return True when the browser speaks HTTPS: with this server, or with the proxy before it.

    The proxy nearest to the browser comes first (RFC 7239, 5.4; X-Forwarded-Proto is written the same).
    """
    if request.secure:
        return True
    first = request.headers.get(_SCHEME_HEADER, "").partition(",")[0].strip().lower()
    if first:
        return first in ("https", "wss")
    found = _PROTOCOL.search(request.headers.get(hdrs.FORWARDED, "").partition(",")[0])
    return found is not None and found[1].lower() == "https"


def prefix_of(request: web.BaseRequest) -> str:
    """Return the path under which the proxy serves this server, without its last slash: ``/drone``; empty for none."""
    given = request.headers.get(PREFIX_HEADER, "").partition(",")[0].strip().rstrip("/")
    is_path = _PREFIX.fullmatch(given) is not None and not _DOTS & set(given.split("/"))
    return given if is_path else ""


def place(request: web.BaseRequest, path: str) -> str:
    """Return where a browser finds a path of this server: relative to the request's own where a proxy passed it on.

    A relative address is right under every sub-path, whether or not the proxy names it.
    """
    if forwarding_header(request) is None:
        return path
    depth = request.rel_url.raw_path.count("/") - 1
    return f"{'../' * depth or './'}{path.removeprefix('/')}"

"""Cookies that no script can read and no other site can send."""

from __future__ import annotations

from urllib.parse import urlsplit

from aiohttp import hdrs, web

from hawk.web.access.proxied import is_secure, prefix_of


def cookie_name(request: web.BaseRequest, purpose: str) -> str:
    """Return a cookie name of this server alone: cookies are shared by all ports of a host.

    With TLS a browser takes a name with ``__Host-`` from this server only, never from one without TLS (RFC 6265bis);
    under a sub-path of a proxy, whose other paths are other servers, it is ``__Secure-``, with that path.
    """
    secure = is_secure(request)
    prefix = ("__Secure-" if prefix_of(request) else "__Host-") if secure else ""
    return f"{prefix}hawk_{purpose}_{_port(request.headers.get(hdrs.HOST, ''), is_secure=secure)}"


def set_strict_cookie(
    request: web.BaseRequest, response: web.StreamResponse, purpose: str, value: str, max_age: int | None = None
) -> None:
    """Set a cookie for this server. ``max_age``: seconds; None: until the browser is closed."""
    response.set_cookie(
        cookie_name(request, purpose),
        value,
        httponly=True,
        samesite="Strict",
        path=f"{prefix_of(request)}/",
        secure=is_secure(request),
        max_age=max_age,
    )


def drop_cookie(request: web.BaseRequest, response: web.StreamResponse, purpose: str) -> None:
    """Make the browser forget a cookie."""
    set_strict_cookie(request, response, purpose, "", max_age=0)


def _port(host: str, *, is_secure: bool) -> int:
    fallback = 443 if is_secure else 80
    try:
        return urlsplit(f"//{host}").port or fallback
    except ValueError:
        return fallback

"""Admission of a request: by the cookie of a login, by a token in the header, or by a token in the address."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final
from urllib.parse import urlencode, urlsplit

from aiohttp import hdrs, web

from hawk.comm.protocol.authority import Role
from hawk.web.access.access import ACCESS, OPEN_TO_ALL, Access, AccessBook
from hawk.web.access.guesses import TokenGuesses, network_of
from hawk.web.access.paced_log import PacedLog
from hawk.web.access.proxied import is_secure, place, prefix_of


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


TOKEN_PARAMETER: Final = "token"  # noqa: S105 - the parameter's name
LOGIN_COOKIE: Final = "login"
PAGE: Final = "/"
BEARER: Final = 'Bearer realm="hawk"'
LOG_IN_FIRST: Final = (
    "A token is needed: log in on the page, or send the header Authorization: Bearer TOKEN. "
    "hawk-drone tokens rotate operator makes a new one."
)
_RANK: Final = {Role.VIEWER: 0, Role.OPERATOR: 1}


class Admission:
    """Looks at cookies and tokens, and begins and ends logins."""

    def __init__(
        self,
        book: AccessBook,
        guesses: TokenGuesses,
        log: PacedLog,
        keeps_place: Callable[[web.Request], bool],
        limit_s: float,
    ) -> None:
        """Keep what is compared.

        Args:
            book: Present tokens and logins.
            guesses: Wrong tokens so far.
            log: Log of wrong tokens.
            keeps_place: Returns True for the operator in control, whose token is looked at in any case.
            limit_s: Age of a login's cookie at which a browser forgets it.
        """
        self._book = book
        self._guesses = guesses
        self._log = log
        self._keeps_place = keeps_place
        self._limit_s = limit_s

    @property
    def asks_for_token(self) -> bool:
        """False on loopback without tokens."""
        return bool(self._book.tokens)

    def admit(self, request: web.Request) -> web.StreamResponse | None:
        """Note the request's access and return None; or return the answer. Raises 401 and 429."""
        if not self._book.tokens:
            request[ACCESS] = OPEN_TO_ALL
            return None
        known = self.by_login(request)
        if known is not None:
            request[ACCESS] = known
            return self._address_of_one_who_is_known(request, known)
        scheme, _, bearer = request.headers.get(hdrs.AUTHORIZATION, "").partition(" ")
        given = [bearer.strip()] if scheme.lower() == "bearer" else []
        if given and (drone := self._drone(request, given[0])) is not None:
            request[ACCESS] = drone
            return None
        is_link = _is_page(request) and bool(request.query.get(TOKEN_PARAMETER))
        if request.query.get(TOKEN_PARAMETER) and not (is_link and _is_foreign(request)):
            given.append(request.query[TOKEN_PARAMETER])
        proved = self.prove(request, given) if given else None
        if proved is None:
            raise web.HTTPUnauthorized(text=LOG_IN_FIRST, headers={hdrs.WWW_AUTHENTICATE: BEARER})
        request[ACCESS] = proved
        return self.log_in(request, proved) if is_link else None

    def _drone(self, request: web.Request, given: str) -> Access | None:
        """Return the access of a drone by its token; None for another one. Raises as `prove`."""
        self._check_wait(request)
        name = self._book.tokens.drone_of(given)
        if name is None:
            return None
        self._guesses.right(network_of(request.remote))
        return Access(Role.VIEWER, self._book.tokens.drone_proof(name), drone=name)

    def by_login(self, request: web.Request) -> Access | None:
        """Return the access of the request's cookie, None when its login has ended or there is none."""
        value = request.cookies.get(cookie_name(request, LOGIN_COOKIE))
        login = self._book.logins.find(value, self._book.tokens)
        if login is None:
            return None
        return self._book.of_person(login.person, login) if login.person else Access(login.role, login.proof, login)

    def prove(self, request: web.Request, given: list[str], only: Role | None = None) -> Access | None:
        """Return the access that one of the tokens proves, None when all are wrong. ``only``: the role that it must be.

        A guess is counted and logged: a token that was valid, or is that of another role, is none. Raises 429 while the
        request's address has to wait.
        """
        self._check_wait(request)
        address = network_of(request.remote)
        found = [self._access_by(each, only) for each in given]
        proved = next((each for each in found if each is not None), None)
        if proved is not None:
            self._guesses.right(address)
            return proved
        for guess in (each for each in given if not self._book.tokens.is_or_was_one(each)):
            self._log.warning("wrong token from %s, its %d.", address, self._guesses.wrong(address, guess))
        return None

    def _access_by(self, given: str, only: Role | None) -> Access | None:
        tokens = self._book.tokens
        role, person = tokens.role_of(given, only), tokens.person_of(given, only)
        if role is not None:
            return Access(role, tokens.proof(role))
        return None if person is None else self._book.of_person(person)

    def _check_wait(self, request: web.Request) -> None:
        """Refuse a token from an address that has to wait. Raises 429."""
        wait = self._guesses.wait_s(network_of(request.remote))
        if wait > 0 and not self._keeps_place(request):
            raise web.HTTPTooManyRequests(
                text=f"Too many wrong tokens came from your address: wait {math.ceil(wait)} s, send the right one.",
                headers={hdrs.RETRY_AFTER: str(math.ceil(wait))},
            )

    def log_in(self, request: web.Request, proved: Access) -> web.StreamResponse:
        """Begin a login in place of the one that the browser has; send it to the page, without a token in the address.

        Addresses end up in histories.
        """
        assert proved.proof is not None  # noqa: S101 - it was proved a moment ago
        self.log_out(request)
        value = self._book.logins.begin(proved.role, proved.proof, proved.person)
        response = _to_page(request)
        set_strict_cookie(request, response, LOGIN_COOKIE, value, max_age=int(self._limit_s))
        return response

    def log_out(self, request: web.Request) -> None:
        """End the login of the request's cookie; without one there is nothing to end."""
        known = self.by_login(request)
        if known is not None and known.login is not None:
            self._book.logins.end(known.login)

    def leave(self, request: web.Request) -> web.StreamResponse:
        """End the login, and return the answer that makes the browser forget it."""
        self.log_out(request)
        response = web.Response(status=303, headers={hdrs.LOCATION: place(request, "/login")})
        drop_cookie(request, response, LOGIN_COOKIE)
        drop_cookie(request, response, "session")
        return response

    def _address_of_one_who_is_known(self, request: web.Request, known: Access) -> web.StreamResponse | None:
        """Clean the address. A link never takes a role away: only a token that opens more replaces the login."""
        if TOKEN_PARAMETER not in request.query or not _is_page(request):
            return None
        is_all = known.role is Role.OPERATOR and known.lots is None
        if not is_all and request.query[TOKEN_PARAMETER] and not _is_foreign(request):
            proved = self.prove(request, [request.query[TOKEN_PARAMETER]])
            if proved is not None and _opens_more(proved, known):
                return self.log_in(request, proved)
        return _to_page(request)


def _opens_more(proved: Access, known: Access) -> bool:
    """Return whether an access has all that another one has, and a higher role or all lots beside it."""
    new, old = ((_RANK[each.role], each.lots is None) for each in (proved, known))
    return new != old and all(one >= other for one, other in zip(new, old, strict=True))


def _to_page(request: web.Request) -> web.Response:
    """Return the redirect to the page: always to this server, whatever the address asks for."""
    query = [(name, value) for name, value in request.query.items() if name != TOKEN_PARAMETER]
    location = f"{PAGE}?{urlencode(query)}" if _is_page(request) and query else PAGE
    return web.Response(status=303, headers={hdrs.LOCATION: place(request, location)})


def _is_page(request: web.Request) -> bool:
    return request.method == hdrs.METH_GET and request.path == PAGE


def _is_foreign(request: web.Request) -> bool:
    """Return True for a link on a page of somebody else, which could log a person in without their doing."""
    return request.headers.get("Sec-Fetch-Site", "none") not in ("none", "same-origin")

"""Access that a request or a connection has, and the end of it while the connection is open."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Final

from aiohttp import web

from hawk.comm.protocol.authority import Role
from hawk.web.access.logins import Login, Logins
from hawk.web.access.tokens import Tokens


@dataclass(frozen=True, slots=True)
class Access:
    """The role of a request, and what proved it."""

    role: Role
    proof: str | None = None
    """Name of the token; None: no token is asked for."""
    login: Login | None = None
    """The login of the cookie; None for a token in the header or the address, and where none is asked for."""


ACCESS: Final = web.RequestKey("access", Access)
"""Set by `hawk.web.access.admission` before any handler runs."""
OPEN_TO_ALL: Final = Access(Role.OPERATOR)
"""Access where no token is asked for: only on loopback."""


class AccessBook:
    """The present tokens and logins: says whether an access still holds."""

    def __init__(self, tokens: Tokens, logins: Logins) -> None:
        self.tokens = tokens
        self.logins = logins

    def holds(self, access: Access) -> bool:
        """Return False once its login has ended, or its token is another."""
        if access.login is not None:
            return self.logins.is_live(access.login, self.tokens)
        if access.proof is None:
            return not self.tokens
        return access.proof == self.tokens.proof(access.role)


class OpenConnections:
    """WebSockets and streams with the access by which they were opened."""

    def __init__(self, book: AccessBook) -> None:
        self._book = book
        self._open: dict[object, tuple[Access, Callable[[], None]]] = {}

    def __len__(self) -> int:
        return len(self._open)

    @contextlib.contextmanager
    def kept(self, access: Access, end: Callable[[], None]) -> Iterator[None]:
        """Keep a connection as long as it is open. ``end`` closes it, and is called once at most."""
        mark = object()
        self._open[mark] = (access, end)
        if access.login is not None:
            access.login.open += 1
        try:
            yield
        finally:
            self._open.pop(mark, None)
            if access.login is not None:
                access.login.open -= 1

    def end_those_without_access(self) -> int:
        """Close every connection whose access has ended; return how many."""
        ended = [mark for mark, (access, _) in self._open.items() if not self._book.holds(access)]
        for mark in ended:
            _, end = self._open.pop(mark)
            end()
        return len(ended)


BOOK = web.AppKey("access book", AccessBook)
OPEN = web.AppKey("open connections", OpenConnections)


def access_of(request: web.BaseRequest) -> Access | None:
    """Return the access of a request that was admitted, None before."""
    return request.get(ACCESS)

"""Access that a request or a connection has, and the end of it while the connection is open."""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections.abc import AsyncIterator, Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Final, TypeVar

from aiohttp import web

from hawk.comm.protocol.authority import Role
from hawk.runtime.files import write_private
from hawk.web.access.logins import Login, Logins
from hawk.web.access.tokens import TOKEN_FILE, Tokens, TokensError, read_tokens


@dataclass(frozen=True, slots=True)
class Access:
    """The role of a request, and what proved it."""

    role: Role
    proof: str | None = None
    """Name of the token; None: no token is asked for."""
    login: Login | None = None
    """The login of the cookie; None for a token in the header or the address, and where none is asked for."""
    drone: str = ""
    """Name of the drone whose token it is: it has no role, and only the addresses for drones are open to it."""
    person: str = ""
    """Name of the person whose token it is."""
    lots: frozenset[str] | None = None
    """Ids of the lots that the role is for; None: for all, and for the drone."""


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
        if access.drone:
            return access.proof == self.tokens.drone_proof(access.drone)
        if access.person:
            return access == self.of_person(access.person)
        if access.proof is None:
            return not self.tokens
        return access.proof == self.tokens.proof(access.role)

    def of_person(self, name: str, login: Login | None = None) -> Access | None:
        """Return the present access of a person; None when nobody has the name any more."""
        found = self.tokens.people.get(name)
        return None if found is None else Access(found.role, found.token.proof, login, person=name, lots=found.lots)

    def lots_of(self, name: str) -> frozenset[str]:
        """Return the lots that a person's role is for, by their ids: none when nobody has the name any more."""
        found = self.tokens.people.get(name)
        return frozenset() if found is None else found.lots


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


LOG = logging.getLogger(__name__)

LOGIN_FILE: Final = "web-logins.json"
LOOK_S: Final = 1.0
"""Real seconds between two looks at the token file and at the logins."""
WRITE_S: Final = 60.0
"""Real seconds after which the ages of the logins are written again."""
WRITE_TIMEOUT_S: Final = 2.0
"""Real seconds for which a log-out and the end of the program wait for the disk."""
_LARGEST_BYTES: Final = 1024 * 1024

_Mark = tuple[int, int, int] | None
_T = TypeVar("_T")


class AccessKeeper:
    """`restore` before the loop runs, then `run` as a task, `write` after a log-out, `close` at the end."""

    def __init__(
        self,
        folder: Path | None,
        book: AccessBook,
        connections: OpenConnections,
        joined: Callable[[Tokens], Tokens],
        wall: Callable[[], float],
    ) -> None:
        """Keep the parts.

        Args:
            folder: Folder of both files; None: nothing is read or written.
            book: Tokens and logins of this server.
            connections: Closed when their access ends.
            joined: Adds the configured token to those of the file.
            wall: Seconds since 1970.
        """
        self._tokens = None if folder is None else folder / TOKEN_FILE
        self._logins = None if folder is None else folder / LOGIN_FILE
        self._book = book
        self.connections = connections
        self._joined = joined
        self._wall = wall
        self._seen: _Mark = None  # the first look reads the file again: it may have changed since it was read
        self._written = book.logins.changes
        self._executor = ThreadPoolExecutor(1, thread_name_prefix="web-access")

    def restore(self) -> None:
        """Take the logins of an earlier run; a file that cannot be used is reported and costs a login."""
        if self._logins is None:
            return
        try:
            with self._logins.open("rb") as file:
                text = file.read(_LARGEST_BYTES + 1).decode()
            self._book.logins.restore(text, self._wall())
        except FileNotFoundError:
            return
        except (OSError, ValueError) as error:
            LOG.warning("%s: %s; everybody has to log in again", self._logins, error)

    async def run(self) -> None:
        """Look at files and logins until cancelled."""
        since = 0.0
        while True:
            await asyncio.sleep(LOOK_S)
            since += LOOK_S
            try:
                await self.look()
                if self._written != self._book.logins.changes or (since >= WRITE_S and len(self._book.logins)):
                    since = 0.0
                    await self.write()
            except Exception:  # whatever a file holds, the next look is taken
                LOG.exception("the tokens and logins could not be looked at")

    async def look(self) -> None:
        """Take new tokens, and end what has lost its access."""
        path = self._tokens
        if path is not None and (mark := await self._elsewhere(lambda: _mark(path))) != self._seen:
            self._seen = mark
            await self._take(path, is_gone=mark is None)
        self._book.logins.sweep(self._book.tokens)
        if ended := self.connections.end_those_without_access():
            LOG.info("%d connections were closed: their login or token has ended", ended)

    async def write(self) -> None:
        """Write the logins. A disk that refuses costs a log-in after the next restart, and nothing now."""
        self._written = self._book.logins.changes
        path, text = self._logins, self._book.logins.to_json(self._wall())
        if path is None:
            return
        try:
            async with asyncio.timeout(WRITE_TIMEOUT_S):
                await self._elsewhere(lambda: write_private(path, text.encode()))
        except (OSError, TimeoutError) as error:
            LOG.warning("%s cannot be written: %s", path, error or "the disk does not answer")

    def close(self) -> None:
        """End the thread."""
        self._executor.shutdown(wait=False, cancel_futures=True)

    async def _take(self, path: Path, *, is_gone: bool) -> None:
        if is_gone:
            LOG.warning("%s is gone: the tokens that were in it stay valid until the next start", path)
            return
        try:
            kept = await self._elsewhere(lambda: read_tokens(path))
        except TokensError as error:
            LOG.error("%s; the tokens before it stay valid", error)
            return
        tokens = self._joined(kept)
        if tokens != self._book.tokens:
            self._book.tokens = tokens
            names = [*(role.value for role in kept.by_role), *kept.people, *kept.drones]
            LOG.info("the tokens have changed: %s", ", ".join(names))

    async def _elsewhere(self, work: Callable[[], _T]) -> _T:
        return await asyncio.get_running_loop().run_in_executor(self._executor, work)


KEEPER = web.AppKey("access keeper", AccessKeeper)


async def keep_access(app: web.Application) -> AsyncIterator[None]:
    """Clean-up context: runs the keeper while the server runs, and writes the logins at its end."""
    keeper = app[KEEPER]
    task = asyncio.create_task(keeper.run(), name="web-access")
    yield
    task.cancel()
    await asyncio.gather(task, return_exceptions=True)
    await keeper.write()
    keeper.close()


def _mark(path: Path) -> _Mark:
    """Return what differs when a file was replaced, None without a file."""
    try:
        found = path.stat()
    except OSError:
        return None
    return found.st_ino, found.st_mtime_ns, found.st_size

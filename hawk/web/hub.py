"""The connected clients and what waits to be sent to each: a slow one holds up nobody."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Callable
from typing import Final

from hawk.comm.status import ClientId
from hawk.web.heartbeat import ClientView

OUTBOX_LIMIT: Final = 64
"""Answers that wait for one client; a client that reads none of so many is disconnected."""


class Outbox:
    """Answers that wait for one client, and whether a heartbeat is due."""

    def __init__(self, limit: int = OUTBOX_LIMIT) -> None:
        self._texts: deque[str] = deque()
        self._limit = limit
        self._wake = asyncio.Event()
        self._pong: bytes | None = None
        self.heartbeat_due = False
        self.overflowed = False

    def put(self, text: str) -> None:
        """Queue an answer. When too many wait the client is beyond help: see `overflowed`."""
        if len(self._texts) >= self._limit:
            self.overflowed = True
        else:
            self._texts.append(text)
        self._wake.set()

    def heartbeat(self) -> None:
        """A heartbeat is due: the newest when the client can take it, however many came due before."""
        self.heartbeat_due = True
        self._wake.set()

    def pong(self, mark: bytes) -> None:
        """Queue the answer to a ping; only the newest needs one (RFC 6455, section 5.5.3)."""
        self._pong = mark
        self._wake.set()

    def take_pong(self) -> bytes | None:
        """Return, once, the ping that waits for its answer."""
        mark, self._pong = self._pong, None
        return mark

    def wake(self) -> None:
        """There may be something to do again."""
        self._wake.set()

    def take(self) -> str | None:
        """Return the oldest answer, None when there is none."""
        return self._texts.popleft() if self._texts else None

    async def wait(self) -> None:
        """Wait until there is something to do."""
        await self._wake.wait()
        self._wake.clear()


class Client:
    """One connection."""

    def __init__(self, client_id: ClientId) -> None:
        self.id = client_id
        self.outbox = Outbox()
        self.view = ClientView()


class ClientHub:
    """All connections of the command socket; a `hawk.comm.message_socket.ServerTransport`."""

    def __init__(self) -> None:
        self._clients: dict[ClientId, Client] = {}
        self._count = 0
        self._empty = asyncio.Event()
        self._empty.set()

    def __len__(self) -> int:
        return len(self._clients)

    def add(self) -> Client:
        """Take up a new connection."""
        self._count += 1
        client = Client(f"client-{self._count}")
        self._clients[client.id] = client
        self._empty.clear()
        return client

    def remove(self, client: Client) -> None:
        """Forget a connection."""
        self._clients.pop(client.id, None)
        if not self._clients:
            self._empty.set()

    async def empty(self) -> None:
        """Wait until nobody is connected."""
        await self._empty.wait()

    def heartbeat(self) -> None:
        """A heartbeat is due for everyone."""
        for client in self._clients.values():
            client.outbox.heartbeat()

    def forget_map(self, client: ClientId) -> None:
        """Send this client the whole map again."""
        found = self._clients.get(client)
        if found is not None:
            found.view.forget_map()

    # -- ServerTransport ----------------------------------------------------------------------------------------------

    def open(self, on_message: Callable[[str], None]) -> None:
        """Nothing to do: the web server accepts clients and feeds the message socket."""

    def send(self, text: str) -> None:
        """Queue for every client (a loop never waits)."""
        self.post(text)

    def post(self, text: str) -> None:
        """Queue for every client."""
        for client in self._clients.values():
            client.outbox.put(text)

    def send_to(self, client: ClientId, text: str) -> None:
        """Queue for one client; one that has gone is no error."""
        found = self._clients.get(client)
        if found is not None:
            found.outbox.put(text)

    @property
    def is_connected(self) -> bool:
        """Whether any client is connected."""
        return bool(self._clients)

    def close(self) -> None:
        """Nothing to do: the web server closes its connections."""

"""Message Socket (specification, section 6): strings between drone and operator, in order, whole.

`MessageSocket` has the specification's access programs for both roles. The operator's role runs over a WebSocket on a
loop thread of its own, so that it works from plain Python; `hawk.comm.async_message_socket` is the same for asyncio.
The server's role stands on a transport that is given to it; `ServerMessageSocket` adds what the daemon needs: answers
by client, and Hold, Kill Request and Kill past the queue.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from typing import Final, Literal, Protocol

from hawk.comm.base_socket import BaseSocket, ConnectionTimeout, FailedToSend
from hawk.comm.messages import Ack, BadMessageError, Command, Hold, Kill, KillRequest, Outgoing, parse_command
from hawk.comm.status import ClientId, CommandHandler

__all__ = [
    "ConnectionTimeout",
    "FailedToSend",
    "Gate",
    "MessageSocket",
    "NoMessagesError",
    "Role",
    "ServerMessageSocket",
    "ServerTransport",
    "Transport",
]

Role = Literal["SERVER", "OPERATOR"]

QUEUE_LIMIT: Final = 256
"""Messages that wait at most; the next one is answered with an error."""
URGENT: Final = (Hold, KillRequest, Kill)
"""Commands that pass the queue."""


class NoMessagesError(Exception):
    """There is no message to take."""


Gate = Callable[[ClientId, Command], Outgoing | None]
"""Answers a command that is not for the operations manager, or that this client may not give; None lets it through."""


class Transport(Protocol):
    """What carries the strings. Every method may be called from any thread that calls the socket."""

    def open(self, on_message: Callable[[str], None]) -> None:
        """Connect, or begin to listen; ``on_message`` is called with each string. Raises ConnectionTimeout."""
        ...

    def send(self, text: str) -> None:
        """Send and return when it is on its way. Raises FailedToSend."""
        ...

    def post(self, text: str) -> None:
        """Send in the background. Raises FailedToSend when too many messages wait."""
        ...

    @property
    def is_connected(self) -> bool:
        """Whether there is anyone on the other side."""
        ...

    def close(self) -> None:
        """End it."""
        ...


class ServerTransport(Transport, Protocol):
    """A transport with several clients on the other side."""

    def send_to(self, client: ClientId, text: str) -> None:
        """Send to one client in the background; one that has gone is no error. Never blocks."""
        ...


class MessageSocket:
    """The specification's Message Socket: ``in_type`` "SERVER" (drone) or "OPERATOR" (client)."""

    def __init__(
        self,
        in_type: Role,
        in_host: str,
        in_port: int,
        transport: Transport | None = None,
        *,
        timeout_s: float = 5.0,
        token: str | None = None,
        queue_limit: int = QUEUE_LIMIT,
    ) -> None:
        """Raises ValueError for another type, or a server without a transport. ``in_host`` is empty for a server."""
        if in_type not in ("SERVER", "OPERATOR"):
            raise ValueError(f'in_type must be "SERVER" or "OPERATOR", not {in_type!r}')
        if transport is None and in_type == "SERVER":
            raise ValueError("transport: a SERVER socket needs one (hawk.web.hub.ClientHub)")
        self.type = in_type
        self.host = in_host
        self.port = in_port
        self._received: deque[str] = deque()
        self._limit = queue_limit
        self._room = threading.Condition()
        self._opened = False
        self._closed = False
        if transport is None:
            # Imported here: the daemon has no use for the loop thread of a client.
            from hawk.comm.client_transport import ClientTransport

            transport = ClientTransport(BaseSocket(in_host, in_port, token=token), timeout_s=timeout_s)
        self._transport = transport

    def init(self) -> None:
        """Connect (client) or be ready for clients (server). Raises ConnectionTimeout."""
        if self._opened:
            self.close()
        with self._room:
            self._received.clear()
            self._closed = False
        self._opened = True
        self._transport.open(self._put)

    def send_message_sync(self, x: str) -> None:
        """Send and block until it is sent; connects again first when not connected. Raises FailedToSend."""
        self._transport.send(x)

    def send_message_async(self, x: str) -> None:
        """Send in the background. Raises FailedToSend only when too many messages wait already."""
        self._transport.post(x)

    def get_message(self) -> str:
        """Return the oldest message that was not taken yet. Raises NoMessagesError when there is none."""
        with self._room:
            if not self._received:
                raise NoMessagesError("no message has come")
            text = self._received.popleft()
            self._room.notify()
        return text

    def is_connected(self) -> bool:
        """Return whether a connection is established."""
        return self._transport.is_connected

    def close(self) -> None:
        """Close the connection."""
        with self._room:
            self._closed = True
            self._room.notify_all()
        self._transport.close()

    def _put(self, text: str) -> None:
        """Keep a message; a full queue holds the sender up (TCP passes that on), so that nothing is lost."""
        with self._room:
            self._room.wait_for(lambda: len(self._received) < self._limit or self._closed)
            if not self._closed:
                self._received.append(text)


class ServerMessageSocket(MessageSocket):
    """The drone's role in the daemon: `feed` by the web server, `receive` and `reply` by the operations manager.

    Lives on the loop; nothing in it blocks.
    """

    def __init__(
        self, transport: ServerTransport, gate: Gate | None = None, port: int = 3000, *, queue_limit: int = QUEUE_LIMIT
    ) -> None:
        super().__init__("SERVER", "", port, transport, queue_limit=queue_limit)
        self._clients = transport
        self._gate = gate
        self._commands: deque[tuple[ClientId, Command]] = deque()
        self._handler: CommandHandler | None = None

    def attach(self, handler: CommandHandler) -> None:
        """Name who acts on Hold, Kill Request and Kill at once."""
        self._handler = handler

    def feed(self, client: ClientId, text: str) -> None:
        """Take one string of a client: queued, acted on at once, or refused with the reason. Never raises for input."""
        try:
            command = parse_command(text)
        except BadMessageError as error:
            self.reply(client, Ack(id=error.message_id, accepted=False, reason=str(error)))
            return
        answer = self._gate(client, command) if self._gate is not None else None
        if answer is not None:
            self.reply(client, answer)
        elif isinstance(command, URGENT):
            self.reply(client, self._act_now(client, command))
        elif len(self._commands) >= self._limit:
            reason = f"{self._limit} commands are waiting; send it again in a moment"
            self.reply(client, Ack(id=command.id, accepted=False, reason=reason))
        else:
            self._commands.append((client, command))

    def receive(self) -> list[tuple[ClientId, Command]]:
        """Take all commands that wait, oldest first."""
        taken = list(self._commands)
        self._commands.clear()
        return taken

    def get_message(self) -> str:
        """Take the oldest command alone, as its string. Raises NoMessagesError when none waits."""
        if not self._commands:
            raise NoMessagesError("no message has come")
        _, command = self._commands.popleft()
        return command.model_dump_json(by_alias=True)

    def reply(self, client: ClientId, message: Outgoing) -> None:
        """Answer one client; a client that has gone is no error. Never blocks."""
        self._clients.send_to(client, message.to_json())

    def _act_now(self, client: ClientId, command: Command) -> Outgoing:
        if self._handler is None:
            return Ack(id=command.id, accepted=False, reason="The drone is starting; send it again.")
        return self._handler.handle_now(client, command)

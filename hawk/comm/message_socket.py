"""Message Socket (specification, section 6) for asyncio: strings between drone and operator, whole and in order.

`AsyncMessageSocket` is an operator's end. `ServerMessageSocket` is the server's role inside the daemon: the web server
carries its strings, and it adds answers by client, a share of each tick for each client, and the commands that stop or
save the drone past the queue.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import time
from collections import deque
from collections.abc import Callable, Coroutine, Sequence
from typing import Final

from hawk.comm.base_socket import ConnectionTimeout, FailedToSend, MessageLink, SocketClosedError
from hawk.comm.protocol.command_table import COMMAND_TABLE, Urgency
from hawk.comm.protocol.commands import Ack, BadMessageError, Command, Outgoing, parse_command
from hawk.comm.protocol.heartbeat import ClientId, CommandHandler
from hawk.model.sentences import say
from hawk.runtime.supervision import end_tasks

_LOG = logging.getLogger(__name__)

QUEUE_LIMIT: Final = 256
"""Messages that wait at most in each direction. A full receive queue stops reading: the drone then sends fewer
heartbeats."""
CLIENT_WAITING: Final = 16
"""Commands of one client that wait at most in the daemon; the next one is refused."""
TURNS_KEPT: Final = 100
"""Ticks for which a client's turn is remembered."""
TICK_COMMANDS: Final = 4
"""Commands that a tick takes at most, one of a client: each costs it some tenths of a millisecond."""
STALE_S: Final = 2.0
"""A posted message that waited longer for the link is dropped: the drone must not act on an old command."""
_SLACK_S: Final = 0.05
"""Real seconds by which the words of the attempt itself come first."""
RETRY_S: Final = (0.1, 0.25, 0.5, 1.0, 2.0)
"""Pauses between attempts to connect again; the last one repeats."""

Gate = Callable[[ClientId, Command], Outgoing | None]
"""Answers a command that is not for the operations manager, or that this client may not give; None lets it through."""
SendTo = Callable[[ClientId, str], None]
"""Sends to one client in the background; one that has left is no error."""


class ServerMessageSocket:
    """The drone's Message Socket in the daemon: `feed` by the web server, `receive` and `reply` by the manager.

    Lives on the loop; nothing in it blocks. The web server listens, accepts and closes.
    """

    def __init__(self, send_to: SendTo, gate: Gate | None = None) -> None:
        self._send_to = send_to
        self._gate = gate
        self._waiting: dict[ClientId, deque[Command]] = {}
        self._served: dict[ClientId, int] = {}
        """Number of the last tick that took a command of a client."""
        self._ticks = 0
        self._handler: CommandHandler | None = None

    @property
    def waiting(self) -> int:
        """Commands that wait for the operations manager."""
        return sum(map(len, self._waiting.values()))

    def attach(self, handler: CommandHandler) -> None:
        """Set the handler that acts on the urgent commands at once."""
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
        elif COMMAND_TABLE[command.type].urgency is not Urgency.WAITS:
            self.reply(client, self._act_now(client, command))
        elif len(self._waiting.get(client, ())) >= CLIENT_WAITING:
            reason = f"Too many commands: send at most {CLIENT_WAITING} at once."
            self.reply(client, Ack(id=command.id, accepted=False, reason=reason))
        else:
            self._waiting.setdefault(client, deque()).append(command)

    def receive(self) -> list[tuple[ClientId, Command]]:
        """Take what a tick has time for: the oldest command of each client, those first that waited longest for a turn.

        So a client that sends seldom is answered in the next tick, whatever the others send.
        """
        self._ticks += 1
        self._served = {client: tick for client, tick in self._served.items() if self._ticks - tick <= TURNS_KEPT}
        turn = sorted(self._waiting, key=lambda client: self._served.get(client, 0))[:TICK_COMMANDS]
        taken = [(client, self._waiting[client].popleft()) for client in turn]
        self._served.update(dict.fromkeys(turn, self._ticks))
        self._waiting = {client: commands for client, commands in self._waiting.items() if commands}
        return taken

    def reply(self, client: ClientId, message: Outgoing) -> None:
        """Answer one client; a client that has left is no error."""
        self._send_to(client, message.to_json())

    def _act_now(self, client: ClientId, command: Command) -> Outgoing:
        if self._handler is None:
            return Ack(id=command.id, accepted=False, reason=say("The drone is starting; send it again."))
        answer = self._handler(client, command)
        is_saving = COMMAND_TABLE[command.type].urgency is Urgency.SAVING
        if is_saving and isinstance(answer, Ack) and answer.accepted:
            self._void(say("{command} came first: send it again if you still want it.", command=command.type))
        return answer

    def _void(self, reason: str) -> None:
        """Refuse what was sent before a stop and would be carried out after it; a question changes nothing."""
        waiting, self._waiting = self._waiting, {}
        for client, commands in waiting.items():
            for command in commands:
                if COMMAND_TABLE[command.type].only_asks:
                    self._waiting.setdefault(client, deque()).append(command)
                else:
                    self.reply(client, Ack(id=command.id, accepted=False, reason=reason))


class AsyncMessageSocket:
    """`init`, then `send_message`, `post_message` and `get_message` until `close`. One loop only."""

    def __init__(
        self,
        socket: MessageLink,
        *,
        timeout_s: float = 5.0,
        queue_limit: int = QUEUE_LIMIT,
        retry_s: Sequence[float] = RETRY_S,
        monotonic: Callable[[], float] = time.monotonic,
    ) -> None:
        self._socket = socket
        self._timeout = timeout_s
        self._retry_s = retry_s
        self._monotonic = monotonic
        self._received: asyncio.Queue[str] = asyncio.Queue(queue_limit)
        self._waiting: asyncio.Queue[tuple[float, str]] = asyncio.Queue(queue_limit)
        self._connected = asyncio.Event()
        self._connecting = asyncio.Lock()
        self._tasks: list[asyncio.Task[None]] = []
        self._problem = ""

    @property
    def is_connected(self) -> bool:
        """True while there is a connection."""
        return self._connected.is_set() and self._socket.is_connected

    async def init(self) -> None:
        """Connect and start the tasks that read and write. Raises ConnectionTimeout."""
        try:
            await self._connect()
        except ConnectionTimeout:
            if not self._tasks:
                await self._socket.close()
            raise

    def begin(self) -> None:
        """Start the tasks, and connect in the background; needs the running loop."""
        if not self._tasks:
            self._start(self._reconnect_and_read())

    async def send_message(self, text: str) -> None:
        """Send now; connect first when there is no connection, within the time-out. Raises FailedToSend."""
        if not self.is_connected:
            try:
                # an attempt in the background may hold the lock: waiting for it counts too
                async with asyncio.timeout(self._timeout + _SLACK_S):
                    await self._connect()
            except ConnectionTimeout as error:
                raise FailedToSend(str(error)) from error
            except TimeoutError:
                raise FailedToSend(self._problem or f"no connection within {self._timeout:g} s") from None
        await self._socket.send(text)

    def post_message(self, text: str) -> None:
        """Send in the background. Raises FailedToSend when too many messages wait already."""
        try:
            self._waiting.put_nowait((self._monotonic(), text))
        except asyncio.QueueFull:
            raise FailedToSend(f"{self._waiting.maxsize} messages wait already; send again later") from None

    async def get_message(self) -> str:
        """Wait for the oldest message that was not taken yet and return it."""
        return await self._received.get()

    async def close(self) -> None:
        """End tasks and connection."""
        tasks, self._tasks = self._tasks, []
        await end_tasks(*tasks)
        self._connected.clear()
        await self._socket.close()

    async def _connect(self) -> None:
        async with self._connecting:
            if self.is_connected:
                return
            self._connected.clear()
            try:
                await self._socket.connect(self._timeout)
            except ConnectionTimeout as error:
                self._problem = str(error)
                raise
            self._connected.set()
            if not self._tasks:
                self._start(self._read())

    def _start(self, read: Coroutine[None, None, None]) -> None:
        self._tasks = [
            asyncio.create_task(read, name="message-socket-read"),
            asyncio.create_task(self._write(), name="message-socket-write"),
        ]

    async def _reconnect_and_read(self) -> None:
        await self._reconnect()
        await self._read()

    async def _read(self) -> None:
        """Fill the queue; after a lost connection try again until closed."""
        while True:
            try:
                while True:
                    await self._received.put(await self._socket.receive())
            except SocketClosedError:
                self._connected.clear()
            await self._reconnect()

    async def _reconnect(self) -> None:
        attempt = 0
        while not self.is_connected:
            await asyncio.sleep(self._retry_s[min(attempt, len(self._retry_s) - 1)])
            attempt += 1
            with contextlib.suppress(ConnectionTimeout):
                await self._connect()

    async def _write(self) -> None:
        while True:
            posted, text = await self._waiting.get()
            await self._connected.wait()
            if self._monotonic() - posted > STALE_S:
                _LOG.warning("A message that waited longer than %.0f s for the link was dropped", STALE_S)
                continue
            try:
                await self._socket.send(text)
            except FailedToSend as error:
                self._connected.clear()
                _LOG.warning("A message was not sent: %s", error)

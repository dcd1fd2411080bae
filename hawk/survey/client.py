"""The drone for Python programs: its map and heartbeat kept up to date, commands answered."""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import logging
from types import TracebackType
from typing import Annotated, Any, Final, Self, TypeVar

import aiohttp
from pydantic import Field, TypeAdapter, ValidationError

from hawk.comm.async_message_socket import AsyncMessageSocket
from hawk.comm.base_socket import BaseSocket, FailedToSend
from hawk.comm.fence_messages import FenceSetup
from hawk.comm.messages import (
    Ack,
    Answer,
    Command,
    Control,
    Heartbeat,
    LogEntry,
    MapResync,
    OperatorHeartbeat,
    Point,
    RouteAnswer,
    RouteRequest,
    Welcome,
)
from hawk.model import GlobalPose, TileKey
from hawk.survey.client_map import BadMapError, ClientMap
from hawk.survey.survey_map import SurveyMap

LOG = logging.getLogger(__name__)

ANSWER_TIMEOUT_S: Final = 5.0
"""Real seconds that an answer may take: a tick is 50 ms, the rest is the network."""
SIGN_INTERVAL_S: Final = 1.0
"""Seconds of the drone's clock between signs of life."""
SHORTEST_SIGN_INTERVAL_S: Final = 0.2
PICTURE_TIMEOUT_S: Final = 10.0
LOG_LIMIT: Final = 1000

_Incoming = Annotated[Heartbeat | Answer | Welcome, Field(discriminator="type")]
_INCOMING: TypeAdapter[Any] = TypeAdapter(_Incoming)
C = TypeVar("C", bound=Command)


class CommandRefusedError(Exception):
    """The drone said no; the text is its reason."""


class LinkLostError(ConnectionError):
    """Nothing came from the drone for too long."""


class DroneClient:
    """`start`, then commands and `next_heartbeat`, then `close`; or ``async with``. Reconnects by itself."""

    def __init__(self, host: str, port: int, *, token: str | None = None, timeout_s: float = 5.0) -> None:
        self._socket = AsyncMessageSocket(BaseSocket(host, port, token=token), timeout_s=timeout_s)
        self._numbers = itertools.count(1)
        self._answers: dict[str, asyncio.Future[Answer]] = {}
        self._waiters: set[asyncio.Future[Heartbeat]] = set()
        self._tasks: list[asyncio.Task[None]] = []
        self._welcomed = asyncio.Event()
        self.map = ClientMap()
        self.welcome: Welcome | None = None
        """What the drone said at the last connection."""
        self.heartbeat: Heartbeat | None = None
        """The last heartbeat."""
        self.log: list[LogEntry] = []
        """The drone's messages, oldest first."""
        self.trail: list[Point] = []
        """Where the drone flew."""
        self.fence_setup: FenceSetup | None = None
        """Which fence the next Arm puts in force."""

    @property
    def is_connected(self) -> bool:
        """Whether there is a connection now."""
        return self._socket.is_connected

    async def start(self) -> Welcome:
        """Connect and return what the drone says of itself. Raises ConnectionTimeout."""
        await self._socket.init()
        self._tasks = [
            asyncio.create_task(self._read(), name="drone-client-read"),
            asyncio.create_task(self._show_life(), name="drone-client-sign-of-life"),
        ]
        try:
            async with asyncio.timeout(ANSWER_TIMEOUT_S):
                await self._welcomed.wait()
        except TimeoutError:
            await self.close()
            raise LinkLostError("connected, but the other side does not speak as a drone does") from None
        assert self.welcome is not None  # noqa: S101 - narrows for the type checker
        return self.welcome

    async def close(self) -> None:
        """End the connection; control is given back by the lease only, so release it first."""
        tasks, self._tasks = self._tasks, []
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        await self._socket.close()

    # -- commands -----------------------------------------------------------------------------------------------------

    async def ask(self, command: Command, timeout_s: float = ANSWER_TIMEOUT_S) -> Answer:
        """Send one command and return the answer. Raises FailedToSend, or LinkLostError when none comes."""
        answer = await self._ask(command, timeout_s)
        if isinstance(answer, RouteAnswer):
            raise TypeError("a way is asked for by route()")
        return answer

    async def route(self, request: RouteRequest) -> RouteAnswer:
        """Ask for the way that an Autonomous Move would take. Raises as `ask`, and CommandRefusedError."""
        answer = await self._ask(request, ANSWER_TIMEOUT_S)
        if not isinstance(answer, RouteAnswer):
            raise CommandRefusedError(answer.reason if isinstance(answer, Ack) else "another answer came")
        return answer

    async def _ask(self, command: Command, timeout_s: float) -> Answer:
        number = f"c{next(self._numbers)}"
        answer: asyncio.Future[Answer] = asyncio.get_running_loop().create_future()
        self._answers[number] = answer
        try:
            async with asyncio.timeout(timeout_s):
                await self._socket.send_message(_numbered(command, number).model_dump_json(by_alias=True))
                return await answer
        except TimeoutError:
            raise LinkLostError(f"no answer to {type(command).__name__} within {timeout_s:g} s") from None
        finally:
            del self._answers[number]

    async def order(self, command: Command) -> None:
        """Send one command that must be taken. Raises CommandRefusedError with the drone's reason."""
        answer = await self.ask(command)
        if isinstance(answer, Ack) and not answer.accepted:
            raise CommandRefusedError(answer.reason)

    async def request_control(self) -> None:
        """Take control. Raises CommandRefusedError when someone else has it."""
        await self.order(Control(action="Request"))

    async def release_control(self) -> None:
        """Give control back. Raises CommandRefusedError when there was none to give."""
        await self.order(Control(action="Release"))

    # -- what the drone tells -----------------------------------------------------------------------------------------

    async def next_heartbeat(self, timeout_s: float) -> Heartbeat:
        """Wait for the next heartbeat. Raises LinkLostError after ``timeout_s`` real seconds."""
        waiter: asyncio.Future[Heartbeat] = asyncio.get_running_loop().create_future()
        self._waiters.add(waiter)
        try:
            async with asyncio.timeout(timeout_s):
                return await waiter
        except TimeoutError:
            raise LinkLostError(f"no heartbeat from the drone for {timeout_s:g} s") from None
        finally:
            self._waiters.discard(waiter)

    async def whole_map(self, timeout_s: float = 30.0) -> None:
        """Wait until nothing of the map is outstanding. Raises LinkLostError."""
        try:
            async with asyncio.timeout(timeout_s):
                await self.next_heartbeat(timeout_s)
                while self.map.backlog:
                    await self.next_heartbeat(timeout_s)
        except TimeoutError:
            raise LinkLostError(f"the map was not complete within {timeout_s:g} s") from None

    async def pictures(self) -> dict[TileKey, bytes]:
        """Fetch the mosaic (JPEG by tile). A picture that cannot be had is left out."""
        found = {}
        base = self._socket.socket
        timeout = aiohttp.ClientTimeout(total=PICTURE_TIMEOUT_S)
        for (row, column), version in sorted(self.map.mosaic.items()):
            address = f"{base.url}/api/mosaic/{row}/{column}.jpg?v={version}"
            try:
                async with base.session().get(address, timeout=timeout) as response:
                    if response.status == 200:
                        found[row, column] = await response.read()
            except (aiohttp.ClientError, TimeoutError) as error:
                LOG.warning("picture of tile %d/%d: %s", row, column, error)
        return found

    async def survey_map(self) -> SurveyMap | None:
        """Return the map for the exports; None while it has no place on Earth (the drone was never armed)."""
        await self.whole_map()
        if self.heartbeat is None or self.heartbeat.datum is None:
            return None
        latitude, longitude = self.heartbeat.datum
        return self.map.survey_map(GlobalPose(latitude, longitude, 0.0), await self.pictures())

    # -----------------------------------------------------------------------------------------------------------------

    async def _read(self) -> None:
        while True:
            text = await self._socket.get_message()
            try:
                message = _INCOMING.validate_json(text)
            except ValidationError:
                LOG.exception("a message of the drone is not understood: %.200s", text)
                continue
            self._take(message)

    def _take(self, message: Heartbeat | Answer | Welcome) -> None:
        if isinstance(message, Heartbeat):
            self._take_heartbeat(message)
        elif isinstance(message, Welcome):
            self.map.clear()
            self.log.clear()  # all that the drone remembers comes again, and a restarted one counts anew
            self.welcome = message
            self._welcomed.set()
        else:
            answer = self._answers.get(str(message.id))
            if answer is not None and not answer.done():
                answer.set_result(message)

    def _take_heartbeat(self, beat: Heartbeat) -> None:
        self.heartbeat = beat
        if beat.occupancy_map is not None:
            try:
                self.map.apply(beat.occupancy_map)
            except BadMapError:
                LOG.exception("the map is asked for again")
                self.map.clear()
                with contextlib.suppress(FailedToSend):
                    self._socket.post_message(MapResync().model_dump_json(by_alias=True))
        last = self.log[-1].number if self.log else -1
        self.log.extend(entry for entry in beat.messages if entry.number > last)
        del self.log[:-LOG_LIMIT]
        if beat.trail_start:
            self.trail.clear()
        self.trail.extend(beat.trail)
        self.fence_setup = beat.fence_setup or self.fence_setup
        for waiter in tuple(self._waiters):
            if not waiter.done():
                waiter.set_result(beat)

    async def _show_life(self) -> None:
        sign = OperatorHeartbeat().model_dump_json(by_alias=True)
        while True:
            if self._socket.is_connected:  # a sign of life is of now: none waits for the link
                with contextlib.suppress(FailedToSend):
                    self._socket.post_message(sign)
            speed = 1.0 if self.welcome is None else self.welcome.speed
            await asyncio.sleep(max(SHORTEST_SIGN_INTERVAL_S, SIGN_INTERVAL_S / speed))

    async def __aenter__(self) -> Self:
        await self.start()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        await self.close()


def _numbered(command: C, number: str) -> C:
    return command.model_copy(update={"id": number})

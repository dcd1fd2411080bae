"""Client for Python programs: commands, heartbeats, and an up-to-date copy of the drone's map."""

from __future__ import annotations

import asyncio
import base64
import binascii
import contextlib
import itertools
import logging
import ssl
import zlib
from collections.abc import Mapping
from http import HTTPStatus
from typing import Annotated, Any, Final, Self

import aiohttp
import numpy as np
from numpy.typing import NDArray
from pydantic import Field, TypeAdapter, ValidationError

from hawk.comm.base_socket import BaseSocket, FailedToSend
from hawk.comm.message_socket import AsyncMessageSocket
from hawk.comm.protocol.commands import (
    Ack,
    Answer,
    Command,
    MapResync,
    OperatorHeartbeat,
    Welcome,
)
from hawk.comm.protocol.heartbeat import (
    FenceSetup,
    Heartbeat,
    LogEntry,
    MapUpdate,
    OutlineSetup,
    Point,
    SectionUpdate,
    StallUpdate,
)
from hawk.model.lot_map import TILE_CELLS, Cell, Stall, StallState, TileKey
from hawk.model.poses import GlobalPose
from hawk.results.survey_map import SurveyMap

LOG = logging.getLogger(__name__)

ANSWER_TIMEOUT_S: Final = 5.0
"""Real seconds that an answer may take: a tick is 50 ms, the rest is the network."""
SIGN_INTERVAL_S: Final = 1.0
"""Seconds of the drone's clock between signs of life."""
SHORTEST_SIGN_INTERVAL_S: Final = 0.2
PICTURE_TIMEOUT_S: Final = 10.0
LOTS_AT_ONCE: Final = 1000
"""Lots of one answer: the most that the API gives."""
LOG_LIMIT: Final = 1000

_Incoming = Annotated[Heartbeat | Answer | Welcome, Field(discriminator="type")]
_INCOMING: TypeAdapter[Any] = TypeAdapter(_Incoming)


class CommandRefusedError(Exception):
    """The drone refused; the text is its reason."""


class LinkLostError(ConnectionError):
    """The drone was silent for too long."""


class DroneClient:
    """`start`, then commands and `next_heartbeat`, then `close`; or ``async with``. It reconnects by itself."""

    def __init__(
        self,
        host: str,
        port: int,
        *,
        token: str | None = None,
        timeout_s: float = 5.0,
        tls: ssl.SSLContext | None = None,
    ) -> None:
        """``token``: of the role operator, or viewer to watch only. ``tls``: certificates that are trusted (HTTPS)."""
        self._base = BaseSocket(host, port, token=token, tls=tls)
        self._socket = AsyncMessageSocket(self._base, timeout_s=timeout_s)
        self._numbers = itertools.count(1)
        self._answers: dict[str, asyncio.Future[Answer]] = {}
        self._waiters: set[asyncio.Future[Heartbeat]] = set()
        self._tasks: list[asyncio.Task[None]] = []
        self._welcomed = asyncio.Event()
        self.map = ClientMap()
        self.welcome: Welcome | None = None
        """The drone's first message of the last connection."""
        self.heartbeat: Heartbeat | None = None
        """The last heartbeat."""
        self.log: list[LogEntry] = []
        """The drone's messages, oldest first."""
        self.trail: list[Point] = []
        """Path flown."""
        self.fence_setup: FenceSetup | None = None
        """The fence that the next Arm puts in force."""
        self.outline_setup: OutlineSetup | None = None
        """The area that Explore is to survey."""
        self.sections: dict[str, SectionUpdate] = {}
        """Sections of the known lot that is flown over, by their ids."""
        self.is_hidden = False
        """Says with each sign of life that nobody sees this client, as a page does that is hidden."""

    @property
    def is_connected(self) -> bool:
        """True while connected."""
        return self._socket.is_connected

    async def start(self) -> Welcome:
        """Connect and return the drone's first message. Raises ConnectionTimeout, LinkLostError."""
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
        number = f"c{next(self._numbers)}"
        answer: asyncio.Future[Answer] = asyncio.get_running_loop().create_future()
        self._answers[number] = answer
        try:
            async with asyncio.timeout(timeout_s):
                await self._socket.send_message(
                    command.model_copy(update={"id": number}).model_dump_json(by_alias=True)
                )
                return await answer
        except TimeoutError:
            raise LinkLostError(f"no answer to {type(command).__name__} within {timeout_s:g} s") from None
        finally:
            del self._answers[number]

    async def order(self, command: Command) -> None:
        """Send one command that must be accepted. Raises CommandRefusedError with the drone's reason."""
        answer = await self.ask(command)
        if isinstance(answer, Ack) and not answer.accepted:
            raise CommandRefusedError(answer.reason)

    # -- from the drone ----------------------------------------------------------------------------------------------

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
        """Wait until the map is complete. Raises LinkLostError."""
        try:
            async with asyncio.timeout(timeout_s):
                await self.next_heartbeat(timeout_s)
                while self.map.backlog:
                    await self.next_heartbeat(timeout_s)
        except TimeoutError:
            raise LinkLostError(f"the map was not complete within {timeout_s:g} s") from None

    async def pictures(self) -> dict[TileKey, bytes]:
        """Fetch the mosaic (JPEG by tile). A picture that cannot be fetched is left out."""
        found = {}
        timeout = aiohttp.ClientTimeout(total=PICTURE_TIMEOUT_S)
        for (row, column), version in sorted(self.map.mosaic.items()):
            address = f"{self._base.url}/api/mosaic/{row}/{column}.jpg?v={version}"
            try:
                async with self._base.session().get(address, timeout=timeout) as response:
                    if response.status == 200:
                        found[row, column] = await response.read()
            except (aiohttp.ClientError, TimeoutError) as error:
                LOG.warning("picture of tile %d/%d: %s", row, column, error)
        return found

    async def lots(self) -> list[dict[str, Any]]:
        """Return the lots of the store, as ``/api/v1/lots`` has them.

        Raises:
            CommandRefusedError: They cannot be read; the text is the reason.
        """
        timeout = aiohttp.ClientTimeout(total=PICTURE_TIMEOUT_S)
        found: list[dict[str, Any]] = []
        after = ""
        try:
            while True:
                address = f"{self._base.url}/api/v1/lots?limit={LOTS_AT_ONCE}{after}"
                async with self._base.session().get(address, timeout=timeout) as response:
                    answer = await response.json(content_type=None)
                if response.status != HTTPStatus.OK:
                    raise CommandRefusedError(str(answer["detail"]))
                found += answer["items"]
                if answer["next"] is None:
                    return found
                after = f"&after={answer['next']}"
        except (aiohttp.ClientError, TimeoutError, ValueError, KeyError) as error:
            raise CommandRefusedError(str(error) or type(error).__name__) from error

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
            self.sections.clear()
            self.log.clear()  # the drone sends its whole log again, and a restarted drone numbers it from zero
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
        self.outline_setup = beat.outline_setup or self.outline_setup
        if beat.sections is not None:
            self.sections |= {each.id: each for each in beat.sections.changed}
            for gone in beat.sections.removed:
                self.sections.pop(gone, None)
        for waiter in tuple(self._waiters):
            if not waiter.done():
                waiter.set_result(beat)

    async def _show_life(self) -> None:
        while True:
            sign = OperatorHeartbeat(hidden=self.is_hidden).model_dump_json(by_alias=True)
            if self._socket.is_connected:  # a sign of life is never queued for a later link
                with contextlib.suppress(FailedToSend):
                    self._socket.post_message(sign)
            speed = 1.0 if self.welcome is None else self.welcome.speed
            await asyncio.sleep(max(SHORTEST_SIGN_INTERVAL_S, SIGN_INTERVAL_S / speed))

    async def __aenter__(self) -> Self:
        await self.start()
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.close()


class BadMapError(ValueError):
    """An update that cannot be applied; the remedy is to ask for the map again (Map Resync)."""


class ClientMap:
    """Tiles as (256, 256) arrays of `Cell`, stalls by id, versions of the mosaic's pictures."""

    def __init__(self) -> None:
        self.map_id: str | None = None
        self.backlog = 0
        """Changes that the drone has not sent yet."""
        self.tiles: dict[TileKey, NDArray[np.uint8]] = {}
        self.stalls: dict[int, Stall] = {}
        self.mosaic: dict[TileKey, int] = {}

    def clear(self) -> None:
        """Forget the map: the connection or the map is new."""
        self.map_id = None
        self.backlog = 0
        self.tiles.clear()
        self.stalls.clear()
        self.mosaic.clear()

    def apply(self, update: MapUpdate) -> None:
        """Apply one update. Raises BadMapError; the valid part before the error is kept."""
        if update.map_id != self.map_id:
            self.clear()
            self.map_id = update.map_id
        for tile in update.tiles:
            self.tiles[tile.row, tile.column] = _cells(tile.data)
        for stall in update.stalls:
            if stall.removed:
                self.stalls.pop(stall.id, None)
            else:
                self.stalls[stall.id] = _stall(stall)
        for picture in update.mosaic:
            self.mosaic[picture.row, picture.column] = picture.version
        self.backlog = update.backlog

    def survey_map(self, datum: GlobalPose, pictures: Mapping[TileKey, bytes]) -> SurveyMap:
        """Return the map for the exports, with the mosaic's pictures (JPEG)."""
        return SurveyMap(datum, dict(self.stalls), dict(self.tiles), dict(pictures), self.map_id or "")


def _cells(data: str) -> NDArray[np.uint8]:
    size = TILE_CELLS * TILE_CELLS
    try:
        inflater = zlib.decompressobj()
        raw = inflater.decompress(base64.b64decode(data, validate=True), size + 1)
    except (binascii.Error, zlib.error) as error:
        raise BadMapError(f"Tiles.Data: cannot be unpacked: {error}") from error
    if len(raw) != size:
        raise BadMapError(f"Tiles.Data: holds {len(raw)} cells, not {size}")
    cells = np.frombuffer(raw, np.uint8).reshape(TILE_CELLS, TILE_CELLS)
    if cells.max() > max(Cell):
        raise BadMapError(f"Tiles.Data: cell class {cells.max()} is not known")
    return cells


def _stall(update: StallUpdate) -> Stall:
    numbers = (update.north, update.east, update.angle, update.width, update.length)
    if update.state is None or any(number is None for number in numbers):
        raise BadMapError(f"Stalls: stall {update.id} is without place or state")
    north, east, angle, width, length = (float(number) for number in numbers if number is not None)
    return Stall(
        id=update.id,
        north=north,
        east=east,
        angle=angle,
        width=width,
        length=length,
        taken=0.5 if update.taken is None else update.taken,
        state=StallState(update.state),
        score=1.0 if update.score is None else update.score,
        seen=update.seen or 0,
        last_seen=update.last_seen or 0.0,
        version=update.version,
        label=update.label or "",
    )

"""A TCP proxy between drones and their desk: it lets pass, loses answers, or loses a share of all and is late."""

from __future__ import annotations

import asyncio
import contextlib
import random
from enum import StrEnum
from typing import Final

HOST: Final = "127.0.0.1"
LOST: Final = 0.3
"""Share of connections that end somewhere, while the link is bad."""
LATE_S: Final = 2.0
"""Delay of each direction while the link is bad."""
_CHUNK: Final = 16_384
_LONGEST_LIFE: Final = 20
"""Chunks after which a connection that is to end has ended."""


class LinkState(StrEnum):
    """State of a link."""

    GOOD = "good"
    NO_ANSWERS = "no answers"
    """The desk hears the drones, and no answer comes back."""
    BAD = "bad"


class Link:
    """``state`` may be changed at any time, also of open connections."""

    def __init__(self, port: int, rng: random.Random) -> None:
        """``port``: of the desk."""
        self.state = LinkState.GOOD
        self._port = port
        self._rng = rng
        self._server: asyncio.Server | None = None
        self._writers: set[asyncio.StreamWriter] = set()

    async def open(self) -> int:
        """Begin; return the port at which drones find the desk."""
        self._server = await asyncio.start_server(self._connected, HOST, 0)
        return int(self._server.sockets[0].getsockname()[1])

    def close(self) -> None:
        """End with all connections."""
        if self._server is not None:
            self._server.close()
        for writer in self._writers:
            writer.close()

    async def _connected(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        try:
            there, onward = await asyncio.open_connection(HOST, self._port)
        except OSError:  # the desk was killed
            writer.close()
            return
        self._writers |= {writer, onward}
        life = self._rng.randrange(_LONGEST_LIFE) if self._rng.random() < LOST else None
        try:
            async with asyncio.TaskGroup() as both:
                both.create_task(self._pass(reader, onward, life))
                both.create_task(self._pass(there, writer, life, is_answer=True))
        except* OSError:
            pass
        finally:
            for each in (writer, onward):
                each.close()
                self._writers.discard(each)

    async def _pass(
        self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, life: int | None, *, is_answer: bool = False
    ) -> None:
        chunks = 0
        while data := await reader.read(_CHUNK):
            if self.state is LinkState.BAD:
                await asyncio.sleep(LATE_S)
                if life is not None and chunks >= life:
                    raise ConnectionResetError
            if not (is_answer and self.state is LinkState.NO_ANSWERS):
                writer.write(data)
                await writer.drain()
            chunks += 1
        with contextlib.suppress(OSError):
            writer.write_eof()

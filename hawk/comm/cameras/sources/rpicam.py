"""Pictures of a camera on a Raspberry Pi's CSI connector, through ``rpicam-vid`` in a process of its own.

``rpicam-vid`` writes JPEG pictures to its standard output, and after each of them its metadata to a pipe (rpicam-apps,
``output/output.cpp``), as lines ``NAME=VALUE`` that an empty line ends. SensorTimestamp, nanoseconds, is the time at
which the picture's first row was exposed (libcamera's reference of controls): a picture is stamped by it.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import shutil
from collections.abc import AsyncGenerator, AsyncIterator, Callable
from dataclasses import dataclass, field
from typing import Final

from hawk.comm.cameras.sources.child import CHILD_TIMEOUTS, READ, Child, ChildTimeouts
from hawk.comm.cameras.sources.mjpeg import MAX_PART
from hawk.comm.cameras.sources.source import CameraError, CameraSource, SourceFrame
from hawk.comm.cameras.stamp_clock import captured_at
from hawk.config.addresses import RpicamCamera
from hawk.runtime.supervision import end_tasks

_START: Final = b"\xff\xd8"
_END: Final = b"\xff\xd9"
_SCAN: Final = 0xDA
_BARE: Final = frozenset((0x01, *range(0xD0, 0xD8)))
"""Markers without a length (ITU-T T.81, B.1.1.3)."""


@dataclass(frozen=True, slots=True)
class StreamPicture:
    """One whole JPEG. ``number`` counts all that began, the torn ones included, from 0."""

    body: bytes = field(repr=False)
    number: int


class JpegSplitter:
    """Feed it bytes, it returns whole pictures. One whose headers make no sense is dropped and counted in ``torn``."""

    def __init__(self, longest: int = MAX_PART) -> None:
        self._longest = longest
        self._buffer = bytearray()
        self._at = 0  # up to here the picture was read; 0: its start is not found yet
        self._in_scan = False
        self._begun = 0
        self.torn = 0

    def feed(self, data: bytes) -> list[StreamPicture]:
        """Return the pictures that these bytes complete."""
        self._buffer += data
        found: list[StreamPicture] = []
        while self._find_start() and self._read_headers():
            # in the scan an FF of the picture's own is followed by 00 or by a restart marker: FF D9 is the end
            end = self._buffer.find(_END, self._at)
            if end < 0:
                self._at = max(self._at, len(self._buffer) - 1)
                if len(self._buffer) <= self._longest:
                    break
                self._lose()
                continue
            end += len(_END)
            found.append(StreamPicture(bytes(self._buffer[:end]), self._begun - 1))
            self._forget(end)
        return found

    def _find_start(self) -> bool:
        if self._at:
            return True
        start = self._buffer.find(_START)
        if start < 0:
            del self._buffer[: max(0, len(self._buffer) - 1)]
            return False
        del self._buffer[:start]
        self._at, self._begun = len(_START), self._begun + 1
        return True

    def _read_headers(self) -> bool:
        """Step over the segments up to the scan; return False when more bytes are needed."""
        while not self._in_scan:
            if len(self._buffer) < self._at + 4:
                return False
            if self._buffer[self._at] != 0xFF:
                self._lose()
                if not self._find_start():
                    return False
                continue
            marker = self._buffer[self._at + 1]
            if marker in _BARE:
                self._at += 2
            elif marker == 0xFF:  # a fill byte
                self._at += 1
            else:
                self._at += 2 + int.from_bytes(self._buffer[self._at + 2 : self._at + 4], "big")
                self._in_scan = marker == _SCAN
        return True

    def _lose(self) -> None:
        self.torn += 1
        self._forget(len(_START))

    def _forget(self, size: int) -> None:
        del self._buffer[:size]
        self._at, self._in_scan = 0, False


PROGRAM: Final = "rpicam-vid"
_STAMP: Final = "SensorTimestamp"
_NANOSECONDS: Final = 1e-9
_REMEDY: Final = "install the package rpicam-apps-lite of Raspberry Pi OS"

Metadata = asyncio.Queue[float | None]
"""SensorTimestamp of each picture in order, seconds; None where it is missing."""


class RpicamSource(CameraSource):
    """``rpicam:NUMBER?OPTIONS``."""

    def __init__(
        self,
        camera: RpicamCamera,
        clock: Callable[[], float],
        program: str = PROGRAM,
        timeouts: ChildTimeouts = CHILD_TIMEOUTS,
    ) -> None:
        """``timeouts``: after these times without a picture the process is ended."""
        self._camera = camera
        self._clock = clock
        self._program = program
        self._timeouts = timeouts
        self._name = f"rpicam:{camera.number}"

    async def frames(self) -> AsyncGenerator[SourceFrame, None]:
        """Start ``rpicam-vid`` and give its pictures until it ends. Raises CameraError with its first error."""
        if shutil.which(self._program) is None:
            raise CameraError(f"{self._name}: needs {self._program}, which is not installed: {_REMEDY}")
        try:
            async with _metadata() as (descriptor, stamps, close_ours):
                command = (self._program, *rpicam_arguments(self._camera, f"/proc/self/fd/{descriptor}"))
                async with Child(command, self._timeouts, pass_fds=(descriptor,)) as child:
                    close_ours()
                    splitter, torn_before, taken = JpegSplitter(), self.torn, 0
                    while data := await child.read():
                        arrival = self._clock()
                        pictures = splitter.feed(data)
                        self.torn = torn_before + splitter.torn
                        for picture in pictures:
                            stamp = None
                            while taken <= picture.number:  # a torn picture has metadata, too
                                stamp = await child.within(stamps.get())
                                taken += 1
                            child.heard()
                            yield self._frame(picture.body, arrival, stamp)
                    said = await child.last_words()
        except CameraError as error:
            raise CameraError(f"{self._name}: {error}") from error
        raise CameraError(f"{self._name}: {said or f'{self._program} ended'}")

    def _frame(self, jpeg: bytes, arrival: float, stamp: float | None) -> SourceFrame:
        captured = None if stamp is None else captured_at(stamp, self._clock)
        return SourceFrame(jpeg, arrival, stamp, captured)


def rpicam_arguments(camera: RpicamCamera, metadata: str) -> list[str]:
    """Return the arguments of ``rpicam-vid``; ``metadata``: the path of the file for the metadata."""
    fixed = "--nopreview --timeout 0 --codec mjpeg --flush --output - --metadata-format txt --autofocus-mode manual"
    options = camera.model_dump(by_alias=True, exclude_none=True, exclude={"number"})  # they have rpicam-vid's names
    values = {"metadata": metadata, "camera": camera.number, **options}
    given = [word for name, value in values.items() for word in (f"--{name}", f"{value}")]
    return [*fixed.split(), *given]


@contextlib.asynccontextmanager
async def _metadata() -> AsyncIterator[tuple[int, Metadata, Callable[[], None]]]:
    """Give the descriptor that the child writes its metadata to, the stamps that come, and what closes our copy."""
    reading, writing = os.pipe()
    is_open = True

    def close_ours() -> None:
        nonlocal is_open
        if is_open:
            os.close(writing)
        is_open = False

    loop, reader, stamps = asyncio.get_running_loop(), asyncio.StreamReader(), Metadata()
    transport, _ = await loop.connect_read_pipe(
        lambda: asyncio.StreamReaderProtocol(reader), os.fdopen(reading, "rb", buffering=0)
    )
    listener = loop.create_task(_read_stamps(reader, stamps), name="camera-rpicam-metadata")
    try:
        yield writing, stamps, close_ours
    finally:
        close_ours()
        await end_tasks(listener)
        transport.close()


async def _read_stamps(reader: asyncio.StreamReader, stamps: Metadata) -> None:
    rest, stamp = b"", None
    while data := await reader.read(READ):
        *lines, rest = (rest + data).split(b"\n")
        for line in lines:
            name, equals, value = line.decode("utf-8", "replace").strip().partition("=")
            if not name:
                stamps.put_nowait(stamp)
                stamp = None
            elif equals and name == _STAMP and value.isdecimal():
                stamp = int(value) * _NANOSECONDS

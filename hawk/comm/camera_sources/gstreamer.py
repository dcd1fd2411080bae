"""Pictures from any GStreamer pipeline, through ``gst-launch-1.0`` in a process of its own.

PyPI's OpenCV has no GStreamer. The pipeline's pictures are encoded as JPEG, framed by ``multipartmux`` and read from
the process's standard output; they carry no stamp, so their time is arrival less the configured latency.
"""

from __future__ import annotations

import asyncio
import contextlib
import shlex
import shutil
from collections import deque
from collections.abc import AsyncGenerator, Callable

from hawk.comm.camera_sources.mjpeg import MultipartParser
from hawk.comm.camera_sources.source import CameraError, CameraSource, SourceFrame

_BOUNDARY = "hawk-gstreamer"
_TAIL = ("!", "videoconvert", "!", "jpegenc", "!", "multipartmux", f"boundary={_BOUNDARY}", "!", "fdsink", "fd=1")
_READ = 1 << 16
_END_S = 2.0
_PACKAGES = "install the Debian packages gstreamer1.0-tools and gstreamer1.0-plugins-good"


class GStreamerSource(CameraSource):
    """``gst:PIPELINE`` without its sink, for example ``v4l2src ! video/x-raw,width=1280,height=720``."""

    def __init__(self, pipeline: str, clock: Callable[[], float], program: str = "gst-launch-1.0") -> None:
        self._pipeline = pipeline.strip()
        self._clock = clock
        self._program = program

    async def frames(self) -> AsyncGenerator[SourceFrame, None]:
        """Start the pipeline and give its pictures until it ends. Raises CameraError with GStreamer's own words."""
        process = await self._start()
        words: deque[str] = deque(maxlen=5)
        errors = asyncio.create_task(_keep_words(process, words), name="camera-gstreamer-words")
        try:
            assert process.stdout is not None  # noqa: S101
            parser, torn_before = MultipartParser(_BOUNDARY.encode()), self.torn
            while data := await process.stdout.read(_READ):
                parts = parser.feed(data, self._clock())
                self.torn = torn_before + parser.torn
                for part in parts:
                    yield SourceFrame(part.body, part.arrival)
            await asyncio.wait_for(asyncio.shield(errors), _END_S)
        except TimeoutError:
            pass
        finally:
            await _end(process, errors)
        raise CameraError(f"gst:{self._pipeline}: {_reason(words)}")

    async def _start(self) -> asyncio.subprocess.Process:
        if shutil.which(self._program) is None:
            raise CameraError(f"gst: needs {self._program}, which is not installed: {_PACKAGES}")
        try:
            words = shlex.split(self._pipeline)
        except ValueError as error:
            raise CameraError(f"gst:{self._pipeline}: cannot be read: {error}") from error
        if not words:
            raise CameraError("gst: names no pipeline; write for example gst:v4l2src ! videoconvert")
        pipe = asyncio.subprocess.PIPE
        return await asyncio.create_subprocess_exec(
            self._program, "--quiet", *words, *_TAIL, stdin=asyncio.subprocess.DEVNULL, stdout=pipe, stderr=pipe
        )


async def _keep_words(process: asyncio.subprocess.Process, words: deque[str]) -> None:
    assert process.stderr is not None  # noqa: S101
    while line := await process.stderr.readline():
        words.append(line.decode("utf-8", "replace").strip())


async def _end(process: asyncio.subprocess.Process, errors: asyncio.Task[None]) -> None:
    if process.returncode is None:
        with contextlib.suppress(ProcessLookupError):
            process.terminate()
        try:
            await asyncio.wait_for(process.wait(), _END_S)
        except TimeoutError:
            with contextlib.suppress(ProcessLookupError):
                process.kill()
            await process.wait()
    errors.cancel()
    with contextlib.suppress(asyncio.CancelledError):
        await errors


def _reason(words: deque[str]) -> str:
    said = [line for line in words if line]
    errors = [line for line in said if "ERROR" in line or "WARNING" in line] or said
    if any("no element" in line for line in said):
        return f"{errors[0]} ({_PACKAGES})"
    return errors[0] if errors else "the pipeline ended"

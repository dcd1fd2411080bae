"""Pictures of network cameras and gimbals over RTSP, through ``gst-launch-1.0`` in a process of its own.

A camera that is switched off keeps its TCP connection silent for minutes; the process is ended after seconds without a
picture and started again. Pictures carry no time of capture: it is arrival less the configured latency.
"""

from __future__ import annotations

import shlex
import shutil
from collections.abc import AsyncGenerator, Callable, Sequence
from typing import Final

from hawk.comm.cameras.sources.child import CHILD_TIMEOUTS, Child, ChildTimeouts, Words
from hawk.comm.cameras.sources.mjpeg import MultipartParser
from hawk.comm.cameras.sources.source import CameraError, CameraSource, SourceFrame
from hawk.config.secrets import SecretUrl, without

PROGRAM: Final = "gst-launch-1.0"
_BOUNDARY: Final = "hawk-gstreamer"
_PACE: Final = ("!", "identity", "sync=true", "ts-offset=-200000000")
"""A source that is not live (a file, ``videotestsrc``) is played at its own rate in place of as fast as it can. A live
one is not slowed down: a picture passes up to 200 ms (here in nanoseconds) before its time is due."""
_TAIL: Final = f"! videoconvert ! jpegenc ! multipartmux boundary={_BOUNDARY} ! fdsink fd=1".split()
_GSTREAMER_PACKAGES: Final = "install the Debian packages gstreamer1.0-tools and gstreamer1.0-plugins-good"
_MISSING: Final = ("no element", "missing a plug-in")


class GStreamerSource(CameraSource):
    """``gst:PIPELINE`` without its sink, for example ``v4l2src ! video/x-raw,width=1280,height=720``."""

    def __init__(
        self,
        pipeline: str,
        clock: Callable[[], float],
        program: str = PROGRAM,
        timeouts: ChildTimeouts = CHILD_TIMEOUTS,
    ) -> None:
        """``timeouts``: after these times without a picture the process is ended."""
        self._pipeline = pipeline.strip()
        self._clock = clock
        self._program = program
        self._timeouts = timeouts
        self._packages = _GSTREAMER_PACKAGES
        self._address = SecretUrl(f"gst:{self._pipeline}")

    async def frames(self) -> AsyncGenerator[SourceFrame, None]:
        """Start the pipeline and give its pictures until it ends. Raises CameraError with GStreamer's first error."""
        if shutil.which(self._program) is None:
            raise CameraError(f"{self._address}: needs {self._program}, which is not installed: {self._packages}")
        command = (self._program, "--quiet", *self._elements(), *_TAIL)
        words = Words(lambda line: line.startswith("ERROR") or "erroneous pipeline" in line)
        try:
            async with Child(command, self._timeouts, words) as child:
                parser, torn_before = MultipartParser(_BOUNDARY.encode()), self.torn
                while data := await child.read():
                    parts = parser.feed(data, self._clock())
                    self.torn = torn_before + parser.torn
                    for part in parts:
                        child.heard()
                        yield SourceFrame(part.body, part.arrival)
                said = await child.last_words()
        except CameraError as error:
            raise CameraError(f"{self._address}: {self._hint(str(error))}") from error
        raise CameraError(f"{self._address}: {self._hint(said) if said else 'the pipeline ended'}")

    def _elements(self) -> Sequence[str]:
        """Return the pipeline up to its raw pictures, as words of ``gst-launch-1.0``. Raises CameraError."""
        try:
            words = shlex.split(self._pipeline)
        except ValueError as error:
            raise CameraError(f"{self._address}: cannot be read: {error}") from error
        if not words:
            raise CameraError("gst: names no pipeline; write for example gst:v4l2src ! videoconvert")
        return (*words, *_PACE)

    def _hint(self, said: str) -> str:
        said = without(said, self._address.secrets())
        return f"{said} ({self._packages})" if any(words in said for words in _MISSING) else said


_RTSP_PACKAGES: Final = (
    "install the Debian packages gstreamer1.0-tools, gstreamer1.0-plugins-good, gstreamer1.0-plugins-bad and "
    "gstreamer1.0-libav"
)
_NEWEST: Final = ("queue", "leaky=downstream", "max-size-buffers=1", "max-size-bytes=0", "max-size-time=0")
"""A slow encoder skips pictures in place of falling behind. ``videorate`` would limit their number, but fails an
assertion where a stream names no rate, as most RTSP streams do."""


class RtspSource(GStreamerSource):
    """``rtsp://USER:PASSWORD@HOST:PORT/PATH``, any codec that GStreamer decodes."""

    def __init__(
        self, url: str, clock: Callable[[], float], program: str = PROGRAM, timeouts: ChildTimeouts = CHILD_TIMEOUTS
    ) -> None:
        """``timeouts``: after these times without a picture the process is ended."""
        super().__init__("", clock, program, timeouts)
        self._url = url
        self._address = SecretUrl(url)
        self._packages = _RTSP_PACKAGES

    def _elements(self) -> Sequence[str]:
        """TCP: over a drone's radio a lost datagram breaks all pictures up to the next key frame."""
        quoted = self._url.replace("\\", "\\\\").replace('"', '\\"')
        source = ("rtspsrc", f'location="{quoted}"', "latency=0", "protocols=tcp", "!", "decodebin")
        return (*source, "!", *_NEWEST)

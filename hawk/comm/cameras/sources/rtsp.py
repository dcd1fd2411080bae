"""Pictures of network cameras and gimbals over RTSP, through ``gst-launch-1.0`` in a process of its own.

A camera that is switched off keeps its TCP connection silent for minutes; the process is ended after seconds without a
picture and started again. Pictures carry no time of capture: it is arrival less the configured latency.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final

from hawk.comm.cameras.sources.child import PATIENCE, Patience
from hawk.comm.cameras.sources.gstreamer import PROGRAM, GStreamerSource
from hawk.comm.cameras.sources.source import without_secrets

_PACKAGES: Final = (
    "install the Debian packages gstreamer1.0-tools, gstreamer1.0-plugins-good, gstreamer1.0-plugins-bad and "
    "gstreamer1.0-libav"
)
_NEWEST: Final = ("queue", "leaky=downstream", "max-size-buffers=1", "max-size-bytes=0", "max-size-time=0")
"""A slow encoder skips pictures in place of falling behind. ``videorate`` would limit their number, but fails an
assertion where a stream names no rate, as most RTSP streams do."""


class RtspSource(GStreamerSource):
    """``rtsp://USER:PASSWORD@HOST:PORT/PATH``, any codec that GStreamer decodes."""

    def __init__(
        self, url: str, clock: Callable[[], float], program: str = PROGRAM, patience: Patience = PATIENCE
    ) -> None:
        """``patience``: after these times without a picture the process is ended."""
        super().__init__("", clock, program, patience)
        self._url = url
        self._name = without_secrets(url)
        self._packages = _PACKAGES

    def _elements(self) -> Sequence[str]:
        """TCP: over a drone's radio a lost datagram breaks all pictures up to the next key frame."""
        quoted = self._url.replace("\\", "\\\\").replace('"', '\\"')
        source = ("rtspsrc", f'location="{quoted}"', "latency=0", "protocols=tcp", "!", "decodebin")
        return (*source, "!", *_NEWEST)

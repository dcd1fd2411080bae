"""Chooses the source that ``camera.url`` names."""

from __future__ import annotations

from hawk.comm.camera_sources.gstreamer import GStreamerSource
from hawk.comm.camera_sources.http_mjpeg import HttpMjpegSource
from hawk.comm.camera_sources.opencv import OpenCvSource
from hawk.comm.camera_sources.source import CameraSource
from hawk.comm.clock import Clock
from hawk.config import CAMERA_KINDS, CameraSettings, ConfigError


def make_source(settings: CameraSettings, clock: Clock) -> CameraSource:
    """Return the source for ``settings.url``. Raises ConfigError naming the kinds that there are."""
    url = settings.url
    if url.startswith(("http://", "https://")):
        return HttpMjpegSource(url, clock)
    if url.startswith("gst:"):
        return GStreamerSource(url.removeprefix("gst:"), clock)
    if url.startswith(("v4l2://", "rtsp://", "rtsps://", "file://")):
        return OpenCvSource(url, clock)
    raise ConfigError(f"camera.url: {url!r} is no source of pictures: it must start with {', '.join(CAMERA_KINDS)}")

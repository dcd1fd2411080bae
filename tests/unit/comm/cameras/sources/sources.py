"""Pictures of a camera's source."""

from __future__ import annotations

import asyncio
import shutil
from contextlib import aclosing

import pytest

from hawk.comm.cameras.sources.source import CameraSource, SourceFrame

needs_gstreamer = pytest.mark.skipif(
    shutil.which("gst-launch-1.0") is None, reason="needs the Debian package gstreamer1.0-tools"
)


async def first_frames(source: CameraSource, count: int, within_s: float = 20.0) -> list[SourceFrame]:
    """Return the first ``count`` pictures, and end their stream."""
    found: list[SourceFrame] = []
    async with asyncio.timeout(within_s), aclosing(source.frames()) as frames:
        async for frame in frames:
            found.append(frame)
            if len(found) == count:
                break
    return found

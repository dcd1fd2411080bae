"""What the server counts of its own work, for ``/metrics``."""

from __future__ import annotations

from dataclasses import dataclass

from aiohttp import web


@dataclass(slots=True)
class Counters:
    """Rising counts, and the age of the last video frame when it was handed out (seconds of the daemon's clock)."""

    heartbeats: int = 0
    heartbeats_failed: int = 0
    video_frames: int = 0
    video_clients: int = 0
    frame_latency_s: float | None = None


COUNTERS = web.AppKey("counters", Counters)

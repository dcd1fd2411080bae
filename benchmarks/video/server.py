"""The server under test, a process of its own: hawk's real web server with a made-up camera.

``python -m benchmarks.video.server PICTURES FPS`` says ``ready PORT``, and serves until its standard input ends.
"""

from __future__ import annotations

import asyncio
import os
import sys
import time
from collections.abc import Sequence
from itertools import count
from pathlib import Path

from benchmarks.video.pictures import read, stamped
from hawk.comm.clock import Clock
from hawk.comm.protocol.heartbeat import DroneStatus
from hawk.comm.topic import Topic
from hawk.config.sections import OperatorSettings, WebSettings
from hawk.model.lot_map import OccupancyMap
from hawk.model.pictures import AnnotatedFrame
from hawk.runtime.performance import LagSummary
from hawk.web.app import WebServer
from hawk.web.services import OperatorSide, WebServices

STATUS_S = 0.2
"""Heartbeats go out at 5 Hz, as a daemon's do."""


async def serve(pictures: Sequence[bytes], fps: float) -> None:
    """Serve until standard input ends."""
    clock = Clock()
    side = OperatorSide.create(clock, OperatorSettings())
    status: Topic[DroneStatus] = Topic("status", clock)
    video: Topic[AnnotatedFrame] = Topic("video", clock)
    occupancy: Topic[OccupancyMap] = Topic("map", clock)
    services = WebServices(
        clock=clock, web=WebSettings(port=0), operator=OperatorSettings(), side=side, status=status,
        occupancy_map=occupancy, video=video, version="benchmark", simulation=True, camera_fov_deg=70.0,
        loop_lag=lambda: LagSummary(0, 0, 0, 0),
    )  # fmt: skip
    server = WebServer(services)
    await server.start()
    works = [
        asyncio.create_task(_film(pictures, fps, video), name="camera"),
        asyncio.create_task(_report(status), name="status"),
    ]
    print(f"ready {server.port}", flush=True)
    ended = asyncio.Event()
    loop = asyncio.get_running_loop()

    def look() -> None:
        if not os.read(0, 1024):
            ended.set()

    loop.add_reader(0, look)
    await ended.wait()
    loop.remove_reader(0)
    for work in works:
        work.cancel()
    await asyncio.gather(*works, return_exceptions=True)
    await server.close()


async def _film(pictures: Sequence[bytes], fps: float, video: Topic[AnnotatedFrame]) -> None:
    loop = asyncio.get_running_loop()
    begun = loop.time()
    for number in count(1):
        await asyncio.sleep(begun + number / fps - loop.time())
        now_ns = time.monotonic_ns()
        video.publish(AnnotatedFrame(number, now_ns / 1e9, stamped(pictures[number % len(pictures)], now_ns)))


async def _report(status: Topic[DroneStatus]) -> None:
    while True:
        status.publish(DroneStatus())
        await asyncio.sleep(STATUS_S)


if __name__ == "__main__":
    asyncio.run(serve(read(Path(sys.argv[1])), float(sys.argv[2])))

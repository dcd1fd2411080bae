"""A client behind a slow link receives fresh pictures, or none; never old ones."""

from __future__ import annotations

import asyncio
import json
import struct
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import cv2
import numpy as np
import pytest

from hawk.model.pictures import AnnotatedFrame
from hawk.web.video.viewers import STEPS, FrameShrinker
from tests.unit.web.rig import Rig, browser
from tests.unit.web.video.slow_link import slow_link

BYTES_PER_S = 60_000.0
OLD_S = 2.0
"""Age at which the page marks a picture."""
WATCHED_S = 6.0


def picture() -> bytes:
    """A picture with as many details as a lot from above: some 200 kB."""
    noise = np.random.default_rng(1).integers(0, 255, (270, 480, 3), dtype=np.uint8)
    encoded, data = cv2.imencode(".jpg", cv2.resize(noise, (960, 540)), [cv2.IMWRITE_JPEG_QUALITY, 80])
    assert encoded
    assert len(data) > 2 * BYTES_PER_S, "a whole picture takes longer than it is fresh"
    return bytes(data)


@asynccontextmanager
async def camera(rig: Rig) -> AsyncIterator[None]:
    """Publish ten pictures a second, stamped by real time."""
    jpeg = picture()

    async def publish() -> None:
        number = 0
        while True:
            number += 1
            rig.video.publish(AnnotatedFrame(number, time.monotonic(), jpeg))
            await asyncio.sleep(0.1)

    task = asyncio.create_task(publish())
    try:
        yield
    finally:
        task.cancel()


@pytest.mark.fault("a link of 60 kB/s and pictures of 290 kB", "every picture of /video younger than 2 s")
@pytest.mark.slow
async def test_a_slow_link_receives_fresh_pictures_over_the_web_socket(rig: Rig) -> None:
    server = await rig.start()
    ages: list[float] = []
    async with (
        camera(rig),
        slow_link(server.port, BYTES_PER_S) as port,
        browser() as session,
        session.ws_connect(f"http://127.0.0.1:{port}/video") as socket,
    ):
        end = time.monotonic() + WATCHED_S
        while time.monotonic() < end:
            async with asyncio.timeout(30):
                data = await socket.receive_bytes()
            _, sequence, captured, _ = struct.unpack("<4sIdI", data[:20])
            ages.append(time.monotonic() - captured)
            await socket.send_str(json.dumps({"ack": sequence}))
    assert len(ages) >= 5
    assert max(ages) < OLD_S, ages


@pytest.mark.fault(
    "a link of 60 kB/s and pictures of 290 kB, a reader of /stream.mjpg",
    "every picture after the first younger than 2 s",
)
@pytest.mark.slow
async def test_a_slow_link_receives_fresh_pictures_over_the_stream(rig: Rig) -> None:
    server = await rig.start()
    ages: list[float] = []
    async with camera(rig), slow_link(server.port, BYTES_PER_S) as port:
        reader, writer = await asyncio.open_connection("127.0.0.1", port, limit=4 * 1024)
        writer.write(b"GET /stream.mjpg HTTP/1.0\r\nHost: 127.0.0.1\r\n\r\n")
        await reader.readuntil(b"\r\n\r\n")
        end = time.monotonic() + WATCHED_S
        while time.monotonic() < end:
            async with asyncio.timeout(30):
                head = (await reader.readuntil(b"\r\n\r\n")).decode("ascii")
                values = dict(line.split(": ", 1) for line in head.splitlines() if ": " in line)
                await reader.readexactly(int(values["Content-Length"]))
            ages.append(time.monotonic() - float(values["X-Timestamp"]))
        writer.close()
    assert len(ages) >= 5
    assert max(ages[1:]) < OLD_S, ages  # the first shows how slow the link is


@pytest.mark.slow
async def test_a_quick_link_receives_whole_pictures_after_the_first(rig: Rig) -> None:
    server = await rig.start()
    sizes: list[int] = []
    async with camera(rig), browser() as session, session.ws_connect(server.make_url("/video")) as socket:
        while len(sizes) < 4:
            async with asyncio.timeout(10):
                data = await socket.receive_bytes()
            sizes.append(len(data) - 20)
            await socket.send_str(json.dumps({"ack": struct.unpack("<4sIdI", data[:20])[1]}))
    assert sizes[0] < len(picture()) / 4
    assert sizes[-1] == len(picture())


def test_a_small_picture_is_the_same_moment_and_a_damaged_one_stays_as_it_is() -> None:
    frame = AnnotatedFrame(3, 1.5, picture())
    shrink = FrameShrinker().make
    small = shrink(frame, STEPS)
    assert (small.sequence, small.captured) == (3, 1.5)
    assert len(small.jpeg) < len(frame.jpeg) / 4
    assert shrink(small, STEPS) is small
    broken = AnnotatedFrame(3, 1.5, b"\xff\xd8\xff\xd9")
    assert shrink(broken, STEPS) is broken

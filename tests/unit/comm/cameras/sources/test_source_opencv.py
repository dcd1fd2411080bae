from __future__ import annotations

import asyncio
import socket
import threading
from contextlib import aclosing
from pathlib import Path

import cv2
import numpy as np
import pytest

from hawk.comm.cameras.sources.source import CameraError, OpenCvSource, SourceFrame
from hawk.formats.image import decode
from tests.manual_clock import ManualClock


@pytest.fixture
def video(tmp_path: Path) -> str:
    """A film of five pictures, 100 a second, each lighter than the one before."""
    path = tmp_path / "a film.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 100.0, (64, 48))
    assert writer.isOpened()
    for index in range(5):
        writer.write(np.full((48, 64, 3), 40 * index + 20, np.uint8))
    writer.release()
    return path.as_uri()


async def read_all(source: OpenCvSource, into: list[SourceFrame]) -> None:
    async with asyncio.timeout(10), aclosing(source.frames()) as frames:
        async for frame in frames:
            into.append(frame)  # noqa: PERF401 - what came before an error counts


def camera_threads() -> list[str]:
    return [thread.name for thread in threading.enumerate() if thread.name == "camera-source"]


async def test_a_film_is_played_to_its_end_and_says_so(video: str) -> None:
    source = OpenCvSource(video, ManualClock(3.0))
    found: list[SourceFrame] = []
    with pytest.raises(CameraError, match="the file has ended"):
        await read_all(source, found)
    await source.close()
    assert 1 <= len(found) <= 5
    assert all(frame.arrival == 3.0 and frame.stamp is None for frame in found)
    greys = [float(decode(frame.jpeg).mean()) for frame in found]
    assert greys == sorted(greys)
    assert source.torn == 0


async def test_it_may_be_opened_again(video: str) -> None:
    source = OpenCvSource(video, ManualClock())
    for _ in range(2):
        async with asyncio.timeout(10), aclosing(source.frames()) as frames:
            async for frame in frames:
                assert decode(frame.jpeg).shape == (48, 64, 3)
                break
    await source.close()
    assert camera_threads() == []


async def test_what_cannot_be_opened_is_an_error_with_its_name() -> None:
    source = OpenCvSource("file:///there/is/no.mp4", ManualClock())
    with pytest.raises(CameraError, match=r"^file:///there/is/no.mp4: there is no such file$"):
        await read_all(source, [])
    await source.close()


async def test_a_file_that_is_no_film_is_an_error(tmp_path: Path) -> None:
    path = tmp_path / "text.mp4"
    path.write_text("no film")
    source = OpenCvSource(path.as_uri(), ManualClock())
    with pytest.raises(CameraError, match="cannot be opened"):
        await read_all(source, [])
    await source.close()


async def test_closing_before_anything_was_opened_does_nothing() -> None:
    await OpenCvSource("file:///there/is/no.mp4", ManualClock()).close()


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("film.m3u8", "#EXTM3U\n#EXT-X-TARGETDURATION:5\n#EXTINF:5,\nhttp://127.0.0.1:{port}/a.ts\n#EXT-X-ENDLIST\n"),
        ("film.ffconcat", "ffconcat version 1.0\nfile 'http://127.0.0.1:{port}/a.ts'\n"),
    ],
)
async def test_a_film_that_names_an_address_opens_none(tmp_path: Path, name: str, text: str) -> None:
    """OpenCV's FFmpeg has an OpenSSL that nobody mends: nothing of a network may reach it (docs/threat-model.md)."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        path = tmp_path / name
        path.write_text(text.format(port=server.getsockname()[1]))
        source = OpenCvSource(path.as_uri(), ManualClock())
        with pytest.raises(CameraError, match="cannot be opened"):
            await read_all(source, [])
        await source.close()
        server.settimeout(0)
        with pytest.raises(BlockingIOError):
            server.accept()

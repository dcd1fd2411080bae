from __future__ import annotations

import asyncio
import ssl
import threading
import time
from collections.abc import AsyncIterator, Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TypeVar

import numpy as np
import pytest
from numpy.typing import NDArray

from hawk.formats.image import NoImage
from hawk.specification.operator_camera import OperatorCamera
from tests.manual_clock import ManualClock
from tests.unit.comm.cameras.pictures import StreamServer, forever, once, part, picture
from tests.unit.web.access.certificates import make_pair

T = TypeVar("T")
DARK, LIGHT = picture(32, 24, 20), picture(32, 24, 220)


@pytest.fixture
async def blocking() -> AsyncIterator[ThreadPoolExecutor]:
    """Runs the camera's synchronous calls beside the test's server."""
    executor = ThreadPoolExecutor(1)
    yield executor
    executor.shutdown()


async def call(executor: ThreadPoolExecutor, function: Callable[[], T]) -> T:
    return await asyncio.get_running_loop().run_in_executor(executor, function)


def wait_image(camera: OperatorCamera) -> NDArray[np.uint8]:
    """Poll as the specification's user interface does."""
    end = time.monotonic() + 5.0
    while True:
        try:
            return camera.get_image()
        except NoImage:
            if time.monotonic() > end:
                raise
        time.sleep(0.005)


async def serve(server: StreamServer) -> tuple[str, int]:
    await server.start()
    assert server.server.port is not None
    return "127.0.0.1", server.server.port


async def test_pictures_of_the_daemon_are_given_as_bgr(blocking: ThreadPoolExecutor) -> None:
    server = StreamServer(forever(part(LIGHT)))
    camera = OperatorCamera(*await serve(server))
    camera.init()
    camera.init()
    image = await call(blocking, lambda: wait_image(camera))
    assert image.shape == (24, 32, 3)
    assert abs(int(image.mean()) - 220) < 3
    assert (await call(blocking, camera.get_image)).shape == (24, 32, 3)
    await call(blocking, camera.close)
    await server.close()
    assert "operator-camera" not in [thread.name for thread in threading.enumerate()]


@pytest.mark.fault("the daemon serves HTTPS", "Operator Camera and Message Socket speak it, by a trusted certificate")
async def test_pictures_come_by_https_from_a_certificate_that_is_trusted(
    tmp_path: Path, blocking: ThreadPoolExecutor
) -> None:
    pair = make_pair(tmp_path)
    certified = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    certified.load_cert_chain(pair.certificate, pair.key)
    server = StreamServer(forever(part(LIGHT)))
    server.server.scheme = "https"
    await server.start(certified)
    port = server.server.port
    assert port is not None
    camera = OperatorCamera("localhost", port, tls=ssl.create_default_context(cafile=str(pair.certificate)))
    camera.init()
    image = await call(blocking, lambda: wait_image(camera))
    assert image.shape == (24, 32, 3)
    await call(blocking, camera.close)
    await server.close()


async def test_a_picture_older_than_three_seconds_is_none(blocking: ThreadPoolExecutor) -> None:
    server, clock = StreamServer(forever(part(LIGHT))), ManualClock(100.0)
    camera = OperatorCamera(*await serve(server), clock=clock)
    camera.init()
    await call(blocking, lambda: wait_image(camera))
    await call(blocking, camera.close)
    await server.close()
    clock.advance(2.9)
    assert camera.get_image().shape == (24, 32, 3)
    clock.advance(0.2)
    with pytest.raises(NoImage, match="the picture is too old"):
        camera.get_image()


async def test_before_a_picture_comes_there_is_none(unused_tcp_port: int, blocking: ThreadPoolExecutor) -> None:
    camera = OperatorCamera("127.0.0.1", unused_tcp_port, reconnect_s=0.01)
    with pytest.raises(NoImage, match="no picture yet"):
        camera.get_image()
    camera.init()
    with pytest.raises(NoImage, match=r"stream\.mjpg"):
        await call(blocking, camera.get_image)
    await call(blocking, camera.close)


async def test_the_token_goes_along_as_a_header_not_in_the_address(blocking: ThreadPoolExecutor) -> None:
    server = StreamServer(forever(part(LIGHT)))
    camera = OperatorCamera(*await serve(server), token="sixteen letters!")
    camera.init()
    await call(blocking, lambda: wait_image(camera))
    await call(blocking, camera.close)
    await server.close()
    assert server.requests[0].headers["Authorization"] == "Bearer sixteen letters!"
    assert server.requests[0].path_qs == "/stream.mjpg"


async def test_a_stream_that_breaks_is_connected_again(blocking: ThreadPoolExecutor) -> None:
    server = StreamServer(once(part(DARK)))
    camera = OperatorCamera(*await serve(server), reconnect_s=0.01)
    camera.init()
    await call(blocking, lambda: wait_image(camera))
    server.writer = forever(part(LIGHT))

    def until_light() -> None:
        while wait_image(camera).mean() < 100:
            pass

    await call(blocking, until_light)
    await call(blocking, camera.close)
    await server.close()
    assert len(server.requests) >= 2


async def test_a_refusal_is_reported(blocking: ThreadPoolExecutor) -> None:
    server = StreamServer(forever(part(LIGHT)))
    server.status = 401
    camera = OperatorCamera(*await serve(server), reconnect_s=0.01)
    camera.init()

    def wait_for_words() -> str:
        words = ""
        while "answers 401" not in words:
            with pytest.raises(NoImage) as caught:
                camera.get_image()
            words = str(caught.value)
        return words

    assert "answers 401 Unauthorized" in await call(blocking, wait_for_words)
    await call(blocking, camera.close)
    await server.close()


def test_it_can_be_closed_before_it_was_started_and_twice() -> None:
    camera = OperatorCamera("127.0.0.1", 3000)
    camera.close()
    camera.init()
    camera.close()
    camera.close()


@pytest.mark.parametrize("port", [0, -1, 70_000])
def test_a_port_that_is_none_is_an_error(port: int) -> None:
    with pytest.raises(ValueError, match="port must be 1 to 65535"):
        OperatorCamera("127.0.0.1", port)

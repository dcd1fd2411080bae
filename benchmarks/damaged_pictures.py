"""Lost bytes in JPEG: the share that the reader notices, its false alarms, and its time beside OpenCV's.

``python -m benchmarks.damaged_pictures``. Pictures of drawn lots, 1280 x 960, JPEG of quality 85, on one core.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable

import cv2
import numpy as np
import simplejpeg
from numpy.typing import NDArray

from hawk.formats.image import DamagedImage, NoImage, decode
from hawk.model.pictures import CameraModel
from hawk.worlds.camera import WorldCamera
from hawk.worlds.generate import generate_world

WIDTH, HEIGHT = 1280, 960
LOSSES = (1, 2, 4, 16, 64, 188, 512, 1460, 3000)
TRIES = 120
SOUND = 240


def pictures(count: int, rng: np.random.Generator) -> list[NDArray[np.uint8]]:
    """Return pictures over three drawn lots, half of them with rows and kerbs along the picture's lines."""
    found = []
    model = CameraModel(WIDTH, HEIGHT, 900, 900, (WIDTH - 1) / 2, (HEIGHT - 1) / 2)
    for seed in (5, 9, 11):
        world = generate_world(seed)
        camera = WorldCamera(world, model)
        for k in range(count // 3):
            x, y = rng.uniform(0.1, 0.9, 2) * world.size_m
            yaw = rng.uniform(0, 2 * math.pi) if k % 2 else 0.5 * math.pi * (k % 4)
            roll, pitch = rng.normal(0, 0.03, 2)
            found.append(camera.render(x, y, float(rng.uniform(15, 60)), roll, pitch, yaw, rng=rng))
    return found


def encoded(picture: NDArray[np.uint8], restarts: int = 0) -> bytes:
    """Return a picture as JPEG of quality 85, with a restart marker after N MCUs."""
    options = [cv2.IMWRITE_JPEG_QUALITY, 85, cv2.IMWRITE_JPEG_RST_INTERVAL, restarts]
    return bytes(cv2.imencode(".jpg", picture, options)[1].tobytes())


def noticed(jpegs: list[bytes], count: int, rng: np.random.Generator) -> float:
    """Return the share of losses of N bytes that are noticed."""
    found = 0
    for k in range(TRIES):
        data = jpegs[k % len(jpegs)]
        at = int(rng.integers(data.rindex(b"\xff\xda") + 14, len(data) - 2 - count))
        try:
            decode(data[:at] + data[at + count :])
        except NoImage:
            found += 1
    return found / TRIES


def milliseconds(work: Callable[[], object]) -> float:
    """Return the median time of 60 calls."""
    times = []
    for _ in range(60):
        started = time.perf_counter()
        work()
        times.append((time.perf_counter() - started) * 1e3)
    return float(np.median(times))


def main() -> int:
    """Print the three."""
    cv2.setNumThreads(1)
    rng = np.random.default_rng(1)
    drawn = pictures(SOUND, rng)
    false = 0
    for picture in drawn:
        try:
            decode(encoded(picture))
        except DamagedImage as error:
            false += 1
            print(f"false alarm: {error}")
    print(f"{false} of {len(drawn)} sound pictures were called damaged")
    for name, restarts in (("without restart markers", 0), ("a restart marker in each row of blocks", WIDTH // 16)):
        jpegs = [encoded(picture, restarts) for picture in drawn[:8]]
        shares = [f"{count} B {noticed(jpegs, count, rng):.0%}" for count in LOSSES]
        print(f"noticed, {name}: {', '.join(shares)}")
    data = encoded(drawn[0])
    array = np.frombuffer(data, np.uint8)
    by_opencv = milliseconds(lambda: cv2.imdecode(array, cv2.IMREAD_COLOR))
    by_decoder = milliseconds(lambda: simplejpeg.decode_jpeg(data, "BGR"))
    print(
        f"{len(data) // 1000} kB: OpenCV {by_opencv:.1f} ms, simplejpeg {by_decoder:.1f} ms, "
        f"hawk.formats.image.decode {milliseconds(lambda: decode(data)):.1f} ms"
    )
    return 0


if __name__ == "__main__":
    raise SystemExit(main())

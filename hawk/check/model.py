"""Check of the network that looks for stalls: it loads, it answers, and it is fast enough for the flight."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.vision.network import NetworkMaps, StallNetwork, VisionModelError
from hawk.algo.vision.rectify import GROUND_M, MAXIMUM_PIXELS
from hawk.check.result import CheckResult, failed, passed, warning
from hawk.config.sections import Config, VisionSettings

LEAST_HZ: Final = 3.0
"""At fewer frames a second the drone must fly slower than its travel speed, or the map has holes."""
_ROUNDS: Final = 3
_LEAST_SIDE: Final = 64
_NAME: Final = "Model"

Run = Callable[[NDArray[np.uint8]], NetworkMaps]


def load_network(settings: VisionSettings) -> StallNetwork:
    """Return the network of the settings. Raises VisionModelError."""
    return StallNetwork.load(settings.model, settings.engine, settings.threads)


def look_at_model(
    config: Config,
    load: Callable[[Config], Run] = lambda config: load_network(config.vision).run,
    monotonic: Callable[[], float] = time.perf_counter,
) -> CheckResult:
    """Load the network, run it on a picture as large as the flight's, and judge its time. Blocks for some seconds."""
    cv2.setNumThreads(config.vision.threads)
    try:
        run = load(config)
        milliseconds = _time(run, ground_size(config), monotonic)
    except VisionModelError as error:
        remedy = "Name a fitting ONNX file in vision.model and an engine that is installed, or leave both out."
        return failed(_NAME, f"{error}.", remedy)
    width, height = ground_size(config)
    rate = 1000 / max(milliseconds, 1e-3)
    found = f"{milliseconds:.0f} ms for a frame of {width} x {height} at {config.heights.desired_m:g} m"
    words = f"{found}: {rate:.1f} frames a second at most."
    if rate >= LEAST_HZ:
        return passed(_NAME, words)
    remedy = (
        "Free the processor, raise vision.threads, set vision.engine to onnxruntime where it is installed, fly lower "
        "or slower, or use a faster computer."
    )
    return warning(_NAME, f"{words[:-1]}, {LEAST_HZ:g} are needed.", remedy)


def ground_size(config: Config) -> tuple[int, int]:
    """Return (width, height) in pixels of the rectified picture that a 16:9 camera gives at the desired height."""
    metres = 2 * config.heights.desired_m * math.tan(math.radians(config.camera.horizontal_fov_deg) / 2)
    width, height = metres / GROUND_M, metres / GROUND_M * 9 / 16
    shrink = min(1.0, MAXIMUM_PIXELS[0] / width, MAXIMUM_PIXELS[1] / height)
    return max(_LEAST_SIDE, round(width * shrink)), max(_LEAST_SIDE, round(height * shrink))


def _time(run: Run, size: tuple[int, int], monotonic: Callable[[], float]) -> float:
    """Return the least time of some runs, milliseconds: the first one allocates."""
    picture = np.random.default_rng(1).integers(0, 255, (size[1], size[0], 3), np.uint8)
    spent = []
    for _ in range(_ROUNDS):
        begun = monotonic()
        run(picture)
        spent.append(monotonic() - begun)
    return min(spent) * 1000

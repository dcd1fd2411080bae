"""Pace of tests: how fast flights are simulated here, and how long a test waits for what must come."""

from __future__ import annotations

import functools
import time
from typing import Final

import cv2
import numpy as np

from hawk.algo.vision.network import StallNetwork

PATIENCE_S: Final = 90.0
"""A test waits so long for what must come, real seconds: on a busy computer it comes late. Where
quickness itself is asked for, a test judges it by an event or by the drone's own time."""
FAST_S: Final = 0.045
"""The network takes no longer for a frame where simulator, daemon and browser share two cores at three times the real
speed, seconds of one core. On a core of 0.11 s pictures come late at that speed, and the planner waits in vain."""
_FRAME: Final = (400, 704, 3)
"""A frame of a flight at 35 m as the network sees it, at 0.1 m a pixel."""
_RUNS: Final = 4


def speed_here(wanted: float) -> float:
    """Return the speed at which a flight with vision is simulated: ``wanted``, or what this computer can do."""
    return max(1.0, round(wanted * min(1.0, FAST_S / _network_s()), 1))


@functools.cache
def _network_s() -> float:
    """Return the processor time of one thread that the network takes for a frame, seconds, the least of some runs."""
    before = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        network = StallNetwork.load(None)
        frame = np.full(_FRAME, 120, np.uint8)
        return min(_seconds(network, frame) for _ in range(_RUNS))
    finally:
        cv2.setNumThreads(before)


def _seconds(network: StallNetwork, frame: np.ndarray) -> float:
    began = time.thread_time()
    network.run(frame)
    return time.thread_time() - began

"""Time stamps of Linux's camera drivers on the daemon's clock.

V4L2 stamps buffers by CLOCK_MONOTONIC (kernel documentation, "Buffers", V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC).
libcamera's reference says CLOCK_BOOTTIME of SensorTimestamp, and on a Raspberry Pi it passes the V4L2 stamp on. Both
clocks differ by the time that the computer slept. The clock is taken by which the picture is just a moment old.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Final

_CLOCKS: Final = (time.CLOCK_MONOTONIC, time.CLOCK_BOOTTIME, time.CLOCK_REALTIME)
"""CLOCK_REALTIME: the driver of USB cameras stamps by it when its parameter ``clock`` says so."""
_LONGEST_S: Final = 2.0
"""An older picture is not from this camera's present stream."""
_AHEAD_S: Final = 0.005
"""Rounding of a stamp may lead it so far ahead of its reading."""


def captured_at(
    stamp_s: float, clock: Callable[[], float], kernel: Callable[[int], float] = time.clock_gettime
) -> float | None:
    """Return the daemon's time of a stamp (seconds of a clock of the kernel); None when it is of none of its clocks."""
    for each in _CLOCKS:
        age = kernel(each) - stamp_s
        if -_AHEAD_S <= age <= _LONGEST_S:
            return clock() - max(age, 0.0)
    return None

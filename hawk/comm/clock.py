"""The daemon's one clock, and how the clocks of autopilot and camera map onto it."""

from __future__ import annotations

import time
from collections.abc import Callable


class Clock:
    """Seconds from zero on, ``speed`` times as fast as real ones (`--sim --speed N`; 1 in real flight)."""

    def __init__(self, speed: float = 1.0, monotonic: Callable[[], float] = time.monotonic) -> None:
        """Start at zero. Raises ValueError for a speed that is not positive and finite."""
        if not 0 < speed < float("inf"):
            raise ValueError(f"speed must be a positive number, not {speed}")
        self.speed = speed
        """Seconds of this clock per real second."""
        self._monotonic = monotonic
        self._start = monotonic()

    def __call__(self) -> float:
        """Return the time now, seconds."""
        return (self._monotonic() - self._start) * self.speed


class OffsetEstimator:
    """Maps a remote clock onto ours by the least delay seen in a sliding window.

    A stamp can only arrive late, so the smallest difference of arrival and stamp is the best estimate of the offset
    (Cristian 1989; as in ROS ``CuckooTimeTranslator``). The window follows drift; a remote clock that jumps back (a
    reboot) resets it.
    """

    def __init__(self, window_s: float = 30.0, latency_s: float = 0.0) -> None:
        self._window = window_s
        self._latency = latency_s
        self._samples: list[tuple[float, float]] = []  # (arrival, offset): offsets rise, so the head is the least
        self._last_remote = float("-inf")

    def update(self, remote: float, arrival: float) -> float:
        """Take one stamp with its arrival on our clock; return the stamp on our clock (seconds)."""
        if remote < self._last_remote - 1.0:
            self._samples.clear()
        self._last_remote = remote
        offset = arrival - remote - self._latency
        while self._samples and self._samples[-1][1] >= offset:
            self._samples.pop()
        self._samples.append((arrival, offset))
        while self._samples[0][0] < arrival - self._window:
            self._samples.pop(0)
        return self.to_ours(remote)

    def to_ours(self, remote: float) -> float:
        """Return a remote time on our clock. Raises LookupError before the first `update`."""
        if not self._samples:
            raise LookupError("no stamp of this clock has been seen yet")
        return remote + self._samples[0][1]

"""The daemon's one clock, and how the clocks of autopilot and camera map onto it."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Protocol


class Clock(Protocol):
    """Seconds that only grow. In a simulation of speed N they pass N times as fast as real ones."""

    def __call__(self) -> float:
        """Return the time now, seconds."""
        ...

    @property
    def speed(self) -> float:
        """Seconds of this clock per real second."""
        ...


class ScaledClock:
    """``speed`` x monotonic time, starting at zero: the clock of `--sim --speed N`, and of real flight with speed 1."""

    def __init__(self, speed: float = 1.0, monotonic: Callable[[], float] = time.monotonic) -> None:
        if not 0 < speed < float("inf"):
            raise ValueError(f"speed must be a positive number, not {speed}")
        self._speed = speed
        self._monotonic = monotonic
        self._start = monotonic()

    def __call__(self) -> float:
        """Return seconds since the clock was made."""
        return (self._monotonic() - self._start) * self._speed

    @property
    def speed(self) -> float:
        """Seconds of this clock per real second."""
        return self._speed


class ManualClock:
    """A clock that a test moves by hand."""

    def __init__(self, now: float = 0.0) -> None:
        self.now = now

    def __call__(self) -> float:
        """Return the time that was set."""
        return self.now

    @property
    def speed(self) -> float:
        """A hand-moved clock counts as real time."""
        return 1.0

    def advance(self, seconds: float) -> None:
        """Move the time forward."""
        if seconds < 0:
            raise ValueError("time does not run backwards")
        self.now += seconds


class OffsetEstimator:
    """Maps a remote clock onto ours by the least delay seen in a sliding window.

    A stamp can only arrive late, so the smallest difference of arrival and stamp is the best estimate of the offset
    (Cristian 1989; as in ROS ``CuckooTimeTranslator``). The window lets it follow drift; a remote clock that jumps
    back (a reboot) starts it anew.
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

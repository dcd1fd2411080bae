"""A camera's stamps on our clock, also when the camera's clock steps.

The least delay seen is the camera's own (`hawk.comm.clock.OffsetEstimator`). A clock that steps back by less than that
window's memory would put every picture too early for half a minute. By arrival a late picture and a step look the same.
Two things distinguish them. Stamps that go back are a step: no delay does that. A step that is hidden, by missing
pictures or because it is shorter than the time between two pictures, leaves the least delay steady from then on; the
delays of a busy computer or a full link rise and fall.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from statistics import median
from typing import Final

from hawk.comm.clock import OffsetEstimator

JUMP_S: Final = 0.12
"""A stamp this far off the mapping is no jitter: a delay, or a step. Real delays are N times as long at speed N."""
_INTERVALS: Final = 20
_SHORT: Final = 0.6
"""An interval of stamps shorter than this share of the usual one is no camera's."""
_LONG: Final = 1.5
"""In a longer one pictures are missing."""
_KNOWN: Final = 3
"""Intervals after which the usual one is known."""
_PART_S: Final = 1.0
"""After a doubt the least delays of `_PARTS` times of this length are compared. At speed 1."""
_PARTS: Final = 3
_LEAST_PICTURES: Final = 8
"""Fewer may be as late as each other by chance."""
_STEADY_S: Final = 0.025
"""Delays this close to each other are steady: the least ones of a camera vary by some milliseconds. At speed 1."""
_GIVE_UP_S: Final = 6.0
"""A doubt that has not found steady delays in this time was a delay. At speed 1."""
_SETTLED: Final = 4
"""Pictures after which a new mapping is used: the first may have come late."""
_AGREE: Final = 2
"""Stamps ahead of the mapping that must agree; a single one is corrupt."""


@dataclass(frozen=True, slots=True)
class Placed:
    """A stamp. ``time``: seconds of our clock, None while it is not known. ``stepped_s``: a step was noticed now.

    ``stands``: it is the stamp of the picture before. That picture came again, or the camera's clock stands still.
    """

    time: float | None
    stepped_s: float | None = None
    stands: bool = False


_UNKNOWN: Final = Placed(None)
_STANDS: Final = Placed(None, stands=True)


class _Doubt:
    """Delays since a step may have happened, each with the part of the time that it belongs to."""

    def __init__(self, since: float, part_s: float, usual_s: float) -> None:
        """``usual_s``: median of the delays over the least one, before the doubt."""
        self.since = since
        self._part_s = part_s
        self._usual_s = usual_s
        self._parts: dict[int, list[float]] = {}

    def take(self, late: float, arrival: float) -> None:
        self._parts.setdefault(int((arrival - self.since) / self._part_s), []).append(late)

    def is_steady(self, within: float) -> bool:
        """Return True when the last parts that are over have the same least delay, and no more over it than usual."""
        newest = max(self._parts)
        parts = [self._parts.get(part, []) for part in range(newest - _PARTS, newest)]
        if not all(parts) or sum(map(len, parts)) < _LEAST_PICTURES:
            return False
        least = [min(part) for part in parts]
        over = median(late for part in parts for late in part) - min(least)
        return max(least) - min(least) <= within and over <= self._usual_s + within


class StampClock:
    """Maps the stamps of one camera."""

    def __init__(self, latency_s: float = 0.0, speed: float = 1.0) -> None:
        """``latency_s``: delay that every picture has. ``speed``: seconds of our clock per real second."""
        self._latency_s = latency_s
        self._scale = max(1.0, speed)
        self._jump = JUMP_S * self._scale
        self._estimator = OffsetEstimator(latency_s=latency_s)
        self._intervals: deque[float] = deque(maxlen=_INTERVALS)
        self._delays: deque[float] = deque([0.0], maxlen=_INTERVALS)  # over the least, outside of a doubt
        self._last: tuple[float, float] | None = None  # stamp, arrival
        self._to_settle = 0
        self._doubt: _Doubt | None = None
        self._ahead: list[tuple[float, float]] = []  # stamps and arrivals that are ahead of the mapping
        self.has_stepped = False
        """True once the clock went back: a mapping that was known otherwise holds no more. A step ahead looks as a
        delay that ends; a mapping that is known shows it by pictures that arrive before they were taken."""

    def take(self, stamp: float, arrival: float) -> Placed:
        """Take a picture's stamp (seconds of the camera's clock) and its arrival (ours)."""
        last = self._last
        if last is not None and stamp == last[0]:
            return _STANDS
        self._last = (stamp, arrival)
        if last is None:
            return Placed(self._estimator.update(stamp, arrival))
        interval = stamp - last[0]
        late = arrival - self._latency_s - self._estimator.to_ours(stamp)
        step = self._step(interval, late, arrival)
        if interval > 0:
            self._intervals.append(interval)
        if step is not None:
            return step
        if late < -self._jump:
            return self._take_ahead(stamp, arrival, late)
        self._ahead.clear()
        self._delays.append(max(0.0, late))
        time = self._estimator.update(stamp, arrival)
        if self._to_settle:
            self._to_settle -= 1
            return _UNKNOWN
        return Placed(time)

    def _step(self, interval: float, late: float, arrival: float) -> Placed | None:
        """Begin again where the stamps went back, wait where they may have; None where they did not."""
        if late <= self._jump:
            self._doubt = None
            return None if interval >= 0 else self._went_back(late)
        if interval < 0:
            return self._went_back(late)
        if self._doubt is None and self._may_hide_a_step(interval):
            self._doubt = _Doubt(arrival, _PART_S * self._scale, median(self._delays))
        if self._doubt is None:
            return None
        self._doubt.take(late, arrival)
        if self._doubt.is_steady(_STEADY_S * self._scale):
            return self._went_back(late)
        if arrival - self._doubt.since > _GIVE_UP_S * self._scale:
            self._doubt = None
            return None
        return _UNKNOWN

    def _may_hide_a_step(self, interval: float) -> bool:
        """Return True for an interval with missing pictures in it, or one too short for this camera."""
        if len(self._intervals) < _KNOWN:
            return False
        usual = median(self._intervals)
        return interval > _LONG * usual or 0 < interval < _SHORT * usual

    def _went_back(self, late: float) -> Placed:
        assert self._last is not None  # noqa: S101 - just taken
        self._begin([self._last])
        self.has_stepped = True
        return Placed(None, -late)

    def _take_ahead(self, stamp: float, arrival: float, late: float) -> Placed:
        """Take a stamp ahead of the mapping: no picture comes before it is taken, so two that agree are a step."""
        self._ahead.append((stamp, arrival))
        offsets = [came - taken for taken, came in self._ahead]
        if max(offsets) - min(offsets) > self._jump:
            self._ahead = self._ahead[-1:]
        if len(self._ahead) < _AGREE:
            return _UNKNOWN
        self._begin(self._ahead)
        return Placed(None, -late)

    def _begin(self, samples: list[tuple[float, float]]) -> None:
        """Begin the mapping again with stamps and arrivals."""
        self._estimator = OffsetEstimator(latency_s=self._latency_s)
        for stamp, arrival in samples:
            self._estimator.update(stamp, arrival)
        self._ahead, self._doubt = [], None
        self._to_settle = _SETTLED - len(samples)


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

"""A camera's stamps on our clock, also when the camera's clock steps.

The least delay seen is the camera's own (`hawk.comm.clock.OffsetEstimator`). A clock that steps back by less than that
window's memory would put every picture too early for half a minute. A late picture and a step look the same by arrival;
the stamps differ: a delay leaves their intervals alone, a step shortens one of them.
"""

from __future__ import annotations

from collections import deque
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
_WAIT_S: Final = 0.6
"""Time after missing pictures in which a delay goes back, else it was a step. At speed 1."""
_SETTLED: Final = 4
"""Pictures after which a new mapping is used: the first may have come late."""
_AGREE: Final = 2
"""Stamps ahead of the mapping that must agree; a single one is corrupt."""


@dataclass(frozen=True, slots=True)
class Placed:
    """A stamp. ``time``: seconds of our clock, None while it is not known. ``stepped_s``: a step was noticed now."""

    time: float | None
    stepped_s: float | None = None


_UNKNOWN: Final = Placed(None)


class StampClock:
    """Maps the stamps of one camera."""

    def __init__(self, latency_s: float = 0.0, speed: float = 1.0) -> None:
        """``latency_s``: delay that every picture has. ``speed``: seconds of our clock per real second."""
        self._latency_s = latency_s
        self._jump = JUMP_S * max(1.0, speed)
        self._wait = _WAIT_S * max(1.0, speed)
        self._estimator = OffsetEstimator(latency_s=latency_s)
        self._intervals: deque[float] = deque(maxlen=_INTERVALS)
        self._last: tuple[float, float] | None = None  # stamp, arrival
        self._to_settle = 0
        self._doubted: float | None = None  # arrival of the first picture that may be of another mapping
        self._ahead: list[tuple[float, float]] = []  # stamps and arrivals that are ahead of the mapping
        self.has_stepped = False
        """True once the clock has stepped: a mapping that was known otherwise holds no more."""

    def take(self, stamp: float, arrival: float) -> Placed:
        """Take a picture's stamp (seconds of the camera's clock) and its arrival (ours)."""
        last, self._last = self._last, (stamp, arrival)
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
        time = self._estimator.update(stamp, arrival)
        if self._to_settle:
            self._to_settle -= 1
            return _UNKNOWN
        return Placed(time)

    def _step(self, interval: float, late: float, arrival: float) -> Placed | None:
        """Begin again where the stamps went back, wait where they may have; None where they did not."""
        is_late = late > self._jump
        usual = median(self._intervals) if len(self._intervals) >= _KNOWN else None
        went_back = interval < 0 or (usual is not None and 0 < interval < _SHORT * usual and is_late)
        if not is_late:
            self._doubted = None
        elif self._doubted is None and usual is not None and interval > _LONG * usual:
            self._doubted = arrival  # pictures are missing, and with them the interval that would show a step
        if self._doubted is not None and not went_back and arrival - self._doubted < self._wait:
            return _UNKNOWN
        if not went_back and self._doubted is None:
            return None
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
        self.has_stepped = True
        return Placed(None, -late)

    def _begin(self, samples: list[tuple[float, float]]) -> None:
        """Begin the mapping again with stamps and arrivals."""
        self._estimator = OffsetEstimator(latency_s=self._latency_s)
        for stamp, arrival in samples:
            self._estimator.update(stamp, arrival)
        self._ahead, self._doubted = [], None
        self._to_settle = _SETTLED - len(samples)

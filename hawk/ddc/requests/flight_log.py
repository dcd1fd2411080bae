"""The record of the flight for the operator: short messages with the autopilot's own words, and the trail."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from datetime import UTC, datetime

from hawk.comm.protocol.base import listed
from hawk.comm.protocol.heartbeat import LogEntry
from hawk.model.operation import Level
from hawk.model.poses import MapPoint, MapPose
from hawk.model.sentences import say
from hawk.model.vehicle import StatusText

KEPT_ENTRIES = 200
REPEAT_S = 10.0
"""The same words of the autopilot within this time are shown once, seconds."""
CAUSE_S = 5.0
"""A warning of the autopilot explains what it does within this time, seconds."""
STEP_M = 1.0
"""Distance between two points of the trail."""
MAXIMUM_POINTS = 10_000
KEEP_S = 0.5
"""Flight time and distance are journalled this often: with the journal's own pace a second at most is lost."""


class FlightLog:
    """Numbered entries, newest last; bounded."""

    def __init__(self, clock: Callable[[], float], utc: Callable[[], datetime]) -> None:
        self._clock = clock
        self._utc = utc
        self._number = 0
        self._entries: deque[LogEntry] = deque(maxlen=KEPT_ENTRIES)
        self.entries: tuple[LogEntry, ...] = ()
        """The last entries, oldest first."""
        self._heard: dict[str, float] = {}
        self._warning: tuple[float, str] | None = None

    def add(self, level: Level, text: str, details: str = "") -> LogEntry:
        """Append one entry."""
        self._number += 1
        time = self._utc().astimezone(UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")
        entry = listed(LogEntry(number=self._number, time=time, level=level, text=text, details=details))
        self._entries.append(entry)
        self.entries = tuple(self._entries)
        return entry

    def hear(self, message: StatusText) -> None:
        """Take a message of the autopilot. Severity follows MAV_SEVERITY; debug messages are left out."""
        now = self._clock()
        if message.severity <= 4:
            self._warning = (now, message.text)
        if message.severity >= 7 or now - self._heard.get(message.text, float("-inf")) < REPEAT_S:
            return
        self._heard = {text: time for text, time in self._heard.items() if now - time < REPEAT_S}
        self._heard[message.text] = now
        if message.severity <= 3:
            self.add("error", say("The autopilot reports a fault: {words}", words=message.text))
        elif message.severity == 4:
            self.add("warning", say("The autopilot warns: {words}", words=message.text))
        else:
            self.add("info", say("The autopilot: {words}", words=message.text))

    def autopilot_reason(self) -> str:
        """Return what the autopilot warned of a moment ago, empty when it said nothing."""
        if self._warning is None or self._clock() - self._warning[0] > CAUSE_S:
            return ""
        return self._warning[1]


class Trail:
    """Points on the ground below the path flown; every second point is dropped when there are too many.

    ``keep`` is given flight time (seconds) and distance (metres) every KEEP_S in the air, and None after the landing.
    """

    def __init__(self, keep: Callable[[tuple[float, float] | None], None] = lambda _flight: None) -> None:
        self._keep = keep
        self._next_keep = -math.inf
        self._points: list[MapPoint] = []
        self.points: tuple[MapPoint, ...] = ()
        """All points, oldest first."""
        self._took_off: float | None = None
        self._last: MapPose | None = None
        self.identity = 0
        """Changes when the points do not continue the former ones."""
        self.distance = 0.0
        """Metres flown since take-off, across the ground."""

    def flight_time(self, now: float) -> float | None:
        """Return seconds since take-off, None on the ground."""
        return None if self._took_off is None else now - self._took_off

    def resume(self, seconds: float, distance: float, now: float) -> None:
        """Continue a flight that began ``seconds`` ago, before this program, and is ``distance`` metres long so far."""
        self._took_off, self.distance = now - seconds, distance

    def update(self, pose: MapPose | None, airborne: bool, now: float) -> None:
        """Take this tick's pose."""
        if not airborne:
            if self._took_off is not None:
                self._keep(None)
            self._took_off = self._last = None
            return
        if self._took_off is None:
            self._took_off, self.distance = now, 0.0
            self._next_keep = -math.inf
        self._follow(pose)
        if now >= self._next_keep:
            self._next_keep = now + KEEP_S
            self._keep((now - self._took_off, self.distance))

    def _follow(self, pose: MapPose | None) -> None:
        if pose is None or not pose.is_finite():
            return
        if self._last is not None:
            step = math.hypot(pose.north - self._last.north, pose.east - self._last.east)
            if step < STEP_M:
                return
            self.distance += step
        self._last = pose
        self._append(pose.point)

    def _append(self, point: MapPoint) -> None:
        self._points.append(point)
        if len(self._points) > MAXIMUM_POINTS:
            self._points = self._points[::2]
            self.identity += 1
        self.points = tuple(self._points)

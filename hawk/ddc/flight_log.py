"""The message list of the flight: short sentences for the operator, the autopilot's own words as details."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from datetime import UTC, datetime
from typing import Literal

from hawk.comm.messages import LogEntry
from hawk.model import StatusText

KEPT_ENTRIES = 200
REPEAT_S = 10.0
"""The same words of the autopilot within so many seconds are shown once."""
CAUSE_S = 5.0
"""What the autopilot said within so many seconds before it acted counts as its reason."""

Level = Literal["info", "ok", "warning", "error"]


class FlightLog:
    """Numbered entries, newest last; bounded."""

    def __init__(self, clock: Callable[[], float], utc: Callable[[], datetime]) -> None:
        self._clock = clock
        self._utc = utc
        self._number = 0
        self._entries: deque[LogEntry] = deque(maxlen=KEPT_ENTRIES)
        self._snapshot: tuple[LogEntry, ...] = ()
        self._heard: dict[str, float] = {}
        self._warning: tuple[float, str] | None = None

    @property
    def entries(self) -> tuple[LogEntry, ...]:
        """The last entries, oldest first."""
        return self._snapshot

    def add(self, level: Level, text: str, details: str = "") -> LogEntry:
        """Append one entry."""
        self._number += 1
        time = self._utc().astimezone(UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")
        entry = LogEntry(number=self._number, time=time, level=level, text=text, details=details)
        self._entries.append(entry)
        self._snapshot = tuple(self._entries)
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
            self.add("error", "The autopilot reports a fault.", message.text)
        elif message.severity == 4:
            self.add("warning", "The autopilot warns.", message.text)
        else:
            self.add("info", "Message of the autopilot.", message.text)

    def autopilot_reason(self) -> str:
        """Return what the autopilot warned of a moment ago, empty when it said nothing."""
        if self._warning is None or self._clock() - self._warning[0] > CAUSE_S:
            return ""
        return self._warning[1]

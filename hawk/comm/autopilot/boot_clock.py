"""The autopilot's boot clock: which time stamps are believed, where they lie on our clock, and when it has booted.

A datagram may come late, twice, out of order or with a corrupt stamp, so no single one moves the clock. A message whose
stamp contradicts the clock is dropped. Several such messages of several kinds that agree with each other, while no
message of the old clock comes any more, replace the clock.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any, Final, Literal

from hawk.comm.clock import OffsetEstimator

LATE_S: Final = 0.5
"""A stamp this much older than the newest is late: the message is dropped."""
AHEAD_S: Final = 0.25
"""A stamp ahead of the clock by more than this, at speed 1, contradicts it: no message arrives before it is sent."""
AGREE_S: Final = 0.5
"""Delays of messages that agree on a clock differ by no more than this, at speed 1."""
AGREE_KINDS: Final = 2
FOUND_MESSAGES: Final = 3
"""This number of messages that agree is a clock where none is known."""
REPLACE_MESSAGES: Final = 6
"""This number replaces a known clock."""
STAYS_S: Final = 0.5
"""A new clock replaces a known one after this time without a message of the old one."""
_BOOT_SLACK_S: Final = 0.5

EARLIEST_UTC: Final = datetime(2025, 1, 1, tzinfo=UTC).timestamp()
LATEST_UTC: Final = datetime(2090, 1, 1, tzinfo=UTC).timestamp()
"""Moments that are believed, Unix seconds."""

Event = Literal["", "found", "booted", "corrected"]


@dataclass(frozen=True, slots=True)
class Reading:
    """One stamp. ``time``: the stamp on our clock, seconds; None: the message is not believed.

    ``event``: the clock was found with this message; the autopilot has booted; the clock was wrong and is right now.
    """

    time: float | None
    event: Event = ""


_DROPPED: Final = Reading(None)


class GnssClock:
    """The moment by the autopilot's UTC, which it has from GNSS, on our clock.

    A moment before this software, as after an overflow of GNSS weeks or in 1970, or far beyond it is not believed. The
    computer's own clock has no part in it: without a network it goes on from where it stood at the last shutdown.
    """

    def __init__(self) -> None:
        self._utc_at_zero: float | None = None

    def take(self, fields: Mapping[str, Any], time: float) -> None:
        """Take a SYSTEM_TIME; ``time`` is its stamp on our clock, seconds. A UTC of 0 is "not known"."""
        utc = int(fields["time_unix_usec"]) / 1e6
        self._utc_at_zero = utc - time if EARLIEST_UTC <= utc <= LATEST_UTC else None

    def at(self, time: float) -> datetime | None:
        """Return the moment at a time of our clock, seconds; None where it is not known."""
        return None if self._utc_at_zero is None else datetime.fromtimestamp(self._utc_at_zero + time, UTC)

    def forget(self) -> None:
        """Forget the moment: the autopilot has booted."""
        self._utc_at_zero = None


class BootClock:
    """Maps the autopilot's boot clock onto ours, by stamps of several kinds of messages."""

    def __init__(self, speed: float) -> None:
        """``speed``: seconds of our clock per real second; real delays count that many times as long."""
        self._stretch = max(1.0, speed)
        self._known: _Track | None = None
        self._rival: _Track | None = None

    @property
    def newest(self) -> float | None:
        """The newest believed time since boot, seconds; None before the clock is found."""
        return None if self._known is None else self._known.newest

    def to_ours(self, boot: float) -> float | None:
        """Return a time since boot on our clock, seconds; None before the clock is found."""
        return None if self._known is None else self._known.to_ours(boot)

    def take(self, kind: str, boot: float, arrival: float) -> Reading:
        """Take one stamp.

        Args:
            kind: Name of the message; the stamps of one kind rise.
            boot: The stamp, seconds since the autopilot's boot.
            arrival: Moment of arrival, seconds of our clock.
        """
        known = self._known
        event: Event = "found"
        if known is not None:
            verdict = self._judge(known, kind, boot, arrival)
            if verdict == "fresh":
                self._rival = None
                return Reading(known.add(kind, boot, arrival))
            if verdict == "late":
                return _DROPPED
            event = verdict
        rival = self._weigh(kind, boot, arrival)
        if not rival.is_agreed(FOUND_MESSAGES if known is None else REPLACE_MESSAGES):
            return _DROPPED
        if known is not None and rival.age < STAYS_S:
            return _DROPPED
        self._known, self._rival = rival, None
        return Reading(rival.to_ours(boot), event)

    def _judge(
        self, known: _Track, kind: str, boot: float, arrival: float
    ) -> Literal["fresh", "late", "booted", "corrected"]:
        """Compare a stamp with the known clock.

        A boot is possible only after the newest message of the old clock was sent: a stamp that puts it earlier is
        late.
        """
        booted_at = arrival - boot
        if booted_at < known.booted_at - AHEAD_S * self._stretch:
            return "corrected"
        if boot < known.newest - LATE_S:
            return "booted" if booted_at > known.to_ours(known.newest) - _BOOT_SLACK_S else "late"
        return "fresh" if known.follows(kind, boot) else "late"

    def _weigh(self, kind: str, boot: float, arrival: float) -> _Track:
        """Add a stamp that contradicts the known clock to its rival, or begin another one; return the rival."""
        rival = self._rival
        if rival is None or abs(arrival - boot - rival.booted_at) > AGREE_S * self._stretch:
            rival = self._rival = _Track(arrival)
        if rival.follows(kind, boot):
            rival.add(kind, boot, arrival)
        return rival


class _Track:
    """Stamps that agree on one boot clock."""

    def __init__(self, began: float) -> None:
        self._began = self._last_arrival = began
        self._offset = OffsetEstimator()
        self._last: dict[str, float] = {}
        self._count = 0
        self.newest = -math.inf
        """Newest time since boot, seconds."""

    @property
    def booted_at(self) -> float:
        """Moment of the boot, seconds of our clock."""
        return self.to_ours(0.0)

    @property
    def age(self) -> float:
        """Seconds from the first to the last stamp."""
        return self._last_arrival - self._began

    def is_agreed(self, messages: int) -> bool:
        """Return True when this number of messages agrees, of enough kinds."""
        return self._count >= messages and len(self._last) >= AGREE_KINDS

    def follows(self, kind: str, boot: float) -> bool:
        """Return True when the stamp is newer than the last one of its kind: neither repeated nor overtaken."""
        return boot > self._last.get(kind, -math.inf)

    def add(self, kind: str, boot: float, arrival: float) -> float:
        """Take a stamp; return it on our clock, seconds."""
        self._last[kind] = boot
        self._last_arrival = arrival
        self._count += 1
        self.newest = max(self.newest, boot)
        return self._offset.update(boot, arrival)

    def to_ours(self, boot: float) -> float:
        """Return a time since boot on our clock, seconds."""
        return self._offset.to_ours(boot)

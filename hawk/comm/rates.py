"""Message rates: ArduPilot sends only what it was asked for and forgets it at a reboot."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

_STALE_PERIODS = 8
_LEAST_STALE_S = 1.0
_ASK_AGAIN_S = 1.0


@dataclass(frozen=True, slots=True)
class Stream:
    """A message to be sent so many times a second."""

    message_id: int
    hertz: float

    @property
    def interval_us(self) -> float:
        """Parameter 2 of MAV_CMD_SET_MESSAGE_INTERVAL."""
        return 1e6 / self.hertz


def wanted_streams(position_rate_hz: float) -> Mapping[str, Stream]:
    """Return the messages that the daemon lives on, by name (ids of MAVLink common.xml)."""
    return {
        "LOCAL_POSITION_NED": Stream(32, position_rate_hz),
        "ATTITUDE": Stream(30, position_rate_hz),
        "GLOBAL_POSITION_INT": Stream(33, 10.0),
        "SYS_STATUS": Stream(1, 2.0),
        "GPS_RAW_INT": Stream(24, 2.0),
        "EXTENDED_SYS_STATE": Stream(245, 5.0),
        "HOME_POSITION": Stream(242, 0.5),
    }


class RateKeeper:
    """Says which rates are to be asked for: those of streams that are silent."""

    def __init__(self, wanted: Mapping[str, Stream]) -> None:
        self._wanted = wanted
        self._seen = dict.fromkeys(wanted, -math.inf)
        self._asked = dict.fromkeys(wanted, -math.inf)

    def seen(self, name: str, arrival: float) -> None:
        """Note that a message came."""
        if name in self._seen:
            self._seen[name] = arrival

    def forget(self) -> None:
        """The autopilot has booted: every rate is to be asked for at once."""
        self._seen = dict.fromkeys(self._wanted, -math.inf)
        self._asked = dict.fromkeys(self._wanted, -math.inf)

    def age(self, name: str, now: float) -> float:
        """Return the seconds since a message came, infinite when it never did."""
        return now - self._seen[name]

    def due(self, now: float) -> list[Stream]:
        """Return the streams to ask for at this moment and note that they were asked for."""
        due = []
        for name, stream in self._wanted.items():
            stale = now - self._seen[name] > max(_LEAST_STALE_S, _STALE_PERIODS / stream.hertz)
            if stale and now - self._asked[name] >= _ASK_AGAIN_S:
                self._asked[name] = now
                due.append(stream)
        return due

"""The autopilot's streams: which messages the daemon asks for, at which rates, and which are silent."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

_STALE_PERIODS: Final = 8
_LEAST_STALE_S: Final = 1.0


@dataclass(frozen=True, slots=True)
class Stream:
    """A message and its rate. A silent one is asked for every ``ask_again_s`` seconds."""

    message_id: int
    hertz: float
    ask_again_s: float = 1.0

    @property
    def interval_us(self) -> float:
        """Parameter 2 of MAV_CMD_SET_MESSAGE_INTERVAL."""
        return 1e6 / self.hertz


def wanted_streams(position_rate_hz: float, *, has_gimbal: bool = False) -> Mapping[str, Stream]:
    """Return the messages that the daemon needs, by name (ids of MAVLink common.xml)."""
    gimbal = {"GIMBAL_DEVICE_ATTITUDE_STATUS": Stream(285, 10.0)} if has_gimbal else {}
    return {
        "LOCAL_POSITION_NED": Stream(32, position_rate_hz),
        "ATTITUDE": Stream(30, position_rate_hz),
        "GLOBAL_POSITION_INT": Stream(33, 10.0),
        "SYS_STATUS": Stream(1, 2.0),
        "GPS_RAW_INT": Stream(24, 2.0),
        "EXTENDED_SYS_STATE": Stream(245, 5.0),
        "SYSTEM_TIME": Stream(2, 10.0),  # a second witness of a boot: without a position there is only ATTITUDE
        "EKF_STATUS_REPORT": Stream(193, 2.0),
        "HOME_POSITION": Stream(242, 1.0),
        "RC_CHANNELS": Stream(65, 5.0),
        "DISTANCE_SENSOR": Stream(132, 10.0, ask_again_s=10.0),  # silent for ever where there is no rangefinder
        **gimbal,
    }


class RateKeeper:
    """Finds the streams to ask for: the silent ones. ArduPilot sends only those asked for since its last boot."""

    def __init__(self, wanted: Mapping[str, Stream]) -> None:
        self._wanted = wanted
        self.forget()

    def seen(self, name: str, arrival: float) -> None:
        """Note the arrival of a message, seconds of the daemon's clock."""
        if name in self._seen:
            self._seen[name] = arrival

    def forget(self) -> None:
        """Ask for every stream at once: the autopilot has booted."""
        self._seen = dict.fromkeys(self._wanted, -math.inf)
        self._asked = dict.fromkeys(self._wanted, -math.inf)

    @property
    def any(self) -> Stream:
        """One of the wanted streams."""
        return next(iter(self._wanted.values()))

    def age(self, name: str, now: float) -> float:
        """Return the age of the last message, seconds; infinite when none came."""
        return now - self._seen[name]

    def due(self, now: float) -> list[Stream]:
        """Return the streams to ask for now, and note that they were asked for."""
        due = []
        for name, stream in self._wanted.items():
            stale = now - self._seen[name] > max(_LEAST_STALE_S, _STALE_PERIODS / stream.hertz)
            if stale and now - self._asked[name] >= stream.ask_again_s:
                self._asked[name] = now
                due.append(stream)
        return due

"""The pilot's remote control as the autopilot hears it: RC_CHANNELS and the receiver's bits of SYS_STATUS.

ArduCopter goes on sending the last pulses of a receiver that was lost: only SYS_STATUS says that it was, a second
later, and only while FS_THR_ENABLE is not 0. Before it has heard a receiver since its boot, every pulse is 0.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Final

from hawk.comm.topic import Topic

_RECEIVER: Final = 1 << 16  # MAV_SYS_STATUS_SENSOR_RC_RECEIVER
_CHANNELS: Final = 18
_UNUSED: Final = 65535  # UINT16_MAX: MAVLink's word for a channel that is not there


@dataclass(frozen=True, slots=True)
class RemoteControl:
    """``pulses`` of channels 1 to 18, microseconds (0: none); ``channels``: number that the receiver gives.

    ``receiver``: the autopilot has a receiver and hears it; None before it said so. Times in seconds of the daemon's
    clock, at which each was heard last. ``boots`` counts the autopilot's boots.
    """

    pulses: tuple[int, ...] = ()
    channels: int = 0
    time: float = -math.inf
    receiver: bool | None = None
    receiver_time: float = -math.inf
    boots: int = 0

    def pulse(self, channel: int) -> int:
        """Return the pulse of a channel counted from 1, microseconds; 0 for one that is not there."""
        return self.pulses[channel - 1] if 1 <= channel <= len(self.pulses) else 0


class RemoteControlReports:
    """Publishes the newest of both messages as one value."""

    def __init__(self, topic: Topic[RemoteControl]) -> None:
        self._topic = topic
        self._now = RemoteControl()

    def take_channels(self, fields: Mapping[str, Any], arrival: float) -> None:
        """Take a RC_CHANNELS. Raises KeyError, TypeError or ValueError when it cannot be read."""
        raw = (int(fields[f"chan{number}_raw"]) for number in range(1, _CHANNELS + 1))
        pulses = tuple(0 if pulse == _UNUSED else pulse for pulse in raw)
        self._publish(replace(self._now, pulses=pulses, channels=int(fields["chancount"]), time=arrival))

    def take_status(self, fields: Mapping[str, Any], arrival: float) -> None:
        """Take a SYS_STATUS; one without the receiver's bits says nothing."""
        present, health = (fields.get(f"onboard_control_sensors_{name}") for name in ("present", "health"))
        if present is None or health is None:
            return
        hears = bool(int(present) & int(health) & _RECEIVER)
        self._publish(replace(self._now, receiver=hears, receiver_time=arrival))

    def forget(self) -> None:
        """Drop what was heard: the autopilot has booted."""
        self._publish(RemoteControl(boots=self._now.boots + 1))

    def _publish(self, now: RemoteControl) -> None:
        self._now = now
        self._topic.publish(now)

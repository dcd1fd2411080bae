"""Other MAVLink systems and components on the vehicle's link: each gives its sign of life just before the vehicle's."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Final

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from hawk.sim.autopilot.options import Other

_SECOND_NORTH_DEG: Final = 0.002
"""The second copter flies this far north of where the world begins: 220 m."""


@dataclass(frozen=True, slots=True)
class _Kind:
    """MAVLink ids and the HEARTBEAT's fields (MAV_TYPE, MAV_AUTOPILOT, base_mode, custom_mode, MAV_STATE)."""

    system: int
    component: int
    heartbeat: tuple[int, int, int, int, int]


_KINDS: Final = {
    Other.TRACKER: _Kind(2, 1, (mavlink.MAV_TYPE_ANTENNA_TRACKER, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA, 81, 10, 4)),
    Other.GIMBAL: _Kind(
        1, mavlink.MAV_COMP_ID_GIMBAL, (mavlink.MAV_TYPE_GIMBAL, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 4)
    ),
    Other.COPTER: _Kind(3, 1, (mavlink.MAV_TYPE_HEXAROTOR, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA, 217, 3, 4)),
    Other.STATION: _Kind(
        255, mavlink.MAV_COMP_ID_MISSIONPLANNER, (mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 4)
    ),
}
"""The tracker is armed in AUTO, the second copter flies in AUTO; a gimbal is a component of the vehicle itself."""


class Others:
    """`present` of them are on the link. ``latitude`` and ``longitude`` (degrees) are where the world begins."""

    def __init__(self, latitude: float, longitude: float) -> None:
        self.present: frozenset[Other] = frozenset()
        self._place = round((latitude + _SECOND_NORTH_DEG) * 1e7), round(longitude * 1e7)
        self._encoders = {
            kind: mavlink.MAVLink(None, srcSystem=each.system, srcComponent=each.component)
            for kind, each in _KINDS.items()
        }

    def say(self, now: float, pack: Callable[[Any, mavlink.MAVLink], bytes]) -> list[bytes]:
        """Return the datagrams of one round; ``now`` is seconds of the simulation."""
        return [
            pack(message, self._encoders[kind])
            for kind in sorted(self.present)
            for message in self._messages(kind, int(now * 1000))
        ]

    def _messages(self, kind: Other, milliseconds: int) -> Iterator[Any]:
        yield mavlink.MAVLink_heartbeat_message(*_KINDS[kind].heartbeat, 3)
        if kind is Other.COPTER:
            yield mavlink.MAVLink_global_position_int_message(milliseconds, *self._place, 140_000, 40_000, 500, 0, 0, 0)
            yield mavlink.MAVLink_sys_status_message(0, 0, 0, 300, 14_800, 1500, 61, 0, 0, 0, 0, 0, 0)

"""One status for everybody, made into each client's Heartbeat: with what that client was not sent yet."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, field, fields
from enum import Enum
from typing import Any, Final

from hawk.comm.fence_messages import FenceSetup
from hawk.comm.messages import Heartbeat, Point
from hawk.comm.status import DroneStatus
from hawk.model import MapPoint, OccupancyMap
from hawk.web.map_view import MapView

LOG_LIMIT: Final = 50
"""Log entries in one heartbeat; the rest comes with the next."""
TRAIL_LIMIT: Final = 500
"""Trail points in one heartbeat."""
_PER_CLIENT: Final = frozenset({"log", "trail", "trail_id", "fence_setup"})


class SharedHeartbeat:
    """Builds the part that is the same for every client once per status."""

    def __init__(self) -> None:
        self._status: DroneStatus | None = None
        self._keys: dict[str, Any] = {}

    def keys(self, status: DroneStatus) -> dict[str, Any]:
        """Return the message's keys with the per-client ones empty. Raises ValidationError for a bad status."""
        if status is not self._status:
            self._keys = _shared(status).model_dump(mode="json", by_alias=True)
            self._status = status
        return self._keys


@dataclass(slots=True)
class ClientView:
    """What one client was sent of map, log, trail and fence."""

    map: MapView = field(default_factory=MapView)
    _log: int = -1
    _trail: int = 0
    _trail_id: int | None = None
    _fence: FenceSetup | None = None

    def forget_map(self) -> None:
        """The client asked for the whole map again."""
        self.map.forget()

    def heartbeat(
        self,
        shared: dict[str, Any],
        status: DroneStatus,
        current: OccupancyMap | None,
        controller: str | None,
        in_control: bool,
    ) -> str:
        """Return the client's Heartbeat as JSON and take all in it as sent."""
        drone = None if status.north is None or status.east is None else MapPoint(status.north, status.east)
        start, trail = self._next_trail(status)
        return json.dumps(
            shared
            | {
                "Occupancy Map": None
                if current is None
                else self.map.update(current, drone).model_dump(by_alias=True, exclude_unset=True),
                "Messages": [entry.model_dump(by_alias=True) for entry in self._next_log(status)],
                "Trail": [{"North": point.north, "East": point.east} for point in trail],
                "Trail Start": start,
                "Fence Setup": self._next_fence(status),
                "Controller": controller,
                "In Control": in_control,
            },
            separators=(",", ":"),
            allow_nan=False,
        )

    def _next_log(self, status: DroneStatus) -> list[Any]:
        entries = [entry for entry in status.log if entry.number > self._log][:LOG_LIMIT]
        if entries:
            self._log = entries[-1].number
        return entries

    def _next_fence(self, status: DroneStatus) -> dict[str, Any] | None:
        if status.fence_setup is None or status.fence_setup is self._fence:
            return None
        self._fence = status.fence_setup
        return self._fence.model_dump(by_alias=True)

    def _next_trail(self, status: DroneStatus) -> tuple[bool, list[MapPoint]]:
        start = status.trail_id != self._trail_id or len(status.trail) < self._trail
        if start:
            self._trail_id = status.trail_id
            self._trail = 0
        points = list(status.trail[self._trail : self._trail + TRAIL_LIMIT])
        self._trail += len(points)
        return start, [p for p in points if math.isfinite(p.north) and math.isfinite(p.east)]


def _shared(status: DroneStatus) -> Heartbeat:
    values = {f.name: _plain(getattr(status, f.name)) for f in fields(status) if f.name not in _PER_CLIENT}
    return Heartbeat(
        occupancy_map=None, messages=[], trail=[], fence_setup=None, controller=None, in_control=False, **values
    )


def _plain(value: Any) -> Any:
    """Return the value as the message wants it; a number that is not finite is not known."""
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if isinstance(value, MapPoint):
        return Point(north=value.north, east=value.east)
    if isinstance(value, Enum):
        return value.value
    if isinstance(value, tuple):
        return [_plain(item) for item in value]
    return value

"""The mission protocol, for fences and rally points: item by item (https://mavlink.io/en/services/mission.html)."""

from __future__ import annotations

import math
from typing import Any

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from hawk.sim.autopilot.autopilot import Autopilot
from hawk.sim.autopilot.fence import MAX_ITEMS, FenceError, FenceItem, FenceOverrunError, FenceStorageError
from hawk.sim.autopilot.rally import COMMAND as RALLY_COMMAND
from hawk.sim.autopilot.rally import MAX_POINTS, RallyPoint

RETRY_S = 1.0
TIMEOUT_S = 8.0
WARNING = int(mavlink.MAV_SEVERITY_WARNING)

FENCE = int(mavlink.MAV_MISSION_TYPE_FENCE)
RALLY = int(mavlink.MAV_MISSION_TYPE_RALLY)
_MOST = {FENCE: MAX_ITEMS, RALLY: MAX_POINTS}
HANDLED = frozenset(
    {
        "MISSION_COUNT",
        "MISSION_ITEM_INT",
        "MISSION_ITEM",
        "MISSION_REQUEST_LIST",
        "MISSION_REQUEST_INT",
        "MISSION_REQUEST",
        "MISSION_CLEAR_ALL",
        "MISSION_ACK",
    }
)


class Missions:
    """One transfer at a time. Answers are returned; `poll` asks again for an item that did not come."""

    def __init__(self, autopilot: Autopilot) -> None:
        self._autopilot = autopilot
        self._peer = (0, 0)
        self._expected = 0
        self._kind = FENCE
        """Mission type of the transfer."""
        self._items: list[FenceItem] = []
        self._points: list[RallyPoint] = []
        self._asked: float | None = None
        self._progress = 0.0

    def handle(self, message: Any, now: float) -> list[Any]:
        """Return the answers to a message of the protocol."""
        self._peer = (message.get_srcSystem(), message.get_srcComponent())
        kind = message.get_type()
        if kind == "MISSION_ACK":
            return []
        if kind == "MISSION_COUNT":
            return self._begin(message, now)
        if kind in ("MISSION_ITEM_INT", "MISSION_ITEM"):
            return self._take(message, now)
        if kind == "MISSION_REQUEST_LIST":
            count = len(self._held(message.mission_type))
            return [mavlink.MAVLink_mission_count_message(*self._peer, count, message.mission_type)]
        if kind == "MISSION_CLEAR_ALL":
            return self._clear(message)
        return self._send(message)

    def poll(self, now: float) -> list[Any]:
        """Request a missing item again; give up after TIMEOUT_S."""
        if self._asked is None or now - self._asked < RETRY_S:
            return []
        if now - self._progress > TIMEOUT_S:
            self._asked = None
            return [self._ack(mavlink.MAV_MISSION_OPERATION_CANCELLED, self._kind)]
        return [self._request(now)]

    def _held(self, kind: int) -> tuple[FenceItem, ...] | tuple[RallyPoint, ...]:
        if kind == RALLY:
            return self._autopilot.rally.points
        return self._autopilot.fence.items if kind == FENCE else ()

    def _begin(self, message: Any, now: float) -> list[Any]:
        most = _MOST.get(message.mission_type)
        if most is None:
            kind = mavlink.MAV_MISSION_ACCEPTED if message.count == 0 else mavlink.MAV_MISSION_UNSUPPORTED
            return [self._ack(kind, message.mission_type)]
        if message.count > most:
            self._autopilot.say(WARNING, f"Only {most} items are supported")
            return [self._ack(mavlink.MAV_MISSION_NO_SPACE, message.mission_type)]
        self._kind, self._items, self._points = message.mission_type, [], []
        self._expected, self._progress = message.count, now
        return [self._request(now)] if message.count else [self._finish()]

    def _take(self, message: Any, now: float) -> list[Any]:
        if self._asked is None or message.mission_type != self._kind:
            return [self._ack(mavlink.MAV_MISSION_INVALID_SEQUENCE, message.mission_type)]
        if message.seq != self._taken:
            return [self._request(now)]
        scale = 1e-7 if message.get_type() == "MISSION_ITEM_INT" else 1.0
        latitude, longitude = message.x * scale, message.y * scale
        if not (math.isfinite(latitude + longitude) and abs(latitude) <= 90.0 and abs(longitude) <= 180.0):
            self._asked = None
            return [self._ack(mavlink.MAV_MISSION_INVALID_PARAM5_X, self._kind)]
        if self._kind == RALLY:
            if message.command != RALLY_COMMAND or not math.isfinite(message.z):
                self._asked = None
                return [self._ack(mavlink.MAV_MISSION_UNSUPPORTED, RALLY)]
            self._points.append(RallyPoint(latitude, longitude, message.z))
        else:
            self._items.append(FenceItem(message.command, message.param1, latitude, longitude))
        self._progress = now
        return [self._finish()] if self._taken == self._expected else [self._request(now)]

    @property
    def _taken(self) -> int:
        """Number of items that have come."""
        return len(self._points if self._kind == RALLY else self._items)

    def _finish(self) -> Any:
        self._asked = None
        if self._kind == RALLY:
            self._autopilot.load_rally(self._points)
            return self._ack(mavlink.MAV_MISSION_ACCEPTED, RALLY)
        try:
            self._autopilot.load_fence(self._items)
        except FenceStorageError:
            self._autopilot.say(WARNING, "Fence exceeds storage size")
            return self._ack(mavlink.MAV_MISSION_ERROR, FENCE)
        except FenceOverrunError as error:
            self._autopilot.crash_program(f"a fence that fills its memory: {error}")
            return self._ack(mavlink.MAV_MISSION_ERROR, FENCE)
        except FenceError:
            return self._ack(mavlink.MAV_MISSION_INVALID, FENCE)
        return self._ack(mavlink.MAV_MISSION_ACCEPTED, FENCE)

    def _clear(self, message: Any) -> list[Any]:
        if message.mission_type in (FENCE, mavlink.MAV_MISSION_TYPE_ALL):
            self._autopilot.load_fence([])
        if message.mission_type in (RALLY, mavlink.MAV_MISSION_TYPE_ALL):
            self._autopilot.load_rally([])
        return [self._ack(mavlink.MAV_MISSION_ACCEPTED, message.mission_type)]

    def _send(self, message: Any) -> list[Any]:
        items = self._held(message.mission_type)
        if message.seq >= len(items):
            return [self._ack(mavlink.MAV_MISSION_INVALID_SEQUENCE, message.mission_type)]
        item = items[message.seq]
        if isinstance(item, RallyPoint):
            frame, command, first, height = mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT, RALLY_COMMAND, 0.0, item.altitude
        else:
            frame, command, first, height = mavlink.MAV_FRAME_GLOBAL, item.command, item.parameter, 0.0
        return [
            mavlink.MAVLink_mission_item_int_message(
                *self._peer,
                message.seq,
                frame,
                command,
                0,
                1,
                first,
                0.0,
                0.0,
                0.0,
                round(item.latitude * 1e7),
                round(item.longitude * 1e7),
                height,
                message.mission_type,
            )
        ]

    def _request(self, now: float) -> Any:
        self._asked = now
        return mavlink.MAVLink_mission_request_int_message(*self._peer, self._taken, self._kind)

    def _ack(self, result: int, mission_type: int) -> Any:
        return mavlink.MAVLink_mission_ack_message(*self._peer, result, mission_type)

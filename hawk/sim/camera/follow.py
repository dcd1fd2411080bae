"""The camera without the drone: follows another MAVLink vehicle over our world."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from hawk.sim.camera.camera import FRAME_S, Shot, SimulationClock
from hawk.sim.geometry import Origin
from hawk.sim.link.mavlink_link import Datagrams

SYSTEM, COMPONENT = 246, 191
"""Our own MAVLink id: an onboard computer, not a ground station that a failsafe could watch."""
ASK_S = 2.0
RATE_HZ = {
    mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT: 30,
    mavlink.MAVLINK_MSG_ID_ATTITUDE: 60,
    mavlink.MAVLINK_MSG_ID_SIM_STATE: 20,
}
STALE_S = 1.0
COMPARED_S = 0.15
"""A position that is older than this is not compared with the truth, seconds: the vehicle turns meanwhile."""
FOLLOW_SHARE = 0.2
"""Share by which one SIM_STATE corrects the error of the estimate: it has no time stamp, so that it is some hundredths
of a second beside the moment that it is taken for, that of the newest ATTITUDE."""
LEAP_M = 2.0
"""An error that differs by more is a leap of the estimate, once `LEAP_LOOKS` looks have seen it: then it is taken at
once. A single look may be of a moment when messages came late."""
LEAP_LOOKS = 3


@dataclass(frozen=True, slots=True)
class _Position:
    stamp: float
    north: float
    east: float
    height: float
    velocity: tuple[float, float, float]

    def at(self, stamp: float) -> _Position:
        """Return the position at another moment, seconds of the vehicle's clock."""
        ahead = stamp - self.stamp
        north, east, down = self.velocity
        return _Position(
            stamp, self.north + north * ahead, self.east + east * ahead, self.height - down * ahead, self.velocity
        )


@dataclass(frozen=True, slots=True)
class _Error:
    """The estimate less the truth: metres north, east and up, radians of yaw."""

    north: float = 0.0
    east: float = 0.0
    up: float = 0.0
    yaw: float = 0.0

    def is_leap(self, seen: _Error) -> bool:
        """Return True when another look differs by more than `LEAP_M`."""
        return math.dist((self.north, self.east, self.up), (seen.north, seen.east, seen.up)) > LEAP_M

    def towards(self, seen: _Error, share: float) -> _Error:
        """Return the error after another look at it, which counts by a share."""
        return _Error(
            self.north + share * (seen.north - self.north),
            self.east + share * (seen.east - self.east),
            self.up + share * (seen.up - self.up),
            self.yaw + share * math.remainder(seen.yaw - self.yaw, math.tau),
        )


class Follower:
    """Turns GLOBAL_POSITION_INT and ATTITUDE into shots, one a frame period of the vehicle's own clock.

    A simulated vehicle also reports the truth (SIM_STATE): the camera then sees from the true place, whatever the
    vehicle's sensors say. Heights are ``relative_alt``: the ground of the world lies at the vehicle's home.
    """

    def __init__(self, origin: Origin, clock: SimulationClock, frame_s: float = FRAME_S) -> None:
        self._origin = origin
        self._clock = clock
        self._frame_s = frame_s
        self._datagrams = Datagrams()
        self._encoder = mavlink.MAVLink(None, srcSystem=SYSTEM, srcComponent=COMPONENT)
        self._vehicle: tuple[int, int] | None = None
        self._position: _Position | None = None
        self._error, self._leaps = _Error(), 0
        self._stamp, self._yaw = 0.0, 0.0
        self._next_slot = -math.inf
        self._asked = -math.inf
        self._shots: list[Shot] = []
        self.last: Shot | None = None

    def receive(self, data: bytes) -> None:
        """Take a datagram."""
        for message in self._datagrams.read(data):
            self._handle(message)

    def shots(self) -> list[Shot]:
        """Return the shots since the last call."""
        shots, self._shots = self._shots, []
        return shots

    def poll(self) -> list[bytes]:
        """Return the datagrams to send: a heartbeat and the requests for the two streams, every two seconds."""
        now = self._clock()
        if now - self._asked < ASK_S:
            return []
        self._asked = now
        out = [
            mavlink.MAVLink_heartbeat_message(
                mavlink.MAV_TYPE_ONBOARD_CONTROLLER, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, mavlink.MAV_STATE_ACTIVE, 3
            )
        ]
        if self._vehicle is not None:
            out += [
                mavlink.MAVLink_command_long_message(
                    *self._vehicle, mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, 0, message_id, 1e6 / rate, 0, 0, 0, 0, 0
                )
                for message_id, rate in RATE_HZ.items()
            ]
        return [bytes(message.pack(self._encoder)) for message in out]

    def _handle(self, message: Any) -> None:
        kind = message.get_type()
        if kind == "HEARTBEAT" and message.autopilot != mavlink.MAV_AUTOPILOT_INVALID:
            self._vehicle = (message.get_srcSystem(), message.get_srcComponent())
        elif kind == "GLOBAL_POSITION_INT":
            self._take_position(message)
        elif kind == "ATTITUDE":
            self._take_attitude(message)
        elif kind == "SIM_STATE":
            self._take_truth(message)

    def _take_truth(self, message: Any) -> None:
        """Compare the estimate with the truth of about the same moment."""
        position = self._position
        if position is None or not message.lat_int or abs(self._stamp - position.stamp) > COMPARED_S:
            return
        position = position.at(self._stamp)
        place = (message.lat_int * 1e-7, message.lon_int * 1e-7, self._origin.altitude)
        north, east, _ = self._origin.to_world(*place)
        up = message.alt - self._origin.altitude
        seen = _Error(position.north - north, position.east - east, position.height - up, self._yaw - message.yaw)
        self._leaps = self._leaps + 1 if self._error.is_leap(seen) else 0
        if self._leaps == 0:
            self._error = self._error.towards(seen, FOLLOW_SHARE)
        elif self._leaps >= LEAP_LOOKS:
            self._error = self._error.towards(seen, 1.0)

    def _take_position(self, message: Any) -> None:
        north, east, _ = self._origin.to_world(message.lat * 1e-7, message.lon * 1e-7, self._origin.altitude)
        velocity = (message.vx * 0.01, message.vy * 0.01, message.vz * 0.01)
        self._position = _Position(message.time_boot_ms * 1e-3, north, east, message.relative_alt * 1e-3, velocity)

    def _take_attitude(self, message: Any) -> None:
        stamp = message.time_boot_ms * 1e-3
        self._stamp, self._yaw = stamp, message.yaw
        if self._next_slot - stamp > 1.0:
            self._next_slot = stamp  # the vehicle booted again
        position = self._position
        if position is None or stamp < self._next_slot or abs(stamp - position.stamp) > STALE_S:
            return
        is_late = stamp - self._next_slot > self._frame_s
        self._next_slot = (stamp if is_late else self._next_slot) + self._frame_s
        position, error = position.at(stamp), self._error
        self.last = Shot(
            stamp=stamp,
            slot=self._clock(),
            x_east=position.east - error.east,
            y_south=-(position.north - error.north),
            height=max(0.0, position.height - error.up),
            roll=message.roll,
            pitch=message.pitch,
            yaw=message.yaw - error.yaw,
        )
        self._shots.append(self.last)

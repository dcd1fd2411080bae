"""A second ground station on a link of its own: the true state of ArduPilot's simulation, parameters, commands."""

from __future__ import annotations

import asyncio
import math
import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

import shapely
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from hawk.model.vehicle import mode_name
from proving.faults.station import command_fields, parameter_fields

SYSTEM, COMPONENT = 254, 190
"""Our MAVLink id: another than the daemon's, whom the autopilot's ground-station failsafe watches."""
HARD_M_S: Final = 2.5
"""A drone that hits the ground faster has crashed; ArduCopter lands at 0.5 m/s."""
_RATES_HZ: Final = {
    mavlink.MAVLINK_MSG_ID_HEARTBEAT: 10,
    mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE: 10,
    mavlink.MAVLINK_MSG_ID_SIM_STATE: 20,
    mavlink.MAVLINK_MSG_ID_ATTITUDE: 20,
    mavlink.MAVLINK_MSG_ID_BATTERY_STATUS: 5,
}
_NEEDED: Final = frozenset({"HEARTBEAT", "SIM_STATE", "ATTITUDE", "EXTENDED_SYS_STATE"})
_ASK_S: Final = 1.0
_SET_S: Final = 0.5
_ITEM_S: Final = 0.1
_CHARGE_PERCENT: Final = 2.0
_SETTINGS: Final = 10  # times that a parameter is sent before it is given up
M_PER_DEG: Final = 111_195.0  # a sphere of 6371 km is right to 0.5 % over a lot
_HIT: Final = re.compile(r"SIM Hit ground at (?P<speed>[\d.]+)")


class Observer:
    """Hears the autopilot; `status` is what is true of the vehicle now."""

    def __init__(self) -> None:
        self._last: dict[str, Any] = {}
        self._home = (0.0, 0.0, 0.0)
        self._heard = asyncio.Event()
        self._crashed = False
        self._fence: shapely.Geometry | None = None
        self._farthest = 0.0
        self._decoder = mavlink.MAVLink(None)
        self._decoder.robust_parsing = True
        self._encoder = mavlink.MAVLink(None, srcSystem=SYSTEM, srcComponent=COMPONENT)
        self._autopilot: tuple[str, int] | None = None
        self._transport: asyncio.DatagramTransport | None = None
        self._asking: asyncio.Task[None] | None = None
        self._waiting: dict[str, tuple[float, asyncio.Event]] = {}

    async def open(self, host: str) -> int:
        """Listen on a free UDP port; return it."""
        loop = asyncio.get_running_loop()
        transport, _ = await loop.create_datagram_endpoint(lambda: _End(self._receive), local_addr=(host, 0))
        self._transport = transport
        self._asking = asyncio.create_task(self._ask(), name="observer")
        return int(transport.get_extra_info("sockname")[1])

    def close(self) -> None:
        """Close the socket."""
        if self._asking is not None:
            self._asking.cancel()
        if self._transport is not None:
            self._transport.close()

    async def wait_until_heard(self, home: tuple[float, float, float], timeout_s: float) -> None:
        """Wait for the first of every message that `status` needs; heights count from ``home``. Raises TimeoutError."""
        self._home = home
        async with asyncio.timeout(timeout_s):
            await self._heard.wait()

    def status(self) -> dict[str, Any]:
        """Return the state under the names of hawk-sim's ``/status``.

        Besides: ``from_home``, metres; ``outside`` and ``farthest_outside``, metres outside the watched fence, now and
        since it was set.
        """
        beat, state = self._last["HEARTBEAT"], self._last["SIM_STATE"]
        seconds = self._last["ATTITUDE"].time_boot_ms / 1000.0
        north, east = self._flat(state.lat_int * 1e-7, state.lon_int * 1e-7)
        return {
            "time": seconds,
            "time_boot": seconds,
            "mode": mode_name(beat.custom_mode),
            "landed": self._last["EXTENDED_SYS_STATE"].landed_state == mavlink.MAV_LANDED_STATE_ON_GROUND,
            "disarmed": not beat.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED,
            "crashed": self._crashed,
            "position": {
                "latitude": state.lat_int * 1e-7,
                "longitude": state.lon_int * 1e-7,
                "x": east,
                "y": -north,
                "height": state.alt - self._home[2],
            },
            "from_home": math.hypot(north, east),
            "outside": self._outside(),
            "farthest_outside": self._farthest,
        }

    @property
    def latitude(self) -> float:
        """Degrees, of the start."""
        return self._home[0]

    def watch_fence(self, polygon: list[tuple[float, float]]) -> None:
        """Measure from here on how far the true position leaves a polygon of (latitude, longitude)."""
        fence = shapely.Polygon([self._flat(*corner) for corner in polygon])
        shapely.prepare(fence)
        self._fence, self._farthest = fence, 0.0

    def send(self, kind: str, fields: Mapping[str, Any]) -> None:
        """Send the autopilot a message."""
        if self._transport is None or self._autopilot is None or self._transport.is_closing():
            return
        found = getattr(mavlink, f"MAVLink_{kind.lower()}_message")(**fields)
        self._transport.sendto(bytes(found.pack(self._encoder)), self._autopilot)

    async def upload(self, mission_type: int, items: Sequence[tuple[int, float, float, float, float]]) -> None:
        """Replace fence (1) or rally points (2): command, parameter 1, metres north and east of home, height above it.

        The autopilot takes the items in their order; they are sent without waiting for its requests.
        """
        address = {"target_system": 1, "target_component": 1, "mission_type": mission_type}
        if not items:
            self.send("MISSION_CLEAR_ALL", address)
            return
        self.send("MISSION_COUNT", {**address, "count": len(items)})
        for number, (command, parameter, north, east, height) in enumerate(items):
            await asyncio.sleep(_ITEM_S)
            place = {"x": self._degrees(north, 0, 1.0), "y": self._degrees(east, 1, self._shrink), "z": height}
            fields = {"seq": number, "frame": 3, "command": command, "current": 0, "autocontinue": 1}  # above home
            parameters = {"param1": parameter, "param2": 0.0, "param3": 0.0, "param4": 0.0}
            self.send("MISSION_ITEM_INT", {**address, **fields, **parameters, **place})

    def _degrees(self, metres: float, axis: int, shrink: float) -> int:
        return round((self._home[axis] + metres / (M_PER_DEG * shrink)) * 1e7)

    @property
    def _shrink(self) -> float:
        return math.cos(math.radians(self._home[0]))

    async def set_parameter(self, name: str, value: float) -> None:
        """Set a parameter and wait until the autopilot repeats it. Raises TimeoutError naming it."""
        done = asyncio.Event()
        self._waiting[name] = (value, done)
        try:
            for _ in range(_SETTINGS):
                self.send("PARAM_SET", parameter_fields(name, value))
                try:
                    async with asyncio.timeout(_SET_S):
                        await done.wait()
                except TimeoutError:
                    continue
                return
        finally:
            del self._waiting[name]
        raise TimeoutError(f"the autopilot does not take {name}={value:g}")

    async def set_charge(self, percent: float) -> None:
        """Reset the counted charge and wait until the autopilot says so. Raises TimeoutError."""
        for _ in range(_SETTINGS):
            self.send("COMMAND_LONG", command_fields(mavlink.MAV_CMD_BATTERY_RESET, 1.0, percent))
            await asyncio.sleep(_SET_S)
            said = self._last.get("BATTERY_STATUS")
            if said is not None and abs(said.battery_remaining - percent) <= _CHARGE_PERCENT:
                return
        raise TimeoutError(f"the autopilot does not take a battery of {percent:g} %")

    async def _ask(self) -> None:
        """Ask for the rates again and again: the autopilot may boot."""
        while True:
            for number, rate in _RATES_HZ.items():
                interval = command_fields(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, number, 1e6 / rate)
                self.send("COMMAND_LONG", interval)
            await asyncio.sleep(_ASK_S)

    def _receive(self, data: bytes, sender: tuple[str, int]) -> None:
        self._autopilot = sender
        for found in self._decoder.parse_buffer(data) or []:
            kind = found.get_type()
            if found.get_srcSystem() != 1 or (kind == "HEARTBEAT" and found.autopilot == mavlink.MAV_AUTOPILOT_INVALID):
                continue
            self._last[kind] = found
            if self._last.keys() >= _NEEDED:
                self._heard.set()
            if kind == "STATUSTEXT":
                self._read(str(found.text))
            elif kind == "PARAM_VALUE":
                self._hear(str(found.param_id), found.param_value)
            elif kind == "SIM_STATE":
                self._farthest = max(self._farthest, self._outside())

    def _read(self, text: str) -> None:
        hit = _HIT.search(text)
        self._crashed |= text.startswith("Crash:") or (hit is not None and float(hit["speed"]) > HARD_M_S)

    def _hear(self, name: str, value: float) -> None:
        wanted, done = self._waiting.get(name, (math.nan, None))
        if done is not None and math.isclose(value, wanted, rel_tol=1e-5, abs_tol=1e-6):
            done.set()

    def _outside(self) -> float:
        if self._fence is None or "SIM_STATE" not in self._last:
            return 0.0
        state = self._last["SIM_STATE"]
        return float(
            shapely.distance(self._fence, shapely.Point(self._flat(state.lat_int * 1e-7, state.lon_int * 1e-7)))
        )

    def _flat(self, latitude: float, longitude: float) -> tuple[float, float]:
        """Return metres north and east of home."""
        north = (latitude - self._home[0]) * M_PER_DEG
        return north, (longitude - self._home[1]) * M_PER_DEG * self._shrink


class _End(asyncio.DatagramProtocol):
    def __init__(self, receive: Callable[[bytes, tuple[str, int]], None]) -> None:
        self._receive = receive

    def datagram_received(self, data: bytes, addr: Any) -> None:
        self._receive(data, addr)

    def error_received(self, exc: Exception) -> None:
        """An autopilot that is down refuses datagrams."""

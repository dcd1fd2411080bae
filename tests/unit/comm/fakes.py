"""Stand-ins for the autopilot: its messages made by hand, and a link that remembers what was sent."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from hawk.comm.autopilot.mavlink_link import Link, Message, OnMessage, SensorHealth
from hawk.comm.autopilot.vehicle import AutopilotError, FenceRings
from hawk.comm.mavlink.peer import FIRST_HEARD, Expected
from hawk.comm.mavlink.udp_gate import NOBODY, Hearing

LATITUDE, LONGITUDE, ALTITUDE = 43.2609, -79.9192, 100.0
METRE_NORTH = 1 / 111_097.0  # degrees of latitude at LATITUDE
METRE_EAST = 1 / 81_196.0  # degrees of longitude at LATITUDE


class Said:
    """Makes the autopilot's messages; ``boot`` is its clock in seconds."""

    def __init__(self) -> None:
        self.boot = 100.0

    @property
    def ms(self) -> int:
        return round(self.boot * 1000)

    def heartbeat(self, *, armed: bool = False, mode: int = 4, autopilot: int = 3) -> tuple[str, dict[str, Any]]:
        return "HEARTBEAT", {
            "autopilot": autopilot, "base_mode": 81 + 128 * armed, "custom_mode": mode, "system_status": 4, "type": 2,
        }  # fmt: skip

    def landed(self, state: int) -> tuple[str, dict[str, Any]]:
        return "EXTENDED_SYS_STATE", {"landed_state": state, "vtol_state": 0}

    def local(
        self, x: float = 0.0, y: float = 0.0, z: float = 0.0, velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    ) -> tuple[str, dict[str, Any]]:
        vx, vy, vz = velocity
        return "LOCAL_POSITION_NED", {
            "time_boot_ms": self.ms, "x": x, "y": y, "z": z, "vx": vx, "vy": vy, "vz": vz,
        }  # fmt: skip

    def attitude(self, roll: float = 0.0, pitch: float = 0.0, yaw: float = 0.5) -> tuple[str, dict[str, Any]]:
        return "ATTITUDE", {"time_boot_ms": self.ms, "roll": roll, "pitch": pitch, "yaw": yaw}

    def world(self, north: float = 0.0, up: float = 0.0, east: float = 0.0) -> tuple[str, dict[str, Any]]:
        return "GLOBAL_POSITION_INT", {
            "time_boot_ms": self.ms,
            "lat": round((LATITUDE + north * METRE_NORTH) * 1e7),
            "lon": round((LONGITUDE + east * METRE_EAST) * 1e7),
            "alt": round((ALTITUDE + up) * 1000),
            "relative_alt": round(up * 1000),
        }

    def system_time(self, utc: float = 0.0) -> tuple[str, dict[str, Any]]:
        return "SYSTEM_TIME", {"time_boot_ms": self.ms, "time_unix_usec": round(utc * 1e6)}

    def home(self, north: float = 0.0) -> tuple[str, dict[str, Any]]:
        return "HOME_POSITION", {
            "latitude": round((LATITUDE + north * METRE_NORTH) * 1e7),
            "longitude": round(LONGITUDE * 1e7),
            "altitude": round(ALTITUDE * 1000),
        }

    def system(
        self, remaining: int = 80, millivolts: int = 15_800, centiamperes: int = 1200
    ) -> tuple[str, dict[str, Any]]:
        return "SYS_STATUS", {
            "battery_remaining": remaining, "voltage_battery": millivolts, "current_battery": centiamperes,
        }  # fmt: skip

    def gps(self, fix: int = 3, satellites: int = 12, accuracy_mm: int = 800) -> tuple[str, dict[str, Any]]:
        return "GPS_RAW_INT", {"fix_type": fix, "satellites_visible": satellites, "h_acc": accuracy_mm}

    def estimator(
        self, flags: int = 831, velocity: float | None = 0.01, position: float | None = 0.01, compass: float = 0.02
    ) -> tuple[str, dict[str, Any]]:
        """As a real ArduCopter reports a good position (flags 831)."""
        return "EKF_STATUS_REPORT", {
            "flags": flags, "velocity_variance": velocity, "pos_horiz_variance": position, "pos_vert_variance": 0.0,
            "compass_variance": compass, "terrain_alt_variance": 0.0,
        }  # fmt: skip

    def text(self, words: str, severity: int = 3) -> tuple[str, dict[str, Any]]:
        return "STATUSTEXT", {"text": words, "severity": severity, "id": 0, "chunk_seq": 0}


@dataclass
class FakeLink(Link):
    """A link without an autopilot: records what is sent, answers commands with ``results`` (0 where there is none)."""

    url: str
    system_id: int
    clock: Callable[[], float]
    on_message: OnMessage
    expected: Expected = FIRST_HEARD
    heard: Hearing = NOBODY
    sent: list[tuple[str, dict[str, Any]]] = field(default_factory=list)
    commanded: list[tuple[int, list[float]]] = field(default_factory=list)
    results: dict[int, int] = field(default_factory=dict)
    fences: list[FenceRings] = field(default_factory=list)
    held: FenceRings | None = None
    keeps: FenceRings | None = None
    """The fence that it holds after any upload; None: the uploaded one."""
    answer: Callable[[str, Mapping[str, Any]], None] = lambda _name, _fields: None
    before_ack: Callable[[], None] = lambda: None
    problems: list[str] = field(default_factory=list)
    health: SensorHealth = field(default_factory=lambda: SensorHealth(True, True, True, True))
    appears: bool = True
    found: bool = False
    opened: int = 0
    looked: int = 0
    reopened: int = 0
    closed: bool = False
    voices: list[bool] = field(default_factory=list)
    changed: threading.Event = field(default_factory=threading.Event)

    def say(self, message: tuple[str, dict[str, Any]], arrival: float | None = None) -> None:
        name, fields = message
        self.on_message(Message(name, fields, self.clock() if arrival is None else arrival))

    def open(self) -> None:
        self.opened += 1
        if self.problems:
            raise AutopilotError(self.problems.pop(0))

    def look_around(self) -> None:
        self.looked += 1

    def find(self, timeout_s: float) -> bool:
        self.found = self.appears
        return self.found

    def reopen(self) -> None:
        self.reopened += 1
        self.changed.set()

    def close(self) -> None:
        self.closed = True

    def hearing(self) -> Hearing:
        return self.heard

    def set_voice(self, speaks: bool) -> None:
        self.voices.append(speaks)

    def sensor_health(self) -> SensorHealth:
        return self.health

    def send(self, name: str, fields: Mapping[str, Any]) -> None:
        self.sent.append((name, dict(fields)))
        self.answer(name, fields)
        self.changed.set()

    def command(self, command: int, parameters: Sequence[float] = ()) -> int:
        self.commanded.append((command, list(parameters)))
        self.before_ack()
        return self.results.get(command, 0)

    def upload_fence(self, rings: FenceRings) -> None:
        self.fences.append(rings)
        self.held = rings if self.keeps is None else self.keeps

    def download_fence(self) -> FenceRings:
        if self.held is None:
            raise AutopilotError("The autopilot's fence has 0 inclusion polygons")
        return self.held

    def named(self, name: str) -> list[dict[str, Any]]:
        return [fields for sent, fields in self.sent if sent == name]


class Memory:
    """The parameters of an autopilot without one: answers PARAM_REQUEST_READ and PARAM_SET."""

    def __init__(self, values: Mapping[str, tuple[float, int]]) -> None:
        self.values = dict(values)
        self.deaf = 0
        self.stubborn: set[str] = set()
        self.late: dict[str, int] = {}
        """Reads that still give the old value after a set was confirmed, by name."""
        self._old: dict[str, tuple[float, int]] = {}
        self.asked: list[tuple[str, str]] = []

    def answer(self, name: str, fields: Mapping[str, Any]) -> dict[str, Any] | None:
        """Return the fields of the PARAM_VALUE that answers, None for silence."""
        if name not in {"PARAM_REQUEST_READ", "PARAM_SET"}:
            return None
        parameter = str(fields["param_id"])
        self.asked.append((name, parameter))
        if self.deaf:
            self.deaf -= 1
            return None
        if parameter not in self.values:
            return None
        if name == "PARAM_SET" and parameter not in self.stubborn:
            self._old.setdefault(parameter, self.values[parameter])
            self.values[parameter] = (fields["param_value"], fields["param_type"])
        value, kind = self.values[parameter]
        if name == "PARAM_REQUEST_READ" and parameter in self._old and self.late.get(parameter, 0) > 0:
            self.late[parameter] -= 1
            value, kind = self._old[parameter]
        return {"param_id": parameter, "param_value": value, "param_type": kind, "param_index": 0, "param_count": 9}

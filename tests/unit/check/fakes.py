"""Stand-ins for what the checks ask: a camera, an autopilot's link, a folder of processes."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncGenerator, Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from hawk.check.autopilot import AutopilotTools, ReadingLink
from hawk.comm.autopilot.mavlink_link import Message, OnMessage, SensorHealth
from hawk.comm.cameras.sources.source import CameraError, CameraSource, SourceFrame
from hawk.comm.clock import Clock
from hawk.comm.mavlink.peer import Expected
from hawk.comm.mavlink.udp_gate import NOBODY, Hearing
from hawk.runtime.programs import Processes
from tests.unit.comm.fakes import FakeLink, Said

GOOD: dict[str, float] = {
    "FS_GCS_ENABLE": 1, "FS_GCS_TIMEOUT": 5, "FS_THR_ENABLE": 1, "FS_EKF_ACTION": 1, "FS_EKF_THRESH": 0.8,
    "BATT_FS_LOW_ACT": 2, "BATT_FS_CRT_ACT": 1, "FENCE_TYPE": 5, "FENCE_ACTION": 1, "FENCE_ENABLE": 1,
    "FS_OPTIONS": 16, "MAV_GCS_SYSID": 245, "MAV_GCS_SYSID_HI": 0, "RTL_ALT_M": 20, "RTL_ALT_FINAL_M": 0,
    "RTL_CLIMB_MIN_M": 0, "RTL_ALT_TYPE": 0, "RALLY_TOTAL": 0, "BATT_LOW_VOLT": 14.0, "BATT_LOW_TIMER": 10,
    "BATT_LOW_MAH": 0, "BATT_CRT_VOLT": 0, "BATT_CRT_MAH": 0, "BATT_CAPACITY": 5000, "FLTMODE_CH": 5,
    "FENCE_ALT_MAX": 100, "FENCE_TOTAL": 0, "RTL_LOIT_TIME": 5000, "RTL_SPEED_MS": 0,
    "FLTMODE1": 5, "FLTMODE2": 5, "FLTMODE3": 4, "FLTMODE4": 4, "FLTMODE5": 6, "FLTMODE6": 6,
}  # fmt: skip
"""Parameters of an autopilot whose failsafes are right."""


class Pictures(CameraSource):
    """A source that gives a picture at a pace, and a CameraError where there is none."""

    def __init__(self, jpeg: bytes | None, clock: Clock, pause_s: float = 0.01, count: int = 10**6) -> None:
        self.jpeg, self.clock, self.pause_s, self.count = jpeg, clock, pause_s, count
        self.closed = False

    async def frames(self) -> AsyncGenerator[SourceFrame, None]:
        if self.jpeg is None:
            raise CameraError("v4l2:///dev/video7: there is no such device")
        for _ in range(self.count):
            yield SourceFrame(self.jpeg, self.clock())
            await asyncio.sleep(self.pause_s)
        await asyncio.Event().wait()

    async def close(self) -> None:
        self.closed = True


class FakeReadingLink(ReadingLink, FakeLink):
    """The link of a check over one that remembers what was sent."""


class FakeVehicle:
    """An autopilot that is heard, and answers reads from ``values``. ``said``: what comes with each heartbeat."""

    def __init__(
        self, values: Mapping[str, float], *, is_heard: bool = True, is_armed: bool = False, beat: Any = None
    ) -> None:
        self.values = dict(values)
        self.is_heard, self.is_armed = is_heard, is_armed
        self.settle_s = 0.05
        self.hearing: Hearing = NOBODY
        self.health = SensorHealth(True, True, True, True)
        self.beat = beat or {}
        self.problems: list[str] = []
        self.links: list[FakeReadingLink] = []
        self.others: list[tuple[str, dict[str, Any]]] = []

    @property
    def link(self) -> FakeReadingLink:
        return self.links[-1]

    def tools(self, proc: Path) -> AutopilotTools:
        return AutopilotTools(self._make, Processes(proc), find_s=1.0, settle_s=self.settle_s, parameter_answer_s=0.01)

    def _make(self, url: str, system_id: int, clock: Clock, on_message: OnMessage, expected: Expected) -> FakeLink:
        link = FakeReadingLink(url, system_id, clock, on_message, expected)
        link.answer, link.heard, link.problems = self._answer, self.hearing, self.problems
        link.appears, link.health = self.is_heard, self.health
        self.links.append(link)
        find = link.find

        def found(timeout_s: float) -> bool:
            is_found = find(timeout_s)
            if is_found:
                self._speak(on_message, clock)
            return is_found

        link.find = found  # type: ignore[method-assign]
        return link

    def _speak(self, on_message: OnMessage, clock: Clock) -> None:
        said = Said()
        name, fields = said.heartbeat(armed=self.is_armed)
        system, status = said.system()
        status["onboard_control_sensors_enabled"] = 1 << 20  # MAV_SYS_STATUS_GEOFENCE
        for message in ((name, {**fields, **self.beat}), (system, status), *self.others):
            on_message(Message(*message, clock()))

    def _answer(self, name: str, fields: Mapping[str, Any]) -> None:
        parameter = fields.get("param_id")
        if name == "PARAM_REQUEST_READ" and parameter in self.values:
            answer = {"param_id": parameter, "param_value": float(self.values[parameter]), "param_type": 9}
            self.link.on_message(Message("PARAM_VALUE", answer, self.link.clock()))


def write_process(
    proc: Path,
    number: int,
    command: Sequence[str],
    files: Sequence[str] = (),
    link: Callable[..., None] = Path.symlink_to,
) -> None:
    """Write what ``/proc`` holds of a process; ``files``: the targets of its descriptors."""
    folder = proc / str(number)
    (folder / "fd").mkdir(parents=True)
    (folder / "cmdline").write_bytes(b"\0".join(word.encode() for word in command) + b"\0")
    for descriptor, target in enumerate(files):
        link(folder / "fd" / str(descriptor), target)


def write_sockets(proc: Path, kind: str, *sockets: tuple[int, str, int]) -> None:
    """Write ``/proc/net/KIND``: port, state, inode of each socket."""
    lines = [
        f"   0: 0100007F:{port:04X} 00000000:0000 {state} 00000000:00000000 00:00000000 00000000 1000 0 {inode} 1 0 0"
        for port, state, inode in sockets
    ]
    (proc / "net").mkdir(parents=True, exist_ok=True)
    (proc / "net" / kind).write_text("\n".join(["  sl  local_address ...", *lines]) + "\n")

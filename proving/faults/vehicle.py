"""A real ArduCopter in software-in-the-loop, hawk-sim's camera over it, and a daemon that flies it.

The program is ArduPilot's (licence GPL-3). It is started as a child and spoken to by MAVLink; it is no part of hawk.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import socket
import struct
import sys
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any, Final

import aiohttp

from hawk.comm.autopilot.commands import MavCommand
from hawk.sim.launch import (
    READY_TIMEOUT_S,
    SimulationAddress,
    SimulationError,
    SimulationOptions,
    end_process,
    free_udp_port,
)
from hawk.survey.stack import SimulatedStack
from proving.faults.fault import Drone, Fault
from proving.faults.gnss_error import FIELDS, GnssError
from proving.faults.observer import Observer
from proving.faults.station import FORCE, command_fields, parameter_fields

HOST: Final = "127.0.0.1"
HEARD_TIMEOUT_S: Final = 60.0
STOP_TIMEOUT_S: Final = 5.0
_MIDDLE, _LOWEST = 1500, 1000  # pulse widths of a remote control, microseconds
_THROTTLE: Final = 2  # its channel, counted from 0
_CHANNELS: Final = 16
_CAMERA: Final = frozenset({"camera", "camera_turn_deg"})
_FULL_V: Final = 12.6
"""SIM_BATT_VOLTAGE at first."""
_FENCE, _RALLY = 1, 2  # MAV_MISSION_TYPE
_FENCE_CORNER, _RALLY_POINT = 5001, 5100  # MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION, MAV_CMD_NAV_RALLY_POINT
_BY_STATION: Final = frozenset({"parameters", "fence", "rally"})
_FIRST: Final = -15
"""Niceness of the sessions that stand for a drone; the daemon sets its own when it runs."""


class UnknownFaultError(ValueError):
    """A fault that a real vehicle cannot be given; the text names it."""


@dataclass(frozen=True, slots=True)
class ArduCopter:
    """The program, its defaults (parameter file), and the instance, which shifts its own TCP and UDP ports by tens."""

    program: Path
    defaults: Path
    instance: int = 0

    def command(self, home: tuple[float, float, float], ports: Ports) -> list[str]:
        """Return the command line. ``home``: latitude, longitude (degrees), metres above sea level."""
        latitude, longitude, altitude = home
        links = (ports.daemon, ports.camera, ports.observer)
        serials = [f"--serial{number}=udpclient:{HOST}:{port}" for number, port in enumerate(links)]
        unused = [f"--serial{number}=none:0" for number in (5, 6, 7, 8)]  # 3 and 4 are its two GPS receivers
        return [
            str(self.program.absolute()),
            "--model=quad",
            "--speedup=1",
            f"--home={latitude:.7f},{longitude:.7f},{altitude:.1f},0",
            f"--instance={self.instance}",
            f"--rc-in-port={ports.radio}",
            f"--defaults={self.defaults.absolute()}",
            *serials,
            *unused,
        ]


@dataclass(frozen=True, slots=True)
class Ports:
    """UDP ports on the loopback: three links that the autopilot sends to, and its receiver of remote control."""

    daemon: int
    camera: int
    observer: int
    radio: int


class VehiclePrograms:
    """The autopilot and hawk-sim's camera, which follows it; an observer on a link of its own."""

    def __init__(self, copter: ArduCopter, options: SimulationOptions, folder: Path) -> None:
        self.observer = Observer()
        self._copter = copter
        self._options = options
        self._folder = folder
        self._processes: list[asyncio.subprocess.Process] = []
        self._drain: asyncio.Task[None] | None = None
        self._log: IO[bytes] | None = None
        self._radio = 0

    async def start(self, log: int | None = None) -> SimulationAddress:
        """Start camera and autopilot; return their addresses. Raises SimulationError."""
        observed = await self.observer.open(HOST)
        ports = Ports(free_udp_port(), free_udp_port(), observed, free_udp_port())
        self._radio = ports.radio
        http = await self._start_camera(ports.camera, log)
        start = (await _get(f"{http}/truth"))["start"]
        home = (start["latitude"], start["longitude"], start["altitude"])
        self._folder.mkdir(parents=True, exist_ok=True)
        self._log = (self._folder / "arducopter.log").open("ab")
        command = self._copter.command(home, ports)
        await self._spawn(command, cwd=self._folder, stdout=self._log, stderr=self._log)
        try:
            await self.observer.wait_until_heard(home, HEARD_TIMEOUT_S)
        except TimeoutError:
            await self.stop()
            text = f"{self._copter.program} was not heard within {HEARD_TIMEOUT_S:.0f} s ({self._log.name})"
            raise SimulationError(text) from None
        return SimulationAddress(http, f"udpin://{HOST}:{ports.daemon}")

    def move_stick(self, throttle: float) -> None:
        """Hold the remote control's throttle stick there, 0..1; the other channels stay as they are."""
        pulses = [0] * _CHANNELS  # a zero leaves its channel as it is
        pulses[_THROTTLE] = round(_LOWEST + 2 * (_MIDDLE - _LOWEST) * throttle)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            sender.sendto(struct.pack(f"<{_CHANNELS}H", *pulses), (HOST, self._radio))

    async def stop(self) -> None:
        """End both processes, by force after `STOP_TIMEOUT_S`."""
        self.observer.close()
        for process in reversed(self._processes):
            await end_process(process, STOP_TIMEOUT_S)
        if self._drain is not None:
            self._drain.cancel()
            await asyncio.gather(self._drain, return_exceptions=True)
        if self._log is not None:
            self._log.close()

    async def _start_camera(self, port: int, log: int | None) -> str:
        """Start hawk-sim's camera; return its URL."""
        command = [sys.executable, "-m", "hawk.sim.cli", *self._options.arguments()]
        command += [f"--follow=udpin:{HOST}:{port}", f"--http={HOST}:0", f"--parent-pid={os.getpid()}"]
        process = await self._spawn(command, stdout=asyncio.subprocess.PIPE, stderr=log)
        assert process.stdout is not None
        try:
            async with asyncio.timeout(READY_TIMEOUT_S):
                async for raw in process.stdout:
                    if raw.startswith(b"{"):
                        self._drain = asyncio.create_task(_drain(process.stdout), name="hawk-sim output")
                        return str(json.loads(raw)["http"]).rstrip("/")
        except TimeoutError:
            pass
        await self.stop()
        raise SimulationError("hawk-sim --follow did not become ready; see its message above")

    async def _spawn(self, command: list[str], **options: Any) -> asyncio.subprocess.Process:
        try:
            process = await asyncio.create_subprocess_exec(
                *command, stdin=asyncio.subprocess.DEVNULL, start_new_session=True, **options
            )
        except OSError as error:
            await self.stop()
            raise SimulationError(f"{command[0]} cannot be started: {error.strerror}") from None
        self._processes.append(process)
        _go_first(process.pid)
        return process


class VehicleStack(SimulatedStack):
    """The daemon on a real ArduCopter, behind the interface of the simulated stack."""

    def __init__(
        self,
        copter: ArduCopter,
        options: SimulationOptions,
        folder: Path,
        config: Path | None,
        link: Callable[[str], Awaitable[str]] | None = None,
    ) -> None:
        self._vehicle = VehiclePrograms(copter, options, folder / "arducopter")
        self._gnss = GnssError(lambda name, value: self.station("PARAM_SET", parameter_fields(name, value)))
        super().__init__(options, folder, config, None, link, self._vehicle)

    async def stop(self) -> None:
        """End the programs."""
        self._gnss.stop()
        await super().stop()

    async def status(self) -> dict[str, Any]:
        """Return the true state of the vehicle, from ArduPilot's own simulation."""
        return self._vehicle.observer.status()

    async def inject(self, fault: Mapping[str, Any]) -> None:
        """Inject or clear faults under the names of hawk-sim. Raises UnknownFaultError."""
        for name, value in simulation_parameters(fault).items():
            await self._vehicle.observer.set_parameter(name, value)
        if FIELDS & fault.keys():
            self._gnss.take(fault, self._vehicle.observer.latitude)
        if "motors" in fault:
            self.station("COMMAND_LONG", command_fields(MavCommand.COMPONENT_ARM_DISARM, 0.0, FORCE))
        for name, value in fault.get("parameters", {}).items():
            self.station("PARAM_SET", parameter_fields(name, value))
        if "fence" in fault:
            ring = fault["fence"]
            corners = [(_FENCE_CORNER, float(len(ring)), north, east, 0.0) for north, east in ring]
            await self._vehicle.observer.upload(_FENCE, corners)
        if "rally" in fault:
            points = [(_RALLY_POINT, 0.0, north, east, up) for north, east, up in fault["rally"]]
            await self._vehicle.observer.upload(_RALLY, points)
        if "battery" in fault:
            await self._vehicle.observer.set_charge(float(fault["battery"]))
        if "stick" in fault:
            self._vehicle.move_stick(float(fault["stick"]))
        if "pilot_mode" in fault:
            self.station("COMMAND_LONG", command_fields(MavCommand.DO_SET_MODE, 1.0, float(fault["pilot_mode"])))
        if of_camera := {name: value for name, value in fault.items() if name in _CAMERA}:
            await super().inject(of_camera)

    async def watch_fence(self, polygon: list[tuple[float, float]], ceiling: float) -> None:  # noqa: ARG002
        """Measure from here on how far the true position leaves this fence (latitude, longitude), seen from above."""
        self._vehicle.observer.watch_fence(polygon)

    def station(self, kind: str, fields: Mapping[str, Any]) -> None:
        """Send the autopilot a message from a second ground station, on a link of its own."""
        self._vehicle.observer.send(kind, fields)

    def _began(self, session: int) -> None:
        _go_first(session)  # a service manager starts it with the unit's Nice; later it sets its own

    def _attached(self) -> list[str]:
        """Let the daemon know that its pictures bear the autopilot's time: on a busy machine they are drawn late."""
        assert self.address is not None
        return ["--attach-sim", self.address.http]


def simulation_parameters(fault: Mapping[str, Any]) -> dict[str, float]:
    """Return the parameters of ArduPilot's simulation that stand for faults of hawk-sim. Raises UnknownFaultError."""
    values: dict[str, float] = {}
    for name, value in fault.items():
        match name, value:
            case ("gps", "ok" | "lost"):
                values["SIM_GPS1_ENABLE"] = float(value == "ok")
            case ("radio", "ok" | "lost"):
                values["SIM_RC_FAIL"] = float(value == "lost")
            case ("wind", _):
                values |= {"SIM_WIND_T": 1.0, "SIM_WIND_SPD": float(value)}  # type 1: the same at each height
            case ("wind_heading_deg", _):
                values["SIM_WIND_DIR"] = (float(value) + 180.0) % 360.0  # theirs is where it comes from
            case ("baro_drift", _):
                values["SIM_BARO_DRIFT"] = float(value)
            case ("compass", "ok" | "lost"):
                values |= {f"SIM_MAG{number}_FAIL": float(value == "lost") for number in (1, 2, 3)}
            case ("battery_rest_v", _):
                values["SIM_BATT_VOLTAGE"] = float(value) or _FULL_V
            case (str() as by_station, _) if by_station in _BY_STATION:
                pass
            case ("motors", "off") | ("gps_glitch" | "gps_walk", _):
                pass
            case ("link", "ok") | ("battery" | "stick" | "pilot_mode" | "camera" | "camera_turn_deg", _):
                pass
            case _:
                raise UnknownFaultError(f"{name}={value}: a real vehicle cannot be given this fault")
    return values


def can_be_given(fault: Fault) -> bool:
    """Return True when a real vehicle can be given a fault of the simulated drone."""
    for step in fault.steps:
        if isinstance(step, Drone):
            try:
                simulation_parameters(step.values)
            except UnknownFaultError:
                return False
    return True


def _go_first(session: int) -> None:
    """Let a session go before others, where we may: real time does not wait for what else a computer does."""
    with contextlib.suppress(OSError):
        Path(f"/proc/{session}/autogroup").write_text(str(_FIRST))


async def _get(url: str) -> dict[str, Any]:
    async with aiohttp.ClientSession() as session, session.get(url) as response:
        response.raise_for_status()
        return dict(await response.json())


async def _drain(stream: asyncio.StreamReader) -> None:
    async for _ in stream:
        pass

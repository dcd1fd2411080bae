"""hawk-sim as a process, and the real MAVSDK connected to it."""

from __future__ import annotations

import contextlib
import json
import os
import socket
import subprocess
import sys
import threading
import time
import urllib.request
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from mavsdk import ComponentType, Configuration, Mavsdk
from mavsdk.plugins.action import Action
from mavsdk.plugins.geofence import Geofence
from mavsdk.plugins.mavlink_direct import MavlinkDirect, MavlinkMessage
from mavsdk.plugins.mission_raw import MissionRaw
from mavsdk.plugins.param import Param
from mavsdk.plugins.telemetry import Telemetry

from hawk.sim.launch import free_udp_port
from tests.pace import PATIENCE_S

__all__ = ["Pilot", "free_tcp_port", "free_udp_port", "get_json", "simulation", "small_picture"]


def free_tcp_port() -> int:
    """Return a TCP port of the loopback that nobody listens on."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def small_picture(folder: Path) -> Path:
    """Write a picture of 60 x 60 m at half a metre a pixel: a world that is ready at once."""
    path = folder / "world.png"
    rng = np.random.default_rng(1)
    cv2.imwrite(str(path), rng.integers(0, 255, (120, 120, 3), dtype=np.uint8))
    return path


@contextlib.contextmanager
def simulation(*arguments: str) -> Iterator[dict[str, str]]:
    """Run hawk-sim; yields its ready line. It ends with status 0."""
    command = [sys.executable, "-m", "hawk.sim.cli", "--http=127.0.0.1:0", f"--parent-pid={os.getpid()}", *arguments]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        try:
            yield json.loads(process.stdout.readline())
        finally:
            process.terminate()
            status = process.wait(PATIENCE_S)
        assert status == 0


def get_json(url: str, body: Any = None) -> Any:
    """GET, or POST a JSON body."""
    data = None if body is None else json.dumps(body).encode()
    with urllib.request.urlopen(urllib.request.Request(url, data), timeout=PATIENCE_S) as answer:  # noqa: S310
        return json.loads(answer.read())


class Pilot:
    """MAVSDK 4 connected to one autopilot. Every message and text that comes is noted."""

    def __init__(self, url: str, system_id: int = 245) -> None:
        configuration = Configuration.create_with_component_type(ComponentType.GROUND_STATION)
        configuration.system_id = system_id
        self._mavsdk = Mavsdk(configuration)
        self._changed = threading.Condition()
        self.messages: dict[str, dict[str, Any]] = {}
        self.counts: dict[str, int] = {}
        self.texts: list[str] = []
        self.landed: list[int] = []
        self.connected: list[bool] = []
        self.connection = self._mavsdk.add_any_connection_with_handle(url)
        system = self._mavsdk.first_autopilot(PATIENCE_S)
        assert system is not None, "MAVSDK found no autopilot"
        self.system = system
        self.action = Action(system)
        self.telemetry = Telemetry(system)
        self.parameters = Param(system)
        self.geofence = Geofence(system)
        self.missions = MissionRaw(system)
        self.direct = MavlinkDirect(system)
        self.direct.subscribe_message("", self._take_message)
        self.telemetry.subscribe_status_text(self._take_text)
        self.telemetry.subscribe_landed_state(self._take_landed)
        system.subscribe_is_connected(self._take_connected)

    def close(self) -> None:
        """Disconnect."""
        self._mavsdk.destroy()

    def wait(self, condition: Callable[[], bool], timeout: float = PATIENCE_S) -> float:
        """Wait until something holds; return the seconds that it took. Fails with TimeoutError."""
        start = time.monotonic()
        with self._changed:
            if not self._changed.wait_for(condition, timeout):
                raise TimeoutError(f"not within {timeout} s; texts {self.texts[-5:]}")
        return time.monotonic() - start

    def pause(self, seconds: float) -> None:
        """Let real time pass where no message can be awaited."""
        with self._changed:
            self._changed.wait_for(lambda: False, seconds)

    def forget(self) -> None:
        """Drop every message heard so far."""
        with self._changed:
            self.messages.clear()
            self.counts.clear()

    def command(self, number: int, *parameters: float) -> int:
        """Send COMMAND_LONG; return the result of the acknowledgement."""
        fields: dict[str, Any] = {"target_system": 1, "target_component": 1, "command": number, "confirmation": 0}
        for index in range(7):
            fields[f"param{index + 1}"] = parameters[index] if index < len(parameters) else 0.0
        answer = self.direct.send_command(MavlinkMessage("COMMAND_LONG", 245, 190, 1, 1, json.dumps(fields)))
        return int(json.loads(answer.fields_json)["result"])

    def guided(self) -> None:
        """Set GUIDED by DO_SET_MODE."""
        assert self.command(176, 1, 4) == 0

    def target(self, x: float, y: float, z: float, yaw: float = 0.0) -> None:
        """Send one SET_POSITION_TARGET_LOCAL_NED: position and yaw."""
        zeros = dict.fromkeys(("vx", "vy", "vz", "afx", "afy", "afz", "yaw_rate"), 0.0)
        fields = {
            "time_boot_ms": 0,
            "target_system": 1,
            "target_component": 1,
            "coordinate_frame": 1,
            "type_mask": 2552,
            "x": x,
            "y": y,
            "z": z,
            "yaw": yaw,
            **zeros,
        }
        self.direct.send_message(MavlinkMessage("SET_POSITION_TARGET_LOCAL_NED", 245, 190, 1, 1, json.dumps(fields)))

    @property
    def local(self) -> tuple[float, float, float]:
        """The last EKF-local position."""
        message = self.messages["LOCAL_POSITION_NED"]
        return message["x"], message["y"], message["z"]

    def ready(self) -> None:
        """Ask for the streams that a daemon needs, and wait until the vehicle is healthy."""
        self.telemetry.set_rate_health(5.0)
        self.telemetry.set_rate_position(5.0)
        self.telemetry.set_rate_battery(2.0)
        self.telemetry.set_rate_position_velocity_ned(20.0)
        self.telemetry.set_rate_attitude_euler(20.0)
        self.wait(lambda: self.telemetry.health_all_ok() and "LOCAL_POSITION_NED" in self.messages)

    def take_off(self, height: float) -> None:
        """Arm and climb."""
        self.guided()
        self.action.arm()
        self.action.set_takeoff_altitude(height)
        self.action.takeoff()
        self.wait(lambda: self.local[2] < 0.5 - height)

    def _take_message(self, message: MavlinkMessage, _: object = None) -> None:
        with self._changed:
            self.messages[message.message_name] = json.loads(message.fields_json)
            self.counts[message.message_name] = self.counts.get(message.message_name, 0) + 1
            self._changed.notify_all()

    def _take_text(self, text: Any, _: object = None) -> None:
        with self._changed:
            self.texts.append(text.text)
            self._changed.notify_all()

    def _take_landed(self, state: Any, _: object = None) -> None:
        with self._changed:
            if not self.landed or self.landed[-1] != int(state):
                self.landed.append(int(state))
            self._changed.notify_all()

    def _take_connected(self, connected: bool, _: object = None) -> None:
        with self._changed:
            self.connected.append(connected)
            self._changed.notify_all()

"""A ground station on a hand-moved simulation: no sockets, no real time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from hawk.sim.autopilot.autopilot import Autopilot
from hawk.sim.autopilot.parameters import AutopilotOptions
from hawk.sim.geometry import Origin
from hawk.sim.link.mavlink_link import MavlinkLink

STREAM_IDS = (0, 1, 24, 30, 32, 33, 147, 242, 245)


class GroundStation:
    """An autopilot, its link, and what it said."""

    def __init__(self, options: AutopilotOptions, system: int = 245) -> None:
        self.autopilot = Autopilot(options, Origin(), np.random.default_rng(7))
        self.link = MavlinkLink(self.autopilot, np.random.default_rng(8))
        self.heard: list[Any] = []
        self.system = system
        self._encoder = mavlink.MAVLink(None, srcSystem=system, srcComponent=190)
        self._decoder = mavlink.MAVLink(None)

    def run(self, seconds: float, until: Callable[[], bool] | None = None, heartbeat: bool = False) -> float:
        """Let time pass, or until something holds; return the seconds that passed."""
        start = self.autopilot.time
        due = start
        while self.autopilot.time < start + seconds - 1e-9:
            if heartbeat and self.autopilot.time >= due:
                due += 1.0
                self.heartbeat()
            self.autopilot.step()
            self.listen()
            if until is not None and until():
                break
        return self.autopilot.time - start

    def listen(self) -> None:
        """Take what is due without letting time pass."""
        for data in self.link.poll():
            self.heard += self._decoder.parse_buffer(data) or []

    def send(self, message: Any) -> None:
        """Send one message."""
        self.link.receive(bytes(message.pack(self._encoder)))

    def heartbeat(self) -> None:
        """Say that we are there."""
        self.send(mavlink.MAVLink_heartbeat_message(mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 4, 3))

    def command(self, number: int, *parameters: float) -> int | None:
        """Send COMMAND_LONG; return the MAV_RESULT, None without an answer."""
        self.heard = [message for message in self.heard if message.get_type() != "COMMAND_ACK"]
        padded = [*parameters, *([0.0] * (7 - len(parameters)))]
        self.send(mavlink.MAVLink_command_long_message(1, 1, number, 0, *padded))
        self.listen()
        acknowledged = [message.result for message in self.all("COMMAND_ACK") if message.command == number]
        return acknowledged[-1] if acknowledged else None

    def stream(self, *message_ids: int, hertz: float = 10.0) -> None:
        """Ask for streams."""
        for message_id in message_ids:
            assert self.command(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, message_id, 1e6 / hertz) == 0

    def all(self, kind: str) -> list[Any]:
        """Return every message of a kind, oldest first."""
        return [message for message in self.heard if message.get_type() == kind]

    def last(self, kind: str) -> Any:
        """Return the newest message of a kind."""
        return self.all(kind)[-1]

    def texts(self) -> list[str]:
        """Return what came as STATUSTEXT."""
        return [message.text for message in self.all("STATUSTEXT")]

    def mode(self, number: int) -> int | None:
        """Ask for a mode by DO_SET_MODE."""
        return self.command(mavlink.MAV_CMD_DO_SET_MODE, 1, number)

    def arm(self) -> int | None:
        """Arm."""
        return self.command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1)

    def wait_for_position(self) -> None:
        """Let the GNSS settle."""
        self.run(30.0, until=lambda: self.autopilot.position_ok)
        self.run(0.3)

    def fly(self, height: float = 12.0) -> None:
        """Arm and hover in GUIDED."""
        if not self.autopilot.position_ok:
            self.wait_for_position()
        assert self.mode(4) == 0
        assert self.arm() == 0
        assert self.command(mavlink.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, 0, 0, 0, height) == 0
        self.run(60.0, until=lambda: self.autopilot.body.height > height - 0.5)
        self.run(2.0)

    def local_target(
        self,
        x: float = 0.0,
        y: float = 0.0,
        z: float = -12.0,
        yaw: float = 0.0,
        *,
        mask: int = 2552,
        velocity: tuple[float, float, float] = (0.0, 0.0, 0.0),
        frame: int = 1,
    ) -> None:
        """Send SET_POSITION_TARGET_LOCAL_NED, position and yaw unless the mask says otherwise."""
        self.send(
            mavlink.MAVLink_set_position_target_local_ned_message(
                0, 1, 1, frame, mask, x, y, z, *velocity, 0.0, 0.0, 0.0, yaw, 0.0
            )
        )

    def set_parameter(self, name: str, value: float, kind: int = 9) -> None:
        """Send PARAM_SET."""
        self.send(mavlink.MAVLink_param_set_message(1, 1, name.encode(), value, kind))
        self.listen()

    def local(self) -> tuple[float, float, float]:
        """Return EKF-local now."""
        place = self.autopilot.local_position
        assert place is not None
        return place


Make = Callable[..., GroundStation]


@pytest.fixture
def make_station() -> Make:
    """Return a maker of ground stations: options of the autopilot by name."""

    def make(system: int = 245, **changes: Any) -> GroundStation:
        calm = AutopilotOptions(gnss_sigma=0.0, gnss_wait_s=0.5)
        return GroundStation(replace(calm, **changes), system)

    return make


@pytest.fixture
def station(make_station: Make) -> GroundStation:
    """A drone on the ground, just booted, without wind or drift."""
    return make_station()


@pytest.fixture
def flying(station: GroundStation) -> GroundStation:
    """A drone that hovers 12 m up in GUIDED."""
    station.fly()
    station.heard.clear()
    return station

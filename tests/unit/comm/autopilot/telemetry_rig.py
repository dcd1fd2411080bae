"""Telemetry that is given an autopilot's messages by hand, on a clock that is moved by hand."""

from __future__ import annotations

from typing import Any

from hawk.comm.autopilot.mavlink_link import Message, SensorHealth
from hawk.comm.autopilot.streams import RateKeeper, wanted_streams
from hawk.comm.autopilot.telemetry import Telemetry
from hawk.comm.autopilot.vehicle import VehicleTopics
from hawk.model.moment import Moment
from hawk.model.poses import ArmPlace, GlobalPose
from tests.manual_clock import ManualClock
from tests.unit.comm.fakes import Said

WALL = 1_800_000_000.0
UP = 3600.0
"""Seconds for which this computer has run when the rig is made."""
ON_GROUND, IN_AIR = 1, 2


class Rig:
    """Telemetry with a clock that is moved by hand; the autopilot's messages arrive without delay."""

    def __init__(self, speed: float = 1.0) -> None:
        self.clock = ManualClock(50.0)
        self.clock.speed = speed
        self.topics = VehicleTopics.create(self.clock)
        self.rates = RateKeeper(wanted_streams(20.0))
        self.health = SensorHealth(True, True, True, True)
        self.now = Moment("host", UP, WALL)
        self.boots = 0
        self.telemetry = Telemetry(
            self.clock, self.topics, self.rates, lambda: self.health, lambda: self.now, self.count_boot
        )
        self.said = Said()
        self.places: list[ArmPlace] = []
        self.jumps: list[float] = []
        self.topics.arm_place.listen(self.places.append)
        self.topics.frame_jump.listen(self.jumps.append)

    def count_boot(self) -> None:
        self.boots += 1

    def take(self, *messages: tuple[str, dict[str, Any]]) -> None:
        for name, fields in messages:
            self.telemetry.handle(Message(name, fields, self.clock()))

    def origin(self) -> GlobalPose | None:
        return self.telemetry.tie.fence_origin

    def advance(self, seconds: float = 0.05) -> None:
        self.clock.advance(seconds)
        self.said.boot += seconds
        self.pass_host(seconds)

    def pass_host(self, seconds: float) -> None:
        self.now = self.now.before(-seconds)

    def fly(
        self,
        seconds: float,
        ekf: tuple[float, float, float] = (0.0, 0.0, 0.0),
        north: float = 0.0,
        up: float = 0.0,
        east: float = 0.0,
    ) -> None:
        """Stand still somewhere for a while, saying so."""
        for _ in range(round(seconds / 0.05)):
            self.advance()
            self.take(self.said.attitude(), self.said.local(*ekf), self.said.world(north, up, east))

    def arm_here(self, ekf: tuple[float, float, float] = (0.0, 0.0, 0.0), north: float = 0.0) -> None:
        self.take(self.said.heartbeat(), self.said.landed(ON_GROUND))
        self.fly(0.3, ekf, north)
        self.take(self.said.heartbeat(armed=True))
        self.fly(0.3, ekf, north)

"""The operations manager with a drone that hovers: no link, telemetry by hand, a clock that is moved by hand."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from hawk.comm.autopilot.autopilot import MavsdkAutopilot
from hawk.comm.autopilot.vehicle import VehicleTopics
from hawk.comm.clock import Clock
from hawk.comm.protocol.authority import OperatorDesk
from hawk.comm.protocol.commands import Command, Outgoing
from hawk.comm.protocol.heartbeat import ClientId, CommandSocket, DroneStatus
from hawk.config.sections import AutopilotSettings
from hawk.ddc.operations_manager import OperationsManager
from hawk.ddc.readings.topic_interface import DdcInputs, DdcTopicInterface
from hawk.ddc.requests.service_interface import DdcServiceInterface
from hawk.ddc.settings import ManagerSetup
from hawk.model.lot_map import OccupancyMap
from hawk.model.operation import Health
from hawk.model.poses import GlobalPose, LocalPose, MapPose, VehiclePose
from hawk.model.vehicle import BatteryInfo, CopterMode, Diagnostics, LandedState, VehicleState

TICK_S = 0.05
_PLACE = GlobalPose(43.26, -79.92, 100.0)


Seats = Callable[[Clock], tuple[OperatorDesk, CommandSocket]]


class Nobody:
    """An operator's side without an operator, and with nothing to say."""

    def operator_present(self, _: float) -> bool:
        """Present, so that the drone holds."""
        return True

    def controller(self) -> ClientId | None:
        """Return nobody."""
        return None

    def controlling_clients(self) -> frozenset[ClientId]:
        """Nobody has control."""
        return frozenset()

    def names(self) -> dict[ClientId, str]:
        """Nobody is connected."""
        return {}

    def given_back_by(self) -> str:
        """Nobody gave control back."""
        return ""

    def hidden_since(self) -> float | None:
        """No page is hidden."""
        return None

    def receive(self) -> list[tuple[ClientId, Command]]:
        """Return no command."""
        return []

    def reply(self, client: ClientId, message: Outgoing) -> None:
        """Answer nobody."""


class StillDrone:
    """A manager to be ticked."""

    def __init__(self, folder: Path, seats: Seats | None = None) -> None:
        """``seats``: returns where the operators sit; nobody does without it."""
        self._seconds = 0.0
        self.clock = Clock(monotonic=lambda: self._seconds)
        self._vehicle = VehicleTopics.create(self.clock)
        self._autopilot = MavsdkAutopilot(AutopilotSettings(), self.clock, self._vehicle)
        self._inputs = DdcInputs.create(self.clock)
        topics = DdcTopicInterface(self._vehicle, self._inputs, self.clock)
        service = DdcServiceInterface(self._autopilot, topics, self.clock, 4.0, lambda *_: None)
        desk, socket = (Nobody(), Nobody()) if seats is None else seats(self.clock)
        setup = ManagerSetup(clock=self.clock, desk=desk, directory=folder)
        self.manager = OperationsManager(setup, socket, topics, service)
        self.manager.init()

    @property
    def status(self) -> DroneStatus:
        """The last status."""
        return self.manager.status.value or DroneStatus()

    def see(self, current: OccupancyMap) -> None:
        """Publish the map as the mapper does."""
        self._inputs.occupancy_map.publish(current)
        for topic in (self._inputs.vision_health, self._inputs.mapper_health, self._inputs.path_plan_health):
            topic.publish(Health())

    def advance(self) -> None:
        """Let a tick's time pass and the telemetry come in."""
        self._seconds += TICK_S
        now = self.clock()
        self._vehicle.state.publish(VehicleState(True, True, int(CopterMode.GUIDED), LandedState.IN_AIR, now, now))
        self._vehicle.battery.publish(BatteryInfo(80.0, 16.0, 10.0, now))
        self._vehicle.diagnostics.publish(Diagnostics(True, True, True, True, 3, 16, 0.9, now))
        pose = MapPose(0.0, 0.0, 35.0, 0.0, 0.0, 0.0)
        local = LocalPose(0.0, 0.0, -35.0)
        velocity = (0.0, 0.0, 0.0)
        self._vehicle.pose.publish(VehiclePose(now, _PLACE, 35.0, local, pose, velocity, 0.0, 0.0, 0.0))

    async def close(self) -> None:
        """End everything."""
        await self.manager.close()
        await self._autopilot.close()

"""A drone for the headless operator: its states on a clock of its own, five heartbeats a second, no real time."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import dataclass, field

from hawk.comm.protocol.commands import (
    Ack,
    Arm,
    AutonomousExplore,
    Command,
    CompulsiveMove,
    Configure,
    Control,
    Disarm,
    ReturnToLaunch,
    SetFailsafes,
    SetOutline,
    SurveyAgain,
    Takeoff,
)
from hawk.comm.protocol.heartbeat import (
    CheckItem,
    DroneStatus,
    Heartbeat,
    OperationStatus,
    PerceptionStatus,
    PoseStatus,
    SiteStatus,
    StatusStamp,
    TravelStatus,
    VehicleStatus,
)
from hawk.model.operation import StateName, UserError
from hawk.survey.client import LinkLostError
from hawk.web.clients import ClientView
from hawk.web.sessions import ControlView

BEAT_S = 0.2


def check(name: str, passed: bool, remedy: str = "", command: str | None = None) -> CheckItem:
    return CheckItem(
        name=name, passed=passed, value="ok" if passed else "off", remedy=remedy, remedy_command=command  # type: ignore[arg-type]
    )  # fmt: skip


@dataclass
class FakeDrone:
    """Flags say what goes wrong; ``orders`` are the commands, refused or not."""

    lot_seen_after: float = 0.0
    """Metres of searching until the lot is in sight; infinite: never."""
    explore_s: float = 5.0
    explore_ends: Callable[[FakeDrone], None] | None = None
    failsafes_set: bool = True
    failsafes_settable: bool = True
    connected_at: float = 1.0
    refusals: dict[str, str] = field(default_factory=dict)
    refuse_moves_to: Callable[[CompulsiveMove], bool] = lambda _: False
    arms: bool = True
    climbs: bool = True
    silent_after: float = float("inf")
    stop_the_return_once: bool = False
    on_beat: Callable[[FakeDrone], None] = lambda _: None
    lot_area: float = 0.0
    """Of the map, square metres: that of an earlier flight before take-off."""
    outline_unseen: float | None = None
    """Area of an outline that it cannot reach, square metres."""
    explored: float = 0.5
    is_left_done: bool = False
    """The rest of an earlier survey, by its journal: nothing."""
    tour_m: float | None = 87.5
    """Length of the flight over a lot that is surveyed again, once it is asked for."""
    # -- what it is ------------------------------------------------------------
    time: float = 0.0
    state: StateName = StateName.IDLE
    armed: bool = False
    north: float = 3.0
    east: float = -2.0
    height: float = 0.0
    heights: tuple[float, float, float] = (15.0, 35.0, 60.0)
    detail: str = ""
    user_error: UserError = UserError.NONE
    done: bool = False
    searched: float = 0.0
    entered: float = 0.0
    target: CompulsiveMove | None = None
    orders: list[Command] = field(default_factory=list)
    heartbeat: Heartbeat | None = None
    control: bool = False
    outline: SetOutline | SurveyAgain | None = None

    async def ask(self, command: Command) -> Ack:
        await asyncio.sleep(0)
        if self.time >= self.silent_after:
            raise LinkLostError("no answer")
        self.orders.append(command)
        reason = self.refusals.get(command.type) or self._refusal(command)
        if not reason:
            self._accept(command)
        return Ack(id=None, accepted=not reason, reason=reason)

    async def next_heartbeat(self, timeout_s: float) -> Heartbeat:
        await asyncio.sleep(0)
        if self.time >= self.silent_after:
            raise LinkLostError(f"no heartbeat from the drone for {timeout_s:g} s")
        self.time += BEAT_S
        self.on_beat(self)
        self._live()
        status = DroneStatus(
            stamp=StatusStamp(sequence=round(self.time / BEAT_S), time=self.time),
            operation=OperationStatus(
                state=self.state,
                detail=self.detail,
                user_error=self.user_error,
                checks=() if self.height > 0 else self._checks(),
            ),
            vehicle=VehicleStatus(
                armed=self.armed,
                connected=self.time >= self.connected_at,
                landed="ON_GROUND" if self.height == 0 else "IN_AIR",
                survey_basis="map" if self.is_left_done else None,
                battery_needed_survey=0.0 if self.is_left_done else None,
            ),
            pose=PoseStatus(relative_altitude=self.height, north=self.north, east=self.east),
            site=SiteStatus(
                heights=self.heights,
                outline_area=None if self.outline is None else 1000.0,
                again_distance=self.tour_m if isinstance(self.outline, SurveyAgain) else None,
            ),
            perception=PerceptionStatus(
                explore_done=self.done,
                outline_unseen=self.outline_unseen if self.done else None,
                park_lot_detected=self.height > 0 and self.searched >= self.lot_seen_after,
                explored=self.explored,
                lot_area=self.lot_area,
            ),
            travel=TravelStatus(distance_flown=12.0),
        )
        view = ClientView()
        text = view.heartbeat(status, None, ControlView(in_control=self.control))
        self.heartbeat = Heartbeat.model_validate_json(text)
        return self.heartbeat

    def received(self, kind: type[Command]) -> list[Command]:
        return [command for command in self.orders if isinstance(command, kind)]

    def go(self, state: StateName, detail: str = "") -> None:
        self.state, self.detail, self.entered = state, detail, self.time

    def _checks(self) -> tuple[CheckItem, ...]:
        gps = check("GPS", self.time > 2.0, "Wait for satellites.")
        return (gps, check("Failsafes", self.failsafes_set, "Set them.", "Set Failsafes"))

    def _refusal(self, command: Command) -> str:
        if isinstance(command, Control):
            return ""
        if not self.control:
            return "Take control first."
        needed = {
            Arm: StateName.IDLE, Configure: StateName.IDLE, Takeoff: StateName.ARM, Disarm: StateName.ARM,
            AutonomousExplore: StateName.HOVER, CompulsiveMove: StateName.HOVER,
        }.get(type(command))  # fmt: skip
        if needed is not None and self.state is not needed:
            return f"Not in {self.state}."
        if isinstance(command, ReturnToLaunch) and self.height == 0:
            return "On the ground."
        if isinstance(command, CompulsiveMove) and self.refuse_moves_to(command):
            return "Outside the fence."
        return ""

    def _accept(self, command: Command) -> None:
        if isinstance(command, Control):
            self.control = command.action == "Request"
        elif isinstance(command, Configure):
            self.heights = (command.min, command.des, command.max)
        elif isinstance(command, SetOutline | SurveyAgain):
            self.outline = command
        elif isinstance(command, SetFailsafes):
            self.failsafes_set = self.failsafes_settable
        elif isinstance(command, Arm):
            self.go(StateName.ARM)
        elif isinstance(command, Disarm):
            self.armed = False
            self.go(StateName.IDLE)
        elif isinstance(command, Takeoff):
            self.go(StateName.TAKEOFF)
        elif isinstance(command, AutonomousExplore):
            self.user_error = UserError.NONE
            self.go(StateName.AUTONOMOUS_EXPLORE)
        elif isinstance(command, CompulsiveMove):
            self.target = command
            self.go(StateName.COMPULSIVE_MOVE)
        elif isinstance(command, ReturnToLaunch):
            self.go(StateName.RETURN_TO_LAUNCH)

    def _live(self) -> None:
        """Each state does what it does within a few beats."""
        age = self.time - self.entered
        if self.state is StateName.ARM:
            self._arming(age)
        elif self.state is StateName.TAKEOFF and self.climbs:
            self.height = min(self.heights[1], self.height + 10)
            if self.height == self.heights[1]:
                self.go(StateName.HOVER)
        elif self.state is StateName.COMPULSIVE_MOVE and self.target is not None and age > 1:
            self.searched += abs(self.target.x - self.north) + abs(self.target.y - self.east)
            self.north, self.east = self.target.x, self.target.y
            self.height = self.target.height or self.height
            self.go(StateName.HOVER)
        elif self.state is StateName.AUTONOMOUS_EXPLORE and age > self.explore_s:
            self.go(StateName.HOVER, "Explored: the lot found is seen whole, 100 % of 4500 m².")
            self.done = True
            if self.explore_ends is not None:
                self.done = False
                self.explore_ends(self)
        elif self.state is StateName.RETURN_TO_LAUNCH:
            self._homing(age)

    def _arming(self, age: float) -> None:
        if self.arms and age > 0.5:
            self.armed = True
        elif not self.arms and age > 1.0:
            self.go(StateName.IDLE, "Arm was refused. PreArm: compass not calibrated")
        if self.armed and age > 10:
            self.armed = False
            self.go(StateName.IDLE, "Motors off.")

    def _homing(self, age: float) -> None:
        if self.stop_the_return_once and age > 0.5:
            self.stop_the_return_once = False
            self.go(StateName.HOVER, "Held by someone.")
        elif age > 2:
            self.height, self.armed = 0.0, False
            self.go(StateName.IDLE, "Motors off.")

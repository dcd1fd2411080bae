"""A drone, an operator and perception for the tests of manager and states, on a clock that is moved by hand."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable, Coroutine, Mapping
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from hawk.comm.autopilot.remote_control import RemoteControl
from hawk.comm.autopilot.remote_id import RemoteIdReport
from hawk.comm.autopilot.terrain import RangeReading, TerrainEstimator
from hawk.comm.autopilot.vehicle import AutopilotError, OtherFenceError, VehicleTopics
from hawk.comm.protocol.commands import (
    Ack,
    Arm,
    AutonomousExplore,
    AutonomousMove,
    CheckFence,
    Command,
    CompulsiveMove,
    Configure,
    Land,
    Outgoing,
    ReturnToLaunch,
    Takeoff,
)
from hawk.comm.protocol.heartbeat import CheckItem, ClientId, CommandSocket, DroneStatus
from hawk.config.sections import FenceSettings, FlightSettings, HeightSettings, OperatorSettings
from hawk.ddc.fence.geometry import to_map
from hawk.ddc.operations_manager import OperationsManager
from hawk.ddc.readings.topic_interface import DdcInputs, DdcTopicInterface
from hawk.ddc.requests.service_interface import DdcServiceInterface, Sender
from hawk.ddc.settings import DdcSettings, ManagerSetup, SurveyMemory
from hawk.model.moment import Moment
from hawk.model.operation import Fall, FlightSoFar, Health, StateName, UserError
from hawk.model.plans import DesiredPose, ExploreStatus, Fence, Inbound, PathPlan, Route, Verdict
from hawk.model.poses import ArmPlace, GlobalPose, LocalPose, MapPoint, MapPose, VehiclePose
from hawk.model.vehicle import BatteryInfo, CopterMode, Diagnostics, LandedState, StatusText, VehicleState
from tests.manual_clock import ManualClock

TICK_S = 0.05
STRIDE, FIRST, LAST = 3, 4, 8
"""A long time passes in fewer ticks, each of a stride, but for its first and last: a minute costs a third."""
HOLDING_STATES = frozenset({StateName.HOVER, StateName.COMMUNICATION_LOST})
COMMANDING_STATES = HOLDING_STATES | {
    StateName.AUTONOMOUS_EXPLORE,
    StateName.AUTONOMOUS_MOVE,
    StateName.COMPULSIVE_MOVE,
}
"""The states that may send targets, written down apart from their traits."""
PLACE = GlobalPose(43.2609, -79.9192, 100.0)
_DEGREE = MapPoint(
    to_map(PLACE, PLACE.latitude + 1e-3, PLACE.longitude).north * 1e3,
    to_map(PLACE, PLACE.latitude, PLACE.longitude + 1e-3).east * 1e3,
)
"""Metres of a degree of latitude and of longitude; good to centimetres over a few hundred metres."""
_ALWAYS_SAFE: Mapping[str, float] = {
    "FS_GCS_TIMEOUT": 5,
    "FS_THR_ENABLE": 1,
    "FS_EKF_ACTION": 1,
    "FS_EKF_THRESH": 0.8,
    "FENCE_ACTION": 1,
    "FENCE_TYPE": 7,
    "BATT_FS_CRT_ACT": 0,
    "BATT_LOW_VOLT": 10.5,
    "BATT_LOW_MAH": 0,
    "BATT_LOW_TIMER": 10,
    "BATT_CAPACITY": 3300,
    "RTL_ALT": 1500,
    "RTL_ALT_FINAL": 0,
    "RTL_CLIMB_MIN": 0,
    "RTL_ALT_TYPE": 0,
    "RTL_LOIT_TIME": 5000,
    "RTL_SPEED": 0,
    "FENCE_ALT_MAX": 100,
    "FENCE_TOTAL": 0,
    "RALLY_TOTAL": 0,
    "FLTMODE_CH": 5,
    **{f"FLTMODE{position}": mode for position, mode in enumerate((7, 9, 6, 3, 5, 0), start=1)},
}
SAFE_PARAMETERS: Mapping[str, float] = {
    **_ALWAYS_SAFE,
    "FS_GCS_ENABLE": 1,
    "SYSID_MYGCS": 245,
    "FS_OPTIONS": 16,
    "FENCE_ENABLE": 1,
    "BATT_FS_LOW_ACT": 2,
}
DEFAULT_PARAMETERS: Mapping[str, float] = {
    **_ALWAYS_SAFE,
    "FS_GCS_ENABLE": 0,
    "SYSID_MYGCS": 255,
    "FS_OPTIONS": 0,
    "FENCE_ENABLE": 0,
    "BATT_FS_LOW_ACT": 0,
}
VOLTAGE = 12.0
"""Three cells."""


def sender(state: StateName) -> Sender:
    """Return a state as the gate of the service interface knows it."""
    return Sender(state, state in COMMANDING_STATES, state in HOLDING_STATES)


@dataclass
class Target:
    """A target that was sent, and what was true at that moment."""

    north: float
    east: float
    height: float
    yaw: float
    mode: int
    armed: bool
    state: StateName


class FakeAutopilot:
    """An ArduCopter on a string: modes, arming, climb, targets, RTL and LAND; armed shows at once.

    ``refuse`` holds requests that fail, by name, with the autopilot's words; ``silent`` those that never answer.
    """

    def __init__(self, clock: ManualClock, parameters: Mapping[str, float] | None = None) -> None:
        self.clock = clock
        self.topics = VehicleTopics.create(clock)
        self.values: dict[str, float] = dict(SAFE_PARAMETERS if parameters is None else parameters)
        self.calls: list[tuple[str, Any]] = []
        self.targets: list[Target] = []
        self.refuse: dict[str, str] = {}
        self.silent: set[str] = set()
        self.state_name = StateName.IDLE
        self.mode = int(CopterMode.STABILIZE)
        self.armed = False
        self.landed = LandedState.ON_GROUND
        self.north = self.east = self.height = self.yaw = 0.0
        self.velocity = (0.0, 0.0, 0.0)
        self.wanted: tuple[float, float, float] | None = None
        self.climb_to: float | None = None
        self.arm_place: ArmPlace | None = None
        self.battery: float | None = 95.0
        self.volts: float | None = VOLTAGE
        self.connected = True
        self.uplink = True
        self.position_good = True
        self.estimator_fault = ""
        self.pose_flows = True
        self.landed_flows = True
        self.tilt = (0.0, 0.0)
        """Roll and pitch, radians."""
        self.below: Callable[[float, float], float | None] | None = None
        """Height of what is below a place (north, east), metres above the arm place; None: out of the rangefinder's
        range. Without the function there is no rangefinder."""
        self.terrain_watch = TerrainEstimator()
        self.stuck = False
        self.held_fence: Fence | None = None
        self.radio: bool | None = True
        """The autopilot hears its receiver; None: it does not say."""
        self.radio_flows = True
        self.switch_pulse = 1800
        self.boots = 0
        self.remote_id: RemoteIdReport | None = None
        """The transmitter's word, sent each time."""
        self.fence_on: bool | None = None
        """SYS_STATUS's word on the fence; None: as FENCE_ENABLE says."""
        self.home: GlobalPose | None = None
        self._home_reported = -math.inf
        self.keeps_home = True
        """False: a home that is sent is not taken."""
        self._rtl_to: tuple[float, float] | None = None
        self._datum: GlobalPose | None = None
        self._read: dict[str, float | int] = {}

    # -- what the manager asks ------------------------------------------------------------------------------------

    async def arm(self) -> None:
        await self._answer("arm")
        self.armed = True
        self._project_arm_place()

    async def disarm(self) -> None:
        await self._answer("disarm")
        if self.landed is not LandedState.ON_GROUND:
            raise AutopilotError("disarm: in the air")
        self.armed = False

    async def set_mode(self, mode: CopterMode) -> None:
        await self._answer("set_mode", mode)
        self.change_mode(mode)

    async def send_mode(self, mode: CopterMode) -> None:
        """The message gets through where ``uplink`` says so, heard or not."""
        self.calls.append(("send_mode", mode))
        if self.uplink:
            self.change_mode(mode)

    def set_voice(self, speaks: bool) -> None:
        self.calls.append(("set_voice", speaks))

    async def takeoff(self, relative_altitude: float) -> None:
        await self._answer("takeoff", relative_altitude)
        if not self.armed:
            raise AutopilotError("takeoff: not armed")
        self.mode = CopterMode.GUIDED
        self.climb_to = relative_altitude

    async def set_rtl_altitude(self, metres: float) -> float:
        await self._answer("set_rtl_altitude", metres)
        self.values["RTL_ALT"] = metres * 100
        return metres

    async def get_parameter(self, name: str) -> float | int:
        await self._answer("get_parameter", name)
        if name not in self.values:
            raise AutopilotError(f"{name}: no answer")
        self._read[name] = self.values[name]
        return self.values[name]

    async def set_parameter(self, name: str, value: float) -> None:
        await self._answer("set_parameter", (name, value))
        self.report(name, value)

    def report(self, name: str, value: float) -> None:
        """Change a parameter and send it to all, as after another station's PARAM_SET."""
        self.values[name] = self._read[name] = value

    async def upload_fence(self, fence: Fence) -> None:
        await self._answer("upload_fence", fence)
        self.held_fence = fence
        self.report("FENCE_TOTAL", len(fence.autopilot_polygon))
        self.report("FENCE_ALT_MAX", fence.autopilot_ceiling)
        self.report("FENCE_TYPE", 5)
        self.report("FENCE_ENABLE", 1)

    async def compare_fence(self, fence: Fence) -> None:
        await self._answer("compare_fence", fence)
        if fence != self.held_fence or self.values["FENCE_ENABLE"] != 1:
            raise OtherFenceError("its polygon is another one")

    async def enable_fence(self) -> None:
        await self._answer("enable_fence")
        self.fence_on = None

    async def clear_rally_points(self) -> None:
        await self._answer("clear_rally_points")
        self.report("RALLY_TOTAL", 0)

    async def set_home(self, place: GlobalPose) -> None:
        await self._answer("set_home", place)
        if self.keeps_home:
            self.move_home(place)

    async def kill(self) -> None:
        await self._answer("kill")
        self.armed = False
        self.height, self.landed = 0.0, LandedState.ON_GROUND

    def send_target(self, north: float, east: float, height: float, yaw: float) -> None:
        self.targets.append(Target(north, east, height, yaw, self.mode, self.armed, self.state_name))
        self.wanted = (north, east, height)
        self.climb_to = None

    def pose_at(self, time: float) -> VehiclePose | None:
        return self.topics.pose.value

    def set_datum(self, datum: GlobalPose | None) -> None:
        self._datum = datum

    @property
    def datum(self) -> GlobalPose | None:
        return self._datum

    def restore_arm_place(self, place: ArmPlace) -> None:
        self.arm_place = place
        self.topics.arm_place.publish(place)
        self.home = GlobalPose(place.latitude, place.longitude, place.altitude)

    @property
    def parameters(self) -> Mapping[str, float | int]:
        return self._read

    # -- what the test does ---------------------------------------------------------------------------------------

    def count(self, name: str) -> int:
        """Return the number of times that a request was made."""
        return sum(1 for call, _ in self.calls if call == name)

    def asked(self, name: str) -> list[Any]:
        """The arguments of a request, in order."""
        return [argument for call, argument in self.calls if call == name]

    def change_mode(self, mode: int) -> None:
        """Change the mode, by anyone: the vehicle stops where it is. RTL flies to home as it is now."""
        if mode != self.mode:
            self.wanted = self.climb_to = None
            self._rtl_to = self._home() if mode == CopterMode.RTL else None
        self.mode = int(mode)

    def put_in_air(self, height: float = 30.0, mode: int = CopterMode.GUIDED) -> None:
        """Fly, as found by a daemon that starts in the air."""
        self.armed, self.mode, self.height, self.landed = True, int(mode), height, LandedState.IN_AIR
        if self._datum is None:
            self._datum = PLACE
        self._project_arm_place()

    def say(self, text: str, severity: int = 3) -> None:
        """Send a STATUSTEXT."""
        self.topics.status_text.publish(StatusText(self.clock(), severity, text))

    def publish(self) -> None:
        """Publish what a moment's telemetry would say."""
        now = self.clock()
        if self.connected:
            self.topics.state.publish(self._state(now))
            self.topics.battery.publish(BatteryInfo(self.battery, self.volts, 10.0, now))
            if self.home is None:
                self.home = GlobalPose(*self._where(), PLACE.altitude)
            if now - self._home_reported >= 1.0:
                self._home_reported = now
                self.topics.home.publish(self.home)
            good = self.position_good and not self.estimator_fault
            fence_on = bool(self.values["FENCE_ENABLE"]) if self.fence_on is None else self.fence_on
            self.topics.diagnostics.publish(
                Diagnostics(
                    good, True, good, True, 3, 16, 0.9, now, estimator_fault=self.estimator_fault, fence_on=fence_on
                )
            )
            self._publish_radio(now)
            if self.pose_flows:
                self.topics.pose.publish(self._pose(now))
            self._measure(now)
        elif self.topics.state.value is not None:
            self.topics.state.publish(replace(self.topics.state.value, connected=False))

    def _measure(self, now: float) -> None:
        """Send the rangefinder's message: at every tick, 0.2 to 50 m."""
        if self.below is None:
            return
        top = self.below(self.north, self.east)
        distance = None if top is None or not 0.2 < self.height - top < 50.0 else self.height - top
        reading = RangeReading(now, distance, 0.2, 50.0)
        self.topics.terrain.publish(self.terrain_watch.take(reading, (self.north, self.east, self.height)))

    def _publish_radio(self, now: float) -> None:
        if self.radio_flows:
            pulses = (1500, 1500, 1000, 1500, self.switch_pulse, 1000, 1000, 1800, *(0,) * 10)
            self.topics.remote_control.publish(RemoteControl(pulses, 8, now, self.radio, now, self.boots))
        if self.remote_id is not None:
            self.topics.remote_id.publish(replace(self.remote_id, time=now))

    def _state(self, now: float) -> VehicleState:
        before = self.topics.state.value
        if self.landed_flows or before is None:
            return VehicleState(True, self.armed, self.mode, self.landed, now, now)
        return VehicleState(True, self.armed, self.mode, before.landed, now, before.landed_time)

    def step(self, seconds: float) -> None:
        """Move as the mode says."""
        old = (self.north, self.east, self.height)
        if self.armed and not self.stuck:
            self._fly(seconds)
        moved = tuple((b - a) / seconds for a, b in zip(old, (self.north, self.east, self.height), strict=True))
        self.velocity = (moved[0], moved[1], -moved[2])

    def _fly(self, seconds: float) -> None:
        if self.mode == CopterMode.GUIDED and self.climb_to is not None:
            self.landed = LandedState.IN_AIR
            self._towards(self.north, self.east, self.climb_to, seconds)
        elif self.mode == CopterMode.GUIDED and self.wanted is not None and self.landed is not LandedState.ON_GROUND:
            self._towards(*self.wanted, seconds)
        elif self.mode == CopterMode.RTL and self.landed is not LandedState.ON_GROUND:
            home_north, home_east = self._rtl_to or self._home()
            if math.hypot(self.north - home_north, self.east - home_east) > 0.5:
                self._towards(home_north, home_east, max(self.height, 15.0), seconds)
            else:
                self._descend(seconds)
        elif self.mode == CopterMode.LAND and self.landed is not LandedState.ON_GROUND:
            self._descend(seconds)
        elif self.mode in (CopterMode.RTL, CopterMode.LAND):
            self.armed = False

    def _descend(self, seconds: float) -> None:
        self._towards(self.north, self.east, 0.0, seconds)
        if self.height <= 0.05:
            self.height, self.landed = 0.0, LandedState.ON_GROUND

    def _towards(self, north: float, east: float, height: float, seconds: float) -> None:
        across = math.hypot(north - self.north, east - self.east)
        share = min(1.0, 5.0 * seconds / across) if across > 1e-9 else 1.0
        self.north += (north - self.north) * share
        self.east += (east - self.east) * share
        rise = height - self.height
        self.height += math.copysign(min(abs(rise), 2.5 * seconds), rise)

    def _project_arm_place(self) -> None:
        if self._datum is None:
            self._datum = PLACE
        latitude, longitude = self._where()
        self.arm_place = ArmPlace(latitude, longitude, PLACE.altitude, 0.0, 0.0, 0.0)
        self.topics.arm_place.publish(self.arm_place)
        self.move_home(GlobalPose(latitude, longitude, PLACE.altitude))

    def move_home(self, place: GlobalPose) -> None:
        """Move home, by anyone: HOME_POSITION comes at once."""
        self.home = place
        self.topics.home.publish(place)

    def _home(self) -> tuple[float, float]:
        assert self.home is not None
        place = to_map(PLACE, self.home.latitude, self.home.longitude)
        return place.north, place.east

    def _where(self) -> tuple[float, float]:
        return PLACE.latitude + self.north / _DEGREE.north, PLACE.longitude + self.east / _DEGREE.east

    def _pose(self, now: float) -> VehiclePose:
        latitude, longitude = self._where()
        place = GlobalPose(latitude, longitude, PLACE.altitude + self.height)
        anchored = self.arm_place is not None
        return VehiclePose(
            time=now,
            global_=place,
            relative_altitude=self.height if anchored else None,
            local=LocalPose(self.north, self.east, -self.height) if anchored else None,
            map=MapPose(self.north, self.east, self.height, 0.0, 0.0, self.yaw) if anchored else None,
            velocity=self.velocity,
            roll=self.tilt[0],
            pitch=self.tilt[1],
            yaw=self.yaw,
        )

    async def _answer(self, name: str, argument: Any = None) -> None:
        self.calls.append((name, argument))
        if name in self.silent:
            await asyncio.get_running_loop().create_future()
        await asyncio.sleep(0)
        if name in self.refuse:
            raise AutopilotError(self.refuse[name])
        if not self.connected:
            raise AutopilotError("no answer")


@dataclass
class FakeDesk:
    """The holder of control; the operator is there unless the test says otherwise."""

    client: ClientId | None = "ana"
    present: bool = True
    known: dict[ClientId, str] = field(default_factory=lambda: {"ana": "Ana", "eve": "Eve"})
    former: str = ""
    hidden: float | None = None

    def operator_present(self, now: float) -> bool:
        return self.present and self.client is not None

    def hidden_since(self) -> float | None:
        return None if self.client is None else self.hidden

    def controller(self) -> ClientId | None:
        return self.client

    def controlling_clients(self) -> frozenset[ClientId]:
        return frozenset() if self.client is None else frozenset({self.client})

    def names(self) -> dict[ClientId, str]:
        return self.known

    def given_back_by(self) -> str:
        return self.former if self.client is None else ""


@dataclass
class FakeSocket:
    """Commands that wait, and answers that went out."""

    waiting: list[tuple[ClientId, Command]] = field(default_factory=list)
    replies: list[tuple[ClientId, Outgoing]] = field(default_factory=list)
    inner: CommandSocket | None = None
    """A real socket that takes part in the test."""
    replied: asyncio.Event = field(default_factory=asyncio.Event)

    def receive(self) -> list[tuple[ClientId, Command]]:
        taken, self.waiting = self.waiting, []
        return taken if self.inner is None else [*taken, *self.inner.receive()]

    def reply(self, client: ClientId, message: Outgoing) -> None:
        self.replies.append((client, message))
        self.replied.set()
        if self.inner is not None:
            self.inner.reply(client, message)


@dataclass
class Sight:
    """Results of perception; None: no result."""

    lot: bool | None = True
    inbound: Inbound | None = Inbound.INSIDE
    healthy: bool = True
    flows: bool = True
    plan: PathPlan | None = field(default_factory=lambda: PathPlan(explore=ExploreStatus(seen=0.4)))
    route: Route | None = None
    """The route to a place inside; None: straight from the drone's place when it was asked for."""


START = 100.0
"""The rig's clock at the start, seconds."""
UTC_START = 1_700_000_000.0
"""The wall clock then."""


class Rig:
    """Manager, fake drone, fake operator and fake perception around one clock."""

    def __init__(
        self,
        directory: Path,
        *,
        parameters: Mapping[str, float] | None = None,
        settings: DdcSettings | None = None,
        starts: int = 1,
        continues_survey: bool = False,
        flight: FlightSoFar | None = None,
        fall: Fall | None = None,
        memory: SurveyMemory | None = None,
    ) -> None:
        self.clock = ManualClock(START)
        self.kept_flights: list[FlightSoFar | None] = []
        self.kept_falls: list[Fall | None] = []
        self.surveys_begun = 0
        self.autopilot = FakeAutopilot(self.clock, parameters)
        self.desk = FakeDesk()
        self.socket = FakeSocket()
        self.sight = Sight()
        self.inputs = DdcInputs.create(self.clock)
        self.records: list[tuple[str, dict[str, Any]]] = []
        self.topics = DdcTopicInterface(self.autopilot.topics, self.inputs, self.clock)
        self.settings = settings or DdcSettings(
            FlightSettings(), FenceSettings(), OperatorSettings(), HeightSettings(), 245
        )
        self.service = DdcServiceInterface(
            self.autopilot, self.topics, self.clock, self.settings.flight.speed_m_s, self.record
        )
        tokens = (f"token-{n:016d}" for n in range(10_000))
        self.manager = OperationsManager(
            ManagerSetup(
                clock=self.clock,
                desk=self.desk,
                directory=directory,
                settings=self.settings,
                record=lambda kind, payload: self.record(kind, payload),
                count_start=lambda: starts,
                new_token=lambda: next(tokens),
                continues_survey=continues_survey,
                begin_survey=self._begin_survey,
                utc=lambda: datetime.fromtimestamp(UTC_START + self.clock() - START, UTC),
                moment=lambda: Moment("boot", 500.0, UTC_START).before(START - self.clock()),
                flight=flight,
                keep_flight=self.kept_flights.append,
                fall=fall,
                keep_fall=self.kept_falls.append,
                survey=memory or SurveyMemory(),
            ),
            self.socket,
            self.topics,
            self.service,
        )
        self.manager.init()
        self._routes: dict[DesiredPose, Route] = {}
        self._asked: list[asyncio.Task[Any]] = []

    def ask(self, call: Coroutine[Any, Any, Any]) -> None:
        """Start a request of ours beside the states."""
        self._asked.append(asyncio.get_running_loop().create_task(call))

    def record(self, kind: str, payload: dict[str, Any]) -> None:
        self.records.append((kind, payload))

    def _begin_survey(self) -> None:
        self.surveys_begun += 1

    @property
    def ticked(self) -> bool:
        """True once a tick was run."""
        return self.manager.ticks > 0

    @property
    def detail(self) -> str:
        """The state's sentence for the operator."""
        return self.manager.state.detail(self.manager.situation().facts)

    @property
    def first_failed(self) -> CheckItem | None:
        """The first preflight check that has not passed."""
        return next((item for item in self.manager.situation().checks if not item.passed), None)

    @property
    def fence(self) -> Fence | None:
        """The fence in force."""
        return self.topics.fence_pub.value

    @property
    def user_error(self) -> UserError:
        """The User Error that is shown."""
        return self.shown.operation.user_error

    @property
    def shown(self) -> DroneStatus:
        """The last status."""
        assert self.manager.status.value is not None
        return self.manager.status.value

    @property
    def state(self) -> StateName:
        """The active state."""
        return self.manager.state.identity

    def expect(self, state: StateName) -> None:
        """The active state must be this one."""
        assert self.state is state, f"in {self.state}: {self.detail}; {self.log[-3:]}"

    @property
    def log(self) -> list[str]:
        """Texts of the message list."""
        return [entry.text for entry in self.manager.log.entries]

    def see(self) -> None:
        """Publish what perception says."""
        health = Health() if self.sight.healthy else Health.bad("broken")
        self.inputs.camera_health.publish(health)
        self.inputs.recording_health.publish(Health())
        self.inputs.camera_time.publish(self.clock() - 0.1)
        if not self.sight.flows:
            return
        for topic in (self.inputs.vision_health, self.inputs.mapper_health, self.inputs.path_plan_health):
            topic.publish(health)
        if self.sight.lot is not None:
            self.inputs.park_lot_detected.publish(self.sight.lot)
        asked = self._judged(self.topics.asked_place_pub.value)
        if self.sight.plan is not None:
            self.inputs.path_plan.publish(replace(self.sight.plan, asked=asked))
        verdict = self._judged(self.topics.des_pose_pub.value)
        if verdict is not None:
            self.inputs.verdict.publish(verdict)

    def _judged(self, place: DesiredPose | None) -> Verdict | None:
        if place is None or self.sight.inbound is None:
            return None
        if self.sight.inbound is not Inbound.INSIDE:
            return Verdict(place.number, self.sight.inbound)
        here = MapPoint(self.autopilot.north, self.autopilot.east)
        straight = Route((here, MapPoint(place.north, place.east)), (0.0, 0.0))
        kept = self._routes.setdefault(place, straight)
        return Verdict(place.number, Inbound.INSIDE, self.sight.route or kept)

    async def tick(self, count: int = 1, seconds: float = TICK_S) -> None:
        """Run ``count`` ticks, of 50 ms."""
        for _ in range(count):
            self.clock.advance(seconds)
            self.autopilot.step(seconds)
            self.autopilot.publish()
            self.see()
            self.manager.process()
            self.autopilot.state_name = self.state
            for _ in range(4):
                await asyncio.sleep(0)

    async def run(self, seconds: float) -> None:
        """Let time pass: in ticks of a busy computer, but at the beginning and the end."""
        ticks = round(seconds / TICK_S)
        long = max(0, ticks - FIRST - LAST) // STRIDE
        await self.tick(min(ticks, FIRST))
        await self.tick(long, STRIDE * TICK_S)
        await self.tick(max(0, ticks - FIRST - STRIDE * long))

    async def until(self, state: StateName, seconds: float = 60.0) -> None:
        """Let time pass until a state is active."""
        for _ in range(round(seconds / TICK_S / STRIDE)):
            if self.state is state:
                return
            await self.tick(seconds=STRIDE * TICK_S)
        assert self.state is state, f"still in {self.state}: {self.detail}; {self.log[-3:]}"

    def command(self, command: Command, client: ClientId = "ana") -> Ack:
        """Give a command that is answered at once."""
        answer = self.manager.handle(client, command)
        assert isinstance(answer, Ack), answer
        return answer

    async def check_fence(self, command: CheckFence, client: ClientId = "ana") -> Outgoing:
        """Ask about a fence; return the answer, which follows."""
        return (await self.later(client, command))[0]

    async def later(self, client: ClientId, *commands: Command) -> list[Outgoing]:
        """Give commands whose answers follow; return the answers in their order."""
        before = len(self.socket.replies)
        for command in commands:
            assert self.manager.handle(client, command) is None
        while len(self.socket.replies) < before + len(commands):
            self.socket.replied.clear()
            await self.socket.replied.wait()
        return [message for _, message in self.socket.replies[before:]]

    def order(self, command: Command, client: ClientId = "ana") -> None:
        """Give a command that must be taken."""
        answer = self.command(command, client)
        assert answer.accepted, answer.reason

    def target_plan(self, north: float, east: float, height: float | None = None) -> None:
        """Let the planner point to a place."""
        self.sight.plan = PathPlan(MapPoint(north, east), height, 0.5, explore=ExploreStatus(seen=0.4))

    def finish_plan(self) -> None:
        """Let the planner say that nothing is left."""
        self.sight.plan = PathPlan(explore=ExploreStatus(done=True, seen=1.0))

    async def enter(self, state: StateName) -> None:
        """Bring a rig that was not run yet into a state, directly."""
        if state in (StateName.IDLE, StateName.CONFIGURE, StateName.ARM, StateName.TAKEOFF):
            await self._enter_from_ground(state)
            return
        self.autopilot.put_in_air()
        await self.run(0.2)
        if state is StateName.MANUAL:
            self.autopilot.change_mode(CopterMode.LOITER)
            await self.run(3.5)
        elif state is StateName.COMMUNICATION_LOST:
            self.desk.present = False
            await self.run(0.2)
        else:
            await self.run(0.3)  # a new task waits until every parameter was read
        if state not in (StateName.MANUAL, StateName.COMMUNICATION_LOST, StateName.HOVER):
            await self._order_from_hover(state)
        self.expect(state)

    async def _enter_from_ground(self, state: StateName) -> None:
        await self.run(1.5)
        if state is StateName.CONFIGURE:
            self.autopilot.silent.add("set_rtl_altitude")
            self.order(Configure(min=15, des=20, max=50))
            await self.tick()
        if state in (StateName.ARM, StateName.TAKEOFF):
            self.order(Arm())
            await self.run(0.5)
        if state is StateName.TAKEOFF:
            self.order(Takeoff())
            await self.run(0.5)
        self.expect(state)

    async def _order_from_hover(self, state: StateName) -> None:
        self.target_plan(40, 0)
        orders: dict[StateName, Command] = {
            StateName.AUTONOMOUS_EXPLORE: AutonomousExplore(),
            StateName.AUTONOMOUS_MOVE: AutonomousMove(x=60.0, y=0.0),
            StateName.COMPULSIVE_MOVE: CompulsiveMove(x=60.0, y=0.0),
            StateName.RETURN_TO_LAUNCH: ReturnToLaunch(),
            StateName.LAND: Land(),
        }
        self.manager.handle("ana", orders[state])
        await self.run(0.2)

    async def close(self) -> None:
        """End the manager."""
        await asyncio.gather(*self._asked, return_exceptions=True)
        await self.manager.close()

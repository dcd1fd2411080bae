"""Whatever operators, pilots, autopilot and perception do: no unsafe target, no arming without checks, no rank down."""

from __future__ import annotations

import asyncio
import math
import tempfile
from pathlib import Path
from typing import Any
from unittest import mock

import pytest
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from hawk.comm.protocol.commands import (
    Arm,
    AutonomousExplore,
    AutonomousMove,
    ClearKill,
    Command,
    CompulsiveMove,
    Configure,
    Disarm,
    Hold,
    Kill,
    KillRequest,
    KillToken,
    Land,
    Outgoing,
    Resume,
    ReturnToLaunch,
    SetFailsafes,
    Takeoff,
)
from hawk.ddc import decider as decider_room
from hawk.ddc.acts import Acts
from hawk.ddc.facts import Facts
from hawk.ddc.fence.geometry import inside_point, outside_by
from hawk.ddc.motion import maximum_target_distance
from hawk.ddc.orders import Rank, Transition
from hawk.ddc.readings.belief import AIR_HEIGHT_M
from hawk.ddc.settings import DdcSettings
from hawk.ddc.states.base import State
from hawk.ddc.states.factory import make_state
from hawk.model.operation import StateName
from hawk.model.plans import ExploreStatus, Inbound, PathPlan
from hawk.model.poses import GlobalPose, MapPoint
from hawk.model.vehicle import CopterMode, LandedState
from tests.examples import examples
from tests.unit.ddc.fakes import COMMANDING_STATES, DEFAULT_PARAMETERS, PLACE, SAFE_PARAMETERS, Rig

SIMPLE: list[Command] = [
    Arm(),
    Takeoff(),
    AutonomousExplore(),
    Hold(),
    ReturnToLaunch(),
    ReturnToLaunch(confirmed=True),
    Land(),
    Land(confirmed=True),
    Disarm(),
    Resume(confirmed=True),
    SetFailsafes(),
    ClearKill(),
]
any_number = st.floats(-400, 400) | st.sampled_from([math.nan, math.inf, -math.inf])
GUARDED_RANKS = {Rank.COMMUNICATION_LOST, Rank.RETURN_TO_LAUNCH, Rank.LAND, Rank.AUTOPILOT, Rank.PILOT}


class Flight(RuleBasedStateMachine):
    """One drone; every rule is something that may happen."""

    def __init__(self) -> None:
        super().__init__()
        self.loop = asyncio.new_event_loop()
        self.folder = tempfile.TemporaryDirectory()
        self.foreign = True  # a switch that a command, a pilot or the autopilot made may go anywhere
        self.switches: list[tuple[StateName, Rank, StateName, Rank, bool]] = []

    @initialize(safe=st.booleans(), airborne=st.booleans(), starts=st.integers(1, 3))
    def begin(self, safe: bool, airborne: bool, starts: int) -> None:
        parameters = SAFE_PARAMETERS if safe else DEFAULT_PARAMETERS
        self.rig = Rig(Path(self.folder.name), parameters=parameters, starts=starts)
        if airborne:
            self.rig.autopilot.put_in_air()
        self._watch_the_wire()
        self._watch_switches()
        self._run(1.5)

    def teardown(self) -> None:
        if hasattr(self, "rig"):
            self.patch.stop()
            self.loop.run_until_complete(self.rig.close())
        self.loop.close()
        self.folder.cleanup()

    # -- what may happen ------------------------------------------------------------------------------------------

    @rule(command=st.sampled_from(SIMPLE), client=st.sampled_from(["ana", "ana", "eve"]))
    def an_operator_commands(self, command: Command, client: str) -> None:
        checks = self.rig.first_failed is None and not self.rig.manager.situation().interlocks.is_killed
        self._command(command, client)
        if isinstance(command, Arm) and self.rig.state is StateName.ARM and not checks:
            assert self.rig.autopilot.armed, "armed without preflight"

    @rule(
        north=st.floats(-200, 200),
        east=st.floats(-200, 200),
        relative=st.booleans(),
        autonomous=st.booleans(),
    )
    def an_operator_moves_it(self, north: float, east: float, relative: bool, autonomous: bool) -> None:
        kind = AutonomousMove if autonomous else CompulsiveMove
        self._command(kind(x=north, y=east, frame="Relative" if relative else "Map"), "ana")

    @rule(heights=st.tuples(*[st.floats(1, 110)] * 3).map(sorted))
    def an_operator_configures(self, heights: list[float]) -> None:
        low, travel, high = heights
        self._command(Configure(min=low, des=travel, max=high), "ana")

    @rule(held=st.booleans())
    def an_operator_kills(self, held: bool) -> None:
        answer = self._handle(KillRequest(), "ana")
        if isinstance(answer, KillToken) and held:
            self._command(Kill(token=answer.token), "ana")

    @rule(present=st.booleans(), client=st.sampled_from(["ana", "ana", None, "eve"]))
    def the_operator_comes_and_goes(self, present: bool, client: str | None) -> None:
        self.rig.desk.present, self.rig.desk.client = present, client

    @rule(mode=st.sampled_from(CopterMode))
    def somebody_changes_the_mode(self, mode: CopterMode) -> None:
        self.rig.autopilot.change_mode(mode)
        self._run(0.05, foreign=True)

    @rule(armed=st.booleans())
    def somebody_arms_or_disarms(self, armed: bool) -> None:
        drone = self.rig.autopilot
        if drone.landed is LandedState.ON_GROUND:
            drone.armed = armed
        self._run(0.05, foreign=True)

    @rule(
        refused=st.sets(st.sampled_from(["arm", "disarm", "set_mode", "takeoff", "upload_fence", "kill"])),
        silent=st.sets(st.sampled_from(["arm", "set_mode", "takeoff", "get_parameter"]), max_size=1),
    )
    def the_autopilot_refuses(self, refused: set[str], silent: set[str]) -> None:
        self.rig.autopilot.refuse = dict.fromkeys(refused, "no")
        self.rig.autopilot.silent = silent

    @rule(connected=st.booleans(), pose=st.booleans(), stuck=st.booleans())
    def links_and_motors_fail(self, connected: bool, pose: bool, stuck: bool) -> None:
        drone = self.rig.autopilot
        drone.connected, drone.pose_flows, drone.stuck = connected, pose, stuck

    @rule(armed=st.booleans(), landed=st.sampled_from(LandedState), seconds=st.sampled_from([0.05, 0.3]))
    def datagrams_come_late(self, armed: bool, landed: LandedState, seconds: float) -> None:
        """HEARTBEAT and EXTENDED_SYS_STATE of before come after the true ones, for a moment."""
        drone = self.rig.autopilot
        true_armed, true_landed, stands = drone.armed, drone.landed, drone.height <= AIR_HEIGHT_M
        if stands or not drone.connected or self.rig.topics.get_pose_age() > 0.5:
            return
        before = self.rig.manager.situation().facts.vehicle.armed
        frozen, drone.stuck = drone.stuck, True
        drone.armed, drone.landed = armed, landed
        self._run(seconds, foreign=True)
        drone.armed, drone.landed, drone.stuck = true_armed, true_landed, frozen
        believed = self.rig.manager.situation().facts
        if before and true_armed:
            assert believed.vehicle.armed
            assert not believed.is_on_ground
            assert not self.rig.manager.state.on_ground
        self._run(0.05, foreign=True)

    @rule(flows=st.sampled_from([True, True, False]))
    def the_landed_state_comes_and_goes(self, flows: bool) -> None:
        self.rig.autopilot.landed_flows = flows

    @rule(battery=st.none() | st.floats(0, 100))
    def the_battery_says(self, battery: float | None) -> None:
        self.rig.autopilot.battery = battery

    @rule(north=st.floats(-30, 30), east=st.floats(-30, 30), height=st.floats(-20, 20))
    def wind_moves_it(self, north: float, east: float, height: float) -> None:
        drone = self.rig.autopilot
        if drone.landed is LandedState.IN_AIR:
            drone.north, drone.east = drone.north + north, drone.east + east
            drone.height = max(1.0, drone.height + height)

    @rule(jump=st.floats(-10, 10))
    def the_position_jumps(self, jump: float) -> None:
        self.rig.autopilot.topics.frame_jump.publish(jump)

    @rule(north=st.floats(-40, 40), east=st.floats(-40, 40))
    def the_estimate_jumps(self, north: float, east: float) -> None:
        drone = self.rig.autopilot
        if drone.landed is LandedState.IN_AIR:
            drone.north, drone.east = drone.north + north, drone.east + east
            drone.topics.estimate_jump.publish(math.hypot(north, east))

    @rule(metres=st.floats(-400, 400), keeps=st.booleans())
    def somebody_moves_home(self, metres: float, keeps: bool) -> None:
        drone = self.rig.autopilot
        drone.keeps_home = keeps
        drone.move_home(GlobalPose(PLACE.latitude + metres / 111_097, PLACE.longitude, PLACE.altitude))

    @rule(fault=st.sampled_from(["", "GPS glitch"]))
    def the_estimator_says(self, fault: str) -> None:
        self.rig.autopilot.estimator_fault = fault

    @rule(
        north=any_number,
        east=any_number,
        height=st.none() | any_number,
        yaw=st.none() | any_number,
        done=st.booleans(),
        lot=st.none() | st.booleans(),
        inbound=st.none() | st.sampled_from(Inbound),
        healthy=st.sampled_from([True, True, False]),
    )
    def perception_says(
        self,
        north: float,
        east: float,
        height: float | None,
        yaw: float | None,
        done: bool,
        lot: bool | None,
        inbound: Inbound | None,
        healthy: bool,
    ) -> None:
        sight = self.rig.sight
        sight.plan = PathPlan(MapPoint(north, east), height, yaw, explore=ExploreStatus(done, 0.5))
        sight.lot, sight.inbound, sight.healthy = lot, inbound, healthy

    @rule()
    def all_is_well(self) -> None:
        drone = self.rig.autopilot
        drone.refuse, drone.silent = {}, set()
        drone.connected = drone.pose_flows = drone.position_good = drone.landed_flows = True
        drone.stuck, drone.battery, drone.estimator_fault, drone.keeps_home = False, 95.0, "", True
        self.rig.desk.present, self.rig.desk.client = True, "ana"
        self.rig.sight.healthy = self.rig.sight.lot = True
        self.rig.sight.inbound = Inbound.INSIDE
        self.rig.target_plan(20, 10)
        self._run(1.0)

    @rule(task=st.sampled_from([AutonomousExplore(), AutonomousMove(x=30, y=9), CompulsiveMove(x=-25, y=9)]))
    def a_good_operator_goes_on(self, task: Command) -> None:
        self.all_is_well()
        if self.rig.manager.situation().interlocks.is_killed:
            self._command(ClearKill(), "ana")
        following: dict[StateName, list[Command]] = {
            StateName.IDLE: [SetFailsafes(), Arm()],
            StateName.ARM: [Takeoff()],
            StateName.HOVER: [task],
            StateName.MANUAL: [Resume(confirmed=True)],
        }
        for command in following.get(self.rig.state, [Hold()]):
            self._command(command, "ana")
            self._run(1.5)
        if self.rig.state is StateName.TAKEOFF:
            self._run(12.0)

    @rule()
    def a_good_operator_is_there(self) -> None:
        self.a_good_operator_goes_on(AutonomousExplore())

    @rule(seconds=st.sampled_from([0.05, 0.3, 2.0, 6.0]))
    def time_passes(self, seconds: float) -> None:
        self._run(seconds)

    # -- what must hold -------------------------------------------------------------------------------------------

    @invariant()
    def no_automatic_reaction_moved_down_in_rank(self) -> None:
        for former, old, following, new, foreign in self.switches:
            allowed = foreign or new >= old or old not in GUARDED_RANKS
            back = former is StateName.COMMUNICATION_LOST and following is StateName.HOVER and self.rig.desk.present
            landed = following in (StateName.IDLE, StateName.MANUAL)
            assert allowed or back or landed, f"{former} ({old.name}) went to {following} ({new.name})"
        self.switches.clear()

    @invariant()
    def the_ticks_go_on_without_a_fault(self) -> None:
        if hasattr(self, "rig"):
            assert self.rig.manager.own_health.is_healthy, self.rig.manager.own_health.reason

    def _watch_the_wire(self) -> None:
        drone, manager = self.rig.autopilot, self.rig.manager
        send = drone.send_target

        def checked(north: float, east: float, height: float, yaw: float) -> None:
            assert all(map(math.isfinite, (north, east, height, yaw)))
            assert self.rig.topics.curr_state_pub.value in COMMANDING_STATES
            assert manager.situation().interlocks.kill_state != "sending"
            reported = self.rig.topics.get_state()
            assert reported.connected
            assert reported.armed
            assert reported.custom_mode == CopterMode.GUIDED
            assert self.rig.topics.get_pose_age() <= 0.5
            assert self.rig.fence is not None
            pose, fence = self.rig.topics.get_pose(), self.rig.fence
            assert pose is not None
            assert pose.map is not None
            place, away = MapPoint(north, east), outside_by(fence, pose.map.point)
            assert outside_by(fence, place) <= away, "a drone outside is led back, never farther out"
            assert height <= max(fence.ceiling, pose.map.height)
            reach = maximum_target_distance(4.0)
            across = max(reach, pose.map.point.distance(inside_point(fence, pose.map.point)) + 1.0) if away else reach
            assert place.distance(pose.map.point) <= across
            assert abs(height - pose.map.height) <= reach
            send(north, east, height, yaw)

        drone.send_target = checked  # type: ignore[method-assign]

    def _watch_switches(self) -> None:
        """Note each state that the decider makes, while the former one is still active."""

        def noted(transition: Transition, facts: Facts, setup: DdcSettings) -> tuple[State, Acts]:
            former = self.rig.manager.state
            following, messages = make_state(transition, facts, setup)
            self.switches.append((former.identity, former.rank, following.identity, following.rank, self.foreign))
            return following, messages

        self.patch = mock.patch.object(decider_room, "make_state", noted)
        self.patch.start()

    def _command(self, command: Command, client: str) -> None:
        self.foreign = True
        self._handle(command, client)
        self._run(0.05, foreign=True)
        calls = [name for name, _ in self.rig.autopilot.calls]
        if self.rig.manager.situation().interlocks.is_killed and isinstance(command, Arm):
            assert calls[-1:] != ["arm"], "armed while the motors are locked"

    def _handle(self, command: Command, client: str) -> Outgoing | None:
        async def call() -> Outgoing | None:
            return self.rig.manager.handle(client, command)

        return self.loop.run_until_complete(call())

    def _run(self, seconds: float, foreign: bool = False) -> None:
        linked = self.rig.manager.situation().facts.link.is_up
        self.foreign = foreign or linked != self.rig.autopilot.connected or not self.rig.ticked
        self.loop.run_until_complete(self._ticks(max(1, round(seconds / 0.05))))

    async def _ticks(self, count: int) -> Any:
        for _ in range(count):
            await self.rig.tick()


Flight.TestCase.settings = settings(
    max_examples=examples(20),
    stateful_step_count=20,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much],
)
TestFlight = pytest.mark.slow(Flight.TestCase)

"""Operations Manager (specification section 18): holds the active state, takes commands, tells the status.

`process` runs once a tick and never waits. What it decides on comes from the topic interface; what it does goes
through the service interface; every command, decision and tick goes to ``record``.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Coroutine
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from hawk.comm.messages import (
    Ack,
    Command,
    CommandOption,
    Outgoing,
)
from hawk.comm.status import ClientId, CommandSocket, DroneStatus
from hawk.comm.topic import Topic
from hawk.ddc.command_desk import CommandDesk
from hawk.ddc.commands import Judge, command_type
from hawk.ddc.errors import ReqFailed, TargetRefused
from hawk.ddc.fence_keeper import FenceKeeper
from hawk.ddc.fence_plan import FencePlan
from hawk.ddc.flight_log import FlightLog
from hawk.ddc.geofence import FenceError
from hawk.ddc.guard import Guard
from hawk.ddc.inquiry import Inquiries
from hawk.ddc.kill import KillSwitch
from hawk.ddc.motion import Goal
from hawk.ddc.params import ParameterStore
from hawk.ddc.preflight import Preflight
from hawk.ddc.requests import Request, Requests
from hawk.ddc.restart import flight_goes_on
from hawk.ddc.route_requests import RouteRequests
from hawk.ddc.service_interface import DdcServiceInterface
from hawk.ddc.states.base import Cause, Order, State
from hawk.ddc.states.factory import StateFactory
from hawk.ddc.status_builder import StatusBuilder
from hawk.ddc.surroundings import Surroundings
from hawk.ddc.tick_record import tick_inputs
from hawk.ddc.topic_interface import DdcTopicInterface
from hawk.ddc.trail import Trail
from hawk.ddc.vehicle_follower import LEFT_ALONE, VehicleFollower
from hawk.ddc.vehicle_watch import VehicleWatch
from hawk.model import (
    GROUND_STATES,
    TASK_STATES,
    CopterMode,
    DesiredPose,
    Fence,
    FlightSoFar,
    GlobalPose,
    Health,
    HeightParameters,
    MapPoint,
    StateName,
    UserError,
)

HEARTBEAT_S = 0.2
"""One status every so many seconds: 5 Hz."""
SHUTDOWN_WAIT_S = 3.0
"""How long the end of the program waits for RTL to show."""

_LOGGER = logging.getLogger(__name__)


class OperationsManager:
    """The context of the states. ``init`` comes before everything else."""

    def __init__(self, around: Surroundings) -> None:
        self._around = around
        self.settings = around.settings
        self.utc = around.utc
        self.record = around.record
        self.log = FlightLog(around.clock, around.utc)
        self.requests = Requests(around.clock, self._request_ended)
        self.status: Topic[DroneStatus] = Topic("status", around.clock)
        self.own_health = Health()
        self.user_error = UserError.NONE
        self.user_error_text = ""
        self.ticks = 0
        """Ticks that were done: the watchdog looks whether it grows."""
        self._executor = ThreadPoolExecutor(max_workers=1, thread_name_prefix="hawk-parameters")
        self._desired = 0
        self._next_heartbeat = float("-inf")
        self._refused_target = ""
        self._pending_fence: Fence | None = None
        self._listeners: list[Callable[[], None]] = []

    # -- the specification's access programs ---------------------------------------------------------------------

    def init(
        self,
        message_socket: CommandSocket,
        ddc_topic_interface: DdcTopicInterface,
        ddc_service_interface: DdcServiceInterface,
    ) -> None:
        """Take the parts, read the parameters, begin in Idle. Raises FenceError when the fence file cannot be used."""
        self.socket = message_socket
        self.topics = ddc_topic_interface
        self.service = ddc_service_interface
        self.topics.init()
        self.service.init()
        self.fences = FenceKeeper(self.settings, self.topics.fence_pub, self._around.directory)
        limits = self.settings.heights
        defaults = HeightParameters(limits.minimum_m, limits.desired_m, limits.maximum_m)
        self._store = ParameterStore(self._around.directory, defaults, self.settings.ceiling)
        heights, problem = self._store.read()
        self.topics.heights_pub.publish(heights)
        if problem:
            self.log.add("warning", "The stored heights cannot be used; the configured ones are.", problem)
        self.fences.tell_source(self.log.add)
        self.states = StateFactory(self)
        self.kill = KillSwitch(self._around.clock, self._send_kill, self._around.new_token)
        self.guard = Guard(self)
        self.trail = Trail(self._keep_flight)
        self.preflight = Preflight(self)
        self.judge = Judge(self, self._around.desk)
        self.commands = CommandDesk(self)
        self.inquiries = Inquiries(self)
        self.route_requests = RouteRequests(self)
        self._watch = VehicleWatch(self.topics, self.service, self._around.clock)
        self.follower = VehicleFollower(self, self._watch, self._around.count_start)
        self._builder = StatusBuilder(self)
        self.state: State = self.states.idle("Looking for the autopilot.")
        self.topics.curr_state_pub.publish(self.state.identity)
        vehicle = self.topics.vehicle
        self._listeners = [
            vehicle.status_text.listen(self.log.hear),
            vehicle.frame_jump.listen(self.follower.note_frame_jump),
            vehicle.arm_place.listen(self.follower.note_arm_place),
        ]
        if vehicle.arm_place.value is not None:
            self.follower.note_arm_place(vehicle.arm_place.value)

    def process(self) -> None:
        """Run one tick: commands, what the autopilot did, Kill, automatic reactions, the state, the heartbeat."""
        self._guarded(self._record_tick)
        for client, command in self.socket.receive():
            answer = self._handle_safely(client, command)
            if answer is not None:
                self.socket.reply(client, answer)
        self._guarded(self.follower.follow)
        self._guarded(self.route_requests.tick)
        if self.kill.is_sending:
            self._guarded(self._repeat_kill)
        else:
            self._guarded(self._run_state)
        self.ticks += 1
        if self.now >= self._next_heartbeat - 0.5 / self.settings.flight.tick_hz:  # the nearest tick, not the next
            self._guarded(self._send_heartbeat)

    def handle(self, client: ClientId, command: Command) -> Outgoing | None:
        """Decide on a command, act on it, and return the answer; None: the answer follows through the socket."""
        return self.commands.handle(client, command)

    # -- for the web server and the composition root -------------------------------------------------------------

    def handle_now(self, client: ClientId, command: Command) -> Outgoing:
        """Act at once on a command that passes every queue: Hold, Kill Request, Kill."""
        answer = self._handle_safely(client, command)
        if answer is None:
            raise ValueError(f"{command_type(command)} is not a command that passes the queue")
        return answer

    def options(self) -> tuple[CommandOption, ...]:
        """Return for every command whether it would be taken now, and why not."""
        return self.judge.options()

    async def shutdown_in_air(self) -> bool:
        """Before the program ends: in the air Return To Launch is asked for (not in Manual, RTL, Land).

        Returns whether there was something to do. Waits a few real seconds for the answer, no longer.
        """
        if not self.follower.is_airborne or self.state.identity in LEFT_ALONE or not self.has_link:
            return False
        self.switch(self.states.return_to_launch(Cause("The program ends.", lambda: True)))
        try:
            async with asyncio.timeout(SHUTDOWN_WAIT_S):
                await self.service.set_mode(CopterMode.RTL)
        except (TimeoutError, ReqFailed) as error:
            _LOGGER.error("return home at the end of the program: %s", error)
        return True

    async def close(self) -> None:
        """Cancel requests under way and end the thread."""
        for stop in self._listeners:
            stop()
        await self.requests.close()
        self._executor.shutdown(wait=False, cancel_futures=True)

    # -- for the states ------------------------------------------------------------------------------------------

    @property
    def now(self) -> float:
        """Seconds of the daemon's clock."""
        return self._around.clock()

    @property
    def heights(self) -> HeightParameters:
        """Min, Des, Max."""
        return self.topics.heights_pub.value or HeightParameters()

    @property
    def fence(self) -> Fence | None:
        """The fence in force."""
        return self.fences.active

    @property
    def ceiling(self) -> float:
        """Our own ceiling: of the fence in force in the air, of the planned one on the ground; metres."""
        fence = self.fence
        on_ground = self.state.identity in GROUND_STATES
        return self.fences.ceiling if on_ground or fence is None else fence.ceiling

    @property
    def has_link(self) -> bool:
        """Whether the autopilot was found and is heard."""
        return self._watch.has_link

    @property
    def mode_changed_at(self) -> float:
        """When the autopilot's mode last changed, seconds."""
        return self._watch.mode_changed_at

    @property
    def operator_present(self) -> bool:
        """Whether the operator in control showed a sign of life lately."""
        return self._around.desk.operator_present(self.now)

    @property
    def is_judging_move(self) -> bool:
        """Whether the planner is asked about a place."""
        return self.inquiries.is_open

    @property
    def desired_number(self) -> int | None:
        """Number of the place that is desired now."""
        desired = self.topics.des_pose_pub.value
        return None if desired is None else desired.number

    @property
    def target_place(self) -> MapPoint | None:
        """Where the drone is sent, for display."""
        goal: Goal | None = getattr(self.state, "goal", None)
        return None if goal is None else goal.point

    def ask(self, name: str, call: Coroutine[Any, Any, Any]) -> Request:
        """Start a request to the autopilot."""
        return self.requests.start(name, call)

    def send_target(self, target: Goal) -> str:
        """Send a target if nothing speaks against it; return what does."""
        try:
            self.service.send_target(target, self.state.identity, self.heights, self.fence)
        except TargetRefused as refused:
            reason = str(refused)
        else:
            reason = ""
            goal = {"north": target.north, "east": target.east, "height": target.height, "yaw": target.yaw}
            self.record("target", goal)
        if reason != self._refused_target and reason:
            self.record("target refused", {"reason": reason})
        self._refused_target = reason
        return reason

    def set_user_error(self, error: UserError, text: str) -> None:
        """Show a User Error until the next accepted command."""
        self.user_error, self.user_error_text = error, text

    def desire(self, place: MapPoint) -> int:
        """Tell the planner which place is desired; return its number."""
        self._desired += 1
        self.topics.des_pose_pub.publish(DesiredPose(self._desired, place.north, place.east))
        return self._desired

    def forget_desired(self, number: int) -> None:
        """The place of that number is not desired any longer."""
        if self.desired_number == number:
            self.topics.des_pose_pub.publish(None)

    def perception_fault(self) -> str:
        """Return what is wrong with what flying by sight needs; empty when nothing is."""
        topics = self.topics
        for name, health in (
            ("Camera", topics.get_camera_health()),
            ("Vision", topics.get_vision_health()),
            ("Mapper", topics.get_mapper_health()),
            ("Planner", topics.get_path_plan_health()),
        ):
            if not health.is_healthy:
                return f"{name}: {health.reason}"
        return ""

    async def store_heights(self, heights: HeightParameters) -> None:
        """Write the parameter file, off the loop."""
        await asyncio.get_running_loop().run_in_executor(self._executor, self._store.write, heights)

    def use_heights(self, heights: HeightParameters) -> None:
        """These hold from here on."""
        self.topics.heights_pub.publish(heights)

    async def store_fence(self, plan: FencePlan | None) -> None:
        """Write the drawn fence's file (None: put it aside), off the loop; then plan with it, and show it.

        The next Arm uploads it. A drone that a pilot armed meanwhile flies on in the fence that is in force.
        """
        await asyncio.get_running_loop().run_in_executor(self._executor, self.fences.store, plan)
        self.fences.use(plan)
        place, datum = self.topics.get_global_pose(), self.service.datum
        if place is not None and datum is not None and not self.topics.get_state().armed:
            self.fences.put_in_force(self.fences.build(datum, place.latitude, place.longitude))

    def take_up_flight(self) -> None:
        """This program started in the air: flight time and way go on where the earlier run left them."""
        known = flight_goes_on(self._around.flight, self.utc().timestamp(), self._around.speed)
        if known is not None:
            self.trail.go_on(*known, self.now)

    def datum_for_arm(self) -> GlobalPose | None:
        """Return the map's origin, or what becomes it at a survey's first arm: the place where the drone stands."""
        return self.service.datum or self.topics.get_global_pose()

    def prepare_fence(self) -> Fence:
        """Lay the map's origin if this is the survey's first arm, and return the fence to upload. Raises FenceError."""
        place, datum = self.topics.get_global_pose(), self.datum_for_arm()
        if place is None or datum is None:
            raise ValueError("the position is not known")
        if self.fences.problem:
            raise FenceError(self.fences.problem)
        fence = self.fences.build(datum, place.latitude, place.longitude)
        if self.service.datum is None:
            self.service.set_datum(datum)
        self._pending_fence = fence
        return fence

    def fence_uploaded(self) -> None:
        """The autopilot has taken the prepared fence: it is in force."""
        if self._pending_fence is not None:
            self.fences.put_in_force(self._pending_fence)
        self.guard.reset()

    def give(self, order: Order) -> None:
        """Hand an order to the state and follow it at once."""
        self.state.give(order)
        self._guarded(self._advance)

    def abandon_arming(self) -> None:
        """An arming was given up: an "armed" that comes late is answered by a disarm."""
        self.follower.abandon_arming()

    # -- steps of a tick -----------------------------------------------------------------------------------------

    def _handle_safely(self, client: ClientId, command: Command) -> Outgoing | None:
        """A fault while a command is handled refuses that command; the others, and the ticks, go on."""
        answers: list[Outgoing | None] = []
        self._guarded(lambda: answers.append(self.handle(client, command)))
        if answers:
            return answers[0]
        return Ack(id=command.id, accepted=False, reason=f"{self.own_health.reason}.")

    def _keep_flight(self, flown: tuple[float, float] | None) -> None:
        self._around.keep_flight(None if flown is None else FlightSoFar(*flown, at=self.utc().timestamp()))

    def _record_tick(self) -> None:
        self.record("tick", tick_inputs(self))

    # -- Kill ----------------------------------------------------------------------------------------------------

    def _send_kill(self) -> None:
        self.ask("kill", self.service.kill())

    def _repeat_kill(self) -> None:
        vehicle = self.topics.get_state()
        if not self.kill.tick(vehicle.armed, vehicle.time, self.has_link):
            return
        if self.kill.state == "confirmed":
            self.log.add("error", "Motors cut. Arm is locked until you clear it.")
            if self.state.identity is not StateName.IDLE:
                self.switch(self.states.idle("Motors cut."))
            return
        self.log.add("error", "Cutting the motors was not confirmed. Confirm again if it must be.")
        self.follower.take_up(at_start=False)

    # -- the state -----------------------------------------------------------------------------------------------

    def _run_state(self) -> None:
        airborne = self.follower.is_airborne
        if self.has_link:
            pose = self.topics.get_pose()
            self.trail.update(None if pose is None else pose.map, airborne, self.now)
        self.guard.observe(airborne)
        self.preflight.tick(not self.topics.get_state().armed)
        self.inquiries.tick()
        reaction = self.guard.reaction(self.state) if self.has_link else None
        if reaction is not None:
            self.record("reaction", {"rank": reaction.rank.name, "state": self.state.get_identity()})
            self.switch(reaction.make())
        if not self.has_link and self.state.identity not in GROUND_STATES:
            return
        self.state.process()
        self._advance()

    def _advance(self) -> None:
        following = self.state.transition_next_state()
        if following is not self.state:
            self.switch(following)

    def switch(self, following: State) -> None:
        """Make another state the active one."""
        former, self.state = self.state, following
        self.record("state", {"from": former.get_identity(), "to": following.get_identity()})
        former.leave()
        self.inquiries.supersede()
        if following.identity is StateName.MANUAL:
            self.service.forget_asked_modes()
        if following.identity is StateName.ARM:
            self.follower.begin_arming()
        self.topics.curr_state_pub.publish(following.identity)
        following.enter()
        returned = former.identity is StateName.COMMUNICATION_LOST and following.identity is StateName.HOVER
        if returned and self.follower.started_in_air and self._around.continues_survey:
            self.log.add("info", "Explore continues the survey.")

    def _guarded(self, step: Callable[[], None]) -> None:
        """An unexpected exception makes us unhealthy and visible; it never stops the state machine."""
        try:
            step()
        except Exception as error:
            _LOGGER.exception("unexpected")
            self.own_health = Health.bad(f"Fault in the program: {type(error).__name__}: {error}")
            if self.state.identity in TASK_STATES:
                self.state = self.states.hover("A fault in the program.", level="error")
                self.topics.curr_state_pub.publish(self.state.identity)

    def _send_heartbeat(self) -> None:
        late = self.now - self._next_heartbeat
        self._next_heartbeat = self.now + HEARTBEAT_S if late > HEARTBEAT_S else self._next_heartbeat + HEARTBEAT_S
        self.status.publish(self._builder.build())

    def _request_ended(self, name: str, failure: str) -> None:
        self.record("request ended", {"name": name, "failure": failure})
        if failure:
            _LOGGER.warning("%s: %s", name, failure)

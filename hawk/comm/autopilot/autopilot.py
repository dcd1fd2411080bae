"""The autopilot by MAVSDK, a `hawk.comm.autopilot.vehicle.Autopilot`. Secret: the threads.

MAVSDK's calls block, and may hang, so each runs on a thread of its own with a deadline (`hawk.comm.autopilot.calls`);
targets have a lasting thread. The autopilot's messages come in on MAVSDK's own threads and are handled on the loop, in
order.
"""

from __future__ import annotations

import asyncio
import contextlib
import functools
import logging
import math
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

from hawk.comm.autopilot import commands
from hawk.comm.autopilot.calls import Calls
from hawk.comm.autopilot.mavlink_link import Link, Message, OnMessage
from hawk.comm.autopilot.parameters import AutopilotParameters
from hawk.comm.autopilot.streams import RateKeeper, Stream, wanted_streams
from hawk.comm.autopilot.telemetry import Telemetry
from hawk.comm.autopilot.vehicle import AutopilotError, FenceRings, OtherFenceError, VehicleTopics, difference, rings_of
from hawk.comm.clock import Clock
from hawk.comm.mavlink.peer import SEVERAL, Expected
from hawk.comm.mavlink.udp_gate import Hearing
from hawk.comm.threads import Inbox, LatestSender
from hawk.config.addresses import host_and_port
from hawk.config.sections import AutopilotSettings
from hawk.model.frames import wrap_angle
from hawk.model.moment import Moment, this_moment
from hawk.model.plans import Fence
from hawk.model.poses import GlobalPose
from hawk.model.sentences import say, words_of
from hawk.model.vehicle import CopterMode, ForeignWrite, StatusText
from hawk.runtime.repeated_log import Repeated
from hawk.runtime.supervision import Supervisor, end_tasks

_LOG = logging.getLogger(__name__)
T = TypeVar("T")

_FIND_S = 0.5
_WATCH_S = 0.2
_REOPEN_S = 5.0
_LOOK_S = 1.0
_ALONE_S = 1.5
"""A copter that nobody named is kept when none other was heard for this time; each gives a sign of life a second."""
_RETRY_S = 0.5
_CLOSE_S = 5.0
_COMMAND_S = 2.5
"""A little more than MAVSDK waits for an acknowledgement."""
_OPEN_S = 10.0
"""Longest time to open or close a connection: a TCP peer may not answer."""
_FENCE_UPLOAD_S = 15.0
"""Longest time of a fence's upload. MAVSDK repeats each of its messages 5 times, 0.5 s apart, before it gives up."""
_KNOCK_S = 5.0
"""While our heartbeats are held back, a listening peer that has lost our address hears of us this often."""
_WORDS_AFTER_S = 0.3
_FENCE_CEILING_AND_POLYGON = 1 | 4  # FENCE_TYPE bits
_FENCE_NOTICED_S = 0.5
"""ArduPilot looks at FENCE_ENABLE some times a second: one that is back after 10 ms is not noticed."""
_FENCE_SHOWN_S = 2.0
_FENCE_RTL_OR_LAND = 1  # FENCE_ACTION
_FENCE_CEILING_TOLERANCE_M = 0.1
_RALLY_POINTS = 2  # MAV_MISSION_TYPE_RALLY
_CRITICAL = 2  # MAV_SEVERITY_CRITICAL
_COMMAND_ACK_KILL = int(commands.MavCommand.DO_FLIGHTTERMINATION)
_HEARTBEAT = {
    "type": 6,  # MAV_TYPE_GCS
    "autopilot": 8,  # MAV_AUTOPILOT_INVALID
    "base_mode": 0,
    "custom_mode": 0,
    "system_status": 4,  # MAV_STATE_ACTIVE
    "mavlink_version": 3,
}


class MavsdkAutopilot:
    """The real autopilot. After a restart `Telemetry.restore_arm_place` and `set_datum` come before `start`."""

    def __init__(
        self,
        settings: AutopilotSettings,
        clock: Clock,
        topics: VehicleTopics,
        moment: Callable[[], Moment] = this_moment,
        make_link: Callable[[str, int, Clock, OnMessage, Expected], Link] = Link,
        parameter_answer_s: float = 0.5,
        supervisor: Supervisor | None = None,
        *,
        has_gimbal: bool = False,
        flown_id: int | None = None,
        in_flight: bool = False,
    ) -> None:
        """Make it; `start` begins.

        Args:
            settings: The link's URL, and our id on it.
            clock: The daemon's.
            topics: Receive everything that is heard.
            moment: This computer's clocks.
            make_link: Makes the link.
            parameter_answer_s: Real seconds until a request for a parameter is repeated (four times).
            supervisor: Keeps the tasks running.
            has_gimbal: Ask for the attitude of the camera's gimbal.
            flown_id: MAVLink system id of the vehicle whose flight goes on.
            in_flight: A flight may be under way: the first copter is taken at once.
        """
        self.topics = topics
        self._settings = settings
        self._clock = clock
        self._rates = RateKeeper(wanted_streams(settings.position_rate_hz, has_gimbal=has_gimbal))
        self._inbox: Inbox[Message] | None = None
        expected = expected_autopilot(settings, flown_id, in_flight=in_flight)
        self._link = make_link(settings.url, settings.system_id, clock, self._receive, expected)
        self.telemetry = Telemetry(clock, topics, self._rates, self._link.sensor_health, moment, self._on_reboot)
        self.calls = Calls("autopilot")
        """The calls into MAVSDK, and those that hang."""
        self._supervisor = supervisor or Supervisor()
        self._targets = self._make_sender()
        self._speaks = True
        self._parameters = AutopilotParameters(self.send_message, parameter_answer_s)
        self._rtl_in_metres: bool | None = None
        self._tasks: list[asyncio.Task[None]] = []
        self.problem = ""
        """Reason why there is no autopilot: the link cannot be opened, or nobody is heard on it. Else empty."""
        self._repeated = Repeated()
        self._closed = False

    # --- life ------------------------------------------------------------------------------------------------------

    async def start(self) -> None:
        """Open the link and look for the autopilot until `close`; returns at once."""
        loop = asyncio.get_running_loop()
        self._inbox = Inbox(loop, self._handle)
        self.telemetry.check_link(self._clock())
        self.topics.state.publish(self.topics.state.value or self.telemetry.state)
        self._tasks = [
            self._supervisor.start("autopilot-link", self._keep_link),
            self._supervisor.start("autopilot-watch", self._watch),
        ]

    async def close(self) -> None:
        """End tasks, MAVSDK and threads, within a few seconds even when a call hangs."""
        if self._closed:
            return
        self._closed = True
        await end_tasks(*self._tasks)
        self._tasks = []
        if self._inbox is not None:
            self._inbox.close()
        self._targets.close()
        await self.calls.finish(_COMMAND_S)  # MAVSDK never answers a command after it was closed
        try:
            await self.calls.run("close", self._link.close, deadline_s=_CLOSE_S, urgent=True)
        except AutopilotError as error:
            _LOG.warning("%s", error)

    @property
    def hearing(self) -> Hearing:
        """Senders on the link: the kept one, and a second one."""
        return self._link.hearing()

    @property
    def vehicle_id(self) -> int | None:
        """MAVLink system id of the autopilot that was found; None before."""
        return self._link.vehicle_id

    @property
    def dropped(self) -> int:
        """Number of the autopilot's messages that were dropped because the loop did not come in time."""
        return 0 if self._inbox is None else self._inbox.dropped

    # --- commands --------------------------------------------------------------------------------------------------

    async def arm(self) -> None:
        """Arm. Raises AutopilotError with the autopilot's own words."""
        await self._command(commands.arm)

    async def disarm(self) -> None:
        """Disarm; the autopilot refuses it in the air."""
        await self._command(commands.disarm)

    async def set_mode(self, mode: CopterMode) -> None:
        """Ask for a flight mode by DO_SET_MODE."""
        await self._command(commands.set_mode, mode)

    async def takeoff(self, relative_altitude: float) -> None:
        """Climb to ``relative_altitude``, metres above the arm place; armed and in GUIDED only."""
        await self._command(commands.takeoff, relative_altitude)

    async def set_home(self, place: GlobalPose) -> None:
        """Send a home (WGS-84, metres above sea level) and do not wait for the answer. Raises AutopilotError."""
        if not all(math.isfinite(value) for value in (place.latitude, place.longitude, place.altitude)):
            raise AutopilotError(say("Home is not finite: not sent"))
        self._require_link()
        await self.calls.run("set home", commands.set_home, self._link, place)

    async def kill(self) -> None:
        """Send one flight termination at once, also on a link that seems dead. A refusal shows as a message."""
        await self.calls.run("kill", commands.kill, self._link, urgent=True)

    async def send_mode(self, mode: CopterMode) -> None:
        """Send a change of the flight mode at once, also on a link that seems dead, and wait for no answer."""
        await self.calls.run(f"send {mode.name}", commands.send_mode, self._link, mode, urgent=True)

    def set_voice(self, speaks: bool) -> None:
        """Let our heartbeats go out, or hold them back, so that the autopilot misses its ground station."""
        self._speaks = speaks
        self._link.set_voice(speaks)

    def send_target(self, north: float, east: float, height: float, yaw: float) -> None:
        """Send one position target (map frame, metres above the arm place, radians). Never blocks, never repeats."""
        if not all(math.isfinite(value) for value in (north, east, height, yaw)):
            raise AutopilotError(say("The target is not finite: not sent"))
        frames = self.telemetry.tie.frames
        if frames is None:
            raise AutopilotError(say("No arm place yet: there is no map to fly on"))
        self._require_link()
        if not self.telemetry.tie.offset.sure:
            raise AutopilotError(say("The autopilot's position leapt: not sent before it is tied to the map again"))
        self._free_targets()
        place = frames.ekf(north, east, height)
        self._targets.put(commands.position_target(self.telemetry.boot_ms, place, wrap_angle(yaw)))

    # --- parameters and fence --------------------------------------------------------------------------------------

    async def get_parameter(self, name: str) -> float | int:
        """Read one parameter. Raises AutopilotError for an unknown name."""
        self._require_link()
        return await self._parameters.get(name)

    async def set_parameter(self, name: str, value: float) -> None:
        """Set one parameter with the autopilot's type, and check the answer. Raises AutopilotError."""
        self._require_link()
        await self._parameters.set(name, value)

    @property
    def parameters(self) -> Mapping[str, float | int]:
        """Parameters read since the autopilot booted."""
        return self._parameters.values

    async def set_rtl_altitude(self, metres: float) -> float:
        """Set RTL_ALT_M (metres), or RTL_ALT (centimetres) where only that exists; return it in metres as read back."""
        if not (math.isfinite(metres) and metres > 0):
            raise AutopilotError(say("Return altitude is {metres} m: it must be above 0", metres=metres))
        self._require_link()
        if self._rtl_in_metres is None:
            found = await self._parameters.read_many(["RTL_ALT_M", "RTL_ALT"])
            if found["RTL_ALT_M"] is None and found["RTL_ALT"] is None:
                raise AutopilotError(
                    say("Neither RTL_ALT_M nor RTL_ALT is answered: the return altitude cannot be set")
                )
            self._rtl_in_metres = found["RTL_ALT_M"] is not None
        if self._rtl_in_metres:
            await self._parameters.set("RTL_ALT_M", metres)
            return float(self._parameters.values["RTL_ALT_M"])
        await self._parameters.set("RTL_ALT", round(metres * 100))
        return self._parameters.values["RTL_ALT"] / 100.0

    async def upload_fence(self, fence: Fence) -> None:
        """Upload the autopilot's polygon and zones (about the fence origin), set ceiling, type, action, and enable it.

        Raises:
            AutopilotError: It was refused, or a ring that is read back is another one.
        """
        self._require_link()
        rings = rings_of(fence, self.telemetry.tie.fence_origin)
        was_off = await self._drop_other_fence()
        await self.calls.run("upload fence", self._link.upload_fence, rings, deadline_s=_FENCE_UPLOAD_S)
        await self._parameters.set("FENCE_ALT_MAX", fence.autopilot_ceiling)
        await self._parameters.set("FENCE_TYPE", _FENCE_CEILING_AND_POLYGON)
        if await self._parameters.get("FENCE_ACTION") == 0:
            await self._parameters.set("FENCE_ACTION", _FENCE_RTL_OR_LAND)
        await self._parameters.set("FENCE_ENABLE", 1)
        await self._compare_rings(rings)
        if was_off:
            await self._until_fence_is_on()

    async def _drop_other_fence(self) -> bool:
        """Switch a fence of other kinds off, on the ground alone; return True when that was done.

        ArduPilot 4.7 keeps a kind on that FENCE_TYPE loses while the fence is on. A command that switches the fence off
        leaves that kind on, too, and SYS_STATUS goes on to say that there is a fence.
        """
        if self.telemetry.state.armed or await self._parameters.get("FENCE_TYPE") == _FENCE_CEILING_AND_POLYGON:
            return False
        if await self._parameters.get("FENCE_ENABLE") == 0:
            return False
        await self._parameters.set("FENCE_ENABLE", 0)
        await asyncio.sleep(_FENCE_NOTICED_S)
        return True

    async def _until_fence_is_on(self) -> None:
        """Wait until SYS_STATUS shows the fence, as far as it does: else an armed drone seems to have none."""
        seen = self.topics.diagnostics.value
        try:
            async with asyncio.timeout(_FENCE_SHOWN_S):
                while seen is not None and seen.fence_on is False:
                    seen = await self.topics.diagnostics.next()
        except TimeoutError:
            _LOG.warning("The fence is enabled, and SYS_STATUS shows none")

    async def compare_fence(self, fence: Fence) -> None:
        """Read polygon, zones, ceiling and FENCE_ENABLE. Raises AutopilotError when they are not those of the fence."""
        self._require_link()
        rings = rings_of(fence, self.telemetry.tie.fence_origin)
        if await self._parameters.get("FENCE_ENABLE") != 1:
            raise OtherFenceError(say("it is off (FENCE_ENABLE)"))
        ceiling = await self._parameters.get("FENCE_ALT_MAX")
        if not fence.ceiling < ceiling <= fence.autopilot_ceiling + _FENCE_CEILING_TOLERANCE_M:
            ours = fence.autopilot_ceiling
            raise OtherFenceError(
                say("its ceiling is {ceiling:g} m, ours is {ours:g} m (FENCE_ALT_MAX)", ceiling=ceiling, ours=ours)
            )
        await self._compare_rings(rings)

    async def clear_rally_points(self) -> None:
        """Send MISSION_CLEAR_ALL for the rally points and do not wait: RALLY_TOTAL shows whether it was taken."""
        self._require_link()
        await self.send_message("MISSION_CLEAR_ALL", {"mission_type": _RALLY_POINTS})

    async def _compare_rings(self, rings: FenceRings) -> None:
        found = await self.calls.run("read fence", self._link.download_fence, deadline_s=_FENCE_UPLOAD_S)
        words = difference(rings, found)
        if words:
            raise OtherFenceError(words)

    async def enable_fence(self) -> None:
        """Switch the fence on by MAV_CMD_DO_FENCE_ENABLE."""
        await self._command(commands.enable_fence)

    # --- frames ----------------------------------------------------------------------------------------------------

    def set_datum(self, datum: GlobalPose | None) -> None:
        """Set the map frame's origin; None: the next arm place becomes it."""
        self.telemetry.tie.set_datum(datum)

    @property
    def datum(self) -> GlobalPose | None:
        """Origin of the map frame."""
        return self.telemetry.tie.datum

    # --- inside ----------------------------------------------------------------------------------------------------

    def _receive(self, message: Message) -> None:
        if self._inbox is not None:
            self._inbox.put(message)

    def _handle(self, message: Message) -> None:
        if message.sender is not None:
            self._note_foreign(message, *message.sender)
        elif message.name == "PARAM_VALUE":
            self._parameters.take(message.fields)
        elif message.name == "COMMAND_ACK":
            self._check_kill(message.fields)
        else:
            self.telemetry.handle(message)

    def _note_foreign(self, message: Message, system: int, component: int) -> None:
        for subject in message.fields["subjects"]:
            self.topics.foreign_write.publish(ForeignWrite(message.arrival, system, component, subject))

    def _check_kill(self, fields: Mapping[str, Any]) -> None:
        if fields.get("command") == _COMMAND_ACK_KILL and fields.get("result") != commands.MavResult.ACCEPTED:
            words = say("Kill refused by the autopilot (result {result})", result=str(fields.get("result")))
            self.topics.status_text.publish(StatusText(self._clock(), _CRITICAL, words))

    def _on_reboot(self) -> None:
        self._parameters.forget()
        self._rtl_in_metres = None
        self._targets.clear()

    async def _command(self, function: Callable[..., T], *arguments: Any) -> T:
        self._require_link()
        since = self._clock()
        try:
            return await self.calls.run(function.__name__, function, self._link, *arguments)
        except commands.NotAcceptedError as error:
            words = await self._words(since)
            raise AutopilotError(words or words_of(error)) from error

    async def _words(self, since: float) -> str | None:
        """Return the autopilot's reason; STATUSTEXT may come a moment after the acknowledgement."""
        words = self.telemetry.texts.reason_since(since)
        if words is None:
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(_WORDS_AFTER_S):
                    await self.topics.status_text.next()
            words = self.telemetry.texts.reason_since(since)
        return words

    def _require_link(self) -> None:
        if not self.telemetry.state.connected:
            raise AutopilotError(say("No link to the autopilot"))

    async def send_message(self, name: str, fields: Mapping[str, Any]) -> None:
        """Send one message on a thread, and wait until it is sent. Raises AutopilotError."""
        await self.calls.run(name, self._link.send, name, fields)

    async def _keep_link(self) -> None:
        """Open, find, and open again after 5 s of silence, until cancelled."""
        loop = asyncio.get_running_loop()
        missing_since = look_at = loop.time()
        while True:
            try:
                await self.calls.run("open", self._link.open, deadline_s=_OPEN_S)
                if self._link.found and loop.time() >= look_at:
                    look_at = loop.time() + _LOOK_S
                    await self.calls.run("look around", self._link.look_around)
                if self._link.found or await self.calls.run("find", self._link.find, _FIND_S):
                    self._repeated.ends()
                    self.problem = ""
                elif loop.time() - missing_since > self._settings.connect_timeout_s:
                    raise AutopilotError(self._nobody())
                if self.telemetry.silence(self._clock()) > _REOPEN_S * self._clock.speed:
                    await self.calls.run("reopen", self._link.reopen, deadline_s=_OPEN_S)
                    await asyncio.sleep(_REOPEN_S)
                await asyncio.sleep(_WATCH_S)
            except AutopilotError as error:
                line = self._repeated.due(f"{str(error).rstrip('.')}; trying again")
                if line is not None:
                    _LOG.warning("%s", line)
                self.problem = words_of(error)
                await asyncio.sleep(_WATCH_S if self._link.found else _RETRY_S)

    def _nobody(self) -> str:
        """Return why there is no autopilot: nobody is heard, or others are."""
        url, found = self._settings.url, self._link.hearing()
        if found.second_sender.startswith(SEVERAL):
            return say("autopilot.url {url}: {words}", url=repr(url), words=found.second_sender)
        heard = found.heard or found.second_sender
        if heard:
            return say(
                "No copter is heard at autopilot.url {url}: is it on? Heard there: {heard}", url=repr(url), heard=heard
            )
        return say("No autopilot is heard at autopilot.url {url}: is it on and sending here?", url=repr(url))

    async def _watch(self) -> None:
        """Notice silence, ask for missing streams, and keep a fast simulation's failsafe quiet."""
        beat = knock = 0.0
        while True:
            now = self._clock()
            try:
                if self._link.found and self.telemetry.check_link(now):
                    for stream in self._rates.due(now):
                        await self._ask_rate(stream)
                    # MAVSDK's heartbeat is once a real second: too seldom for an autopilot of N seconds a second
                    if self._clock.speed > 1 and now - beat >= 1.0 and self._speaks:
                        beat = now
                        await self.send_message("HEARTBEAT", _HEARTBEAT)
                elif self._link.found:
                    self._targets.clear()
                    if not self._speaks and now - knock >= _KNOCK_S:
                        knock = now
                        await self._ask_rate(self._rates.any)
            except AutopilotError as error:
                _LOG.info("%s", error)
            await asyncio.sleep(_WATCH_S / max(1.0, self._clock.speed))

    async def _ask_rate(self, stream: Stream) -> None:
        await self.calls.run("ask rate", commands.ask_rate, self._link, stream)

    def _make_sender(self) -> LatestSender[Mapping[str, Any]]:
        send = functools.partial(self._link.send, "SET_POSITION_TARGET_LOCAL_NED")
        return LatestSender("autopilot-target", send)

    def _free_targets(self) -> None:
        """Leave a sender that hangs behind, and send by a new one."""
        if self._targets.busy_s > self.calls.deadline_s:
            self._targets.abandon()
            self._targets = self._make_sender()
            self.calls.note_overdue("target")


def expected_autopilot(
    settings: AutopilotSettings, flown_id: int | None = None, *, in_flight: bool = False
) -> Expected:
    """Return the autopilot that the settings name, else that of the flight; without one a second one is waited for."""
    host, port = (None, None) if settings.vehicle_address is None else host_and_port(settings.vehicle_address)
    named = settings.vehicle_system_id or flown_id
    return Expected(named, host, port, 0.0 if named is not None or in_flight else _ALONE_S)

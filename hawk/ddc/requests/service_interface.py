"""DDC Service Interface (specification section 16): requests to the autopilot, and the gate every target passes.

The secret is how the autopilot is asked. Access programs raise ReqFailed with the autopilot's own words.
"""

from __future__ import annotations

import asyncio
import logging
import math
import time
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

from hawk.comm.autopilot.vehicle import Autopilot, AutopilotError, OtherFenceError
from hawk.ddc.fence.geometry import contains, inside_point, leads_inside, outside_by, path_words, place_words
from hawk.ddc.motion import Goal, maximum_target_distance
from hawk.ddc.parameters.values import RALLY_NAME
from hawk.ddc.readings.topic_interface import TARGET_POSE_AGE_S, DdcTopicInterface
from hawk.model.operation import StateName
from hawk.model.plans import Fence, HeightParameters
from hawk.model.poses import GlobalPose, MapPose
from hawk.model.sentences import say, words_of
from hawk.model.vehicle import CopterMode

ABOVE_M = 2.0
"""A target is straight above or below the drone when it is no farther aside than this, metres."""
ENTRANCE_M = 1.0
"""A target for a drone outside may lie this much farther than the nearest place well inside, metres."""


@dataclass(frozen=True, slots=True)
class Limits:
    """Limits of a target: fence in force, travel heights (m), travel speed (m/s).

    ``holds``: the sender holds its place. It may stay above Max, and it leads a drone outside the fence back.
    """

    fence: Fence
    heights: HeightParameters
    speed: float
    holds: bool


def target_refusal(target: Goal, pose: MapPose, limits: Limits) -> str:
    """Return why the target must not be sent to a drone at this pose; empty when it may."""
    away = outside_by(limits.fence, pose.point) if limits.holds else 0.0
    return (
        _fence_refusal(target, pose, limits, away)
        or _height_refusal(target, pose, limits)
        or _distance_refusal(target, pose, limits, away)
    )


def _fence_refusal(target: Goal, pose: MapPose, limits: Limits, away: float) -> str:
    """Check the target and the straight path to it.

    A drone outside that is led back (``away`` metres) goes by steps, none farther out than the one before, and then by
    any path that ends inside.
    """
    if not contains(limits.fence, target.point):
        nearer = 0.0 < outside_by(limits.fence, target.point) <= away
        return "" if nearer else say("the target is {where}", where=place_words(limits.fence, target.point))
    if away > 0.0 or leads_inside(limits.fence, pose.point, target.point):
        return ""
    return say("the straight path to the target {leaves}", leaves=path_words(limits.fence))


def _height_refusal(target: Goal, pose: MapPose, limits: Limits) -> str:
    """Check the height against Min, Max and ceiling; outside them only the straight path back is free."""
    ceiling, lowest = limits.fence.ceiling, limits.heights.minimum
    highest = ceiling if limits.holds else min(limits.heights.maximum, ceiling)
    straight = _aside(target, pose) <= ABOVE_M
    descends = straight and target.height <= pose.height
    if target.height > ceiling and not (limits.holds and descends):
        return say("the target is above the ceiling of {ceiling:g} m", ceiling=ceiling)
    if target.height < lowest and not (straight and target.height >= pose.height):
        return say("the target is below Min, {lowest:g} m", lowest=lowest)
    if target.height > highest and not descends:
        return say("the target is above Max, {highest:g} m", highest=highest)
    return ""


def _distance_refusal(target: Goal, pose: MapPose, limits: Limits, away: float) -> str:
    """Check the distance; a drone outside may be sent to the nearest place well inside, however far that is."""
    limit = maximum_target_distance(limits.speed)
    across, up = _aside(target, pose), abs(target.height - pose.height)
    if max(across, up) <= limit:
        return ""
    if away > 0.0 and up <= limit and contains(limits.fence, target.point):
        nearest = inside_point(limits.fence, pose.point)
        if across <= pose.point.distance(nearest) + ENTRANCE_M:
            return ""
    return say("the target is {across:.1f} m away, more than {limit:.1f} m", across=max(across, up), limit=limit)


def _aside(target: Goal, pose: MapPose) -> float:
    return pose.point.distance(target.point)


MODE_WINDOW_S = 2.0
"""A mode change is ours when a request asked for it within this time, seconds."""
RTL_ALTITUDE_TOLERANCE_M = 0.5
READ_BACK_S = 3.0
"""Real seconds for which a parameter that was set may read as the old value."""
READ_BACK_PAUSE_S = 0.2


class ReqFailed(Exception):  # noqa: N818 - the specification's name
    """The autopilot refused a request, or did not answer; the text is its own words where it gave any."""


class TargetRefused(ReqFailed):
    """A target that must not be sent; the text names the condition that it fails."""


@dataclass(frozen=True, slots=True)
class Sender:
    """The state that sends a target: whether it may send any, and whether it holds above Max as well."""

    name: StateName
    may_send_targets: bool
    holds: bool


_LOGGER = logging.getLogger(__name__)
T = TypeVar("T")
Record = Callable[[str, dict[str, Any]], None]


class DdcServiceInterface:
    """Asks the autopilot; remembers which modes were asked for; sends a target only when nothing speaks against it."""

    def __init__(
        self,
        autopilot: Autopilot,
        topics: DdcTopicInterface,
        clock: Callable[[], float],
        speed: float,
        record: Record,
    ) -> None:
        self._autopilot = autopilot
        self._topics = topics
        self._clock = clock
        self._speed = speed
        self._record_with = record
        self._asked: dict[int, float] = {}
        self._held_fence: Fence | None = None
        self._forgotten = 0

    def init(self) -> None:
        """Forget the modes that were asked for."""
        self._asked.clear()

    @property
    def datum(self) -> GlobalPose | None:
        """Origin of the map frame."""
        return self._autopilot.datum

    @property
    def parameters(self) -> Mapping[str, float | int]:
        """Autopilot parameters read so far."""
        return self._autopilot.parameters

    @property
    def held_fence(self) -> Fence | None:
        """The fence that the autopilot holds, as read back from it; None while that is not known."""
        return self._held_fence

    def forget_held_fence(self) -> None:
        """A flight has ended, or the autopilot was not heard for a while: the fence that it holds is not known."""
        self._held_fence = None
        self._forgotten += 1

    def set_datum(self, datum: GlobalPose | None) -> None:
        """Set the origin of the map frame; None: the next arm place becomes it."""
        self._record("request", {"name": "set datum", "datum": _place(datum)})
        self._autopilot.set_datum(datum)

    async def set_arm(self, arm_req: bool) -> bool:
        """Arm or disarm. Returns True on the acknowledgement; the state follows by HEARTBEAT.

        Raises:
            ReqFailed: The autopilot refused, or did not answer.
        """
        await self._ask("arm" if arm_req else "disarm", self._autopilot.arm if arm_req else self._autopilot.disarm)
        return True

    async def set_rtl_alt(self, altitude: float) -> None:
        """Set the return altitude, metres above the arm place, and compare what the autopilot says when asked back."""
        found = await self._ask(
            "set return altitude", lambda: self._autopilot.set_rtl_altitude(altitude), altitude=altitude
        )
        if abs(found - altitude) > RTL_ALTITUDE_TOLERANCE_M:
            raise ReqFailed(
                say(
                    "return altitude: asked for {asked:g} m, the autopilot says {found:g} m",
                    asked=altitude,
                    found=found,
                )
            )

    async def send_takeoff_cmd(self, pose: GlobalPose | float) -> None:
        """Climb to a height: metres above the arm place, or the altitude of a global pose."""
        height = pose if isinstance(pose, float | int) else self._above_arm_place(pose)
        self._expect_mode(CopterMode.GUIDED)
        await self._ask("take off", lambda: self._autopilot.takeoff(height), height=height)

    async def set_mode(self, mode_req: CopterMode) -> None:
        """Ask for a flight mode."""
        self._expect_mode(mode_req)
        await self._ask("set mode", lambda: self._autopilot.set_mode(mode_req), mode=mode_req.name)

    async def send_mode(self, mode: CopterMode) -> None:
        """Send a flight mode as a message, without an answer: the autopilot may hear without being heard."""
        self._expect_mode(mode)
        await self._ask("send mode", lambda: self._autopilot.send_mode(mode), mode=mode.name)

    def set_voice(self, speaks: bool) -> None:
        """Let our heartbeats go out, or hold them back, so that the autopilot's ground-station failsafe acts."""
        self._record("request", {"name": "set voice", "speaks": speaks})
        self._autopilot.set_voice(speaks)

    async def kill(self) -> None:
        """Cut the motors at once."""
        await self._ask("kill", self._autopilot.kill)

    async def upload_fence(self, fence: Fence) -> None:
        """Upload and enable the autopilot's own fence, and read it back."""
        self._held_fence = None
        await self._ask("upload fence", lambda: self._autopilot.upload_fence(fence))
        self._held_fence = fence

    async def compare_fence(self, fence: Fence) -> None:
        """Read the autopilot's fence and compare it. Raises ReqFailed when it holds another one, or cannot be read.

        What it is known to hold stays known while it is read, and where it cannot be read.
        """
        forgotten = self._forgotten
        try:
            await self._ask("compare fence", lambda: self._autopilot.compare_fence(fence))
        except ReqFailed as failed:
            if isinstance(failed.__cause__, OtherFenceError):
                self._held_fence = None
            raise
        if forgotten == self._forgotten:
            self._held_fence = fence

    async def enable_fence(self) -> None:
        """Switch the autopilot's fence on by command."""
        await self._ask("enable fence", self._autopilot.enable_fence)

    async def set_home(self, place: GlobalPose) -> None:
        """Send a home; HOME_POSITION shows whether the autopilot took it."""
        await self._ask("set home", lambda: self._autopilot.set_home(place), place=_place(place))

    async def get_parameter(self, name: str) -> float | int:
        """Read one parameter."""
        return await self._ask("read parameter", lambda: self._autopilot.get_parameter(name), parameter=name)

    async def set_parameter(self, name: str, value: float) -> None:
        """Set one parameter and read it back."""
        await self._ask(
            "set parameter", lambda: self._autopilot.set_parameter(name, value), parameter=name, value=value
        )

    async def set_failsafes(self, wanted: Mapping[str, float]) -> None:
        """Set these parameters one by one, each read back until it holds; the first that does not ends it.

        Raises:
            ReqFailed: The autopilot refused one, or another value is read for READ_BACK_S.
        """
        for name, value in wanted.items():
            await self.set_parameter(name, value)
            await self._read_back(name, value)

    async def put_back(self, name: str, value: float) -> None:
        """Set one parameter that somebody changed in flight, read back until it holds.

        RALLY_TOTAL counts the rally points: they are cleared, which is the only value that is put back.

        Raises:
            ReqFailed: The autopilot refused it, or another value is read for READ_BACK_S.
        """
        if name == RALLY_NAME:
            await self._ask("clear rally points", self._autopilot.clear_rally_points)
        else:
            await self.set_parameter(name, value)
        await self._read_back(name, value)

    async def _read_back(self, name: str, value: float) -> None:
        deadline = time.monotonic() + READ_BACK_S
        while not math.isclose(found := await self.get_parameter(name), value, rel_tol=1e-6, abs_tol=1e-6):
            if time.monotonic() >= deadline:
                raise ReqFailed(
                    say("{name}: set to {value:g}, the autopilot says {found:g}", name=name, value=value, found=found)
                )
            await asyncio.sleep(READ_BACK_PAUSE_S)

    def asked_for(self, custom_mode: int | None) -> bool:
        """Return True when a request of the last 2 s asked for this mode."""
        asked = None if custom_mode is None else self._asked.get(custom_mode)
        return asked is not None and self._clock() - asked <= MODE_WINDOW_S

    def settle_mode(self, custom_mode: int | None) -> None:
        """A mode was seen: when it is the one asked for last, a change to one asked for earlier is not ours any more.

        It would come from a repeated datagram of a request that was overtaken, or from somebody else.
        """
        if custom_mode is not None and custom_mode in self._asked and custom_mode == next(reversed(self._asked)):
            self._asked = {custom_mode: self._asked[custom_mode]}

    def forget_asked_modes(self) -> None:
        """Somebody else took over: no mode change from here on is ours until we ask again."""
        self._asked.clear()

    def send_target(self, target: Goal, sender: Sender, heights: HeightParameters, fence: Fence | None) -> None:
        """Send one position target. Raises TargetRefused naming the condition that it fails (design, section 6)."""
        reason = self._refusal(target, sender, heights, fence)
        if reason:
            raise TargetRefused(reason)
        try:
            self._autopilot.send_target(target.north, target.east, target.height, target.yaw)
        except AutopilotError as error:
            raise TargetRefused(words_of(error)) from error

    def _refusal(self, target: Goal, sender: Sender, heights: HeightParameters, fence: Fence | None) -> str:
        """Return why the target must not be sent; empty when it may."""
        vehicle = self._topics.get_state()
        if not sender.may_send_targets:
            return say("{state} sends no targets", state=sender.name.value)
        if not self._topics.get_link_health().is_healthy:
            return say("No link to the autopilot")
        if not vehicle.armed or vehicle.custom_mode != CopterMode.GUIDED:
            return say("the autopilot is not armed in GUIDED but in {mode}", mode=str(vehicle.mode))
        if not target.is_finite():
            return say("the target is not finite")
        pose = self._topics.get_fresh_pose()
        if pose is None or pose.map is None:
            return say("the pose is older than {age:g} s", age=TARGET_POSE_AGE_S)
        if fence is None:
            return say("there is no fence in force")
        return target_refusal(target, pose.map, Limits(fence, heights, self._speed, sender.holds))

    def _above_arm_place(self, pose: GlobalPose) -> float:
        place = self._topics.vehicle.arm_place.value
        if place is None:
            raise ReqFailed(say("no arm place yet: give a height above it instead of a global pose"))
        return pose.altitude - place.altitude

    def _expect_mode(self, mode: CopterMode) -> None:
        self._asked.pop(int(mode), None)  # the one asked for last stands last
        self._asked[int(mode)] = self._clock()

    def _record(self, kind: str, content: dict[str, Any]) -> None:
        """Record; a recording that fails must not keep a request from being sent."""
        try:
            self._record_with(kind, content)
        except Exception:
            _LOGGER.exception("%s was not recorded", kind)

    async def _ask(self, name: str, call: Callable[[], Awaitable[T]], **details: Any) -> T:
        self._record("request", {"name": name, **details})
        try:
            answer = await call()
        except AutopilotError as error:
            self._record("answer", {"name": name, "failed": str(error), **details})
            raise ReqFailed(words_of(error)) from error
        self._record("answer", {"name": name, "value": answer if isinstance(answer, int | float) else None, **details})
        return answer


def _place(pose: GlobalPose | None) -> dict[str, float] | None:
    if pose is None:
        return None
    return {"latitude": pose.latitude, "longitude": pose.longitude, "altitude": pose.altitude}

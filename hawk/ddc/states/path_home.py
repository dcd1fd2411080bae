"""The flight home inside a bent fence: GUIDED targets along a path, until home is in straight sight.

The autopilot's RTL flies straight. It is asked for when home is in sight, and at once where the path cannot be flown:
coming home comes before the fence.
"""

from __future__ import annotations

from dataclasses import dataclass

from hawk.ddc.acts import Acts, Log
from hawk.ddc.battery.battery import BATTERY_UNKNOWN_S, RESERVE_CONFIRM_S
from hawk.ddc.battery.energy import Reserve
from hawk.ddc.facts import Facts
from hawk.ddc.fence.geometry import contains, path_is_inside
from hawk.ddc.fence.path import is_in_sight, length, route_inside
from hawk.ddc.motion import Goal, Progress, RouteFollower, stopping_point
from hawk.ddc.readings.position import POSITION_CONFIRM_S
from hawk.ddc.readings.topic_interface import POSE_TIMEOUT_S
from hawk.ddc.settings import DdcSettings
from hawk.ddc.states.explore import Travelling
from hawk.ddc.stopwatch import Stopwatch
from hawk.ddc.words import metres, sentence
from hawk.model.plans import Fence, Route
from hawk.model.poses import MapPoint, MapPose
from hawk.model.sentences import joined, say
from hawk.model.vehicle import CopterMode

CLIMBED_M = 2.0
"""Up to this far below the return height the drone goes across; lower it climbs first, as RTL does, metres."""
PLAN_AGAIN_S = 1.0
"""A drone that was driven off its path gets another one, not more often than this, seconds."""
RETURNING = frozenset({CopterMode.RTL, CopterMode.SMART_RTL})
"""Modes in which the autopilot flies home."""
TOO_FAR = say("the charge does not last for the path inside the fence")
CHARGE_UNKNOWN = say("the charge is not known")
NO_PATH = say("no path inside the fence leads home")
OUTSIDE = say("the drone is outside the fence")
POSITION_OLD = say("the position is too old")
POSITION_LOST = say("the autopilot does not trust its position")
RETURNS_ALREADY = say("the autopilot returns already")


@dataclass(frozen=True, slots=True)
class Straight:
    """RTL flies the rest. ``reason``: why, although home is not in sight; empty where it is."""

    reason: str = ""
    is_above_home: bool = False
    """Nothing flies the rest: the drone is above home, where it lands."""

    @property
    def words(self) -> Acts:
        """The message for the operator."""
        if not self.reason:
            return ()
        return (Log("warning", say("Straight home, beyond the fence: {reason}", reason=sentence(self.reason))),)


def is_beyond_sight(facts: Facts) -> bool:
    """Return True when the straight line home leaves our fence, from the drone or from where it comes to rest.

    An old pose counts here as well. False where fence, home or drone are not known.
    """
    pose, fence, home = facts.position.pose, facts.limits.fence, facts.position.home
    stop = None if pose is None else stopping_point(pose)
    if pose is None or pose.map is None or stop is None or fence is None or home is None:
        return False
    return not (path_is_inside(fence, pose.map.point, home) and path_is_inside(fence, stop.point, home))


def begin(facts: Facts, settings: DdcSettings, *, lands: bool = False) -> PathHome | Straight:
    """Return the flight along the path, where home is not in straight sight and nothing speaks against it.

    ``lands``: the path is flown to the place above home, in sight or not, because RTL would end elsewhere.
    """
    if not lands and not is_beyond_sight(facts):
        return Straight()
    place, fence, home = facts.place, facts.limits.fence, facts.position.home
    if place is None:
        return Straight(POSITION_OLD)
    if lands and facts.witness.place.is_doubted:
        return Straight(POSITION_LOST)
    reason = _obstacle(facts, may_return=lands)
    if not reason and not _lasts(facts):
        reason = TOO_FAR
    if reason or fence is None or home is None:
        return Straight(reason)
    if not contains(fence, place.point):
        return Straight(OUTSIDE)
    route = route_inside(fence, place.point, home)
    if route is None:
        return Straight(NO_PATH)
    return PathHome(facts.now, settings, place, Errand(fence, home, route), lands=lands)


@dataclass(frozen=True, slots=True)
class Errand:
    """A fence, home, and the route there."""

    fence: Fence
    home: MapPoint
    route: Route


class PathHome:
    """Leads the drone along the path: up to the return height first, then from corner to corner."""

    def __init__(self, now: float, settings: DdcSettings, place: MapPose, errand: Errand, *, lands: bool) -> None:
        """``lands``: it ends above home while RTL would end elsewhere."""
        self._lands = lands
        self._was_guided = False
        self._settings = settings
        self._travelling = Travelling(settings)
        self._progress = Progress()
        self._yaw = place.yaw
        self._short = Stopwatch()
        self._needs_path = False
        self._follow(errand, place, now)
        self.end: Straight | None = None
        """Why RTL follows; None while the path is flown."""

    def _follow(self, errand: Errand, place: MapPose, now: float) -> None:
        self._errand = errand
        self._follower = RouteFollower(errand.route, self._settings.flight.arrival_radius_m)
        self._from = place.point
        self._planned = now
        self._needs_path = False

    def restart(self) -> None:
        """Go on from where the drone is: it was not heard for a moment."""
        self._needs_path = True

    def route(self, facts: Facts) -> tuple[MapPoint, ...]:
        """Return the rest of the path, from the drone."""
        place = facts.last_place
        return () if place is None else self._follower.left(place.point)

    def detail(self, facts: Facts) -> str:
        """Return one sentence for the operator, and what hinders."""
        left = say("Returning home inside the fence, {distance} to go.", distance=metres(length(self.route(facts))))
        return joined(left, sentence(self._travelling.obstacle))

    def process(self, facts: Facts) -> Acts:
        """Return this tick's target; ``end`` says when RTL takes over."""
        self._was_guided |= facts.is_guided
        place, reason = facts.place, self._reason(facts)
        if reason:
            self.end = Straight(reason)
        elif place is not None:
            return self._lead(facts, place)
        return ()

    def _lead(self, facts: Facts, place: MapPose) -> Acts:
        away = place.point.distance(self._errand.home)
        if self._lands and facts.is_astray and away <= self._settings.flight.arrival_radius_m:
            self.end = Straight(is_above_home=True)
            return ()
        if not (self._lands and facts.is_astray) and self._is_in_sight(facts, place):
            self.end = Straight()
            return (Log("info", say("Home is in straight sight.")),)
        if self._must_plan(facts) and not self._plan(facts, place):
            self.end = Straight(NO_PATH)
            return ()
        height = min(facts.limits.heights.maximum, self._errand.fence.ceiling)
        aim, corner = self._follower.aim(place.point), self._follower.heading_for
        lowest = height - CLIMBED_M + 0.5  # the carrot itself allows half a metre
        acts = self._travelling.process(facts, Goal(aim.north, aim.east, height, self._yaw), lowest=lowest)
        climbs = place.height < height - CLIMBED_M
        to = self._from if climbs else corner
        if self._progress.is_stuck(place, Goal(to.north, to.east, height, self._yaw), facts.now):
            self.end = Straight(joined(say("no progress on the path for 10 s."), self._travelling.obstacle))
            return ()
        return acts

    def _reason(self, facts: Facts) -> str:
        """Return the reason why the path must not be flown on; empty when it may."""
        short_s = self._short.update(not _lasts(facts), facts.now)
        is_short = short_s is not None and short_s >= RESERVE_CONFIRM_S
        if facts.position.age > POSE_TIMEOUT_S:
            return POSITION_OLD
        if self._travelling.refusal:
            return say("GUIDED was refused: {reason}", reason=self._travelling.refusal)
        may_return = self._lands and not self._was_guided
        return _obstacle(facts, may_return=may_return) or (TOO_FAR if is_short else "")

    def _is_in_sight(self, facts: Facts, place: MapPose) -> bool:
        """Return True when home is in sight from the drone and from where it comes to rest: RTL begins there."""
        stop = None if facts.pose is None else stopping_point(facts.pose)
        fence, home = self._errand.fence, self._errand.home
        return stop is not None and is_in_sight(fence, place.point, home) and is_in_sight(fence, stop.point, home)

    def _must_plan(self, facts: Facts) -> bool:
        """Return True when the path is not the right one any more: it, or the drone on the map, was moved."""
        if (facts.limits.fence, facts.position.home) != (self._errand.fence, self._errand.home):
            return True
        if self._needs_path or max(facts.position.jump_m, facts.position.estimate_jump_m) > 0:
            return True
        return self._travelling.is_path_barred and facts.now - self._planned >= PLAN_AGAIN_S

    def _plan(self, facts: Facts, place: MapPose) -> bool:
        fence, home = facts.limits.fence, facts.position.home
        route = None if fence is None or home is None else route_inside(fence, place.point, home)
        if fence is None or home is None or route is None:
            return False
        self._follow(Errand(fence, home, route), place, facts.now)
        self._travelling.restart()
        return True


def _obstacle(facts: Facts, *, may_return: bool = False) -> str:
    """Return what speaks against flying by targets: position, fence, the autopilot's mode, an unknown charge.

    ``may_return``: the autopilot returns, and GUIDED takes it over.
    """
    if facts.position.distrusted_s >= POSITION_CONFIRM_S:
        return POSITION_LOST
    if facts.is_breached:
        return OUTSIDE
    if facts.vehicle.custom_mode in RETURNING and not may_return:
        return RETURNS_ALREADY
    unknown = facts.battery.reserve is None or facts.battery.unknown_s >= BATTERY_UNKNOWN_S
    return CHARGE_UNKNOWN if unknown else ""


def _lasts(facts: Facts) -> bool:
    reserve: Reserve | None = facts.battery.reserve
    return reserve is not None and reserve.lasts

"""Home: the place that the autopilot's Return To Launch flies to. Any station may move it, so it is watched.

While the drone is armed and no pilot flies, a home that left the arm place is set back and looked at again. RTL plans
its path once, with home as it is at that moment; `hawk.ddc.states.rtl_and_land` begins it again after home was set
back.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

from hawk.comm.topic import Stamped, Topic
from hawk.ddc.fence.geometry import contains, to_map
from hawk.ddc.readings.instant import Instant, Parts, Reading
from hawk.ddc.stopwatch import Stopwatch
from hawk.ddc.words import metres
from hawk.model.frames import offset_ned
from hawk.model.operation import Health
from hawk.model.plans import Fence
from hawk.model.poses import ArmPlace, GlobalPose, MapPoint
from hawk.model.sentences import say

HOME_TOLERANCE_M = 3.0
"""Distance in space between home and the arm place that is no move, metres. ArduCopter sets home at arming to within
2 cm of the pose that it reports then; a receiver may drift until "armed" is heard."""


@dataclass(frozen=True, slots=True)
class HomeFacts:
    """Home as the autopilot reports it, compared with the arm place (`hawk.ddc.readings.home`)."""

    place: GlobalPose | None = None
    age: float = math.inf
    away: float | None = None
    """Distance from the arm place in space, metres; None while disarmed, and before a reading of this arming."""
    moved_s: float | None = None
    """Seconds since home left the arm place; None when it is there and has been for a while."""
    is_inside: bool = False
    """Home lies inside our fence, and about as high as the arm place."""

    @property
    def is_moved(self) -> bool:
        """True while home is not at the arm place: `moved_s` lasts a little longer."""
        return self.away is not None and self.away > HOME_TOLERANCE_M

    @property
    def misleads(self) -> bool:
        """True while RTL would leave the fence."""
        return self.is_moved and not self.is_inside


HOME_HEIGHT_M = 5.0
"""A home farther above or below the arm place changes the return height too much, metres."""
HOME_AGE_S = 10.0
"""An older HOME_POSITION says nothing, seconds; it comes once a second, and at once when home moves."""
HOLDS_S = 3.0
"""Home is back when it has been right for this time, seconds."""
HOME_WAIT_S = 3.0
"""Home that is not back within this time stays moved, seconds."""


def home_words(home: HomeFacts) -> str:
    """Return in words how far home is from the arm place."""
    away = metres(home.away or 0.0)
    if home.is_inside:
        return say("Home is {away} from the arm place.", away=away)
    return say("Home is {away} from the arm place, outside the fence.", away=away)


class HomeReading(Reading):
    """Compares HOME_POSITION with the arm place, in flight and armed on the ground."""

    def __init__(self, home: Topic[GlobalPose]) -> None:
        """``home``: HOME_POSITION."""
        self._home = home
        self._arm: Stamped[ArmPlace] | None = None
        self._disarmed_at = -math.inf
        self._wrong, self._right = Stopwatch(), Stopwatch()
        self._facts = HomeFacts()

    def update(self, instant: Instant) -> None:
        """Compare the two."""
        vehicle, arm = instant.vehicle, instant.arm
        armed = vehicle.armed or not math.isfinite(vehicle.time)  # before the first HEARTBEAT it may be armed
        if not armed:
            self._disarmed_at = instant.now
        self._note_arming(arm if armed and arm is not None and arm.time >= self._disarmed_at else None)
        self._facts = self._compare(instant)

    def facts(self) -> HomeFacts:
        """Return home as the autopilot reported it at the last tick."""
        return self._facts

    def parts(self, instant: Instant) -> Parts:
        """Return the health of home."""
        return (("home", home_health(self._facts)),)

    def ends(self, instant: Instant) -> tuple[MapPoint, ...]:
        """Return the places on the map at which the flight home may end: the arm place, and home where it was moved.

        None is known before there are a datum and an arm place.
        """
        datum, home, place = instant.datum, home_on_map(instant), self._facts.place
        if datum is None or home is None:
            return ()
        if not self._facts.is_moved or place is None:
            return (home,)
        return (home, to_map(datum, place.latitude, place.longitude))  # RTL flies to the latter

    def _compare(self, instant: Instant) -> HomeFacts:
        home, arm, now = self._home.latest, self._arm, instant.now
        if home is None:
            return HomeFacts()
        place, age = home.value, now - home.time
        if arm is None or home.time < arm.time:  # a home of before this arming
            return HomeFacts(place, age)
        down, away = _offset(place, arm.value)
        is_inside = abs(down) <= HOME_HEIGHT_M and _is_inside(place, instant.datum, instant.fence)
        return HomeFacts(place, age, away, self._time(away > HOME_TOLERANCE_M, now), is_inside)

    def _note_arming(self, arm: Stamped[ArmPlace] | None) -> None:
        """Begin again with each arming. A jump of EKF-local publishes the same place again: it is no arming."""
        known = None if self._arm is None else _place(self._arm.value)
        if arm is None or known != _place(arm.value):
            self._arm, self._wrong, self._right = arm, Stopwatch(), Stopwatch()

    def _time(self, is_wrong: bool, now: float) -> float | None:
        """Return for how long it has been wrong: a right reading ends that when it has lasted."""
        right_s, wrong_s = self._right.update(not is_wrong, now), self._wrong.read(now)
        still_wrong = wrong_s is not None and right_s is not None and right_s < HOLDS_S
        return self._wrong.update(is_wrong or still_wrong, now)


def home_on_map(instant: Instant) -> MapPoint | None:
    """Return the arm place on the map; None before there are a datum and an arm place."""
    datum, arm = instant.datum, instant.arm_place
    return None if datum is None or arm is None else _on_map(datum, arm)


def home_health(home: HomeFacts) -> Health:
    """Return the health of home. On the ground before arming nothing depends on it."""
    if home.is_moved:
        return Health.bad(home_words(home))
    if home.away is not None and home.age > HOME_AGE_S:
        return Health.bad(say("No home position from the autopilot."))
    return Health()


@lru_cache(maxsize=1)
def _on_map(datum: GlobalPose, arm: ArmPlace) -> MapPoint:
    return to_map(datum, arm.latitude, arm.longitude)


def _offset(home: GlobalPose, arm: ArmPlace) -> tuple[float, float]:
    """Return how far home lies below the arm place, and from it in space, metres."""
    offset = offset_ned(home, GlobalPose(arm.latitude, arm.longitude, arm.altitude))
    return offset[2], math.hypot(*offset)


def _is_inside(place: GlobalPose, datum: GlobalPose | None, fence: Fence | None) -> bool:
    return datum is not None and fence is not None and contains(fence, to_map(datum, place.latitude, place.longitude))


def _place(arm: ArmPlace) -> tuple[float, float, float]:
    return arm.latitude, arm.longitude, arm.altitude

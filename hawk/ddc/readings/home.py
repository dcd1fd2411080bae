"""Home: the place that the autopilot's Return To Launch flies to. Any station may move it, so it is watched.

While the drone is armed and no pilot flies, a home that left the arm place is set back and looked at again. RTL plans
its path once, with home as it is at that moment; `hawk.ddc.states.homing` begins it again after home was set back.
"""

from __future__ import annotations

import math

from hawk.comm.topic import Stamped
from hawk.ddc.facts import HOME_TOLERANCE_M, Facts, HomeFacts
from hawk.ddc.fence.geometry import contains, to_map
from hawk.ddc.orders import Cause, ToLand, ToReturn
from hawk.ddc.words import metres
from hawk.model.frames import offset_ned
from hawk.model.limits import Fence
from hawk.model.operation import Health
from hawk.model.poses import ArmPlace, GlobalPose
from hawk.model.sentences import joined, say

HOME_HEIGHT_M = 5.0
"""A home farther above or below the arm place changes the return height too much, metres."""
HOME_AGE_S = 10.0
"""An older HOME_POSITION says nothing, seconds; it comes once a second, and at once when home moves."""
HOLDS_S = 3.0
"""Home is back when it has been right for this time, seconds."""
HOME_WAIT_S = 3.0
"""Home that is not back within this time stays moved, seconds."""


def returning(facts: Facts, cause: Cause) -> ToReturn | ToLand:
    """Return the transition of a return that cannot wait, nor fly a path.

    Land where RTL would not end at home, and where the drone's own place is doubted.
    """
    if facts.witness.misleads_home:
        return ToLand(cause_here(facts, cause))
    return (
        ToLand(astray(facts, cause)) if leaves(facts) else ToReturn(cause, straight=say("the program cannot lead it"))
    )


def cause_here(facts: Facts, cause: Cause) -> Cause:
    """Return the cause of a landing in place of a return that would fly to a place that is doubted."""
    return Cause(joined(cause.text, facts.witness.doubt), cause.kind, cause.details)


def leaves(facts: Facts) -> bool:
    """Return True while RTL would not end at home, nor at a home that somebody moved inside the fence."""
    home = facts.position.autopilot_home
    return home.misleads or (bool(facts.kept.astray) and not home.is_moved)


def astray(facts: Facts, cause: Cause | None) -> Cause | None:
    """Return the cause of a landing in place of a return; None keeps a landing that nobody caused."""
    if cause is None:
        return None
    return Cause(joined(cause.text, astray_words(facts)), cause.kind, cause.details)


def astray_words(facts: Facts) -> str:
    """Return in words why RTL would not end at home."""
    home = facts.position.autopilot_home
    return home_words(home) if home.is_moved else facts.kept.astray


def home_words(home: HomeFacts) -> str:
    """Return in words how far home is from the arm place."""
    away = metres(home.away or 0.0)
    if home.is_inside:
        return say("Home is {away} from the arm place.", away=away)
    return say("Home is {away} from the arm place, outside the fence.", away=away)


class HomeWatch:
    """Compares HOME_POSITION with the arm place, in flight and armed on the ground."""

    def __init__(self) -> None:
        self._arm: Stamped[ArmPlace] | None = None
        self._disarmed_at = -math.inf
        self._wrong_since: float | None = None
        self._right_since: float | None = None

    def look(
        self,
        home: Stamped[GlobalPose] | None,
        arm: Stamped[ArmPlace] | None,
        armed: bool,
        datum: GlobalPose | None,
        fence: Fence | None,
        now: float,
    ) -> HomeFacts:
        """Return the facts at ``now``, seconds; ``datum`` is the map's origin, ``fence`` the one in force."""
        if not armed:
            self._disarmed_at = now
        self._note_arming(arm if armed and arm is not None and arm.time >= self._disarmed_at else None)
        if home is None:
            return HomeFacts()
        place, age = home.value, now - home.time
        if self._arm is None or home.time < self._arm.time:  # a home of before this arming
            return HomeFacts(place, age)
        down, away = _offset(place, self._arm.value)
        is_inside = abs(down) <= HOME_HEIGHT_M and _is_inside(place, datum, fence)
        return HomeFacts(place, age, away, self._time(away > HOME_TOLERANCE_M, now), is_inside)

    def _note_arming(self, arm: Stamped[ArmPlace] | None) -> None:
        """Begin again with each arming. A jump of EKF-local publishes the same place again: it is no arming."""
        known = None if self._arm is None else _place(self._arm.value)
        if arm is None:
            self._arm = self._wrong_since = self._right_since = None
        elif known != _place(arm.value):
            self._arm, self._wrong_since, self._right_since = arm, None, None

    def _time(self, is_wrong: bool, now: float) -> float | None:
        if is_wrong:
            self._right_since = None
            self._wrong_since = now if self._wrong_since is None else self._wrong_since
        elif self._right_since is None:
            self._right_since = now
        elif now - self._right_since >= HOLDS_S:
            self._wrong_since = None
        return None if self._wrong_since is None else now - self._wrong_since


def home_health(home: HomeFacts) -> Health:
    """Return the health of home. On the ground before arming nothing depends on it."""
    if home.is_moved:
        return Health.bad(home_words(home))
    if home.away is not None and home.age > HOME_AGE_S:
        return Health.bad(say("No home position from the autopilot."))
    return Health()


def _offset(home: GlobalPose, arm: ArmPlace) -> tuple[float, float]:
    """Return how far home lies below the arm place, and from it in space, metres."""
    offset = offset_ned(home, GlobalPose(arm.latitude, arm.longitude, arm.altitude))
    return offset[2], math.hypot(*offset)


def _is_inside(place: GlobalPose, datum: GlobalPose | None, fence: Fence | None) -> bool:
    return datum is not None and fence is not None and contains(fence, to_map(datum, place.latitude, place.longitude))


def _place(arm: ArmPlace) -> tuple[float, float, float]:
    return arm.latitude, arm.longitude, arm.altitude

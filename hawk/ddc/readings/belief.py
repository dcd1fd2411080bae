"""Belief in armed and landed: a word of the autopilot that ends a flight needs a second witness.

"Armed" is believed at once. "Disarmed" and "on the ground" end the protection of a flight, so they are believed only
while they are young and neither each other nor height and climb speak against them. HEARTBEAT and EXTENDED_SYS_STATE
carry no time stamp: one that comes late looks like a new one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from hawk.ddc.readings.topic_interface import POSE_TIMEOUT_S
from hawk.ddc.stopwatch import Stopwatch
from hawk.model.operation import Health
from hawk.model.poses import VehiclePose
from hawk.model.sentences import say
from hawk.model.vehicle import (
    LANDED_TIMEOUT_S,
    LandedState,
    VehicleState,
)


@dataclass(frozen=True, slots=True)
class GroundFacts:
    """Armed and landed as the autopilot gives them. `Facts.vehicle` holds what is believed.

    The mode of a HEARTBEAT whose "disarmed" is doubted is not believed either.
    """

    armed_said: bool = False
    landed_said: LandedState = LandedState.UNDEFINED
    landed_age: float = math.inf
    """Seconds since the last EXTENDED_SYS_STATE."""
    doubt: str = ""
    """Reason why the autopilot's word is not believed; empty when it is."""
    doubted_s: float = 0.0
    """Seconds since the doubt began."""

    @property
    def lasting_doubt(self) -> str:
        """The doubt once it has lasted long enough to be shown; empty before, and without one."""
        return self.doubt if self.doubted_s >= DOUBT_CONFIRM_S else ""


DOUBT_CONFIRM_S = 0.5
"""Seconds for which a doubt must last before it is shown: one late datagram is soon put right."""

AIR_HEIGHT_M = 3.0
"""An armed drone that is higher than this above its arm place does not stand there: on the ground the height drifts by
a metre or two."""
CLIMB_M_S = 1.0
"""A drone that climbs or sinks faster does not stand: the estimate of one that stands moves by some tenths."""
FALL_M_S = 4.0
"""No mode of ours sinks so fast (LOITER without a radio: 2.4 m/s): a drone that does has no motors."""
DISARMED_S = 5.0
"""HEARTBEATs that say "disarmed" for this time are believed whatever speaks against them: a copter without motors has
fallen 100 m by then."""
ARM_PLACE_LATE_S = 1.0
"""The arm place of a flight is published from this much before "armed" is seen on, seconds."""

_FLYING = frozenset({LandedState.IN_AIR, LandedState.TAKING_OFF, LandedState.LANDING})


@dataclass(frozen=True, slots=True)
class Motion:
    """Height above the arm place (metres) and climb (m/s, up positive); None where not known."""

    height: float | None = None
    climb: float | None = None

    @classmethod
    def of(cls, pose: VehiclePose | None, age: float) -> Motion:
        """Return the motion of a pose of that age, seconds; nothing is known of an old one."""
        if pose is None or age > POSE_TIMEOUT_S:
            return cls()
        return cls(_finite(pose.relative_altitude), _finite(-pose.velocity[2]))

    @property
    def against_ground(self) -> str:
        """Words that speak against a drone that stands; empty when nothing does."""
        if self.height is not None and self.height > AIR_HEIGHT_M:
            return say("its height is {height:z.0f} m", height=self.height)
        if self.climb is not None and abs(self.climb) > CLIMB_M_S:
            if self.climb > 0:
                return say("it climbs at {climb:.1f} m/s", climb=self.climb)
            return say("it sinks at {climb:.1f} m/s", climb=-self.climb)
        return ""

    @property
    def is_fall(self) -> bool:
        """True for a drone that falls."""
        return self.climb is not None and self.climb < -FALL_M_S


@dataclass(frozen=True, slots=True)
class Belief:
    """``vehicle``: the state as it is believed; ``ground``: the same as the autopilot gives it, and the doubt."""

    vehicle: VehicleState = VehicleState()
    ground: GroundFacts = GroundFacts()
    motion: Motion = Motion()
    """Height and climb; no height where the arm place is that of an earlier flight."""

    @property
    def is_airborne(self) -> bool:
        """True when the drone is believed armed and not believed on the ground."""
        return self.vehicle.armed and self.vehicle.landed is not LandedState.ON_GROUND


class BeliefReading:
    """Compares armed, landed, height and climb with each other, moment by moment."""

    def __init__(self) -> None:
        self._first_heard: float | None = None
        self._armed = False
        self._mode: int | None = None
        self._armed_since = -math.inf
        self._disarmed = Stopwatch()  # by the times of HEARTBEATs
        self._doubted = Stopwatch()

    def update(self, said: VehicleState, motion: Motion, arm_place_time: float, now: float) -> Belief:
        """Return what is believed now.

        Args:
            said: The autopilot's state as it came last.
            motion: Height and climb.
            arm_place_time: When the arm place was published, seconds; heights above that of an earlier flight count
                for nothing.
            now: Seconds of the daemon's clock.
        """
        landed = said.landed_at(now)
        rises = said.armed and not self._armed
        if rises and self._first_heard is not None:
            self._armed_since = now
        if arm_place_time < self._armed_since - ARM_PLACE_LATE_S:
            motion = replace(motion, height=None)
        armed, doubt = self._believe_armed(said, landed, motion)
        if armed == said.armed:
            self._mode = said.custom_mode  # that of a HEARTBEAT which is not believed is not believed either
        stands = motion if armed else replace(motion, height=None)  # it may stand on a hill
        believed, second = _believe_landed(armed, landed, stands)
        doubt = doubt or second or self._silence(said)
        doubted_s = self._doubted.update(bool(doubt), now) or 0.0
        ground = GroundFacts(said.armed, said.landed, now - said.landed_time, doubt, doubted_s)
        return Belief(replace(said, armed=armed, custom_mode=self._mode, landed=believed), ground, motion)

    def _believe_armed(self, said: VehicleState, landed: LandedState, motion: Motion) -> tuple[bool, str]:
        """Return whether it counts as armed, and why the autopilot's word is doubted."""
        if not math.isfinite(said.time):
            return False, ""
        if self._first_heard is None:
            self._first_heard = said.time
        if said.armed or not self._armed:
            self._armed = said.armed
            self._disarmed.update(False, said.time)
            return said.armed, ""
        disarmed_s = self._disarmed.update(True, said.time) or 0.0
        against = "" if motion.is_fall else motion.against_ground
        stands = landed is LandedState.ON_GROUND and not against
        if stands or disarmed_s >= DISARMED_S:
            self._armed = False
            self._disarmed.update(False, said.time)
            return False, ""
        if not against:
            against = say("also that it flies") if landed in _FLYING else say("not that it is on the ground")
        return True, say("The autopilot says that it is disarmed, but {against}.", against=against)

    def _silence(self, said: VehicleState) -> str:
        """Return the doubt when HEARTBEATs go on without a landed state."""
        if self._first_heard is None or said.time - max(said.landed_time, self._first_heard) <= LANDED_TIMEOUT_S:
            return ""
        return say("The autopilot does not say whether it is on the ground.")


def ground_health(ground: GroundFacts, *, is_linked: bool) -> Health:
    """Return the health of armed and landed: bad while a doubt lasts. Without a link the link's own health is shown."""
    doubt = ground.lasting_doubt if is_linked else ""
    return Health.bad(doubt) if doubt else Health()


def _believe_landed(armed: bool, landed: LandedState, motion: Motion) -> tuple[LandedState, str]:
    """Return the landed state that is believed, and why the autopilot's word is doubted."""
    if landed is LandedState.ON_GROUND and motion.against_ground:
        against = motion.against_ground
        return LandedState.UNDEFINED, say(
            "The autopilot says that it is on the ground, but {against}.", against=against
        )
    if landed in _FLYING and not armed:
        return LandedState.UNDEFINED, say("The autopilot says that it flies, but also that it is disarmed.")
    return landed, ""


def _finite(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None

"""The position: the latest pose, for how long the autopilot has distrusted it, its jumps, and the places beside it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Final

from hawk.ddc.readings.clearance import BelowFacts
from hawk.ddc.readings.home import HomeFacts
from hawk.ddc.readings.instant import Instant, Reading
from hawk.ddc.readings.topic_interface import DdcTopicInterface
from hawk.model.poses import ArmPlace, GlobalPose, MapPoint, VehiclePose

POSITION_CONFIRM_S: Final = 2.0
"""Seconds for which the autopilot must distrust its position."""


@dataclass(frozen=True, slots=True)
class PositionFacts:
    """The latest pose however old it is, its age, and the places that belong to it."""

    pose: VehiclePose | None = None
    age: float = math.inf
    distrusted_s: float = 0.0
    """Seconds since the autopilot last trusted its position."""
    jump_m: float = 0.0
    """Jump of EKF-local since the last tick, metres; 0 without one."""
    datum: GlobalPose | None = None
    arm_place: ArmPlace | None = None
    home: MapPoint | None = None
    estimate_jump_m: float = 0.0
    """Jump of the estimate since the last tick, metres: the pose moved on the map, the drone did not. 0 without one."""
    autopilot_home: HomeFacts = HomeFacts()
    """Home as the autopilot reports it; ``home`` is the arm place."""
    below: BelowFacts = field(default_factory=BelowFacts)
    """The rangefinder's view of what is below; the slope before Arm."""


class Jumps:
    """Collects the jumps of one kind between two ticks."""

    def __init__(self) -> None:
        self._metres = 0.0

    def note(self, metres: float) -> None:
        """Keep the largest jump."""
        self._metres = max(self._metres, abs(metres))

    def take(self) -> float:
        """Return the largest jump since the last call, metres."""
        taken, self._metres = self._metres, 0.0
        return taken


class PositionReading(Reading):
    """Times the autopilot's distrust, and hears every jump."""

    def __init__(self, topics: DdcTopicInterface, now: float) -> None:
        self._topics = topics
        self._trusted_at = now
        self._jumps, self._estimate_jumps = Jumps(), Jumps()
        self._stops = (
            topics.vehicle.frame_jump.listen(self._jumps.note),
            topics.vehicle.estimate_jump.listen(self._estimate_jumps.note),
        )

    def update(self, instant: Instant) -> None:
        """Look whether the autopilot trusts its position."""
        if self._topics.get_diagnostics().global_position_ok:
            self._trusted_at = instant.now

    def facts(
        self, instant: Instant, home: MapPoint | None, autopilot_home: HomeFacts, below: BelowFacts
    ) -> PositionFacts:
        """Return what is known, without jumps.

        ``home`` is the arm place on the map, ``autopilot_home`` what it reports, ``below`` the rangefinder's.
        """
        return PositionFacts(
            pose=instant.pose,
            age=instant.pose_age,
            distrusted_s=instant.now - self._trusted_at,
            datum=instant.datum,
            arm_place=instant.arm_place,
            home=home,
            autopilot_home=autopilot_home,
            below=below,
        )

    def take_jumps(self, facts: PositionFacts) -> PositionFacts:
        """Return the facts with the largest jump of each kind since the last call."""
        return replace(facts, jump_m=self._jumps.take(), estimate_jump_m=self._estimate_jumps.take())

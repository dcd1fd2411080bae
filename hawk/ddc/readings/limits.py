"""Limits of the flight: heights, the fence in force and whether it is breached, the planned fence, the outline."""

from __future__ import annotations

from dataclasses import dataclass

from hawk.ddc.fence.geometry import BREACH_TOLERANCE_M, outside_by
from hawk.ddc.fence.keepers import FenceKeeper, OutlineKeeper
from hawk.ddc.fence.outline import OutlineFacts
from hawk.ddc.fence.plan import FencePlan
from hawk.ddc.readings.instant import Instant, Reading
from hawk.ddc.stopwatch import Stopwatch
from hawk.model.plans import Fence, HeightParameters


@dataclass(frozen=True, slots=True)
class LimitFacts:
    """Heights, the fence in force and the planned fence."""

    heights: HeightParameters = HeightParameters()
    fence: Fence | None = None
    breached_s: float | None = None
    """Seconds since the drone left our fence or ceiling; None inside."""
    plan: FencePlan = FencePlan("circle", (), 0.0)
    """The fence of the next Arm."""
    plan_problem: str = ""
    """Reason why a stored fence cannot be used; empty when it can."""
    planned_ceiling: float = 0.0
    """Our ceiling of the planned fence, metres above the arm place."""
    held: Fence | None = None
    """The fence that the autopilot holds, as read back from it; None while that is not known."""
    outline: OutlineFacts | None = None
    """Size of the area that Explore is to survey; None: the lot is found by looking."""


class LimitsReading(Reading):
    """Times a breach of fence or ceiling."""

    def __init__(self, fences: FenceKeeper, outlines: OutlineKeeper, ceiling_margin_m: float) -> None:
        """``ceiling_margin_m``: our ceiling lies below the planned fence's by this, metres."""
        self._fences = fences
        self._outlines = outlines
        self._margin_m = ceiling_margin_m
        self._breach = Stopwatch()

    def update(self, instant: Instant) -> None:
        """Look where the drone is: a breach begins beyond the tolerance, and ends inside fence and ceiling."""
        pose, fence, now = instant.fresh_pose, instant.fence, instant.now
        if not instant.is_airborne or fence is None:
            self._breach.update(False, now)
        elif pose is not None and pose.map is not None:
            beyond = max(outside_by(fence, pose.map.point), pose.map.height - fence.ceiling)
            was_beyond = self._breach.read(now) is not None
            self._breach.update(beyond > BREACH_TOLERANCE_M or (was_beyond and beyond > 0.0), now)

    def facts(self, instant: Instant) -> LimitFacts:
        """Return what is known."""
        plan = self._fences.plan
        return LimitFacts(
            heights=instant.heights,
            fence=instant.fence,
            breached_s=self._breach.read(instant.now),
            plan=plan,
            plan_problem=self._fences.problem,
            planned_ceiling=plan.ceiling - self._margin_m,
            held=instant.held_fence,
            outline=self._outlines.facts(instant.datum, instant.fence),
        )

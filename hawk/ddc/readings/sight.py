"""Sight: what camera, vision, mapper and planner say, and for how long one of them has been at fault."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

from hawk.ddc.readings.instant import Instant, Reading
from hawk.ddc.readings.topic_interface import DdcTopicInterface
from hawk.ddc.stopwatch import Stopwatch
from hawk.model.lot_map import Counts
from hawk.model.plans import DesiredPose, PathPlan, Verdict
from hawk.model.poses import MapPoint

PERCEPTION_PARTS: Final = ("camera", "vision", "mapper", "planner")
"""The parts that flight by sight depends on, in the order of dependence."""
FAULT_CONFIRM_S: Final = 1.0
"""Seconds for which a fault of perception must last: one bad picture does not count."""


@dataclass(frozen=True, slots=True)
class SightFacts:
    """Results of camera, vision, mapper and planner; None where a result is older than its limit."""

    lot: bool | None = None
    """Lot in sight."""
    plan: PathPlan | None = None
    plan_time: float = -math.inf
    verdict: Verdict | None = None
    desired: DesiredPose | None = None
    """The place that the planner judges now."""
    desired_count: int = 0
    """Number of the newest desired pose so far."""
    asked: Verdict | None = None
    """Verdict on the place of a Route Request."""
    fault: str = ""
    """The first part of perception that is unhealthy, with its reason; empty when all are well."""
    fault_s: float = 0.0
    footprint: tuple[MapPoint, ...] = ()
    counts: Counts = Counts()
    lot_area: float = 0.0
    vision_rate: float | None = None
    camera_age: float | None = None


class SightReading(Reading):
    """Times a fault of perception."""

    def __init__(self, topics: DdcTopicInterface) -> None:
        self._topics = topics
        self._fault = Stopwatch()

    def update(self, instant: Instant) -> None:
        """Look whether a part of perception is at fault."""
        self._fault.update(bool(_fault_words(instant)), instant.now)

    def facts(self, instant: Instant, desired_count: int) -> SightFacts:
        """Return what is known. ``desired_count``: number of the newest desired pose."""
        topics = self._topics
        occupancy = topics.get_occupancy_map()
        return SightFacts(
            lot=topics.has_lot_word(),
            plan=topics.get_path_plan(),
            plan_time=topics.get_path_plan_time(),
            verdict=topics.get_fresh_verdict(),
            desired=topics.des_pose_pub.value,
            desired_count=desired_count,
            asked=topics.get_asked_verdict(),
            fault=_fault_words(instant),
            fault_s=self._fault.read(instant.now) or 0.0,
            footprint=topics.get_footprint(),
            counts=occupancy.counts,
            lot_area=occupancy.lot_area_m2,
            vision_rate=topics.get_vision_rate(),
            camera_age=topics.get_camera_age(),
        )


def _fault_words(instant: Instant) -> str:
    for name in PERCEPTION_PARTS:
        health = instant.healths[name]
        if not health.is_healthy:
            return f"{name.capitalize()}: {health.reason}"
    return ""

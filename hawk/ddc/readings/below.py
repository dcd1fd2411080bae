"""The senses of what is below: the rangefinder's messages in flight, the drone's tilt before Arm."""

from __future__ import annotations

from hawk.ddc.readings.clearance import SILENT_S, BelowFacts, ClearanceWatch, least_clearance, range_health
from hawk.ddc.readings.slope import SlopeWatch
from hawk.ddc.readings.topic_interface import TARGET_POSE_AGE_S, DdcTopicInterface
from hawk.model.operation import Health
from hawk.model.vehicle import LandedState, VehicleState


class BelowWatch:
    """Looks once a tick."""

    def __init__(self, topics: DdcTopicInterface, least_clearance_m: float) -> None:
        self._topics = topics
        self._least_m = least_clearance_m
        self._clearance = ClearanceWatch()
        self._slope = SlopeWatch()

    def update(self, vehicle: VehicleState) -> None:
        """Take the newest message and pose. ``vehicle``: the state that is believed."""
        stands = vehicle.landed is LandedState.ON_GROUND
        terrain, pose = self._topics.vehicle.terrain.value, self._topics.get_pose()
        if stands or not vehicle.armed:
            self._clearance.reset()
        else:
            self._clearance.update(terrain, least_clearance(self._least_m, self._topics.get_heights().minimum))
        if vehicle.armed or not stands:
            self._slope.reset()
        elif pose is not None and self._topics.get_pose_age() <= TARGET_POSE_AGE_S:  # before Arm there is no map
            self._slope.update(pose)

    def facts(self, now: float) -> BelowFacts:
        """Return what is known."""
        terrain = self._topics.vehicle.terrain.fresh(SILENT_S)
        return BelowFacts(terrain, *self._clearance.low(now), self._slope.slope())

    def part(self) -> tuple[tuple[str, Health], ...]:
        """Return the rangefinder's name and health; nothing when none was ever heard."""
        topic = self._topics.vehicle.terrain
        health = range_health(topic.value, topic.age)
        return () if health is None else (("rangefinder", health),)

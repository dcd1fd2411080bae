"""The senses of second witnesses: what the camera sees of the drone's motion, beside what the autopilot reports."""

from __future__ import annotations

from hawk.ddc.place import PlaceWatch
from hawk.ddc.topic_interface import DdcTopicInterface
from hawk.ddc.witness import WitnessFacts
from hawk.model.ground_motion import GroundStep
from hawk.model.vehicle import LandedState, VehicleState


class Witnesses:
    """Hears every message of the witnesses; looks once a tick."""

    def __init__(self, topics: DdcTopicInterface) -> None:
        self._place = PlaceWatch()
        self._flies = False
        self._stops = (
            topics.ground_step.listen(self._note),
            topics.vehicle.estimate_jump.listen(lambda _: self._place.lose()),
        )

    def close(self) -> None:
        """Stop listening."""
        for stop in self._stops:
            stop()

    def update(self, vehicle: VehicleState) -> None:
        """Take the state that is believed: on the ground everything begins again."""
        self._flies = vehicle.armed and vehicle.landed is not LandedState.ON_GROUND
        if not self._flies:
            self._place.reset()

    def facts(self, now: float) -> WitnessFacts:
        """Return what is known at ``now``, seconds."""
        return WitnessFacts(self._place.facts(now))

    def _note(self, step: GroundStep) -> None:
        if self._flies:
            self._place.note(step)

"""The senses of second witnesses: what the camera sees of the drone's motion, beside what the autopilot reports."""

from __future__ import annotations

from hawk.comm.autopilot.terrain import Terrain
from hawk.ddc.readings.topic_interface import DdcTopicInterface
from hawk.ddc.witnesses.heading import HeadingWatch
from hawk.ddc.witnesses.height import HeightFacts, HeightWatch
from hawk.ddc.witnesses.place import PlaceWatch
from hawk.ddc.witnesses.witness import WitnessFacts
from hawk.model.ground_motion import GroundStep
from hawk.model.stall_size import StallSize
from hawk.model.vehicle import GnssHeight, LandedState, VehicleState


class Witnesses:
    """Hears every message of the witnesses; looks once a tick."""

    def __init__(self, topics: DdcTopicInterface) -> None:
        self._topics = topics
        self._place, self._height, self._heading = PlaceWatch(), HeightWatch(), HeadingWatch()
        self._seen_height = HeightFacts()
        self._flies = False
        self._stops = (
            topics.ground_step.listen(self._note),
            topics.stall_size.listen(self._note_size),
            topics.vehicle.estimate_jump.listen(lambda _: self._place.lose()),
            topics.vehicle.gnss_height.listen(self._note_gnss),
            topics.vehicle.terrain.listen(self._note_range),
        )

    def close(self) -> None:
        """Stop listening."""
        for stop in self._stops:
            stop()

    def update(self, vehicle: VehicleState, now: float) -> None:
        """Take the state that is believed: on the ground everything begins again."""
        self._flies = vehicle.armed and vehicle.landed is not LandedState.ON_GROUND
        if not self._flies:
            self._place.reset()
            self._height.stand()
            self._heading.reset()
        self._seen_height = self._height.look(now, self._topics.get_rel_alt())

    def facts(self, now: float) -> WitnessFacts:
        """Return what is known at ``now``, seconds."""
        return WitnessFacts(self._place.facts(now), self._seen_height, self._heading.facts(now))

    def _note(self, step: GroundStep) -> None:
        if self._flies:
            self._place.note(step)
            self._height.note(step)
            self._heading.note(step)

    def _note_size(self, size: StallSize) -> None:
        if self._flies:
            self._height.note_size(size)

    def _note_gnss(self, height: GnssHeight) -> None:
        self._height.note_gnss(height.time, height.altitude, height.accuracy, height.reported)

    def _note_range(self, terrain: Terrain) -> None:
        if self._flies and terrain.believed_ground is not None:
            self._height.note_range(terrain.time, terrain.believed_ground)

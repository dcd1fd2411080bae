"""Second witnesses of the autopilot's place, height and heading: what they say, and what one tick believes of it."""

from __future__ import annotations

from dataclasses import dataclass, field

from hawk.comm.autopilot.terrain import Terrain
from hawk.ddc.readings.instant import Instant, Parts, Reading
from hawk.ddc.readings.topic_interface import DdcTopicInterface
from hawk.ddc.witnesses.heading import HeadingFacts, HeadingReading
from hawk.ddc.witnesses.height import AGREES_M, HeightFacts, HeightReading
from hawk.ddc.witnesses.place import PlaceFacts, PlaceReading
from hawk.model.operation import Health
from hawk.model.pictures import GroundStep, StallSize
from hawk.model.sentences import say
from hawk.model.vehicle import Diagnostics, GnssHeight

ALONE_S = 10.0
"""The position has no second witness once the camera has compared nothing for this time in the air, seconds."""
LOW_M = 5.0
"""Below this height a drone takes off or lands, and no pictures are compared, metres."""
ALONE = say("The position has no second witness: the camera recognises no ground.")
COMPASS_LOST = say("No compass works: the heading is kept by gyroscopes and GNSS.")


@dataclass(frozen=True, slots=True)
class WitnessFacts:
    """Readings of the autopilot beside those of others."""

    place: PlaceFacts = field(default_factory=PlaceFacts)
    height: HeightFacts = field(default_factory=HeightFacts)
    heading: HeadingFacts = field(default_factory=HeadingFacts)
    unseen_s: float = 0.0
    """Seconds above `LOW_M` for which the camera has compared nothing; 0 on the ground."""

    @property
    def is_alone(self) -> bool:
        """True while the position has no second witness. It ends nothing: the position may well be right."""
        return self.unseen_s >= ALONE_S

    @property
    def doubt(self) -> str:
        """Why no task is flown; empty without a doubt."""
        return self.place.words or self.height.words or self.heading.words

    @property
    def is_displaced(self) -> bool:
        """True when the drone is not where it is reported: held by the report, it would move."""
        return self.place.is_doubted or self.height.is_doubted

    @property
    def misled_s(self) -> float | None:
        """Seconds for which RTL would fly by a place that is wrong, or lower than it says, of the newer doubt.

        None while it would not.
        """
        height = self.height.doubted_s if self.height.off >= AGREES_M else None
        return min((each for each in (self.place.doubted_s, height) if each is not None), default=None)

    @property
    def misleads_home(self) -> bool:
        """True when RTL would fly by a place that is wrong, or lower than it says: Land is flown instead."""
        return self.misled_s is not None

    def position_health(self, reported: Health) -> Health:
        """Return the position's health: as ``reported`` by the autopilot, unless that is good and doubted."""
        return Health.bad(self.doubt) if reported.is_healthy and self.doubt else reported


def compass_part(diagnostics: Diagnostics) -> Parts:
    """Return the compasses' name and health; nothing where none is in use."""
    if diagnostics.compass_ok is None:
        return ()
    return (("compass", Health() if diagnostics.compass_ok else Health.bad(COMPASS_LOST)),)


def witness_health(facts: WitnessFacts) -> Health:
    """Return the health of the position's second witness."""
    return Health.bad(ALONE) if facts.is_alone else Health()


class WitnessReading(Reading):
    """Hears every message of the witnesses; looks once a tick."""

    def __init__(self, topics: DdcTopicInterface) -> None:
        self._topics = topics
        self._place, self._height, self._heading = PlaceReading(), HeightReading(), HeadingReading()
        self._seen_height = HeightFacts()
        self._flies = False
        self._high_since = 0.0
        self._stops = (
            topics.ground_step.listen(self._note),
            topics.stall_size.listen(self._note_size),
            topics.vehicle.estimate_jump.listen(lambda _: self._place.lose()),
            topics.vehicle.gnss_height.listen(self._note_gnss),
            topics.vehicle.terrain.listen(self._note_range),
        )

    def update(self, instant: Instant) -> None:
        """Judge the height; on the ground everything begins again."""
        self._flies = instant.is_airborne
        reported = None if instant.pose is None else instant.pose.relative_altitude
        if not self._flies or (reported is not None and reported < LOW_M):
            self._high_since = instant.now
        if not self._flies:
            self._place.reset()
            self._height.stand()
            self._heading.reset()
        self._seen_height = self._height.look(instant.now, reported)

    def facts(self, instant: Instant) -> WitnessFacts:
        """Return what is known."""
        place, heading = self._place.facts(instant.now), self._heading.facts(instant.now)
        return WitnessFacts(place, self._seen_height, heading, self._unseen_s(instant.now, place))

    def parts(self, instant: Instant) -> Parts:
        """Return the health of the compasses, where one is in use, and of the position's witness, in the air."""
        parts = compass_part(self._topics.get_diagnostics())
        return (*parts, ("witness", witness_health(self.facts(instant)))) if self._flies else parts

    def _unseen_s(self, now: float, place: PlaceFacts) -> float:
        return min(place.camera_age, now - self._high_since) if self._flies else 0.0

    def _note(self, step: GroundStep) -> None:
        if self._flies:
            self._place.note(step, self._topics.get_diagnostics().horizontal_accuracy)
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

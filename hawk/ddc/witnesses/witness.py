"""Second witnesses of the autopilot's place: values, made by the watches of `hawk.ddc.witnesses.watch`."""

from __future__ import annotations

from dataclasses import dataclass, field

from hawk.ddc.witnesses.heading import HeadingFacts
from hawk.ddc.witnesses.height import AGREES_M, HeightFacts
from hawk.ddc.witnesses.place import PlaceFacts
from hawk.model.operation import Health
from hawk.model.sentences import say
from hawk.model.vehicle import Diagnostics

COMPASS_LOST = say("No compass works: the heading is kept by gyroscopes and GNSS.")


@dataclass(frozen=True, slots=True)
class WitnessFacts:
    """Readings of the autopilot beside those of others."""

    place: PlaceFacts = field(default_factory=PlaceFacts)
    height: HeightFacts = field(default_factory=HeightFacts)
    heading: HeadingFacts = field(default_factory=HeadingFacts)

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


def compass_part(diagnostics: Diagnostics) -> tuple[tuple[str, Health], ...]:
    """Return the compasses' name and health; nothing where none is in use."""
    if diagnostics.compass_ok is None:
        return ()
    return (("compass", Health() if diagnostics.compass_ok else Health.bad(COMPASS_LOST)),)

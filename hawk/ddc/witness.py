"""Second witnesses of the autopilot's place: values, made by the watches of `hawk.ddc.witnesses`."""

from __future__ import annotations

from dataclasses import dataclass, field

from hawk.ddc.place import PlaceFacts
from hawk.model.operation import Health


@dataclass(frozen=True, slots=True)
class WitnessFacts:
    """Readings of the autopilot beside those of others."""

    place: PlaceFacts = field(default_factory=PlaceFacts)

    @property
    def doubt(self) -> str:
        """Why no task is flown; empty without a doubt."""
        return self.place.words

    def position_health(self, reported: Health) -> Health:
        """Return the position's health: as ``reported`` by the autopilot, unless that is good and doubted."""
        return Health.bad(self.doubt) if reported.is_healthy and self.doubt else reported

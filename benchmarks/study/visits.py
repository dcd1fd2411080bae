"""The surveys of a study: when they are flown, and what they see."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Final

import numpy as np

from benchmarks.lots.visits import COMPASS, FIRST, Visit, drawn_bias
from hawk.worlds.generate import WorldOptions, generate_world
from hawk.worlds.moment import clock_of
from hawk.worlds.world import World

PLACE: Final = (43.26, -79.92)
CLOCK: Final = clock_of(PLACE[1])
MAPPING: Final = datetime(2026, 5, 3, 10, 30, tzinfo=CLOCK)
"""Moment of the flight that finds the lot, whose plan a person then corrects. No figure uses it."""
DAY: Final = datetime(2026, 5, 4, tzinfo=CLOCK)
"""The day that is flown from morning to evening: a Monday."""
HOURS: Final = (7.2, 8.3, 9.4, 10.5, 11.5, 12.0, 12.5, 13.0, 13.5, 14.6, 16.4, 17.5)
"""Hours of its twelve surveys: every half hour at noon, so that turnover has an upper end there."""
WEEK: Final = ((7, 9.5), (8, 11.4), (9, 13.5), (10, 15.5), (11, 17.3), (12, 12.4))
"""Days after that day and hours of the six surveys of the other week, Monday to Saturday."""


@dataclass(frozen=True, slots=True)
class StudyLot:
    """The lot of a seed, surveyed by a receiver and a compass that are off by what each visit draws."""

    seed: int

    @property
    def name(self) -> str:
        """Name of the lot."""
        return f"seed {self.seed}"

    def visits(self, most: int | None = None) -> list[Visit]:
        """Return the mapping flight and the surveys of the study, `most` of these at most."""
        rng = np.random.default_rng((self.seed, 39))
        return [
            Visit(
                number, (moment - FIRST).total_seconds() / 3600.0, bias=drawn_bias(rng),
                compass=float(rng.uniform(-COMPASS, COMPASS)),
            )
            for number, moment in enumerate((MAPPING, *moments()[:most]), 1)
        ]  # fmt: skip

    def world(self, visit: Visit) -> World:
        """Return what a survey sees."""
        return generate_world(self.seed, WorldOptions(at=visit.at, place=PLACE))


def moments() -> Sequence[datetime]:
    """Return the moments of the study's eighteen surveys."""
    day = [DAY + timedelta(hours=hour) for hour in HOURS]
    return [*day, *(DAY + timedelta(days=days, hours=hour) for days, hour in WEEK)]

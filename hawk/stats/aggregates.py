"""A lot's occupancy hour by hour as aggregates of the Curb Data Specification 1.0 (``/metrics/aggregates``).

Source: https://github.com/openmobilityfoundation/curb-data-specification/tree/main/metrics
"""

from __future__ import annotations

import csv
import io
from collections import defaultdict
from datetime import date, timedelta
from typing import Final

import numpy as np

from hawk.stats.figures import by_hour
from hawk.stats.hours import Hours
from hawk.stats.section_use import SectionPanel
from hawk.stats.values import Panel

FIELDS: Final = ("curb_place_type", "curb_place_id", "metric_type", "date", "hour", "value")
METRIC: Final = "occupancy_percent"
"""The only metric that surveys give as a number: turnover and stay are brackets, sessions are not seen."""
NOT_FLOWN: Final = -1
"""The specification's value for an hour without a source."""


def cds_aggregates(panel: Panel, sections: SectionPanel | None = None) -> str:
    """Return a table (CSV) of the lot, and of each section with places, as a curb zone: a line for each hour of each
    day, from the first day with a survey to the last one, on the panel's clock. The value is the mean share that was
    taken, of a section vehicles ÷ places: above 1 where more are parked.
    """
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(FIELDS)
    of_sections = () if sections is None else sections.shares_by_hour()
    for zone, shares in ((panel.lot, _shares(by_hour(panel))), *of_sections):
        for day in _days(tuple(day for day, _ in shares)):
            for hour in range(24):
                value = shares.get((day, hour), NOT_FLOWN)
                table.writerow(("zone", zone, METRIC, day.isoformat(), hour, value))
    return text.getvalue()


def _shares(hours: Hours) -> dict[tuple[date, int], float]:
    """Return the shares by day and hour; an hour that a clock shows twice has the mean of both."""
    found: dict[tuple[date, int], list[float]] = defaultdict(list)
    for day, hour, mean in zip(hours.day, hours.hour, hours.mean[:, 0].tolist(), strict=True):
        if np.isfinite(mean):
            found[day, hour].append(mean)
    return {key: round(sum(shares) / len(shares), 4) for key, shares in found.items()}


def _days(flown: tuple[date, ...]) -> list[date]:
    if not flown:
        return []
    first = min(flown)
    return [first + timedelta(days=number) for number in range((max(flown) - first).days + 1)]

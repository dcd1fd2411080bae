"""Occupancy hour by hour in the words of the Curb Data Specification."""

from __future__ import annotations

import csv
from dataclasses import replace
from datetime import timedelta, timezone
from zoneinfo import ZoneInfo

from hawk.stats.aggregates import FIELDS, cds_aggregates
from hawk.stats.values import FREE, TAKEN, Panel
from tests.unit.stats.panels import at, panel

HALF = [TAKEN] * 10 + [FREE] * 10
FULL = [TAKEN] * 20


def rows(of: Panel) -> list[dict[str, str]]:
    table = csv.DictReader(cds_aggregates(of).splitlines())
    assert tuple(table.fieldnames or ()) == FIELDS
    return list(table)


def test_every_hour_of_the_days_between_the_first_and_the_last_survey_has_a_line_and_only_flown_ones_a_share() -> None:
    found = rows(panel([at(8.5), at(9.25, days=2)], [HALF, FULL]))
    assert [(row["date"], int(row["hour"])) for row in found] == [
        (f"2026-05-{day:02d}", hour) for day in (4, 5, 6) for hour in range(24)
    ]
    flown = {(row["date"], row["hour"]): float(row["value"]) for row in found if row["value"] != "-1"}
    assert set(flown) == {("2026-05-04", "8"), ("2026-05-06", "9")}
    assert abs(flown["2026-05-04", "8"] - 0.5) < 0.02
    assert flown["2026-05-06", "9"] > 0.97
    assert {(row["curb_place_type"], row["curb_place_id"], row["metric_type"]) for row in found} == {
        ("zone", "lot", "occupancy_percent")
    }


def test_hours_and_dates_are_those_of_the_clock() -> None:
    eastern = replace(panel([at(2.5)], [HALF]), clock=timezone(timedelta(hours=-5)))
    (flown,) = [row for row in rows(eastern) if row["value"] != "-1"]
    assert (flown["date"], flown["hour"]) == ("2026-05-03", "21")


def test_an_hour_that_the_clock_shows_twice_has_one_line() -> None:
    """In Amsterdam the hour from two to three comes twice on 25 October 2026."""
    twice = [at(0.5, days=174), at(1.5, days=174)]
    found = rows(replace(panel(twice, [HALF, FULL]), clock=ZoneInfo("Europe/Amsterdam")))
    assert len(found) == 24
    (flown,) = [row for row in found if row["value"] != "-1"]
    assert (flown["date"], flown["hour"]) == ("2026-10-25", "2")
    assert 0.5 < float(flown["value"]) < 0.99


def test_a_lot_that_nobody_flew_over_has_no_line() -> None:
    assert rows(panel([], [])) == []

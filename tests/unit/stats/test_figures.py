from __future__ import annotations

from dataclasses import replace

import pytest

from hawk.stats.between import steady
from hawk.stats.figures import figures
from hawk.stats.grouping import groups_of
from hawk.stats.values import FREE, TAKEN, UNSEEN, Estimate
from tests.unit.stats.panels import at, everything, panel


def filled(taken: int, of: int = 20) -> list[int]:
    return [TAKEN] * taken + [FREE] * (of - taken)


def holds(found: Estimate, value: float) -> bool:
    return found.low is not None and found.high is not None and found.low <= value <= found.high


def test_capacity_occupancy_accumulation_and_load_are_those_of_the_flown_hours() -> None:
    found = figures(panel([at(9.5), at(10.5), at(9.5, days=1)], [filled(8), filled(12), filled(10)])).whole
    assert found is not None
    assert (found.capacity, found.surveys, found.hours) == (20, 3, 3)
    assert found.occupancy.value == pytest.approx(0.5, abs=0.01)
    assert found.accumulation.value == pytest.approx(10, abs=0.2)
    assert found.load.value == pytest.approx(30, abs=0.6)
    assert holds(found.load, 30)


def test_the_peak_is_the_fullest_flown_hour_and_says_how_many_others_it_may_be() -> None:
    found = figures(
        panel([at(9.5), at(12.5, days=1), at(15.5, days=2)], [filled(20, 100), filled(90, 100), filled(88, 100)])
    ).whole
    assert found is not None
    assert found.peak is not None
    assert (found.peak.begin, found.peak.rivals) == ("2026-05-05T12:00", 1)
    assert holds(found.peak.accumulation, 90)


def test_shares_of_time_above_practical_capacity_count_the_hours_that_may_be_above_it() -> None:
    whole = figures(panel([at(9.5), at(12.5, days=1)], [filled(40, 100), filled(99, 100)])).whole
    assert whole is not None
    assert [each.value for each in whole.above] == [0.5, 0.5]
    near = figures(panel([at(9.5), at(12.5, days=1)], [filled(40, 100), filled(86, 100)])).whole
    assert near is not None
    assert (near.above[0].value, near.above[0].low, near.above[0].high) == (0.5, 0.0, 0.5)


def test_hours_that_nobody_flew_are_empty_and_others_are_means_over_their_days() -> None:
    found = figures(panel([at(9.5), at(9.5, days=1), at(15.5)], [filled(8), filled(12), filled(20)]))
    assert [hour.hour for hour in found.hours if hour.occupancy.value is not None] == [9, 15]
    assert (found.hours[9].days, found.hours[9].occupancy.surveys) == (2, 2)
    assert found.hours[9].occupancy.value == pytest.approx(0.5, abs=0.01)
    empty = found.hours[10]
    assert (empty.occupancy.low, empty.occupancy.high, empty.occupancy.surveys, empty.days) == (None, None, 0, 0)


def test_days_of_the_week_are_compared_by_the_hours_that_both_have() -> None:
    moments = [at(9.5), at(12.5), at(9.5, days=1), at(18.5, days=1), at(9.5, days=7)]
    found = figures(
        panel(moments, [filled(40, 100), filled(90, 100), filled(80, 100), filled(10, 100), filled(50, 100)])
    )
    assert [(day.weekday, day.days, day.hours) for day in found.days] == [(0, 2, 3), (1, 1, 2)]
    (pair,) = found.compared
    assert (pair.first, pair.second, pair.hours) == (0, 1, 1)
    assert pair.difference.value == pytest.approx(0.8 - 0.45, abs=0.03)
    assert holds(pair.difference, 0.35)


def test_rows_and_kinds_have_figures_of_their_own() -> None:
    seen = panel([at(9.5), at(10.5)], [[TAKEN] * 10 + [FREE] * 10] * 2)
    found = figures(seen, "row")
    assert [(part.name, part.capacity) for part in found.parts] == [("A", 10), ("B", 10)]
    assert [part.occupancy.value for part in found.parts] == pytest.approx([1.0, 0.0], abs=0.01)
    stalls = tuple(replace(stall, kind="disabled") if k < 4 else stall for k, stall in enumerate(seen.stalls))
    assert [group.name for group in groups_of(replace(seen, stalls=stalls), "kind")] == ["normal", "disabled"]


def test_stalls_never_and_always_taken_are_those_of_every_look_and_unseen_ones_may_be_both() -> None:
    seen = panel([at(9.5), at(10.5)], [[TAKEN, TAKEN, FREE, FREE, UNSEEN], [TAKEN, FREE, FREE, UNSEEN, UNSEEN]])
    (found,) = steady(seen, everything(seen))
    assert [stall.label for stall in found.never_stalls] == ["A 3"]
    assert [stall.label for stall in found.always_stalls] == ["A 1"]
    assert found.never.value == 1.0
    assert found.never.high == pytest.approx(3.0, abs=0.1)  # two were seen less than twice


def test_a_lot_without_surveys_has_no_figures() -> None:
    found = figures(panel([], []))
    assert (found.whole, found.days, found.compared, found.surveys) == (None, (), (), 0)

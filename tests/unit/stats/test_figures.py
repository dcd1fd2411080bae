from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from zoneinfo import ZoneInfo

import numpy as np
import pytest

from hawk.stats.changes import steady
from hawk.stats.figures import by_hour, figures
from hawk.stats.values import DEVIATIONS, FREE, TAKEN, UNSEEN, Estimate, Panel, groups_of
from tests.unit.stats.panels import at, everything, panel


def filled(taken: int, of: int = 20) -> list[int]:
    return [TAKEN] * taken + [FREE] * (of - taken)


def in_layouts(given: Panel, layouts: Sequence[Sequence[bool]]) -> Panel:
    """Return the surveys with the stalls (S, N) that the layout of each has; none has seen another one."""
    there = np.array(layouts, np.bool_)
    taken = np.where(there, given.taken_probability, np.nan).astype(np.float32)
    return replace(
        given, taken_probability=taken, state=np.where(there, given.state, UNSEEN).astype(np.int8), is_there=there
    )


def same(found: Estimate, share: Estimate, factor: float) -> bool:
    """Return True when a figure is a share times a factor, with its interval."""
    pairs = zip((found.value, found.low, found.high), (share.value, share.low, share.high), strict=True)
    return found.surveys == share.surveys and all(
        one == other if one is None or other is None else one == pytest.approx(other * factor, rel=1e-9, abs=1e-12)
        for one, other in pairs
    )


def holds(found: Estimate, value: float) -> bool:
    return found.low is not None and found.high is not None and found.low <= value <= found.high


def test_capacity_occupancy_accumulation_and_load_are_those_of_the_flown_hours() -> None:
    found = figures(panel([at(9.5), at(10.5), at(9.5, days=1)], [filled(8), filled(12), filled(10)])).whole
    assert found is not None
    assert (found.capacity, found.surveys, found.hours) == (20, 3, 3)
    assert found.occupancy.value == pytest.approx(0.5, abs=0.01)
    assert found.accumulation.value == pytest.approx(10, abs=0.2)
    assert found.load_space_hours.value == pytest.approx(30, abs=0.6)
    assert holds(found.load_space_hours, 30)


def test_load_and_accumulation_take_each_hour_with_the_stalls_of_its_own_layout() -> None:
    """Ten of ten stalls, the next day ten of a hundred: 20 space-hours in two hours."""
    states = [filled(10, 100)] * 2
    given = in_layouts(panel([at(9.5), at(9.5, days=1)], states), [[True] * 10 + [False] * 90, [True] * 100])
    found = figures(given)
    assert found.whole is not None
    assert found.whole.load_space_hours.value == pytest.approx(20, abs=0.01)
    assert found.whole.accumulation.value == pytest.approx(10, abs=0.01)
    assert found.whole.peak is not None
    assert found.whole.peak.accumulation.value == pytest.approx(10, abs=0.01)
    assert found.hours[9].accumulation.value == pytest.approx(10, abs=0.01)
    hours = by_hour(given)
    off = DEVIATIONS * np.hypot(*(hours.capacity[:, 0] * np.sqrt(hours.variance[:, 0])))
    for figure, parts in (
        (found.whole.load_space_hours, 1),
        (found.whole.accumulation, 2),
        (found.hours[9].accumulation, 2),
    ):
        assert (figure.value or 0) - (figure.low or 0) == pytest.approx(off / parts)


def test_a_row_that_comes_into_the_layout_within_an_hour_counts_from_then_on() -> None:
    states = [[TAKEN] * 20] * 2
    grown = in_layouts(panel([at(9.25), at(9.75)], states), [[True] * 10 + [False] * 10, [True] * 20])
    found = figures(grown, "row")
    new = found.parts[1]
    assert (new.name, new.capacity, new.surveys) == ("B", 10, 1)
    assert new.load_space_hours.value == new.accumulation.value == pytest.approx(10, abs=0.01)
    assert new.peak is not None
    assert new.peak.accumulation.value == pytest.approx(10, abs=0.01)
    assert found.whole is not None
    assert found.whole.load_space_hours.value == pytest.approx(15, abs=0.01), "the mean capacity of the hour's surveys"


@pytest.mark.parametrize("seed", range(3))
def test_in_one_layout_load_and_accumulation_are_the_occupancy_by_the_stalls(seed: int) -> None:
    rng = np.random.default_rng(seed)
    moments = sorted(at(float(hour), day) for day in range(5) for hour in rng.uniform(6, 20, 6))
    states = rng.choice([TAKEN, FREE, UNSEEN], p=[0.6, 0.3, 0.1], size=(len(moments), 30))
    states[rng.random(len(moments)) < 0.3, 10:20] = UNSEEN
    found = figures(panel(moments, states.tolist()), "row")
    assert found.whole is not None
    assert len(found.parts) == 3
    for use in (found.whole, *found.parts):
        assert use.capacity is not None
        assert same(use.accumulation, use.occupancy, use.capacity)
        assert same(use.load_space_hours, use.occupancy, use.capacity * use.hours)
        assert use.peak is not None
        assert same(use.peak.accumulation, use.peak.occupancy, use.capacity)
    assert all(same(hour.accumulation, hour.occupancy, 30) for hour in found.hours)
    assert sum(hour.days for hour in found.hours) == found.whole.hours


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
    assert [each.value for each in whole.above.values()] == [0.5, 0.5]
    near = figures(panel([at(9.5), at(12.5, days=1)], [filled(40, 100), filled(86, 100)])).whole
    assert near is not None
    assert (near.above["0.85"].value, near.above["0.85"].low, near.above["0.85"].high) == (0.5, 0.0, 0.5)


def test_hours_that_nobody_flew_are_empty_and_others_are_means_over_their_days() -> None:
    found = figures(panel([at(9.5), at(9.5, days=1), at(15.5)], [filled(8), filled(12), filled(20)]))
    assert [hour.hour for hour in found.hours if hour.occupancy.value is not None] == [9, 15]
    assert (found.hours[9].days, found.hours[9].occupancy.surveys) == (2, 2)
    assert found.hours[9].occupancy.value == pytest.approx(0.5, abs=0.01)
    empty = found.hours[10]
    assert (empty.occupancy.low, empty.occupancy.high, empty.occupancy.surveys, empty.days) == (None, None, 0, 0)


def test_an_hour_that_the_clock_shows_twice_is_of_one_day() -> None:
    """In Amsterdam the hour from two to three comes twice on 25 October 2026."""
    twice = panel([at(0.5, days=174), at(1.5, days=174)], [filled(8), filled(12)])
    found = figures(replace(twice, clock=ZoneInfo("Europe/Amsterdam")))
    assert [(hour.hour, hour.days, hour.occupancy.surveys) for hour in found.hours if hour.days] == [(2, 1, 2)]
    assert [(day.days, day.hours) for day in found.days] == [(1, 2)]
    assert found.whole is not None
    assert same(found.hours[2].occupancy, found.whole.occupancy, 1), "both hours, with the errors that they share"


def test_days_of_the_week_are_compared_by_the_hours_that_both_have() -> None:
    moments = [at(9.5), at(12.5), at(9.5, days=1), at(18.5, days=1), at(9.5, days=7)]
    found = figures(
        panel(moments, [filled(40, 100), filled(90, 100), filled(80, 100), filled(10, 100), filled(50, 100)])
    )
    assert [(day.day, day.days, day.hours) for day in found.days] == [("Monday", 2, 3), ("Tuesday", 1, 2)]
    (pair,) = found.compared
    assert (pair.first, pair.second, pair.hours) == ("Monday", "Tuesday", 1)
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
    ((never, always),) = steady(seen, everything(seen))
    assert never.stalls == ("A 3",)
    assert always.stalls == ("A 1",)
    assert never.value == 1.0
    assert never.high == pytest.approx(3.0, abs=0.1)  # two were seen less than twice


def test_a_lot_without_surveys_has_no_figures() -> None:
    found = figures(panel([], []))
    assert (found.whole, found.days, found.compared, found.surveys) == (None, (), (), 0)

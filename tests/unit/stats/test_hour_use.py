from __future__ import annotations

from collections import defaultdict
from dataclasses import replace
from datetime import UTC, datetime, timedelta, tzinfo
from statistics import fmean
from zoneinfo import ZoneInfo

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.lots.values import LotInputError, moment
from hawk.stats.figures import figures
from hawk.stats.hour_use import UNSEEN_PART, AskedUse, Cell, asked_use
from hawk.stats.panel import UNREGISTERED
from hawk.stats.use_query import Asked, asked_of
from hawk.stats.values import FREE, NO_TIME, NOTHING, TAKEN, UNSEEN, WEEKDAYS, LeftOut, Panel, PanelColumn
from tests.unit.stats.panels import at, panel

AMSTERDAM = ZoneInfo("Europe/Amsterdam")
COLUMNS = [("A", "", ("North",)), ("A", "disabled", ("North",)), ("B", "", ("North", "Gate")), ("B", "disabled", ()),
           ("C", "", ()), ("C", "charging", ("Gate",))]  # fmt: skip


def lot(moments: list[float], states: list[list[int]], clock: tzinfo = UTC) -> Panel:
    """Return a panel of six stalls, by their rows, kinds and zones."""
    drawn = panel(moments, states)
    stalls = tuple(
        PanelColumn(f"{k:036d}", f"{row} {k}", row, kind, zones) for k, (row, kind, zones) in enumerate(COLUMNS)
    )
    return replace(drawn, stalls=stalls, clock=clock, clock_name=str(clock))


def cell(found: AskedUse, weekday: str, hour: int) -> Cell:
    (one,) = (each for each in found.cells if (each.weekday, each.hour) == (weekday, hour))
    return one


LOOKS = st.lists(st.lists(st.sampled_from([FREE, TAKEN, UNSEEN]), min_size=6, max_size=6), min_size=1, max_size=20)
PARTS = st.builds(
    Asked,
    weekdays=st.sets(st.sampled_from(WEEKDAYS), min_size=1).map(tuple),
    hours=st.sets(st.integers(0, 23), min_size=1).map(tuple),
    rows=st.lists(st.sampled_from("ABC"), unique=True).map(tuple),
    zones=st.lists(st.sampled_from(["North", "Gate", "no zone"]), unique=True).map(tuple),
    kinds=st.lists(st.sampled_from(["normal", "disabled", "charging"]), unique=True).map(tuple),
)


def is_member(asked: Asked, stall: tuple[str, str, tuple[str, ...]], rows: tuple[str, ...]) -> bool:
    row, kind, zones = stall
    return (
        (not rows or row in rows)
        and (not asked.kinds or (kind or "normal") in asked.kinds)
        and (not asked.zones or bool({*asked.zones} & {*(zones or ("no zone",))}))
    )


@pytest.mark.slow
@given(states=LOOKS, asked=PARTS, data=st.data())
def test_every_figure_is_the_mean_of_surveys_that_a_plain_count_gives(
    states: list[list[int]], asked: Asked, data: st.DataObject
) -> None:
    """One survey a day: an hour of the week is then the mean of its surveys' shares."""
    hours = data.draw(st.lists(st.floats(0, 23.99), min_size=len(states), max_size=len(states)))
    moments = [at(hour, days=day) for day, hour in enumerate(hours)]
    local = [datetime.fromtimestamp(each, UTC) for each in moments]

    def shares(rows: tuple[str, ...]) -> list[float | None]:
        stalls = [k for k, each in enumerate(COLUMNS) if is_member(asked, each, rows)]
        seen = [[look[k] for k in stalls if look[k] != UNSEEN] for look in states]
        return [looks.count(TAKEN) / len(looks) if looks else None for looks in seen]

    if not any(is_member(asked, each, asked.rows) for each in COLUMNS):
        with pytest.raises(LotInputError, match="leaves no stall of the others that are asked"):
            asked_use(lot(moments, states), asked)
        return
    found = asked_use(lot(moments, states), asked)
    of_cell = defaultdict[tuple[str, int], list[float]](list)
    for share, when in zip(shares(asked.rows), local, strict=True):
        if share is not None:
            of_cell[WEEKDAYS[when.weekday()], when.hour].append(share)
    chosen = {key: each for key, each in of_cell.items() if key[0] in asked.weekdays and key[1] in asked.hours}
    every = [share for each in chosen.values() for share in each]
    assert found.occupancy.surveys == found.hours == found.days == len(found.surveys) == len(every)
    assert found.occupancy.value == (pytest.approx(fmean(every), abs=0.01) if every else None)
    assert len(found.cells) == 7 * 24
    for each in found.cells:
        there = of_cell[each.weekday, each.hour]
        assert each.is_asked == (each.weekday in asked.weekdays and each.hour in asked.hours)
        assert (each.days, each.occupancy.surveys) == (len(there), len(there))
        assert each.occupancy == NOTHING if not there else each.occupancy.value == pytest.approx(fmean(there), abs=0.01)
    flown = [each for each in found.cells if each.is_asked and each.days]
    assert (found.fullest is None) == (found.emptiest is None) == (not flown)
    if found.fullest is not None and found.emptiest is not None:
        values = [each.occupancy.value for each in flown]
        assert (found.fullest.occupancy.value, found.emptiest.occupancy.value) == (max(values), min(values))  # type: ignore[type-var]
    left = {row for row, *_ in COLUMNS} - {*asked.rows} if asked.rows else set()
    assert [each.row for each in found.others] == sorted(
        row for row in left if any(is_member(asked, each, (row,)) for each in COLUMNS)
    )
    for other in found.others:
        there = [
            share for share, when in zip(shares((other.row,)), local, strict=True)
            if share is not None and WEEKDAYS[when.weekday()] in asked.weekdays and when.hour in asked.hours
        ]  # fmt: skip
        assert other.occupancy.surveys == len(there)
        assert other.occupancy.value == (pytest.approx(fmean(there), abs=0.01) if there else None)


@pytest.mark.nightly
@given(states=LOOKS, data=st.data())
def test_all_of_a_lot_and_a_row_have_the_figures_that_statistics_give(
    states: list[list[int]], data: st.DataObject
) -> None:
    hours = data.draw(st.lists(st.floats(0, 100), min_size=len(states), max_size=len(states), unique=True))
    drawn = lot([at(hour) for hour in sorted(hours)], states)
    whole = figures(drawn, "row")
    assert whole.whole is not None
    found = asked_use(drawn, Asked())
    assert (found.occupancy, found.hours) == (whole.whole.occupancy, whole.whole.hours)
    assert found.accumulation == whole.whole.accumulation
    for part in whole.parts:
        row = asked_use(drawn, Asked(rows=(part.name,)))
        assert (row.occupancy, row.accumulation, row.stalls) == (part.occupancy, part.accumulation, part.capacity)
        assert {each.row: each.occupancy for each in row.others} == {
            each.name: each.occupancy for each in whole.parts if each.name != part.name
        }
    for each in found.cells:
        ends = each.occupancy
        if ends.value is not None and ends.low is not None and ends.high is not None:
            assert 0 <= ends.low <= ends.value <= ends.high <= 1


def test_an_hour_is_the_lot_s_across_daylight_saving_in_both_directions() -> None:
    """07:30 UTC is 8:30 in Amsterdam in winter and 9:30 in summer; the clock shows 2 to 3 twice in October."""
    days = [datetime(2026, 3, 28, 7, 30, tzinfo=UTC) + timedelta(days=n) for n in range(3)]
    found = asked_use(lot([day.timestamp() for day in days], [[TAKEN] * 6] * 3, AMSTERDAM), asked_of(hour="9"))
    assert [(each.weekday, each.hour) for each in found.cells if each.days] == [
        ("Monday", 9), ("Saturday", 8), ("Sunday", 9),
    ]  # fmt: skip
    assert found.occupancy.surveys == 2
    assert [each.at for each in found.surveys] == ["2026-03-29T09:30+02:00", "2026-03-30T09:30+02:00"]
    twice = [datetime(2026, 10, 25, hour, 30, tzinfo=UTC).timestamp() for hour in (0, 1)]
    night = asked_use(lot(twice, [[TAKEN] * 6, [FREE] * 6], AMSTERDAM), asked_of("sun", "2"))
    one = cell(night, "Sunday", 2)
    assert (one.days, one.occupancy.surveys, night.hours, night.days) == (1, 2, 2, 1)
    assert one.occupancy.value == pytest.approx(0.5, abs=0.02)


def test_a_survey_on_a_late_evening_is_of_the_lot_s_weekday() -> None:
    late = datetime(2026, 5, 4, 22, 30, tzinfo=UTC).timestamp()  # half past midnight on Tuesday
    found = asked_use(lot([late], [[TAKEN] * 6], AMSTERDAM), asked_of("tue", "0"))
    assert (found.occupancy.surveys, cell(found, "Monday", 22).occupancy) == (1, NOTHING)


def test_a_cell_says_the_same_whatever_else_is_asked() -> None:
    drawn = lot([at(8), at(10.5), at(15)], [[TAKEN] * 6, [FREE, TAKEN] * 3, [FREE] * 6])
    alone, beside = (asked_use(drawn, asked_of(hour=hours)) for hours in ("8", "0-24"))
    assert cell(alone, "Monday", 8) == cell(beside, "Monday", 8)
    assert cell(alone, "Monday", 10) == replace(cell(beside, "Monday", 10), is_asked=False)


def test_surveys_that_are_left_out_are_named_with_the_reason_where_their_hour_is_asked() -> None:
    drawn = lot([at(8), at(9)], [[TAKEN] * 6, [TAKEN] * 2 + [UNSEEN] * 4])
    left_out = tuple(
        LeftOut(f"{k:036d}", moment(at(hour)), why)
        for k, (hour, why) in enumerate([(8.0, UNREGISTERED), (15.0, UNREGISTERED), (15.0, NO_TIME)], 7)
    )
    found = asked_use(replace(drawn, left_out=left_out), asked_of("mon", "7-11", rows=["B"]))
    assert [(int(each.survey), each.why) for each in found.left_out] == [
        (7, UNREGISTERED), (9, NO_TIME), (1, UNSEEN_PART),
    ]  # fmt: skip
    assert [int(each.survey) for each in found.surveys] == [0]


def test_a_lot_that_nobody_flew_has_an_answer_of_nulls() -> None:
    empty = Panel(
        "lot", "Lot 1", UTC, "UTC", lot([at(8)], [[FREE] * 6]).stalls, (), (), np.zeros((0, 6), np.float32),
        np.zeros((0, 6), np.int8), np.zeros((0, 6), np.bool_),
    )  # fmt: skip
    found = asked_use(empty, asked_of(rows=["B"]))
    assert (found.occupancy, found.accumulation, found.fullest, found.surveys, found.stalls) == (
        NOTHING, NOTHING, None, (), 2,
    )  # fmt: skip
    assert {each.occupancy for each in found.cells} == {NOTHING}


@pytest.mark.parametrize(
    ("asked", "field", "words"),
    [
        (Asked(rows=("Q",)), "row", "the lot has none that is called 'Q'; there is A, B, C"),
        (Asked(zones=("South",)), "zone", "the lot has none that is called 'South'; there is"),
        (Asked(kinds=("taxi",)), "kind", "there is normal, charging, disabled"),
        (Asked(rows=("A",), kinds=("charging",)), "kind", "leave one of them out"),
    ],
)
def test_a_part_that_the_lot_has_not_is_refused_with_those_that_there_are(
    asked: Asked, field: str, words: str
) -> None:  # fmt: skip
    with pytest.raises(LotInputError) as refused:
        asked_use(lot([at(8)], [[FREE] * 6]), asked)
    assert refused.value.field == field
    assert words in refused.value.reason


def test_only_the_newest_layout_counts_as_stalls_and_rows_without_the_kind_are_no_others() -> None:
    drawn = lot([at(8), at(32)], [[TAKEN] * 6] * 2)
    there = np.ones((2, 6), np.bool_)
    there[1, 2] = False
    found = asked_use(replace(drawn, is_there=there), Asked(rows=("B",), kinds=("normal", "disabled")))
    assert (found.stalls, [(each.row, each.stalls) for each in found.others]) == (1, [("A", 2), ("C", 1)])

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.lots.values import LotInputError
from hawk.stats.use_query import SHORT, Asked, asked_of
from hawk.stats.values import WEEKDAYS


def days_of(text: str) -> list[str]:
    return [day[:3].lower() for day in asked_of(weekday=text).weekdays]


@pytest.mark.parametrize(
    ("text", "days"),
    [
        ("mon-fri", "mon tue wed thu fri"),
        ("sat", "sat"),
        (" Wed , MON ", "mon wed"),
        ("sat-mon", "mon sat sun"),
        ("mon-mon", "mon"),
        ("mon-wed,tue-thu,sun", "mon tue wed thu sun"),
    ],
)
def test_days_are_ranges_and_lists(text: str, days: str) -> None:
    assert days_of(text) == days.split()


@pytest.mark.parametrize(
    ("text", "hours"),
    [
        ("7-11", [7, 8, 9, 10]), ("8", [8]), ("0-24", [*range(24)]), ("16-18, 7-8", [7, 16, 17]),
        ("22-24,0-2", [0, 1, 22, 23]),
    ],
)  # fmt: skip
def test_hours_are_ranges_whose_end_is_not_asked(text: str, hours: list[int]) -> None:
    assert asked_of(hour=text).hours == tuple(hours)


@given(chosen=st.sets(st.integers(0, 23), min_size=1), days=st.sets(st.integers(0, 6), min_size=1))
def test_any_hours_and_days_can_be_asked_one_by_one(chosen: set[int], days: set[int]) -> None:
    found = asked_of(",".join(SHORT[day] for day in days), ",".join(map(str, chosen)))
    assert found.hours == tuple(sorted(chosen))
    assert found.weekdays == tuple(WEEKDAYS[day] for day in sorted(days))


def test_nothing_named_asks_for_all_and_a_part_counts_once() -> None:
    assert asked_of() == Asked(WEEKDAYS, tuple(range(24)), (), (), ())
    assert asked_of(rows=("B", "C", "B")).rows == ("B", "C")


@pytest.mark.parametrize(
    ("asked", "field", "words"),
    [
        ({"weekday": "weekdays"}, "weekday", "must be days out of mon, tue, wed, thu, fri, sat, sun, as mon-fri"),
        ({"weekday": "mon-"}, "weekday", "must be days out of"),
        ({"weekday": ""}, "weekday", "must be days out of"),
        ({"weekday": "mon;tue"}, "weekday", "must be days out of"),
        ({"hour": "25"}, "hour", "must be hours from 0 to 24, as 7-11, 8 or 7-9,16-18"),
        ({"hour": "24"}, "hour", "the end is after the begin"),
        ({"hour": "7-7:30"}, "hour", "must be hours from 0 to 24"),
        ({"hour": "11-7"}, "hour", "the end is after the begin; write 11-24,0-7 for a night"),
        ({"hour": "8-8"}, "hour", "the end is after the begin"),
        ({"hour": "-3"}, "hour", "must be hours"),
        ({"hour": "٧"}, "hour", "must be hours"),
        ({"hour": ""}, "hour", "must be hours"),
    ],
)
def test_what_is_no_question_is_refused_with_field_and_remedy(asked: dict[str, Any], field: str, words: str) -> None:
    with pytest.raises(LotInputError) as refused:
        asked_of(**asked)
    assert refused.value.field == field
    assert words in refused.value.reason
    assert ("for a night" in refused.value.reason) is ("night" in words)

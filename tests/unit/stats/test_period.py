from __future__ import annotations

from datetime import UTC, datetime
from zoneinfo import ZoneInfo

import pytest

from hawk.lots.values import LotInputError
from hawk.stats.period import period_of


def test_a_date_begins_at_midnight_of_the_lot_s_clock_and_an_end_has_its_whole_day() -> None:
    found = period_of("2026-03-28", "2026-03-29", "Europe/Amsterdam")
    zone = ZoneInfo("Europe/Amsterdam")
    assert found.begin == datetime(2026, 3, 28, tzinfo=zone).timestamp()
    assert found.end == datetime(2026, 3, 30, tzinfo=zone).timestamp()
    assert found.end - found.begin == 47 * 3600  # the clock goes forward
    assert found.clock_name == "Europe/Amsterdam"


def test_a_time_is_on_the_lot_s_clock_unless_it_says_its_offset() -> None:
    here = period_of("2026-05-04T10:30", None, "Europe/Amsterdam")
    there = period_of("2026-05-04T08:30+00:00", None, "Europe/Amsterdam")
    assert here.begin == there.begin == datetime(2026, 5, 4, 8, 30, tzinfo=UTC).timestamp()
    assert here.end is None


def test_utc_has_one_name_whichever_of_the_database_is_given() -> None:
    assert {period_of(None, None, each).clock_name for each in ("UTC", "Etc/UTC", "Zulu")} == {"UTC"}


@pytest.mark.parametrize(
    ("begin", "end", "zone", "field"),
    [
        ("soon", None, "UTC", "from"),
        (None, "9999-12-31", "UTC", "to"),
        ("2026-05-04", "2026-05-03", "UTC", "to"),
        (None, None, "../etc/passwd", "time_zone"),
    ],
)
def test_what_is_no_period_is_refused_with_its_field(
    begin: str | None, end: str | None, zone: str, field: str
) -> None:  # fmt: skip
    with pytest.raises(LotInputError) as refused:
        period_of(begin, end, zone)
    assert refused.value.field == field

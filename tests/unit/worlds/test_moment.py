from __future__ import annotations

from datetime import UTC, datetime, timedelta

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.worlds.moment import EARLIEST, LATEST, clock_of, read_moment


@pytest.mark.parametrize(
    ("longitude", "hours"), [(0.0, 0), (-79.9192, -5), (5.2, 0), (8.0, 1), (180.0, 12), (-180.0, -12)]
)
def test_the_clock_of_a_place_is_an_hour_for_fifteen_degrees(longitude: float, hours: int) -> None:
    assert clock_of(longitude).utcoffset(None) == timedelta(hours=hours)


def test_without_an_offset_a_moment_is_on_the_lots_clock() -> None:
    assert read_moment("2026-05-04T10:30", -79.9) == datetime(2026, 5, 4, 15, 30, tzinfo=UTC)


@pytest.mark.parametrize(
    "text", ["2026-05-04T10:30+02:00", "2026-05-04T10:30 02:00", "2026-05-04T08:30Z", "2026-05-04 08:30:00.9+00:00"]
)
def test_the_same_moment_is_the_same_whatever_clock_names_it(text: str) -> None:
    moment = read_moment(text, -79.9)
    assert moment == datetime(2026, 5, 4, 8, 30, tzinfo=UTC)
    assert moment.isoformat() == "2026-05-04T03:30:00-05:00"


@pytest.mark.parametrize("text", ["", "now", "2026-05-04", "10:30", "2026-02-30T10:30", "2026-05-04T25:00"])
def test_what_is_no_moment_is_refused_with_an_example(text: str) -> None:
    with pytest.raises(ValueError, match="2026-05-04T10:30"):
        read_moment(text)


@pytest.mark.parametrize("text", ["2024-12-31T10:30", "2095-01-01T10:30", "9999-12-31T23:59", "0001-01-01T00:00+14:00"])
def test_a_moment_that_no_daemon_believes_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match="must"):
        read_moment(text, 179.0)


@given(st.datetimes(EARLIEST.replace(tzinfo=None), LATEST.replace(tzinfo=None)), st.floats(-180, 180))
def test_a_moment_survives_its_text(moment: datetime, longitude: float) -> None:
    whole = moment.replace(microsecond=0, tzinfo=UTC)
    assert read_moment(read_moment(whole.isoformat(), longitude).isoformat(), longitude) == whole

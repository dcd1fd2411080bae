"""The sun's position against published values, and the shadow that follows from it."""

from __future__ import annotations

import math
from datetime import UTC, datetime, timedelta, timezone

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.model.sun import SunPosition, sun_position


def _naive(year: int) -> datetime:
    return datetime(year, 5, 4, 10, 30, tzinfo=UTC).replace(tzinfo=None)


MOMENTS = st.datetimes(_naive(2000), _naive(2090), timezones=st.just(UTC))


def test_the_position_is_that_of_the_reference_algorithm_s_own_example() -> None:
    # Reda and Andreas, NREL/TP-560-34302 (2008), table A5: zenith 50.11162 (with air), azimuth 194.34024 degrees
    at = datetime(2003, 10, 17, 12, 30, 30, tzinfo=timezone(timedelta(hours=-7)))
    sun = sun_position(at, 39.742476, -105.1786)
    assert sun.azimuth == pytest.approx(194.340, abs=0.02)
    assert sun.elevation == pytest.approx(90 - 50.111 - 0.016, abs=0.02)


@pytest.mark.parametrize(
    ("at", "elevation"),
    [(datetime(2026, 6, 21, 11, 42, tzinfo=UTC), 61.44), (datetime(2026, 12, 21, 11, 38, tzinfo=UTC), 14.56)],
)
def test_at_noon_of_a_solstice_it_stands_in_the_south_at_ninety_less_the_latitude_and_the_tilt(
    at: datetime, elevation: float
) -> None:
    sun = sun_position(at, 52.0, 5.0)
    assert sun.azimuth == pytest.approx(180.0, abs=1.0)
    assert sun.elevation == pytest.approx(elevation, abs=0.05)


@given(MOMENTS, st.floats(-66, 66), st.floats(-180, 180), st.floats(-12, 12))
def test_a_zone_changes_nothing(at: datetime, latitude: float, longitude: float, hours: float) -> None:
    elsewhere = at.astimezone(timezone(timedelta(minutes=round(hours * 60))))
    here, there = (sun_position(moment, latitude, longitude) for moment in (at, elsewhere))
    assert there.elevation == pytest.approx(here.elevation, abs=1e-6)


@given(st.floats(0, 360), st.floats(1, 89))
def test_a_shadow_points_away_from_the_sun_and_is_as_long_as_its_height_says(azimuth: float, elevation: float) -> None:
    north, east = SunPosition(azimuth, elevation).shadow() or (0.0, 0.0)
    assert math.hypot(north, east) == pytest.approx(1 / math.tan(math.radians(elevation)))
    toward = math.radians(azimuth)
    assert north * math.cos(toward) + east * math.sin(toward) < 0
    assert north * math.sin(toward) - east * math.cos(toward) == pytest.approx(0, abs=1e-6)


def test_a_sun_below_the_horizon_casts_no_shadow() -> None:
    night = sun_position(datetime(2026, 6, 21, 0, 0, tzinfo=UTC), 52.0, 5.0)
    assert not night.is_up
    assert night.shadow() is None


def test_a_moment_without_a_zone_is_refused_with_the_remedy() -> None:
    with pytest.raises(ValueError, match="has no time zone: name one"):
        sun_position(_naive(2026), 52.0, 5.0)


@pytest.mark.parametrize(("latitude", "longitude"), [(91.0, 0.0), (0.0, 181.0), (math.nan, 0.0)])
def test_a_place_that_is_not_on_earth_is_refused(latitude: float, longitude: float) -> None:
    with pytest.raises(ValueError, match="not degrees of a place on Earth"):
        sun_position(datetime(2026, 5, 4, 10, 30, tzinfo=UTC), latitude, longitude)

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.picture.photographs.places import unwrap_longitudes, wrap_longitudes


def test_longitudes_on_both_sides_of_the_180th_meridian_lie_side_by_side() -> None:
    assert unwrap_longitudes(np.array([179.99, -179.99, 180.0, -180.0])).tolist() == [179.99, 180.01, 180.0, 180.0]
    assert unwrap_longitudes(np.array([-179.99, 179.99])) == pytest.approx([-179.99, -180.01])
    assert wrap_longitudes(np.array([180.01, -180.01, 180.0, -180.0, 8.0])) == pytest.approx(
        [-179.99, 179.99, 180.0, -180.0, 8.0]
    )


@given(st.floats(-180.0, 180.0), st.lists(st.floats(-0.1, 0.1), min_size=1, max_size=5))
def test_a_flight_keeps_its_longitudes(first: float, steps: list[float]) -> None:
    flown = wrap_longitudes(first + np.array([0.0, *steps]))
    straight = unwrap_longitudes(flown)
    assert np.abs(straight - straight[0]).max() <= 0.1 + 1e-9
    apart = wrap_longitudes(straight) - flown
    assert np.abs(apart - 360.0 * np.rint(apart / 360.0)).max() < 1e-9


def test_those_that_do_not_cross_it_stay_to_the_last_digit() -> None:
    flown = np.array([8.123456789, 8.123456788, np.nan])
    assert unwrap_longitudes(flown).tobytes() == wrap_longitudes(flown).tobytes() == flown.tobytes()

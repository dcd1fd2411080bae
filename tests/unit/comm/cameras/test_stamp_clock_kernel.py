from __future__ import annotations

import time

import pytest

from hawk.comm.cameras.stamp_clock import captured_at
from tests.manual_clock import ManualClock

NOW = {time.CLOCK_MONOTONIC: 1000.0, time.CLOCK_BOOTTIME: 4600.0, time.CLOCK_REALTIME: 1.7e9}


@pytest.mark.parametrize(
    ("stamp", "captured"),
    [
        (999.95, 49.95),  # CLOCK_MONOTONIC
        (4599.9, 49.9),  # CLOCK_BOOTTIME of a computer that slept for an hour
        (1.7e9 - 0.25, 49.75),  # CLOCK_REALTIME
        (1000.004, 50.0),  # rounded ahead of the reading
        (1000.1, None),  # in the future
        (990.0, None),  # of another stream
    ],
)
def test_a_stamp_is_mapped_by_the_clock_in_which_it_is_a_moment_old(stamp: float, captured: float | None) -> None:
    found = captured_at(stamp, ManualClock(50.0), NOW.__getitem__)
    assert found == (None if captured is None else pytest.approx(captured, abs=1e-6))

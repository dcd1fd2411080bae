"""The slope from the drone's tilt at rest: what the check before Arm says, and when it says nothing."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.ddc.fence.geometry import circle, polygon_fence
from hawk.ddc.readings.clearance import Slope, SlopeReading, slope_of, slope_words
from hawk.model.pictures import rotation
from hawk.model.poses import MapPoint
from tests.unit.ddc.fakes import Rig
from tests.unit.ddc.written_facts import pose

HOME = MapPoint(0.0, 0.0)
FENCE = polygon_fence(circle(HOME, 155.0), 5.0, 100.0, 3.0)
"""Our own limit is 150 m away."""


@given(st.floats(-0.3, 0.3), st.floats(-0.3, 0.3), st.floats(-math.pi, math.pi))
def test_the_drone_stands_parallel_to_the_slope(roll: float, pitch: float, yaw: float) -> None:
    slope = slope_of(roll, pitch, yaw)
    turn = rotation(roll, pitch, yaw)
    for path in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)):  # ahead and to the right, along the ground
        north, east, down = turn @ np.array(path)
        assert slope.rise(HOME, MapPoint(north, east)) == pytest.approx(-down, abs=1e-9)


@pytest.mark.parametrize(
    ("roll", "pitch", "yaw", "words"),
    [(0.0, 0.06, 0.0, "north"), (0.0, 0.06, math.pi / 2, "east"), (0.06, 0.0, 0.0, "west"), (0.0, -0.06, 0.0, "south")],
)
def test_the_direction_is_that_of_the_rise(roll: float, pitch: float, yaw: float, words: str) -> None:
    text = slope_words(slope_of(roll, pitch, yaw), FENCE, HOME, 15.0, None)
    assert text.startswith(f"stands on a slope of 6 % up to the {words}: the ground may be 9 m higher 150 m away, ")


@pytest.mark.parametrize(
    ("minimum", "obstacle", "words"),
    [
        (15.0, None, "Min 15 m clears it by 6 m"),
        (12.0, None, "Min 12 m clears it by 3 m; raise it to 14 m"),
        (8.0, None, "Min 8 m does not clear it; raise it to 14 m"),
        (30.0, 9.0, "Min 30 m clears an obstacle of 9 m there by 12 m"),
        (15.0, 9.0, "Min 15 m does not clear an obstacle of 9 m there; raise it to 23 m"),
    ],
)
def test_what_the_slope_leaves_of_min(minimum: float, obstacle: float | None, words: str) -> None:
    assert slope_words(Slope(0.06, 0.0), FENCE, HOME, minimum, obstacle).endswith(words)


def test_min_that_clears_an_obstacle_by_the_margin_is_high_enough() -> None:
    square = replace(FENCE, polygon=((144.0, 144.0), (144.0, -144.0), (-144.0, -144.0), (-144.0, 144.0)))
    assert slope_words(Slope(0.0625, 0.0), square, HOME, 14.0, None).endswith("Min 14 m clears it by 5 m")
    assert slope_words(Slope(0.0625, 0.0), square, HOME, 13.9, None).endswith("raise it to 14 m")


def test_the_rise_is_that_between_two_places() -> None:
    assert Slope(0.5, 0.25).rise(MapPoint(10.0, 4.0), MapPoint(12.0, 12.0)) == 3.0
    assert slope_words(Slope(0.52, 0.0), FENCE, HOME, 90.0, None).startswith("stands on a slope of 52 % ")


def test_where_the_ground_falls_on_all_sides_nothing_is_higher() -> None:
    beyond = MapPoint(151.0, 0.0)
    assert slope_words(Slope(0.06, 0.0), FENCE, beyond, 15.0, None) == "stands on a slope of 6 % up to the north"


def watched(angles: list[float], start: float = 7.0, step: float = 0.1) -> Slope | None:
    reading = SlopeReading()
    for index, pitch in enumerate(angles):
        reading.update(replace(pose(start + index * step), pitch=pitch))
    return reading.slope()


def test_a_carried_drone_is_at_rest_once_the_last_second_was() -> None:
    assert watched([0.3] + [0.06] * 8, step=0.125) is None
    assert watched([0.3] + [0.06] * 9, step=0.125) is not None


def test_five_poses_at_least() -> None:
    assert watched([0.06] * 4, step=0.34) is None
    assert watched([0.06] * 5, step=0.25) is not None
    reading = SlopeReading()
    for _ in range(3):
        for time in (1.0, 1.5, 2.0):
            reading.update(replace(pose(time), pitch=0.06))
    assert reading.slope() is None, "the same poses again"


def test_roll_counts_as_pitch_does_and_the_last_heading() -> None:
    reading = SlopeReading()
    for index in range(12):
        turned = 0.0 if index < 11 else math.pi / 2
        reading.update(replace(pose(1.0 + index * 0.1), roll=0.055 + 0.01 * (index % 2), pitch=0.1, yaw=turned))
    found, expected = reading.slope(), slope_of(0.06, 0.1, math.pi / 2)
    assert found is not None
    assert (found.north, found.east) == pytest.approx((expected.north, expected.east), abs=1e-3)
    for index in range(20):
        reading.update(replace(pose(3.0 + index * 0.1), roll=0.1 * (index % 2)))
    assert reading.slope() is None, "it rolls"


def test_it_is_the_mean_of_a_second_at_rest() -> None:
    assert watched([0.06] * 10) is None, "less than a second"
    found = watched([0.055, 0.065] * 6)
    assert found is not None
    assert found.north == pytest.approx(0.06, abs=0.001)


def test_the_limits_of_rest_and_of_landing_gear() -> None:
    shaken = math.radians(0.9)
    assert watched([0.06, 0.06 + shaken] * 8) is not None
    assert watched([0.06, 0.06 + shaken + math.radians(0.2)] * 8) is None
    assert Slope(0.0, math.tan(math.radians(3.0))).is_notable
    assert not Slope(0.0, math.tan(math.radians(2.99))).is_notable


def test_a_drone_that_is_carried_stands_on_no_slope() -> None:
    assert watched([0.0, 0.1] * 10) is None
    assert watched([0.0, 0.3] * 5 + [0.06] * 15) is not None


def test_the_same_pose_again_and_a_reset() -> None:
    reading = SlopeReading()
    for _ in range(50):
        reading.update(pose(1.0))
    assert reading.slope() is None
    for index in range(20):
        reading.update(pose(2.0 + index * 0.1))
    assert reading.slope() is not None
    reading.reset()
    assert reading.slope() is None


async def test_the_check_is_there_on_a_slope_alone_and_never_refuses(rig: Rig) -> None:
    assert "Slope" not in [item.name for item in rig.manager.situation().checks]
    rig.autopilot.tilt = (0.0, math.radians(2.9))
    await rig.run(1.5)
    assert "Slope" not in [item.name for item in rig.manager.situation().checks], "landing gear"
    rig.autopilot.tilt = (0.0, math.radians(10.0))
    await rig.run(1.5)
    item = next(item for item in rig.manager.situation().checks if item.name == "Slope")
    assert item.passed
    assert "slope of 18 % up to the north" in item.value
    assert "raise it to" in item.value
    assert all(item.passed for item in rig.manager.situation().checks)


async def test_in_flight_the_tilt_is_no_slope(flying: Rig) -> None:
    flying.autopilot.tilt = (0.0, 0.2)
    await flying.run(2.0)
    assert flying.manager.situation().facts.position.below.slope is None

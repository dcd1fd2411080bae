"""The wind from the lean: found over a flight in several directions, from any wind and any airframe of the prior."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.ddc.readings.wind import BODY_DRAG, GRAVITY, LEAST_S, ROTOR_DRAG, Wind, WindEstimator, ground_speed
from hawk.model.poses import VehiclePose
from tests.unit.ddc.written_facts import pose

STEP_S = 0.2
EAST = math.pi / 2


def flown(wind: Wind, seconds: float, *, square: bool = True, noise: float = 0.0, yaw: float = 0.0) -> WindEstimator:
    """Fly a square at 4 m/s, or hold, and let the estimator see poses whose lean balances the air."""
    estimator, rng = WindEstimator(), np.random.default_rng(1)
    for index in range(round(seconds / STEP_S)):
        now = index * STEP_S
        leg = int(now / 10) % 4
        velocity = ((4.0, 0.0), (0.0, 4.0), (-4.0, 0.0), (0.0, -4.0))[leg] if square else (0.0, 0.0)
        through = (wind.north - velocity[0], wind.east - velocity[1])
        factor = wind.rotor_drag + wind.body_drag * math.hypot(*through)
        north, east = (-factor * each for each in through)
        north, east = north + noise * rng.normal(), east + noise * rng.normal()
        estimator.update(leaning(now, velocity, north, east, yaw))
    return estimator


def leaning(now: float, velocity: tuple[float, float], north: float, east: float, yaw: float) -> VehiclePose:
    """Return the pose whose thrust accelerates so, m/s², in level flight."""
    forward = north * math.cos(yaw) + east * math.sin(yaw)
    right = -north * math.sin(yaw) + east * math.cos(yaw)
    pitch = -math.atan2(forward, GRAVITY)
    roll = math.atan2(right * math.cos(pitch), GRAVITY)
    return replace(pose(now), velocity=(*velocity, 0.0), roll=roll, pitch=pitch, yaw=yaw)


@pytest.mark.nightly
@settings(max_examples=25)
@given(
    st.floats(0, 12),
    st.floats(0, 2 * math.pi),
    st.sampled_from([(0.15, 0.0), (0.0, 0.03), (0.15, 0.015), (0.2, 0.02)]),
    st.floats(-math.pi, math.pi),
)
def test_the_wind_is_found_by_flying_in_several_directions(
    speed: float, towards: float, drag: tuple[float, float], yaw: float
) -> None:
    wind = Wind(speed * math.cos(towards), speed * math.sin(towards), *drag)
    found = flown(wind, 60, noise=0.1, yaw=yaw).estimate()
    assert found is not None
    assert math.hypot(found.north - wind.north, found.east - wind.east) < 0.5 + 0.12 * speed


def test_while_it_holds_the_usual_drag_is_taken() -> None:
    found = flown(Wind(6.0, 0.0), 20, square=False).estimate()
    assert found is not None
    assert (found.north, found.east) == pytest.approx((6.0, 0.0), abs=0.05)
    assert (found.rotor_drag, found.body_drag) == pytest.approx((ROTOR_DRAG, BODY_DRAG), abs=0.01)


def test_there_is_no_estimate_before_enough_was_seen_and_none_after_a_reset() -> None:
    assert flown(Wind(6.0, 0.0), LEAST_S - 1).estimate() is None
    estimator = flown(Wind(6.0, 0.0), LEAST_S + 1)
    assert estimator.estimate() is not None
    estimator.reset()
    assert estimator.estimate() is None


def test_a_drone_that_moves_without_leaning_shows_no_wind() -> None:
    estimator = WindEstimator()
    for index in range(200):
        forth = 0.7 * abs(index % 10 - 5)  # 3.5 m/s² to and fro
        estimator.update(leaning(index * STEP_S, (forth, 0.0), 0.0, 0.0, 0.0))
    assert estimator.estimate() is None


def test_old_wind_is_forgotten() -> None:
    estimator = flown(Wind(6.0, 0.0), 120)
    for index in range(round(150 / STEP_S)):
        estimator.update(leaning(120 + index * STEP_S, (0.0, 0.0), 0.0, 0.0, 0.0))
    found = estimator.estimate()
    assert found is not None
    assert found.speed < 0.5


def test_climbs_and_steep_leans_say_nothing() -> None:
    estimator = WindEstimator()
    for index in range(200):
        steep = leaning(index * STEP_S, (0.0, 0.0), 6.0, 0.0, 0.0)
        climbing = replace(leaning(100 + index * STEP_S, (0.0, 0.0), 2.0, 0.0, 0.0), velocity=(0.0, 0.0, -2.0))
        estimator.update(steep if index < 100 else climbing)
    assert estimator.estimate() is None


def test_the_direction_of_the_wind_is_reported() -> None:
    assert Wind(-5.0, 0.0).from_direction == pytest.approx(0.0)
    assert Wind(0.0, 5.0).from_direction == pytest.approx(1.5 * math.pi), "it blows to the east"
    assert Wind(3.0, 4.0).speed == 5.0


def test_against_the_wind_the_drone_is_slower_and_never_faster_than_commanded() -> None:
    assert ground_speed(4.0, 0.0, None) == 4.0
    assert ground_speed(4.0, 0.0, Wind(30.0, 0.0)) == 4.0, "tailwind"
    air = Wind(0.0, 0.0).airspeed(math.radians(25.0))
    assert ground_speed(4.0, 0.0, Wind(2.0 - air, 0.0)) == pytest.approx(2.0)
    assert ground_speed(4.0, 0.0, Wind(-40.0, 0.0)) == 0.0
    assert ground_speed(4.0, EAST, Wind(40.0, 0.0)) == 0.0, "crosswind"


@given(st.floats(0.02, 0.4), st.floats(0.0, 0.05), st.floats(0.01, 0.6))
def test_a_lean_holds_the_airspeed_whose_drag_balances_it(rotor: float, body: float, lean: float) -> None:
    speed = Wind(0.0, 0.0, rotor, body).airspeed(lean)
    assert (rotor + body * speed) * speed == pytest.approx(GRAVITY * math.tan(lean), rel=1e-3)

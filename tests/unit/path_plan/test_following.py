from __future__ import annotations

import math

import numpy as np
import pytest
import shapely

from benchmarks.kinematic_drone import STEP_S as TICK_S
from benchmarks.kinematic_drone import Drone
from hawk.algo.path_plan.following import STEP_S, Flights, Motion, fly
from hawk.algo.path_plan.footprint import Floats
from hawk.algo.path_plan.settings import PathPlanSettings
from hawk.config import FlightSettings
from hawk.ddc.motion import Goal, carrot_lead
from hawk.model import Fence, MapPose

SETTINGS = PathPlanSettings()
WIDE = Fence(((-900.0, -900.0), (-900.0, 900.0), (900.0, 900.0), (900.0, -900.0)), (), 97.0, 100.0)
NOWHERE = np.zeros(2)


def hovering(yaw: float = 0.0) -> Motion:
    return Motion(NOWHERE, NOWHERE, NOWHERE, NOWHERE, yaw, NOWHERE)


def flown(*tours: list[tuple[float, float]], motion: Motion | None = None, steps: int = 400) -> Flights:
    sizes = np.array([len(tour) for tour in tours])
    padded = np.zeros((len(tours), sizes.max(), 2))
    for row, tour in zip(padded, tours, strict=True):
        row[: len(tour)] = tour
    return fly(motion or hovering(), padded, sizes, SETTINGS, steps)


def simulated(tour: Floats) -> tuple[Floats, Floats, float]:
    """Fly way points as the daemon does: places and yaws at each frame, and the way until the last one is reached."""
    drone = Drone(MapPose(0.0, 0.0, 35.0, 0.0, 0.0, 0.0), WIDE, np.random.default_rng(0), 0.0)
    goal, waiting, left, places, yaws = None, None, list(tour), [], []
    for tick in range(4000):
        if tick % round(STEP_S / TICK_S) == 0:
            goal, at = waiting, drone.true
            places.append((at.north, at.east))
            yaws.append(at.yaw)
            while left and math.dist(left[0], places[-1]) <= SETTINGS.arrival_m:
                left = left[1:]
            if not left:
                return np.array(places), np.array(yaws), drone.way
            off = left[0] - places[-1]
            waiting = Goal(float(left[0][0]), float(left[0][1]), 35.0, math.atan2(off[1], off[0]))
        drone.step(goal)
    raise AssertionError("the drone did not arrive")


@pytest.mark.parametrize("seed", range(6))
def test_a_flight_in_the_mind_is_what_the_simulated_drone_flies(seed: int) -> None:
    rng = np.random.default_rng(seed)
    tour = np.cumsum(rng.uniform(-25, 25, (4, 2)), axis=0)
    places, _, way = simulated(tour)
    flights = flown([(n, e) for n, e in tour.tolist()])
    assert flights.ways[0] == pytest.approx(way, rel=0.03)
    path = shapely.LineString(places)
    aside = [path.distance(shapely.Point(place)) for place in flights.places[:, 0].tolist()]
    assert max(aside) < 1.5
    assert len(flights.places) == pytest.approx(len(places), rel=0.15, abs=4)


def test_many_tours_are_flown_as_each_alone() -> None:
    tours = [[(30.0, 0.0), (30.0, 20.0)], [(0.0, -12.0)], [(20.0, 20.0), (0.0, 30.0), (-10.0, 5.0)]]
    together = flown(*tours)
    for number, tour in enumerate(tours):
        alone = flown(tour)
        assert together.ways[number] == pytest.approx(alone.ways[0])
        assert np.allclose(together.places[together.flies[:, number], number], alone.places[alone.flies[:, 0], 0])


def test_what_no_step_reached_counts_as_way_all_the_same() -> None:
    tour = [(60.0, 0.0), (60.0, 50.0)]
    assert flown(tour, steps=10).ways[0] == pytest.approx(110.0, abs=1.0)
    assert not flown(tour, steps=10).flies[:, 0].sum() > 10


def test_it_leans_ahead_as_it_speeds_up_and_back_as_it_brakes() -> None:
    leans = flown([(50.0, 0.0)]).leans[:, 0, 0]
    assert leans.max() <= SETTINGS.acceleration_m_s2 + 0.15 * SETTINGS.speed_m_s + 1e-9
    assert leans[:12].max() > 2.0
    assert leans[-8:].min() < -0.5


def test_the_picture_turns_to_the_way_no_faster_than_the_autopilot_turns() -> None:
    yaws = flown([(0.0, 40.0)]).yaws[:, 0]
    assert np.diff(yaws).max() <= math.radians(60) * STEP_S + 1e-9
    assert yaws[-1] == pytest.approx(math.pi / 2, abs=0.05)


def test_until_the_plan_is_taken_it_goes_on_to_where_it_went() -> None:
    ahead = np.array([40.0, 0.0])
    motion = Motion(NOWHERE, np.array([4.0, 0.0]), NOWHERE, np.array([5.2, 0.0]), 0.0, ahead, waits=1.0)
    flights = flown([(0.0, 40.0)], motion=motion)
    assert flights.places[3, 0] == pytest.approx((4.0, 0.0), abs=0.5)


def test_a_tour_without_way_points_is_no_way() -> None:
    flights = fly(hovering(), np.zeros((1, 1, 2)), np.array([0]), SETTINGS, 10)
    assert flights.ways[0] == 0.0
    assert len(flights.places) == 0


def test_the_carrot_goes_as_far_ahead_as_the_daemon_lets_it() -> None:
    speed = FlightSettings().speed_m_s
    assert SETTINGS.speed_m_s == speed
    assert pytest.approx(carrot_lead(speed)) == SETTINGS.lead_m

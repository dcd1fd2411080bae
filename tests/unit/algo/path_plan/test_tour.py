from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.algo.ground import Floats
from hawk.algo.path_plan.course import Course, Outlook
from hawk.algo.path_plan.footprint import Footprint, Lean
from hawk.algo.path_plan.settings import PathPlanSettings
from hawk.algo.path_plan.tour import Terms, Tour, Wanted, length_of

FOOTPRINT = Footprint(40.0, 24.0)
LEANING = Footprint(40.0, 24.0, 19.0, 22.0, Lean(corner=10.0, start=12.0, stop=6.0, radius=16.0))


def ground(*boxes: tuple[float, float, float, float], step: float = 3.2, spare: float = 0.0) -> Wanted:
    """All of the boxes (north from, to, east from, to) is wanted."""
    cells = [
        (north, east)
        for a, b, c, d in boxes
        for north in np.arange(a + step / 2, b, step)
        for east in np.arange(c + step / 2, d, step)
    ]
    return Wanted(np.array(cells, np.float32), np.full(len(cells), step * step, np.float32), spare)


def tour_over(wanted: Wanted, *places: tuple[float, float], terms: Terms | None = None) -> Tour:
    return Tour(
        terms or Terms(FOOTPRINT, short_by=60.0), wanted, np.array(places, float), None, np.random.default_rng(1)
    )


def by_hand(wanted: Wanted, places: Floats) -> float:
    """Square metres that no leg shows, leg by leg and cell by cell."""
    missing = 0.0
    for (north, east), weight in zip(wanted.cells, wanted.weights, strict=True):
        for begin, end in itertools.pairwise(places):
            heading = math.atan2(end[1] - begin[1], end[0] - begin[0])
            d_n, d_e = north - begin[0], east - begin[1]
            along = d_n * math.cos(heading) + d_e * math.sin(heading)
            across = d_e * math.cos(heading) - d_n * math.sin(heading)
            half = FOOTPRINT.depth / 2
            if abs(across) <= FOOTPRINT.width / 2 and -half <= along <= math.dist(begin, end) + half:
                break
        else:
            missing += float(weight)
    return missing


def searched(tour: Tour, sweeps: int = 40) -> Tour:
    for sweep in range(sweeps):
        heat = 5.0 * (1 - sweep / sweeps)
        tour.sweep(4.0, heat)
    return tour


def test_what_a_tour_misses_is_what_no_leg_shows() -> None:
    wanted = ground((-30, 60, -50, 50))
    tour = tour_over(wanted, (0.0, 0.0), (40.0, 13.0), (37.0, -60.0))
    assert tour.missing == pytest.approx(by_hand(wanted, tour.places), rel=1e-5)


@pytest.mark.nightly
@settings(max_examples=40)
@given(
    st.integers(0, 10_000),
    st.sampled_from(["shift", "drop", "add", "exchange"]),
    st.sampled_from([FOOTPRINT, LEANING]),
    st.sampled_from([(0.0, 0.0), (0.6, -0.8)]),
)
def test_after_every_move_the_books_are_right(
    seed: int, move: str, footprint: Footprint, before: tuple[float, float]
) -> None:
    wanted = ground((-30, 60, -50, 50))
    rng = np.random.default_rng(seed)
    places = np.vstack([[0.0, 0.0], rng.uniform(-60, 60, (4, 2))])
    terms = Terms(footprint, turn_m=2.0, leg_m=1.0, before=before)
    tour = Tour(terms, wanted, places, 0.5, rng)
    for _ in range(3):
        if move == "shift":
            tour.shift(int(rng.integers(1, len(tour.places))), 8.0, 20.0)
        elif len(tour.places) > 1:
            getattr(tour, move)(20.0)
    fresh = Tour(terms, wanted, tour.places, 0.5, rng)
    assert tour.missing == pytest.approx(fresh.missing)
    assert tour.cost == pytest.approx(fresh.cost)
    assert tuple(tour.places[0]) == (0.0, 0.0)


@pytest.mark.nightly
@settings(max_examples=20)
@given(st.integers(0, 10_000))
def test_without_heat_no_move_makes_a_tour_costlier(seed: int) -> None:
    rng = np.random.default_rng(seed)
    places = np.vstack([[0.0, 0.0], rng.uniform(-60, 60, (5, 2))])
    tour = Tour(Terms(FOOTPRINT, turn_m=2.0, leg_m=1.0), ground((-30, 60, -50, 50)), places, 0.5, rng)
    for _ in range(4):
        for move in ("shift", "drop", "add", "exchange"):
            before = tour.cost
            if move == "shift" and len(tour.places) > 1:
                tour.shift(len(tour.places) - 1, 8.0, 0.0)
            elif move != "shift":
                getattr(tour, move)(0.0)
            assert tour.cost <= before + 1e-6


@pytest.mark.slow
def test_a_strip_is_flown_along_its_length_once() -> None:
    tour = searched(tour_over(ground((-15, 15, -60, 60)), (0.0, -55.0)))
    assert tour.missing < 20
    assert length_of(tour.places) == pytest.approx(55 + 60 - FOOTPRINT.depth / 2, abs=8)


@pytest.mark.slow
def test_two_lots_are_both_shown_and_the_nearer_comes_first() -> None:
    tour = searched(tour_over(ground((-20, 0, -20, 0), (-10, 10, 70, 90)), (30.0, 0.0)))
    assert tour.missing < 20
    assert tour.places[-1][1] > 50


@pytest.mark.slow
def test_no_waypoint_lies_where_the_drone_may_not_be() -> None:
    terms = Terms(FOOTPRINT, short_by=60.0, allowed=lambda places: places[:, 1] < 10.0)
    tour = searched(tour_over(ground((-20, 20, -60, 25)), (0.0, -50.0), terms=terms))
    assert (tour.places[:, 1] < 10.0).all()
    assert tour.missing < 0.05 * tour_over(ground((-20, 20, -60, 25)), (0.0, 0.0)).missing


@pytest.mark.slow
def test_what_may_be_left_out_is_not_flown_to() -> None:
    wanted = ground((0, 10, 80, 90), spare=150.0)
    assert len(searched(tour_over(wanted, (0.0, 0.0))).places) == 1
    assert len(searched(tour_over(ground((0, 10, 80, 90)), (0.0, 0.0))).places) > 1


@pytest.mark.nightly
def test_a_turn_is_avoided_when_it_costs() -> None:
    wanted = ground((60, 80, -10, 10), (-80, -60, -10, 10))
    ahead = Tour(Terms(FOOTPRINT, 60.0, turn_m=10.0), wanted, np.zeros((1, 2)), 0.0, np.random.default_rng(2))
    behind = Tour(Terms(FOOTPRINT, 60.0, turn_m=10.0), wanted, np.zeros((1, 2)), math.pi, np.random.default_rng(2))
    assert searched(ahead).places[1][0] > 0
    assert searched(behind).places[1][0] < 0


@pytest.mark.nightly
def test_a_tour_stops_short_of_what_the_braking_drone_looks_at() -> None:
    strip = ground((-15, 15, -60, 60))
    level, leaning = (
        searched(tour_over(strip, (0.0, -55.0), terms=Terms(footprint, short_by=60.0)))
        for footprint in (Footprint(40.0, 24.0, 10.0, 10.0), replace(LEANING, spun=10.0))
    )
    assert length_of(leaning.places) < length_of(level.places) - 4


def outlook(place: tuple[float, float], wanted: Wanted) -> Outlook:
    return Outlook(place, 0.0, wanted, Terms(FOOTPRINT, 60.0, turn_m=2.0, leg_m=2.0))


@pytest.mark.nightly
def test_a_course_leads_over_all_of_it_and_ends() -> None:
    wanted, place, course, length = ground((-50, 50, -60, 60)), (-40.0, -50.0), Course(PathPlanSettings()), 0.0
    for _ in range(600):
        left = course.follow(outlook(place, wanted))
        if len(left) == 0:
            break
        d_n, d_e = left[0] - place
        away = math.hypot(d_n, d_e)
        step = min(2.0, away)
        place = (place[0] + d_n / away * step, place[1] + d_e / away * step)
        length += step
        on = np.array([[place[0] + d_n / away, place[1] + d_e / away]])
        shown = FOOTPRINT.shown(wanted.cells, np.array([place]), on)[0]
        wanted = Wanted(wanted.cells[~shown], wanted.weights[~shown], 0.0)
    assert wanted.total < 120  # of 12 000
    assert length < 420  # three lines of 100 m and what joins them are 380 m


@pytest.mark.nightly
def test_the_same_course_twice_is_equal() -> None:
    courses = [Course(PathPlanSettings()) for _ in range(2)]
    wanted = ground((-50, 50, -60, 60))
    for step in range(12):
        first, second = (course.follow(outlook((-40.0 + step, -50.0), wanted)) for course in courses)
        assert np.array_equal(first, second)


@pytest.mark.slow
def test_a_course_that_was_prepared_follows_without_a_long_first_step(monkeypatch: pytest.MonkeyPatch) -> None:
    sweeps: list[float] = []
    sweep = Course._sweep

    def counted(course: Course, tour: Tour, heat: float) -> None:
        sweeps.append(heat)
        sweep(course, tour, heat)

    monkeypatch.setattr(Course, "_sweep", counted)
    seen = outlook((-40.0, -50.0), ground((-50, 50, -60, 60)))
    prepared, other = Course(PathPlanSettings()), Course(PathPlanSettings())
    for _ in range(10):
        sweeps.clear()
        prepared.prepare(seen)
        assert len(sweeps) <= 2
    sweeps.clear()
    length = length_of(np.vstack([seen.place, prepared.follow(seen)]))
    assert len(sweeps) <= 2
    assert length < 1.2 * length_of(np.vstack([seen.place, other.follow(seen)]))
    assert len(sweeps) > 6


@pytest.mark.nightly
def test_over_wide_ground_a_course_finds_lanes() -> None:
    """Lanes as wide as the picture over 3 ha are 750 m long; what joins them, their ends and turns come on top."""
    course, seen = Course(PathPlanSettings()), outlook((-5.0, -5.0), ground((0, 150, 0, 200)))
    for _ in range(40):
        course.prepare(seen)
    places = np.vstack([seen.place, course.follow(seen)])
    tour = Tour(seen.terms, seen.wanted, places, seen.yaw, np.random.default_rng(0))
    assert tour.missing < 30.0
    assert tour.cost < 1000.0


@pytest.mark.slow
def test_a_lane_s_end_where_no_waypoint_may_be_is_left_out() -> None:
    terms = Terms(FOOTPRINT, 60.0, allowed=lambda places: places[:, 1] < 150)
    course, wanted = Course(PathPlanSettings()), ground((0, 150, 0, 200))
    for _ in range(16):
        course.prepare(Outlook((-5.0, -5.0), 0.0, wanted, terms))
    places = course.follow(Outlook((-5.0, -5.0), 0.0, wanted, terms))
    assert len(places) > 4
    assert (places[:, 1] < 150).all()


def test_nothing_wanted_gives_no_waypoints() -> None:
    nothing = Wanted(np.empty((0, 2), np.float32), np.empty(0, np.float32), 0.0)
    assert len(Course(PathPlanSettings()).follow(outlook((0.0, 0.0), nothing))) == 0


@pytest.mark.nightly
def test_while_nothing_changes_the_tour_only_gets_cheaper() -> None:
    course, seen = Course(PathPlanSettings()), outlook((-40.0, -50.0), ground((-50, 50, -60, 60)))
    costs = []
    for _ in range(30):
        places = np.vstack([seen.place, course.follow(seen)])
        costs.append(Tour(seen.terms, seen.wanted, places, seen.yaw, np.random.default_rng(0)).cost)
    assert all(after <= before + 1e-6 for before, after in itertools.pairwise(costs))
    assert costs[-1] < costs[0] - 5

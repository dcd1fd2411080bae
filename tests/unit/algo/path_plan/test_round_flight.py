"""The flight of a round: lot after lot, at the travel height between them, inside a concave fence."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely

from benchmarks.known_flight import KnownFlight, SeenMap
from hawk.algo.frame import outcome
from hawk.algo.path_plan.app import PathPlanApp
from hawk.algo.path_plan.round_tour import RoundScene, round_tour
from hawk.model.known_lot import KnownLot
from hawk.model.plans import Fence, HeightParameters
from tests.unit.algo.path_plan.flight import LEVEL
from tests.unit.algo.path_plan.test_round_tour import BENT, lot_at
from tests.unit.algo.synthetic import CAMERA

HEIGHTS = HeightParameters(15.0, 35.0, 60.0)
FENCE = Fence(BENT, BENT, 97.0, 100.0)
LOW = replace(LEVEL, cm_per_pixel=100 * 22.0 / CAMERA.fx)
"""It explores from 22 m, and travels at 35 m."""
LOTS = (lot_at("west", 140.0, 20.0), lot_at("east", 140.0, 200.0))


def flight(lots: tuple[KnownLot, ...] = LOTS, heights: HeightParameters = HEIGHTS) -> KnownFlight:
    tours = outcome(round_tour(lots, frozenset(), RoundScene((0.0, 0.0), CAMERA, heights, FENCE, LOW)))
    return KnownFlight(lots, tours, SeenMap(lots, CAMERA), FENCE, CAMERA, heights, PathPlanApp(LOW))


@pytest.fixture(scope="module")
def flown() -> KnownFlight:
    made = flight()
    made.fly(most_s=600.0)
    return made


@pytest.mark.slow
def test_every_stall_of_every_lot_is_looked_at_and_the_first_lot_is_over_before_the_path_to_the_next(
    flown: KnownFlight,
) -> None:
    assert flown.last.explore.done
    assert flown.last.explore.seen == 1.0
    assert flown.lot_map.whole.all()
    assert [(look.lot, look.seen, look.is_over) for look in flown.last.explore.lots] == [
        ("west", 1.0, True),
        ("east", 1.0, True),
    ]
    over = next(number for number, plan in enumerate(flown.plans) if plan.explore.lots[0].is_over)
    assert not flown.plans[over].explore.lots[1].is_over
    assert flown.plans[over].explore.path_m > 30.0
    assert flown.places[over][1] < 80.0, "still over the west arm"


@pytest.mark.slow
def test_what_is_left_falls_from_lot_to_lot(flown: KnownFlight) -> None:
    left = [plan.explore.remaining_m or 0.0 for plan in flown.plans]
    whole = sum(tour.distance_m for tour in flown.tours)
    assert left[4] == pytest.approx(whole, rel=0.25)
    assert left[-1] < 5.0


@pytest.mark.slow
def test_it_flies_between_lots_at_the_travel_height_and_over_them_at_that_of_exploring(flown: KnownFlight) -> None:
    between = {plan.height for plan in flown.plans if plan.explore.path_m and plan.target is not None}
    over = {round(plan.height or 0.0, 3) for plan in flown.plans if not plan.explore.path_m and plan.target is not None}
    assert between == {35.0}
    assert over == {22.0}


@pytest.mark.slow
def test_the_path_between_lots_never_leaves_a_concave_fence(flown: KnownFlight) -> None:
    allowed = shapely.Polygon(BENT).buffer(1.5)
    assert shapely.contains_xy(allowed, *np.array(flown.places).T).all()


@pytest.mark.parametrize("desired", [60.0, 75.0])
def test_between_lots_it_never_flies_above_the_greatest_height(desired: float) -> None:
    made = flight(heights=HeightParameters(15.0, desired, 60.0))
    made.fly(most_s=1.0)
    assert {plan.height for plan in made.plans} == {60.0}


def test_without_the_plan_of_one_of_its_lots_a_round_is_not_flown() -> None:
    made = flight()
    made.known = made.known[:1]
    made.fly(most_s=0.3)
    assert made.last.target is None


@pytest.mark.nightly
@pytest.mark.slow
def test_a_lot_of_sections_alone_is_flown_in_a_round_and_is_over_once_all_of_it_was_looked_at() -> None:
    sections = replace(LOTS[1], stalls=(), section_places=LOTS[1].stalls)
    made = flight((LOTS[0], sections))
    made.fly(most_s=600.0)
    assert made.last.explore.done
    assert made.lot_map.whole_of["east"].all()
    assert len(made.lot_map.whole_of["east"]) == 16
    assert [(look.lot, look.seen, look.is_over) for look in made.last.explore.lots] == [
        ("west", 1.0, True),
        ("east", 1.0, True),
    ]

from __future__ import annotations

import math
from datetime import UTC, datetime, timedelta
from functools import cache

import cv2
import numpy as np
import pytest
import shapely
from numpy.typing import NDArray

from hawk.model.sun import SunPosition, sun_position
from hawk.worlds.daylight import DUSK_BELOW_DEG, light_at, shadow_of
from hawk.worlds.generate import WorldOptions, generate_world
from hawk.worlds.moment import Condition, clock_of
from hawk.worlds.parked_cars import number_stalls, park, stays_of
from hawk.worlds.plan import PlannedStall, Vehicle
from hawk.worlds.scene.canvas import Canvas
from hawk.worlds.scene.render import OwnStreams, Streams, draw_plan
from hawk.worlds.stays import Stay
from hawk.worlds.world import World, WorldError
from tests.unit.worlds.builders import SUN, generator, plain_plan, square

PLACE = (43.2609, -79.9192)
CLOCK = clock_of(PLACE[1])
MORNING, LATE = datetime(2026, 5, 4, 9, tzinfo=CLOCK), datetime(2026, 5, 4, 16, tzinfo=CLOCK)
SEED = 2


def options(at: datetime, **changes: object) -> WorldOptions:
    return WorldOptions(metres_per_pixel=0.2, at=at, place=PLACE, **changes)  # type: ignore[arg-type]


@cache
def world(at: datetime) -> World:
    return generate_world(SEED, options(at))


@pytest.mark.nightly
def test_the_same_moment_is_the_same_world_byte_for_byte() -> None:
    again = generate_world(SEED, options(MORNING.astimezone(UTC)))
    first = world(MORNING)
    assert again.ground.tobytes() == first.ground.tobytes()
    assert [layer.pixels.tobytes() for layer in again.layers] == [layer.pixels.tobytes() for layer in first.layers]
    assert again.truth_json()["stalls"] == first.truth_json()["stalls"]


@pytest.mark.nightly
def test_another_moment_has_the_same_stalls_in_other_states() -> None:
    one, other = world(MORNING), world(LATE)
    assert [stall.id for stall in one.stalls] == [stall.id for stall in other.stalls]
    for first, second in zip(one.stalls, other.stalls, strict=True):
        np.testing.assert_array_equal(first.corners, second.corners)
        assert first.worn == second.worn
    assert [stall.taken for stall in one.stalls] != [stall.taken for stall in other.stalls]


@pytest.mark.nightly
@pytest.mark.parametrize("at", [MORNING, LATE])
def test_the_truth_of_a_moment_is_that_of_its_stays(at: datetime) -> None:
    seen = world(at)
    assert seen.stays is not None
    around = seen.stays.between(at - timedelta(days=1), at + timedelta(days=1))
    taken = {stay.stall for stay in around if stay.begin <= at < stay.end}
    assert {stall.id for stall in seen.stalls if stall.taken} == taken
    assert taken
    covered = [stall.covered for stall in seen.stalls if stall.taken and stall.kind != "parallel"]
    free = [stall.covered for stall in seen.stalls if not stall.taken]
    assert np.mean(np.array(covered) > 0.3) > 0.9
    assert np.mean(np.array(free) < 0.15) > 0.9
    assert seen.truth_json()["at"] == at.isoformat()


@pytest.mark.nightly
def test_the_lot_is_that_of_the_seed_alone() -> None:
    alone = generate_world(SEED, WorldOptions(metres_per_pixel=0.2))
    assert [s.corners.tolist() for s in alone.stalls] == [s.corners.tolist() for s in world(MORNING).stalls]
    assert "at" not in alone.truth_json()
    assert alone.stays is None


def test_ground_far_from_cars_and_shadows_is_the_same_at_every_moment() -> None:
    one, other = world(MORNING), world(LATE)
    same = (one.ground == other.ground).all(2)
    lot = np.zeros(same.shape, np.uint8)
    for outline in one.lots:
        cv2.fillPoly(lot, [np.round(outline / one.metres_per_pixel).astype(np.int32)], 1)
    for stall in one.stalls:  # cars and their shadows are here
        reach = np.round(shapely.Polygon(stall.corners).buffer(6).exterior.coords / np.array(0.2)).astype(np.int32)
        cv2.fillPoly(lot, [reach], 0)
    assert same[lot > 0].mean() > 0.7, "shadows of trees and of moving cars remain"


@pytest.mark.nightly
def test_a_car_that_stays_is_the_same_car() -> None:
    def cars(seen: World, stalls: set[int]) -> list[NDArray[np.uint8]]:
        areas = shapely.union_all([shapely.Polygon(stall.corners) for stall in seen.stalls if stall.id in stalls])
        middles = [(layer, layer.corners[:, :2].mean(0)) for layer in seen.layers if layer.label == "car"]
        return [layer.pixels for layer, middle in middles if areas.contains(shapely.Point(middle))]

    later = MORNING + timedelta(minutes=5)
    first, second = world(MORNING), world(later)
    assert first.stays is not None
    stayed = {stall for stall, stay in first.stays.at(MORNING).items() if stay.covers(later)}
    before, after = cars(first, stayed), cars(second, stayed)
    assert len(before) > len(stayed) > 20
    for one, same in zip(before, after, strict=True):
        np.testing.assert_array_equal(one[..., 3], same[..., 3])
    alike = [np.array_equal(one, same) for one, same in zip(before, after, strict=True)]
    assert np.mean(alike) > 0.8, "only a shadow that moved on changes a car"


@pytest.mark.parametrize("at", [MORNING, LATE])
def test_shadows_fall_away_from_the_sun(at: datetime) -> None:
    """A block's shadow, measured in the picture, lies along the direction that astral gives."""
    position = sun_position(at, *PLACE)
    sun = light_at(plain_plan(), Condition.DAY, position, SUN, generator())
    plan = plain_plan(buildings=[])
    plan.shades.append(square(20, 20, 0.5) + sun.cast(4.0))
    ground = draw_plan(plan, Canvas(0, 0, 400, 400, 0.1), sun, generator()).ground
    rows, columns = np.nonzero(ground[..., 1] < 90)
    middle = np.array([columns.mean(), rows.mean()]) * 0.1 - 20.25
    azimuth = math.degrees(math.atan2(-middle[0], middle[1])) % 360  # towards the sun: x east, y south
    assert azimuth == pytest.approx(position.azimuth, abs=2)
    assert np.hypot(*middle) == pytest.approx(4.0 / math.tan(math.radians(position.elevation)), abs=0.2)


def test_the_sun_of_the_morning_stands_in_the_east_and_that_of_the_afternoon_in_the_west() -> None:
    assert shadow_of(sun_position(MORNING, *PLACE))[0] < -0.5
    assert shadow_of(sun_position(LATE, *PLACE))[0] > 0.5


def test_in_the_south_the_noon_shadow_falls_south() -> None:
    noon = datetime(2026, 5, 4, 12, tzinfo=clock_of(151.0))
    assert shadow_of(sun_position(noon, -33.9, 151.0))[1] > 0.5


@pytest.mark.parametrize(("elevation", "lamps", "reach"), [(40.0, False, 1.2), (3.0, True, 14.4), (-3.0, True, 0.0)])
def test_lamps_are_lit_at_dusk_and_shadows_stay_finite(elevation: float, lamps: bool, reach: float) -> None:
    plan = plain_plan(lots=[square(0, 0, 50)])
    sun = light_at(plan, Condition.DAY, SunPosition(200.0, elevation), SUN, generator())
    assert (plan.lamps is not None) is lamps
    assert sun.reach == pytest.approx(reach, abs=0.15)
    assert sun.reach <= 1 / math.tan(math.radians(DUSK_BELOW_DEG)) + 1e-9


def test_night_has_no_sun_and_keeps_the_weather() -> None:
    plan = plain_plan(lots=[square(0, 0, 50)])
    sun = light_at(plan, Condition.WET, SunPosition(0.0, -20.0), SUN, generator())
    assert sun.reach == 0.0
    assert plan.wet > 0
    assert plan.lamps is not None


@pytest.mark.slow
def test_a_world_at_night_is_dark() -> None:
    night = world(datetime(2026, 5, 4, 23, tzinfo=CLOCK))
    assert night.ground.mean() < 0.6 * world(MORNING).ground.mean()


@pytest.mark.parametrize("condition", [Condition.DUSK, Condition.NIGHT])
def test_a_time_of_day_beside_a_moment_is_refused(condition: Condition) -> None:
    with pytest.raises(WorldError, match="condition"):
        options(MORNING, condition=condition)


def _two_stalls() -> list[PlannedStall]:
    row = np.array([(0.0, 0.0), (2.5, 0.0), (2.5, 5.0), (0.0, 5.0)])
    return [PlannedStall(row + np.array([2.5 * k, 0.0]), "perpendicular", True, False, 1.0) for k in range(2)]


def test_cars_of_stays_replace_those_of_the_plan() -> None:
    plan = plain_plan(stalls=_two_stalls(), vehicles=[Vehicle(1.2, 2.5, 1.57, "suv"), Vehicle(3.8, 2.5, 1.57, "van")])
    number_stalls(plan)
    stay = Stay(1, MORNING, LATE)
    park(plan, {1: stay}, MORNING, SEED)
    (car,) = plan.vehicles
    assert shapely.Polygon(plan.stalls[1].corners).contains(shapely.Point(car.x, car.y))
    assert abs(math.sin(car.heading)) > 0.95, "along the stall"
    assert [stall.taken for stall in plan.stalls] == [False, True]
    later = plain_plan(stalls=_two_stalls())
    number_stalls(later)
    park(later, {1: stay}, LATE - timedelta(seconds=1), SEED)
    assert later.vehicles == [car]


def test_closed_stalls_have_no_stays() -> None:
    plan = plain_plan(stalls=_two_stalls())
    plan.stalls[0] = PlannedStall(plan.stalls[0].corners, "perpendicular", False, False, 1.0, closed=True)
    number_stalls(plan)
    stays = stays_of(plan, 1, CLOCK).between(MORNING, MORNING + timedelta(days=7))
    assert {stay.stall for stay in stays} == {1}


def test_streams_of_their_own_do_not_depend_on_each_other() -> None:
    streams = OwnStreams(4)
    alone = streams.of("tree", 3.0, 4.0).random(3)
    streams.of("tree", 1.0, 1.0).random(9)
    np.testing.assert_array_equal(OwnStreams(4).of("tree", 3.0, 4.0).random(3), alone)
    for other in (OwnStreams(5).of("tree", 3.0, 4.0), streams.of("tree", 3.1, 4.0), streams.of("post", 3.0, 4.0)):
        assert not np.array_equal(other.random(3), alone)


def test_one_stream_serves_everything_in_order() -> None:
    streams, same = Streams(generator(3)), generator(3)
    assert [streams.of("tree", 1.0).random(), streams.of("ground").random()] == [same.random(), same.random()]

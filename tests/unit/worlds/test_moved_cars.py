"""Cars moved between the stalls of a painted picture that stands for a photograph of a lot."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import cv2
import numpy as np
import pytest
import shapely
from numpy.typing import NDArray

from hawk.worlds.ground_patches import Ground, Spot, moved
from hawk.worlds.moved_cars import move_cars
from hawk.worlds.world import TrueStall, World, WorldError

SCALE = 0.1
ASPHALT = 120.0
SHADE = 0.55
COLOURS = ((40, 40, 200), (190, 90, 40), (230, 230, 230), (30, 30, 30), (90, 90, 150), (200, 200, 40))
TAKEN = (0, 2, 4, 7, 9, 11)
COLUMNS, TOPS = 8, (4.0, 16.0)


def stall_at(number: int) -> NDArray[np.float64]:
    """Corners of one of two rows of stalls apart, metres."""
    x, y = 4 + 2.6 * (number % COLUMNS), TOPS[number // COLUMNS]
    return np.array([(x, y), (x + 2.6, y), (x + 2.6, y + 5.2), (x, y + 5.2)])


@cache
def photographed() -> World:
    """Two rows of stalls on grey ground; cars of six colours, each with shade on its west side."""
    rng = np.random.default_rng(1)
    picture = np.full((260, 290, 3), ASPHALT) + rng.normal(0, 2.5, (260, 290, 1))
    stalls = []
    for number in range(2 * COLUMNS):
        corners = stall_at(number)
        for side in (0, 1):
            x, y = corners[side] / SCALE
            picture[round(y) : round(y) + 52, round(x) - 1 : round(x) + 1] = 215
        taken = number in TAKEN
        stalls.append(TrueStall(number, corners, taken, covered=0.6 + number / 100 if taken else 0.0))
    for k, number in enumerate(TAKEN):
        x, y = (corner.item() for corner in np.round(stall_at(number)[0] / SCALE).astype(int))
        picture[y + 5 : y + 47, x - 5 : x + 4] *= SHADE
        picture[y + 3 : y + 48, x + 4 : x + 22] = COLOURS[k]
    ground = np.clip(picture, 0, 255).astype(np.uint8)
    return World("lot", SCALE, ground, stalls=tuple(stalls), lots=(np.array([(2, 2), (27, 2), (27, 24), (2, 24)]),))


def colour_in(world: World, number: int) -> NDArray[np.float64]:
    x, y = np.round(stall_at(number).mean(0) / SCALE).astype(int)
    return np.asarray(world.ground[y - 10 : y + 10, x - 5 : x + 5].reshape(-1, 3).mean(0))


def colour_number(world: World, number: int) -> int | None:
    """The car of the picture that stands on a stall, by its colour; None: asphalt."""
    away = np.abs(np.array(COLOURS) - colour_in(world, number)).max(1)
    if away.min() < 25:
        return int(away.argmin())
    assert np.abs(colour_in(world, number) - ASPHALT).max() < 8
    return None


@pytest.mark.nightly
@pytest.mark.parametrize("seed", range(5))
def test_every_car_stands_on_a_stall_that_the_truth_calls_taken(seed: int) -> None:
    after = move_cars(photographed(), seed)
    seen = {stall.id: colour_number(after, stall.id) for stall in after.stalls}
    assert {number for number, car in seen.items() if car is not None} == {s.id for s in after.stalls if s.taken}
    assert sorted(car for car in seen.values() if car is not None) == list(range(len(TAKEN)))


@pytest.mark.slow
def test_the_share_under_a_car_moves_with_it() -> None:
    before, after = photographed(), move_cars(photographed(), 3)
    for stall in after.stalls:
        car = colour_number(after, stall.id)
        assert stall.covered == (0.0 if car is None else before.stalls[TAKEN[car]].covered)


@pytest.mark.nightly
def test_the_same_seed_moves_the_same_cars_and_another_others() -> None:
    first, again, other = (move_cars(photographed(), seed) for seed in (1, 1, 2))
    assert first.ground.tobytes() == again.ground.tobytes()
    assert [s.taken for s in first.stalls] == [s.taken for s in again.stalls]
    assert [s.taken for s in first.stalls] != [s.taken for s in other.stalls]


@pytest.mark.slow
def test_stalls_and_ground_away_from_them_stay() -> None:
    before, after = photographed(), move_cars(photographed(), 1)
    for one, same in zip(before.stalls, after.stalls, strict=True):
        np.testing.assert_array_equal(one.corners, same.corners)
        assert one.id == same.id
    rows = shapely.union_all([shapely.Polygon(s.corners) for s in before.stalls]).buffer(2.0, join_style="mitre")
    mask = np.ones(before.ground.shape[:2], np.uint8)
    for part in getattr(rows, "geoms", [rows]):
        cv2.fillPoly(mask, [np.round(np.array(part.exterior.coords) / SCALE).astype(np.int32)], 0)
    assert mask.sum() > 10_000
    np.testing.assert_array_equal(before.ground[mask > 0], after.ground[mask > 0])


@pytest.mark.slow
def test_shade_falls_on_the_same_side_at_the_new_stall_and_none_is_left_at_the_old_one() -> None:
    after = move_cars(photographed(), 4)
    taken = {stall.id for stall in after.stalls if stall.taken}
    for number in range(2 * COLUMNS):
        x, y = np.round(stall_at(number)[0] / SCALE).astype(int)
        inside = after.ground[y + 15 : y + 40, x + 2 : x + 4].mean()
        if number in taken:
            assert inside < 0.75 * ASPHALT, "shade beside the car, on its own stall"
        else:
            assert inside > 0.85 * ASPHALT
        west = number - 1
        if number % COLUMNS and west not in taken:
            beyond = after.ground[y + 15 : y + 40, x - 4 : x - 2].mean()
            assert bool(beyond < 0.8 * ASPHALT) is (number in taken), "shade that reaches over the line"


@pytest.mark.slow
def test_unclear_and_hidden_stalls_are_left_alone() -> None:
    world = photographed()
    picture = world.ground.copy()
    x, y = np.round(stall_at(4)[0] / SCALE).astype(int)
    picture[y : y + 30, x : x + 14] = (40, 110, 60)  # a crown over a car
    stalls = [replace(stall, unclear=True, taken=False) if stall.id == 2 else stall for stall in world.stalls]
    after = move_cars(replace(world, ground=picture, stalls=tuple(stalls)), 1)
    for number in (2, 4):
        x, y = np.round(stall_at(number)[0] / SCALE).astype(int)
        core = np.s_[y + 5 : y + 45, x + 6 : x + 20]
        np.testing.assert_array_equal(after.ground[core], picture[core])
    assert after.stalls[2].state == "unclear"
    assert after.stalls[4].state == "taken"


@pytest.mark.nightly
def test_a_car_that_cannot_be_moved_keeps_its_shade() -> None:
    world = photographed()
    picture = world.ground.copy()
    x, y = np.round(stall_at(9)[0] / SCALE).astype(int)
    picture[y + 3 : y + 48, x + 4 : x + 22] = (60, 170, 60)  # as green as a plant
    free = 0
    for seed in range(4):
        after = move_cars(replace(world, ground=picture), seed)
        assert after.stalls[9].taken
        if not after.stalls[8].taken:
            free += 1
            beside = np.s_[y + 10 : y + 40, x - 4 : x + 20]
            np.testing.assert_array_equal(after.ground[beside], picture[beside])
    assert free > 0


@pytest.mark.nightly
def test_a_free_stall_with_something_on_it_gets_no_car_and_lends_no_ground() -> None:
    world = photographed()
    picture = world.ground.copy()
    x, y = np.round(stall_at(5)[0] / SCALE).astype(int)
    picture[y + 3 : y + 48, x + 4 : x + 22] = (230, 120, 60)  # a shelter that the labels call free
    for seed in range(4):
        after = move_cars(replace(world, ground=picture), seed)
        assert not after.stalls[5].taken
        core = np.s_[y + 5 : y + 46, x + 8 : x + 15]
        np.testing.assert_array_equal(after.ground[core], picture[core])
        same = np.abs(after.ground.astype(int) - (230, 120, 60)).max(2) < 12
        assert same.sum() <= 45 * 18, "it is there once"


@pytest.mark.parametrize("state", [True, False])
def test_a_truth_without_free_or_taken_stalls_is_refused(state: bool) -> None:
    world = photographed()
    stalls = tuple(stall for stall in world.stalls if stall.taken is state)
    with pytest.raises(WorldError, match="--truth must label taken stalls, and free ones"):
        move_cars(replace(world, stalls=stalls), 1)


def test_an_id_that_is_used_twice_is_refused() -> None:
    world = photographed()
    with pytest.raises(WorldError, match="share an id"):
        move_cars(replace(world, stalls=(*world.stalls, world.stalls[0])), 1)


def _spot(corners: NDArray[np.float64]) -> Spot:
    return Spot(TrueStall(0, corners, False), corners)


def test_a_stall_turned_round_is_the_same_place_and_one_across_fits_not() -> None:
    plain = _spot(stall_at(0) / SCALE)
    turned = _spot(np.roll(plain.corners, 2, axis=0))
    across = _spot(np.array([(0.0, 0.0), (0.0, 26.0), (52.0, 26.0), (52.0, 0.0)]))
    assert plain.fits(turned)
    assert plain.is_opposed(turned)
    assert plain.turn_to(turned) == pytest.approx(0.0, abs=1e-9)
    assert not plain.fits(across)
    assert not plain.fits(_spot(plain.corners * 1.3))


@pytest.mark.parametrize("degrees", [-3.5, 2.0, 3.5])
def test_what_is_moved_is_turned_with_the_stall(degrees: float) -> None:
    picture = np.zeros((200, 200, 3), np.float32)
    source = _spot(np.array([(40.0, 40.0), (66.0, 40.0), (66.0, 92.0), (40.0, 92.0)]))
    cv2.circle(picture, (63, 44), 2, (250.0, 250.0, 250.0), -1)  # near its second corner
    turn = np.deg2rad(degrees)
    matrix = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    target = _spot((source.corners - source.centre) @ matrix.T + (130.0, 120.0))
    ground = Ground(picture, SCALE, [])
    window = ground.window(target, 1.0)
    shown = moved(picture, source, target, window)
    row, column = (float(values.mean()) for values in np.nonzero(shown[..., 0] > 100))
    expected = (np.array([63.0, 44.0]) - source.centre) @ matrix.T + target.centre
    assert (column + window.columns.start, row + window.rows.start) == pytest.approx(expected, abs=0.8)

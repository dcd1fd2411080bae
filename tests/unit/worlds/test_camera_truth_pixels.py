"""The truth of a drawn world or scene, compared with its pixels."""

from __future__ import annotations

import math
from functools import cache

import cv2
import numpy as np
import pytest
import shapely

from hawk.model.pictures import CameraModel
from hawk.worlds.camera import Lens, WorldCamera
from hawk.worlds.generate import WorldOptions, generate_world
from hawk.worlds.plan import Building, PlannedStall
from hawk.worlds.rows import plan_row
from hawk.worlds.scene.canvas import Canvas
from hawk.worlds.scene.cars import footprint_m
from hawk.worlds.scene.facets import FacetSet, ground_projection
from hawk.worlds.scene.light import Sun
from hawk.worlds.scene.render import draw_plan
from hawk.worlds.world import TrueStall, World
from tests.unit.worlds.builders import EAST, areas_of, generator, plain_plan, plain_style, square
from training.scenes import Scene, _lot_mask, _scene_stall, _share, draw_scene, photograph

CAMERA = CameraModel(640, 360, 460.0, 460.0, 319.5, 179.5)
CLEAN = Lens(blur=0, noise=0, vignette=0)


@cache
def world(seed: int) -> World:
    return generate_world(seed, WorldOptions(metres_per_pixel=0.2))


@cache
def scene(seed: int) -> Scene:
    return draw_scene(np.random.default_rng(seed), 192)


def car_mask(one: World) -> np.ndarray:
    """Return the cars as seen from straight above, at the world's own scale."""
    rows, columns = one.ground.shape[:2]
    mask = np.zeros((rows, columns), np.uint8)
    projection = ground_projection((0.0, 0.0), one.metres_per_pixel)
    for layer in FacetSet(one.layers).seen(projection, columns, rows):
        layer.mark(mask, int(layer.label == "car"))
    return mask


@pytest.mark.nightly
@pytest.mark.parametrize("seed", [1, 4])
def test_a_taken_stall_shows_a_car_and_a_free_one_none(seed: int) -> None:
    one, right = world(seed), []
    cars = car_mask(one)
    for stall in (stall for stall in one.stalls if not stall.hidden):
        inner = stall.corners.mean(axis=0) + (stall.corners - stall.corners.mean(axis=0)) * 0.5
        right.append((_share(cars, inner / one.metres_per_pixel - 0.5) > 0.35) == stall.taken)
    assert len(right) > 50
    assert np.mean(right) > 0.95


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 4])
def test_what_covers_a_stall_is_measured_as_its_pixels_are(seed: int) -> None:
    one = world(seed)
    cars = car_mask(one)
    measured = [_share(cars, stall.corners / one.metres_per_pixel - 0.5) for stall in one.stalls if not stall.hidden]
    given = [stall.covered for stall in one.stalls if not stall.hidden]
    assert np.corrcoef(measured, given)[0, 1] > 0.9


@pytest.mark.parametrize("seed", [1, 4])
def test_painted_lines_are_where_the_truth_says(seed: int) -> None:
    one, contrasts = world(seed), []
    grey = one.ground.mean(axis=2)
    for stall in one.stalls:
        if stall.worn or stall.hidden or stall.covered > 0.02:
            continue
        start, end = stall.corners[1], stall.corners[2]
        across = (stall.corners[1] - stall.corners[0]) / np.linalg.norm(stall.corners[1] - stall.corners[0])
        shares = np.linspace(0.2, 0.6, 9)[:, None]
        line, beside = start + (end - start) * shares, start + (end - start) * shares - across * 0.8
        contrasts.append(np.abs(sampled(grey, one, line) - sampled(grey, one, beside)).mean())
    assert len(contrasts) > 8
    assert np.median(contrasts) > 4


def sampled(picture: np.ndarray, one: World, points: np.ndarray) -> np.ndarray:
    columns, rows = np.clip((points / one.metres_per_pixel).astype(int), 0, np.array(picture.shape[::-1]) - 1).T
    return np.asarray(picture[rows, columns])


@pytest.mark.slow
@pytest.mark.parametrize("pose", [(0.0, 0.0, 0.0), (0.0, 0.0, 2.1), (0.12, -0.2, 0.7), (-0.25, 0.1, -2.4)])
def test_the_camera_sees_each_stall_where_its_corners_project(pose: tuple[float, float, float]) -> None:
    ground = np.full((300, 400, 3), 60, np.uint8)
    corners = np.array([[18.0, 12.0], [20.5, 12.0], [20.5, 17.0], [18.0, 17.0]])
    ground[120:170, 180:205] = (0, 0, 255)
    one = World("one", 0.1, ground, stalls=(TrueStall(0, corners, taken=False),))
    camera = WorldCamera(one, CAMERA, CLEAN)
    place = (19.0, 15.0, 18.0)
    frame = camera.render(*place, *pose, rng=generator())
    image = np.column_stack([corners, np.zeros(4), np.ones(4)]) @ camera.projection(*place, *pose).T
    quad = image[:, :2] / image[:, 2:]
    red = ((frame[..., 2] > 150) & (frame[..., 1] < 40)).astype(np.uint8)
    assert red.sum() == pytest.approx(cv2.contourArea(quad.astype(np.float32)), rel=0.05)
    assert _share(red, quad) > 0.93


@pytest.mark.slow
def test_a_drawn_row_is_photographed_where_it_was_planned() -> None:
    plan = plain_plan()
    plan_row(plan, generator(3), EAST.moved(2.0, 8.0), 36.0, plain_style(occupancy=0.5))
    drawn = draw_plan(plan, Canvas(0, 0, 400, 200, 0.1), Sun((0.0, 0.0), (1.0, 1.0, 1.0), 0.0), generator(3))
    one = World("row", 0.1, np.clip(drawn.ground, 0, 255).astype(np.uint8), drawn.layers)
    camera = WorldCamera(one, CAMERA, CLEAN)
    pose = (20.0, 10.5, 40.0, 0.05, -0.04, 0.3)
    frame = camera.render(*pose, rng=generator()).astype(float).mean(axis=2)
    differences: dict[bool, list[float]] = {True: [], False: []}
    for stall in plan.stalls:
        inner = stall.corners.mean(axis=0) + (stall.corners - stall.corners.mean(axis=0)) * 0.4
        image = np.column_stack([inner, np.full(4, 0.7 * stall.taken), np.ones(4)]) @ camera.projection(*pose).T
        columns, rows = np.round(image[:, :2] / image[:, 2:]).astype(int).T
        differences[stall.taken].append(float(np.abs(frame[rows, columns] - 100).max()))
    assert np.median(differences[False]) < 12, "bare ground"
    assert np.median(differences[True]) > 20, "a car"


@pytest.mark.slow
@pytest.mark.parametrize("seed", [2, 5])
def test_the_truth_of_a_world_lies_in_its_picture(seed: int) -> None:
    one = world(seed)
    picture = shapely.box(0, 0, *one.size_m)
    lots = shapely.union_all([shapely.Polygon(lot) for lot in one.lots])
    assert picture.contains(lots)
    assert all(lots.buffer(0.1).contains(shapely.Polygon(stall.corners)) for stall in one.stalls)
    assert all(0 <= stall.covered <= 1 for stall in one.stalls)


@pytest.mark.nightly
@pytest.mark.slow
def test_lots_of_scenes_hold_their_stalls() -> None:
    inside = []
    for seed in range(14):
        one = scene(seed)
        for stall in one.stalls:
            column, row = np.round(stall.quad.mean(axis=0)).astype(int)
            if 0 <= row < 192 and 0 <= column < 192:
                inside.append(one.lot[row, column])
    assert len(inside) > 40
    assert np.mean(inside) > 0.97


def test_scene_stalls_are_the_planned_ones_in_pixels() -> None:
    canvas = Canvas(10.0, 20.0, 100, 100, 0.1)
    corners = np.array([[12.0, 22.0], [14.5, 22.0], [14.5, 27.0], [12.0, 27.0]])
    cover = np.zeros((100, 100), np.uint8)
    cover[20:45] = 1
    planned = PlannedStall(corners, "angled", taken=True, worn=True, paint=0.5)
    stall = _scene_stall(canvas, planned, cover, contrast=40.0)
    assert stall.quad == pytest.approx(np.array([[19.5, 19.5], [44.5, 19.5], [44.5, 69.5], [19.5, 69.5]]))
    assert stall.covered == pytest.approx(0.5, abs=0.02)
    assert (stall.taken, stall.worn, stall.kind, stall.hidden, stall.lines_visible) == (
        True,
        True,
        "angled",
        False,
        True,
    )
    assert not _scene_stall(canvas, planned, cover, contrast=10.0).lines_visible, "too faint"
    assert _scene_stall(canvas, planned, np.ones_like(cover), contrast=40.0).hidden


@pytest.mark.parametrize(
    ("quad", "share"),
    [
        (square(10, 10, 20), 1.0),
        (square(60, 10, 20), 0.0),
        (square(40, 10, 19), 0.5),
        (square(-100, 10, 20), 0.0),
        (square(-10, 10, 20), 1.0),
    ],
)
def test_the_share_of_a_mask_over_a_quad(quad: np.ndarray, share: float) -> None:
    mask = np.zeros((100, 100), np.uint8)
    mask[:, :50] = 1
    assert _share(mask, quad) == pytest.approx(share, abs=0.03)


def test_buildings_are_no_part_of_a_lot_and_shelters_are() -> None:
    plan = plain_plan(lots=[square(0, 0, 10)])
    plan.buildings += [Building(EAST.moved(1, 1), 3, 3, 4), Building(EAST.moved(6, 6), 2, 2, 2, shelter=True)]
    mask = _lot_mask(Canvas(-5, -5, 200, 200, 0.1), plan)
    assert mask[75, 75] == 0, "a building"
    assert mask[120, 120] == 1, "a shelter"
    assert mask[110, 75] == 1
    assert mask[20, 20] == mask[170, 100] == 0
    assert mask.sum() * 0.01 == pytest.approx(100 - 9, rel=0.05)


def test_scenes_may_be_of_any_shape_and_scale() -> None:
    wide = draw_scene(np.random.default_rng(3), (48, 160), metres_per_pixel=0.2)
    assert wide.image.shape == (48, 160, 3)
    assert wide.metres_per_pixel == 0.2
    for stall in wide.stalls:
        assert 10 < np.linalg.norm(stall.quad[1] - stall.quad[0]) < 26


def test_a_photograph_keeps_what_is_where() -> None:
    image = np.full((96, 96, 3), 60, np.float32)
    image[30:60, 40:50] = 200
    for seed in range(30):
        shot = photograph(generator(seed), image)
        assert shot.dtype == np.uint8
        inside, outside = shot[35:55, 42:48].mean(), shot[70:90, 10:30].mean()
        assert inside > outside + 25


@pytest.mark.parametrize("level", [0.0, 30.0, 255.0])
def test_a_photograph_of_one_tone_stays_in_range(level: float) -> None:
    for seed in range(20):
        shot = photograph(generator(seed), np.full((32, 32, 3), level, np.float32))
        assert shot.shape == (32, 32, 3)
        assert shot.std() < 40, "grain alone"


def test_a_photograph_does_not_change_its_scene() -> None:
    image = np.full((32, 32, 3), 77, np.float32)
    photograph(generator(1), image)
    assert (image == 77).all()


@pytest.mark.parametrize("seed", [1, 4])
def test_cars_of_a_world_stand_apart(seed: int) -> None:
    plan = plain_plan()
    plan_row(plan, generator(seed), EAST, 100.0, plain_style(occupancy=1.0, tidy=0.5))
    cars = [shapely.Polygon(footprint_m(car)) for car in plan.vehicles]
    near = shapely.STRtree(cars).query(cars, predicate="intersects").T
    assert sum(cars[a].intersection(cars[b]).area > 0.5 for a, b in near if a < b) <= 0.05 * len(cars)
    assert len(areas_of(plan.stalls)) >= len(cars)


@pytest.mark.nightly
@pytest.mark.parametrize("turn", [0.0, math.pi / 3])
def test_the_same_place_looks_the_same_from_a_turned_camera(turn: float) -> None:
    one = world(1)
    camera = WorldCamera(one, CameraModel(201, 201, 200.0, 200.0, 100.0, 100.0), CLEAN)
    x, y = one.size_m[0] / 2, one.size_m[1] / 2
    north = camera.render(x, y, 30.0, 0.0, 0.0, 0.0, rng=generator()).astype(np.float32)
    turned = camera.render(x, y, 30.0, 0.0, 0.0, turn, rng=generator()).astype(np.float32)
    back = cv2.warpAffine(turned, cv2.getRotationMatrix2D((100, 100), -math.degrees(turn), 1.0), (201, 201))
    inner = np.s_[60:141, 60:141]
    assert np.abs(cv2.blur(north, (5, 5)) - cv2.blur(back, (5, 5)))[inner].mean() < 6

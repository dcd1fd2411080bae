from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from hawk.algo.mapper.mosaic import Mosaic
from hawk.algo.mapper.published import nearest_first
from hawk.algo.vision.detection import GroundImage
from hawk.algo.vision.rectify import Rectifier
from hawk.model.lot_map import TILE_CELLS, EncodedTile
from hawk.model.poses import MapPose
from hawk.model.tile_picture import decode_picture
from tests.unit.algo.synthetic import CAMERA, ground_affine, pose_at

Image = NDArray[np.uint8]
SIDE_M = 60.0
FINE = 25
"""Pixels a metre of the drawn ground."""


def drawn_ground() -> Image:
    """Return grey ground of soft spots with fine stripes, north up, its middle at the map's origin."""
    rng = np.random.default_rng(3)
    side = round(2 * SIDE_M * FINE)
    spots = cv2.GaussianBlur(rng.normal(0, 1, (side // 25, side // 25)).astype(np.float32), (0, 0), 1.5)
    ground = 120 + 25 * cv2.resize(spots / spots.std(), (side, side), interpolation=cv2.INTER_CUBIC)
    ground[:, (np.arange(side) // 15) % 3 == 0] += 35
    return np.repeat(np.clip(ground, 30, 220).astype(np.uint8)[..., None], 3, axis=2)


GROUND = drawn_ground()


def shot(north: float, east: float, height: float = 35.0, light: float = 1.0, off: float = 0.0) -> GroundImage:
    """Return a frame of the drawn ground, rectified by a pose that is ``off`` metres to the east."""
    pose = MapPose(north, east, height, 0.0, 0.0, 0.3)
    columns, rows = np.meshgrid([0.0, CAMERA.width - 1], [0.0, CAMERA.height - 1])
    right = (columns - CAMERA.cx) / CAMERA.fx * height
    back = (rows - CAMERA.cy) / CAMERA.fy * height
    c, s = np.cos(pose.yaw), np.sin(pose.yaw)
    ground_north, ground_east = north - c * back - s * right, east - s * back + c * right
    at = np.stack([(ground_east + SIDE_M) * FINE - 0.5, (SIDE_M - ground_north) * FINE - 0.5], -1)
    matrix = cv2.getPerspectiveTransform(
        np.stack([columns, rows], -1).reshape(-1, 2).astype(np.float32), at.reshape(-1, 2).astype(np.float32)
    )
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    image = cv2.warpPerspective(GROUND, matrix, (CAMERA.width, CAMERA.height), flags=flags)
    lit = np.asarray(cv2.convertScaleAbs(image, alpha=light), np.uint8)
    return Rectifier().rectify(lit, CAMERA, replace(pose, east=east + off))


def put(mosaic: Mosaic, north: float, east: float, height: float = 35.0, light: float = 1.0, off: float = 0.0) -> None:
    mosaic.add(shot(north, east, height, light, off), (north, east + off), height)


def whole(mosaic: Mosaic, reach: int = 2) -> tuple[Image, Image]:
    """Return the tiles about the origin as one picture with its mask."""
    while mosaic.encode(9, 1):
        pass
    side = 2 * reach * TILE_CELLS
    pixels, seen = np.zeros((side, side, 3), np.uint8), np.zeros((side, side), np.uint8)
    for (row, column), tile in mosaic.encoded.items():
        if -reach <= row < reach and -reach <= column < reach:
            top, left = (row + reach) * TILE_CELLS, (column + reach) * TILE_CELLS
            part = (slice(top, top + TILE_CELLS), slice(left, left + TILE_CELLS))
            pixels[part], seen[part] = decode_picture(tile.data)
    return pixels, seen


def at(north: float, east: float, reach_m: float = 2.0) -> tuple[slice, slice]:
    """Return the part of `whole` about a place."""
    row, column = round(-north * 10) + 2 * TILE_CELLS, round(east * 10) + 2 * TILE_CELLS
    half = round(reach_m * 10)
    return slice(row - half, row + half), slice(column - half, column + half)


def true_picture() -> Image:
    """Return the drawn ground as `whole` has it."""
    side = 4 * TILE_CELLS
    inner = round((SIDE_M - 51.2) * FINE)
    return np.asarray(cv2.resize(GROUND[inner:-inner, inner:-inner], (side, side), interpolation=cv2.INTER_AREA))


def detail(picture: Image) -> float:
    return float(cv2.Laplacian(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), cv2.CV_32F).var())


def picture(north: float, east: float, grey: int) -> GroundImage:
    pose = pose_at(north, east, 0.4)
    values = np.full((200, 300, 3), grey, np.uint8)
    return GroundImage(values, ground_affine(pose, (200, 300), 0.1), np.ones((200, 300), np.bool_))


def pixels(tile: EncodedTile) -> Image:
    return np.asarray(decode_picture(tile.data)[0][..., 0])


def test_a_picture_is_placed_where_it_was_taken_and_what_it_does_not_show_stays_unseen() -> None:
    mosaic = Mosaic()
    mosaic.add(picture(-12.8, 12.8, 150), (-12.8, 12.8), 35.0)
    while mosaic.encode(1, 1):
        pass
    shown, seen = decode_picture(mosaic.encoded[0, 0].data)
    assert abs(int(shown[128, 128, 0]) - 150) < 4
    assert (seen[128, 128], seen[2, 250]) == (255, 0)
    assert shown.min() > 140, "what was not seen is not black either"


def test_the_cameras_picture_is_sampled_at_its_place() -> None:
    mosaic = Mosaic()
    put(mosaic, 0.0, 0.0)
    shown, seen = whole(mosaic)
    assert seen[at(0, 0)].all()
    apart = np.abs(shown[at(0, 0, 4)].astype(int) - true_picture()[at(0, 0, 4)])
    moved = np.abs(np.roll(shown, 2, axis=1)[at(0, 0, 4)].astype(int) - true_picture()[at(0, 0, 4)])
    assert apart.mean() < 5 < moved.mean()


@pytest.mark.parametrize("light", [0.8, 1.2])
def test_two_pictures_of_different_exposure_meet_without_a_step(light: float) -> None:
    mosaic = Mosaic()
    put(mosaic, 0.0, 0.0)
    put(mosaic, 0.0, 16.0, light=light)
    shown, seen = whole(mosaic)
    true = true_picture()
    ratio = shown[..., 0].astype(float) / true[..., 0]
    means = [ratio[at(0, east, 1.5)].mean() for east in np.arange(2.0, 14.0, 1.0)]
    assert seen[at(0, 8, 7)].all()
    assert max(abs(np.diff(means))) < 0.02, "of 20 % that they differ"


@pytest.mark.slow
def test_the_view_from_straight_above_wins_whatever_the_order() -> None:
    true = true_picture()
    for order in ((0, 1), (1, 0)):
        mosaic, places = Mosaic(), (0.0, 14.0)
        for i in order:
            put(mosaic, 0.0, places[i], off=(0.0, 0.3)[i])
        shown = whole(mosaic)[0].astype(int)
        near = [np.abs(np.roll(shown, -cells, axis=1)[at(0, 0, 3)] - true[at(0, 0, 3)]).mean() for cells in (0, 3)]
        assert near[0] < near[1], "the pixels about the first place are those of its own picture"


@pytest.mark.slow
def test_the_sharp_detail_of_the_best_view_survives_another_one_beside_it() -> None:
    alone, both = Mosaic(), Mosaic()
    put(alone, 0.0, 0.0)
    put(both, 0.0, 0.0)
    put(both, 0.0, 9.0, off=0.2)
    for place in ((0.0, -2.0), (0.0, 12.0)):
        first = detail(whole(both)[0][at(*place)])
        assert first > 0.9 * detail(whole(alone)[0][at(*place)])


@pytest.mark.slow
@pytest.mark.parametrize("order", [(35.0, 110.0), (110.0, 35.0)])
def test_a_picture_from_higher_up_does_not_blur_a_lower_one(order: tuple[float, float]) -> None:
    alone, both = Mosaic(), Mosaic()
    put(alone, 0.0, 0.0)
    for height in order:
        put(both, 0.0, 0.0, height=height)
    sharp, found = (detail(whole(mosaic)[0][at(0, 0, 6)]) for mosaic in (alone, both))
    assert found > 0.9 * sharp


def test_a_picture_that_is_off_is_moved_towards_what_is_shown() -> None:
    mosaic, true = Mosaic(), true_picture()
    put(mosaic, 0.0, 0.0)
    put(mosaic, 0.0, 16.0, off=0.4)
    shown = whole(mosaic)[0]

    def off(east: float) -> float:
        one, other = (cv2.cvtColor(p[at(0, east, 4)], cv2.COLOR_BGR2GRAY).astype(np.float32) for p in (true, shown))
        return cv2.phaseCorrelate(one, other, cv2.createHanningWindow((80, 80), cv2.CV_32F))[0][0] / 10

    assert abs(off(0.0)) < 0.05
    assert 0.1 < off(17.0) < 0.3, "half of what the pose says stays"


def test_a_frame_that_brings_nothing_new_changes_nothing() -> None:
    mosaic = Mosaic()
    put(mosaic, 0.0, 0.0)
    while mosaic.encode(9, 1):
        pass
    put(mosaic, 0.0, 0.0, light=1.1)
    assert not mosaic.encode(9, 2)


@pytest.mark.slow
def test_a_picture_is_blended_a_few_tiles_at_a_time_with_the_same_result() -> None:
    at_once, by_and_by = Mosaic(), Mosaic()
    for east in (0.0, 9.0, 18.0):
        put(at_once, 0.0, east)
        by_and_by.add(shot(0.0, east), (0.0, east), 35.0, 1)
    before = whole(by_and_by)[1].sum()
    assert before < whole(at_once)[1].sum()
    assert by_and_by.go_on(1)
    while by_and_by.go_on(2):
        pass
    assert all(np.array_equal(one, other) for one, other in zip(whole(at_once), whole(by_and_by), strict=True))


def test_encoding_is_bounded_and_the_backlog_comes_round() -> None:
    mosaic = Mosaic()
    mosaic.add(picture(0.0, 0.0, 150), (0.0, 0.0), 35.0)
    assert mosaic.encode(1, 1)
    assert len(mosaic.encoded) == 1
    for _ in range(3):
        mosaic.encode(1, 2)
    assert len(mosaic.encoded) == 4
    assert not mosaic.encode(1, 3)


@pytest.mark.slow
def test_tiles_far_behind_rest_as_jpeg_and_wake_unchanged() -> None:
    mosaic = Mosaic()
    for step in range(0, 800, 20):
        mosaic.add(picture(-12.8, float(step), 150), (-12.8, float(step)), 35.0)
        while mosaic.encode(4, step):
            pass
    assert mosaic.loaded <= 24
    mosaic.add(picture(-12.8, 12.8, 90), (-12.8, 12.8), 30.0)
    while mosaic.encode(4, 999):
        pass
    assert abs(int(pixels(mosaic.encoded[0, 0])[128, 30]) - 150) < 8


def test_a_restored_tile_is_the_same_picture_and_is_improved_upon_by_any_new_look() -> None:
    first, again = Mosaic(), Mosaic()
    put(first, 0.0, 3.0, off=0.0)
    before, seen = whole(first)
    for key, tile in first.encoded.items():
        again.restore(key, 7, tile.data)
        assert again.encoded[key] == EncodedTile(7, tile.data)
    assert all(np.array_equal(one, other) for one, other in zip((before, seen), whole(again), strict=True))
    put(again, 0.0, 11.0)
    assert again.encode(9, 8)
    shown = whole(again)[0]
    assert not np.array_equal(shown[at(0, 3)], before[at(0, 3)])


def test_a_tile_of_an_earlier_release_is_restored_without_its_black() -> None:
    old = np.full((TILE_CELLS, TILE_CELLS, 3), 140, np.uint8)
    old[:, 100:] = 0
    old[40:85, 40:58] = 0
    mosaic = Mosaic()
    mosaic.restore((0, 0), 3, cv2.imencode(".jpg", old, (cv2.IMWRITE_JPEG_QUALITY, 82))[1].tobytes())
    shown, seen = decode_picture(mosaic.encoded[0, 0].data)
    assert (seen[:, 110:].max(), seen[:, :92].min()) == (0, 255), "a black car in it was seen"
    assert shown[:, 110:].min() > 100
    mosaic.add(picture(-12.8, 19.0, 140), (-12.8, 19.0), 35.0)
    mosaic.encode(9, 4)
    assert decode_picture(mosaic.encoded[0, 0].data)[1][128, 90:250].all()


@pytest.mark.parametrize("data", [b"", b"no picture", cv2.imencode(".jpg", np.zeros((8, 8, 3), np.uint8))[1].tobytes()])
def test_what_is_no_tile_is_refused(data: bytes) -> None:
    with pytest.raises(ValueError, match="not a picture"):
        Mosaic().restore((0, 0), 1, data)


def test_a_picture_without_valid_parts_changes_nothing() -> None:
    mosaic, image = Mosaic(), picture(0, 0, 1)
    mosaic.add(GroundImage(image.values, image.to_map, np.zeros((200, 300), np.bool_)), (0.0, 0.0), 35.0)
    assert not mosaic.encode(9, 1)


def test_nearest_first() -> None:
    assert nearest_first([(5, 5), (0, 0), (1, 0)], -12.8, 12.8)[0] == (0, 0)
    assert TILE_CELLS == 256

"""Ground that nobody may look at: nothing of it is left in what is shown, mapped or recorded of a frame."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from hawk.algo.frame import FrameInput
from hawk.algo.vision.detection import VisionResult
from hawk.algo.vision.private_ground import hidden, recorded_jpeg
from hawk.algo.vision.rectify import ground_footprint, project
from hawk.model.pictures import CameraModel
from hawk.model.poses import MapPose, Ring
from tests.examples import examples
from tests.unit.algo.synthetic import SyntheticVision, frame_at, pose_at, rows_lot

GARDEN: Ring = ((-9.0, -8.0), (-9.0, 4.0), (5.0, 4.0), (5.0, -8.0))
"""With stalls of one row in it."""
LENS = CameraModel(1280, 720, 914.0, 914.0, 639.5, 359.5, distortion=(-0.08, 0.02, 0, 0, 0))


def frame(*rings: Ring, pose: MapPose | None = None) -> FrameInput:
    return replace(frame_at(pose or pose_at(0.0, 0.0, 0.0), 1, jpeg=b"whole"), private=rings)


def seen(asked: FrameInput) -> VisionResult:
    found = SyntheticVision(rows_lot(), with_picture=True).see(asked)
    assert found.image is not None
    return replace(found, image=np.full_like(found.image, 200))


def test_nothing_changes_where_there_is_no_private_ground_or_none_in_the_picture() -> None:
    for asked in (frame(), frame(((900.0, 0.0), (900.0, 9.0), (909.0, 9.0)))):
        whole = seen(asked)
        assert hidden(whole, asked) is whole
        assert recorded_jpeg(asked, whole, whole) is None


def test_the_picture_is_black_there_and_as_it_was_beside() -> None:
    asked = frame(GARDEN)
    whole = seen(asked)
    masked = hidden(whole, asked)
    assert masked.image is not None
    assert whole.image is not None
    assert (whole.image == 200).all(), "the picture that the witnesses compare stays whole"
    shown = np.array([(-10.5, -2.0), (7.0, -2.0), (0.0, -10.0), (0.0, 6.0)])
    inside = np.array([(0.0, -2.0), (-5.5, -7.5), (4.5, 3.5)])
    assert asked.pose is not None
    for places, level in ((inside, 0), (shown, 200)):
        for column, row in np.rint(project(places, asked.camera, asked.pose)).astype(int):
            assert masked.image[row, column].tolist() == [level] * 3


def test_no_stall_and_no_evidence_is_left_and_the_ground_counts_as_seen_without_a_lot() -> None:
    asked = frame(GARDEN)
    whole = seen(asked)
    masked = hidden(whole, asked)
    assert whole.ground is not None
    assert masked.ground is not None
    area = shapely.Polygon(GARDEN)
    left = [stall for stall in masked.ground.stalls if area.contains(shapely.Point(stall.north, stall.east))]
    assert (left, 0 < len(masked.ground.stalls) < len(whole.ground.stalls)) == ([], True)
    for layer in (masked.ground.lot, masked.ground.car, masked.ground.core, masked.ground.taken):
        columns, rows = np.meshgrid(np.arange(layer.valid.shape[1]), np.arange(layer.valid.shape[0]))
        places = layer.map_points(np.stack([columns, rows], -1).astype(np.float64))
        inside = shapely.contains_xy(area.buffer(-0.3), places[..., 0], places[..., 1])
        assert inside.any()
        assert layer.valid[inside].all()
        assert not layer.values[inside].any()
    picture = masked.ground.picture
    at = np.rint(picture.pixel_points(np.array([(0.0, -2.0)]))).astype(int)[0]
    assert not picture.valid[at[1], at[0]]
    assert not picture.values[at[1], at[0]].any()
    assert whole.ground.picture.valid[at[1], at[0]]


def test_what_is_recorded_is_the_masked_picture_and_nothing_where_the_place_is_not_sure() -> None:
    asked = frame(GARDEN)
    whole = seen(asked)
    jpeg = recorded_jpeg(asked, whole, hidden(whole, asked))
    assert jpeg is not None
    image = np.asarray(cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR), np.uint8)
    assert 0.1 < np.mean(np.max(image, axis=2) < 20) < 0.9
    lost = replace(asked, pose=None)
    assert recorded_jpeg(lost, whole, hidden(whole, lost)) == b""
    doubted = replace(asked, map_problem="the position is doubted")
    assert recorded_jpeg(doubted, whole, hidden(whole, doubted)) == b""
    broken = replace(whole, image=None)
    assert recorded_jpeg(asked, broken, hidden(broken, asked)) == b""
    assert recorded_jpeg(replace(lost, private=()), whole, whole) is None


@settings(max_examples=examples(60))
@given(
    north=st.floats(-15, 15), east=st.floats(-15, 15), height=st.floats(8, 60), yaw=st.floats(-3.1, 3.1),
    roll=st.floats(-0.4, 0.4), pitch=st.floats(-0.4, 0.4),
)  # fmt: skip
def test_no_pixel_shows_private_ground_from_anywhere(
    north: float, east: float, height: float, yaw: float, roll: float, pitch: float
) -> None:
    pose = MapPose(north, east, height, roll, pitch, yaw)
    asked = replace(frame(GARDEN, pose=pose), camera=LENS)
    image: NDArray[np.uint8] = np.full((720, 1280, 3), 200, np.uint8)
    masked = hidden(VisionResult(image=image), asked).image
    assert masked is not None
    places = np.stack(np.meshgrid(np.linspace(-8.9, 4.9, 12), np.linspace(-7.9, 3.9, 12)), -1).reshape(-1, 2)
    corners = shapely.MultiPoint([(c.north, c.east) for c in ground_footprint(LENS, pose)]).convex_hull
    places = places[shapely.contains_xy(corners, places)]
    pixels = np.rint(project(places, LENS, pose))
    inside = (pixels >= 0).all(1) & (pixels < (1280, 720)).all(1)
    for column, row in pixels[inside].astype(int):
        assert not masked[row, column].any()


def test_a_ring_that_crosses_itself_is_hidden_too() -> None:
    bow: Ring = ((-4.0, -4.0), (4.0, 4.0), (4.0, -4.0), (-4.0, 4.0))
    asked = frame(bow)
    masked = hidden(seen(asked), asked).image
    assert masked is not None
    assert asked.pose is not None
    ((column, row),) = np.rint(project(np.array([(3.0, 0.0)]), asked.camera, asked.pose)).astype(int)
    assert masked[row, column].tolist() == [0, 0, 0]


@pytest.mark.parametrize("height", [0.0, float("nan")])
def test_a_pose_on_the_ground_or_that_is_none_breaks_nothing(height: float) -> None:
    asked = frame(GARDEN, pose=replace(pose_at(0.0, 0.0, 0.0), height=height))
    whole = VisionResult(image=np.full((720, 1280, 3), 200, np.uint8))
    assert hidden(whole, asked) is whole

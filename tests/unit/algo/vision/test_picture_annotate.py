from __future__ import annotations

import math
from dataclasses import replace

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from hawk.algo.vision.detection import Detection
from hawk.algo.vision.picture import FREE_BGR, TAKEN_BGR, UNKNOWN_BGR, PictureStyle, annotate, state_of
from hawk.algo.vision.rectify import project, scaled_camera
from hawk.model.lot_map import Stall, StallState
from hawk.model.pictures import CameraModel
from hawk.model.poses import MapPose

F = 640 / math.tan(math.radians(35))
CAMERA = CameraModel(1280, 720, F, F, 639.5, 359.5, distortion=(-0.05, 0.01, 0, 0, 0))
POSE = MapPose(100, 50, 20, 0.05, -0.05, 1.0)
GROUND = np.full((720, 1280, 3), 90, np.uint8)
STALL = Stall(7, 100, 50, 0.4, 2.6, 5.2, 0.1, StallState.FREE, 0.9, 3, 1.0, 1)


def decoded(jpeg: bytes) -> NDArray[np.int16]:
    return np.asarray(cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)).astype(np.int16)


def drawn(*stalls: Stall | Detection, pose: MapPose | None = POSE, width: int = 960) -> NDArray[np.int16]:
    jpeg = annotate(GROUND, CAMERA, pose, stalls, style=PictureStyle(maximum_width=width, quality=95))
    return decoded(jpeg)


def pixel(north: float, east: float) -> tuple[int, int]:
    column, row = project(np.array([north, east]), scaled_camera(CAMERA, 960, 540), POSE)
    return round(row), round(column)


def test_the_picture_is_at_most_960_wide_and_keeps_its_shape() -> None:
    assert drawn().shape == (540, 960, 3)
    assert drawn(width=2000).shape == (720, 1280, 3)


def test_a_free_stall_is_filled_in_blue_where_it_is() -> None:
    picture = drawn(STALL)
    ahead = np.array([math.cos(0.4), math.sin(0.4)])
    inside = picture[pixel(*(100 + ahead[0] * 1.8, 50 + ahead[1] * 1.8))]
    assert inside[0] > 120 > inside[2]
    outside = picture[pixel(*(100 + ahead[0] * 4, 50 + ahead[1] * 4))]
    assert np.abs(outside - 90).max() < 12
    corner = STALL.corners()
    edge = picture[pixel(*((corner[0] + corner[3]) / 2))]
    assert np.abs(edge - FREE_BGR).max() < 100


def test_the_states_look_different_without_colour() -> None:
    shares = {StallState.FREE: 0.1, StallState.TAKEN: 0.9, StallState.UNKNOWN: 0.5}
    seen = {s: Detection(100, 50, 0.4, 2.6, 5.2, 0.9, taken, 1.0) for s, taken in shares.items()}
    pictures = {s: drawn(seen[s]).mean(axis=2) for s in shares}
    changed = {s: np.abs(p - 90) > 15 for s, p in pictures.items()}
    assert changed[StallState.UNKNOWN].sum() < 0.6 * changed[StallState.FREE].sum()  # dashes, no fill
    top, left = pixel(100, 50)
    spread = {s: pictures[s][top - 20 : top + 20, left - 20 : left + 20].std() for s in shares}
    assert spread[StallState.TAKEN] > 2 * spread[StallState.FREE]  # hatching


def test_a_stall_of_one_frame_is_shown_by_its_probability() -> None:
    seen = Detection(100, 50, 0.4, 2.6, 5.2, 0.9, 0.1, 1.0)
    states = [state_of(replace(seen, taken=t)) for t in (0.0, 0.35, 0.5, 0.65, 1.0)]
    assert states == ["free", "free", "unknown", "taken", "taken"]
    assert np.abs(drawn(seen)[pixel(101.5, 50.6)] - 90).max() > 20


@pytest.mark.parametrize(
    "pose",
    [None, MapPose(math.nan, 0, 20, 0, 0, 0), MapPose(100, 50, -1, 0, 0, 0), MapPose(100, 50, 20, math.pi, 0, 0)],
)
def test_without_a_usable_pose_the_bare_picture_is_sent(pose: MapPose | None) -> None:
    assert np.abs(drawn(STALL, pose=pose) - 90).max() < 6


def test_a_suggested_stall_is_on_the_map_only() -> None:
    assert np.abs(drawn(replace(STALL, state=StallState.SUGGESTED)) - 90).mean() < 1


def test_stalls_beside_and_behind_the_camera_do_no_harm() -> None:
    far = [replace(STALL, north=100 + d, east=50 - d) for d in (-1e6, -200, 30, 1e5)]
    flat = MapPose(100, 50, 20, 0, 1.3, 0)
    assert annotate(GROUND, CAMERA, flat, far)
    assert np.abs(drawn(*far) - 90).max() < 6


def test_the_palette_is_the_design_s() -> None:
    assert (FREE_BGR, TAKEN_BGR, UNKNOWN_BGR) == ((0xFF, 0x8F, 0x2F), (0x1A, 0x7A, 0xFF), (255, 255, 255))


def test_the_given_picture_is_left_alone() -> None:
    image = GROUND[:500, :800].copy()
    annotate(image, CAMERA, POSE, [STALL])
    assert (image == 90).all()


def test_a_simulated_picture_says_so_even_without_a_pose() -> None:
    plain = decoded(annotate(GROUND, CAMERA, None))
    said = decoded(annotate(GROUND, CAMERA, None, style=PictureStyle(caption="SIMULATION")))
    changed = np.abs(plain - said).max(axis=2) > 60
    rows, columns = np.nonzero(changed)
    assert rows.size > 300
    assert rows.max() < 40
    assert columns.min() > plain.shape[1] - 160

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from hawk.algo.vision.detection import FloatArray, GroundImage
from hawk.algo.vision.rectify import MAXIMUM_PIXELS, Rectifier, RectifyError, project
from hawk.model.pictures import CameraModel
from hawk.model.poses import MapPose

F = 640 / math.tan(math.radians(35))
CAMERA = CameraModel(1280, 720, F, F, 639.5, 359.5)
LENS = CameraModel(1280, 720, F, F, 650.0, 350.0, distortion=(-0.12, 0.03, 0.001, -0.002, 0.0))
angles = st.floats(-0.25, 0.25)
poses = st.builds(
    MapPose, st.floats(-200, 200), st.floats(-200, 200), st.floats(8, 60), angles, angles, st.floats(-4, 4)
)


def rectify(image: NDArray[np.uint8], camera: CameraModel, pose: MapPose) -> GroundImage:
    return Rectifier().rectify(image, camera, pose)


def quaternion_turn(vector: FloatArray, axis: tuple[float, float, float], angle: float) -> FloatArray:
    """Rodrigues' formula: turns a vector about an axis; shares nothing with the matrices under test."""
    k = np.array(axis)
    turned = vector * math.cos(angle) + np.cross(k, vector) * math.sin(angle) + k * (k @ vector) * (1 - math.cos(angle))
    return np.asarray(turned)


def independent_pixel(point: FloatArray, camera: CameraModel, pose: MapPose) -> FloatArray:
    """Return a ground point's place in the picture: undo yaw, pitch and roll in turn, then the mount, then the lens."""
    ray = np.array([point[0] - pose.north, point[1] - pose.east, pose.height])
    for yaw, pitch, roll in (
        (pose.yaw, pose.pitch, pose.roll),
        (camera.mount_yaw, camera.mount_pitch, camera.mount_roll),
    ):
        ray = quaternion_turn(ray, (0, 0, 1), -yaw)
        ray = quaternion_turn(ray, (0, 1, 0), -pitch)
        ray = quaternion_turn(ray, (1, 0, 0), -roll)
    forward, right, down = ray
    distortion = np.array(camera.distortion or (0.0,) * 5)
    matrix = np.array([[camera.fx, 0, camera.cx], [0, camera.fy, camera.cy], [0, 0, 1]])
    pixel, _ = cv2.projectPoints(np.array([[right, -forward, down]]), np.zeros(3), np.zeros(3), matrix, distortion)
    return np.asarray(pixel, float).ravel()


def spot(camera: CameraModel, at: FloatArray) -> NDArray[np.uint8]:
    image = np.zeros((camera.height, camera.width, 3), np.uint8)
    cv2.circle(image, (round(at[0] * 16), round(at[1] * 16)), 6 * 16, (255, 255, 255), -1, cv2.LINE_AA, 4)
    return image


@pytest.mark.nightly
@given(poses, st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.sampled_from([CAMERA, LENS]))
@settings(max_examples=25)
def test_a_ground_point_lands_where_an_independent_projection_says(
    pose: MapPose, ahead: float, aside: float, camera: CameraModel
) -> None:
    truth = np.array([pose.north + ahead * pose.height * 0.4, pose.east + aside * pose.height * 0.4])
    at = independent_pixel(truth, camera, pose)
    if not (20 < at[0] < camera.width - 20 and 20 < at[1] < camera.height - 20):
        return
    ground = rectify(spot(camera, at), camera, pose)
    weight = ground.values[..., 0].astype(float)
    rows, columns = np.indices(weight.shape)
    centre = np.array([(columns * weight).sum(), (rows * weight).sum()]) / weight.sum()
    # a disc in the picture is not quite one on tilted ground: its middle moves by a little of its size
    assert np.hypot(*(ground.map_points(centre) - truth)) < 0.08 + 0.004 * pose.height


@pytest.mark.slow
@given(poses, st.floats(-20, 20), st.floats(-20, 20), angles, angles, angles)
@settings(max_examples=60)
def test_project_agrees_with_the_independent_formula(
    pose: MapPose, north: float, east: float, roll: float, pitch: float, yaw: float
) -> None:
    camera = CameraModel(1280, 720, F, F, 650.0, 350.0, (-0.12, 0.03, 0.001, -0.002, 0.0), roll, pitch, yaw)
    point = np.array([pose.north + north * pose.height / 40, pose.east + east * pose.height / 40])
    expected = independent_pixel(point, camera, pose)
    np.testing.assert_allclose(project(point, camera, pose), expected, atol=1e-6 * max(1, *np.abs(expected)))


def test_the_picture_s_top_is_ahead_and_its_right_is_right() -> None:
    image = np.zeros((720, 1280, 3), np.uint8)
    image[:40] = (0, 0, 255)
    image[:, -40:] = (0, 255, 0)
    ground = rectify(image, CAMERA, MapPose(10, 20, 30, 0, 0, math.pi / 2))  # nose east
    top = ground.map_points(np.array([ground.values.shape[1] / 2, 2.0]))
    right = ground.map_points(np.array([ground.values.shape[1] - 3.0, ground.values.shape[0] / 2]))
    assert top[1] > 20 + 10
    assert abs(top[0] - 10) < 0.2
    assert right[0] < 10 - 15
    assert ground.values[2, 100, 2] > 200
    assert ground.values[100, -3, 1] > 200


def test_a_point_outside_the_view_is_not_valid_and_black() -> None:
    pose = MapPose(0, 0, 30, 0.12, 0.1, 0.7)
    ground = rectify(np.full((720, 1280, 3), 200, np.uint8), CAMERA, pose)
    rows, columns = np.indices(ground.valid.shape)
    pixels = project(ground.map_points(np.stack([columns, rows], -1).astype(float)), CAMERA, pose)
    inside = (pixels > 1).all(-1) & (pixels[..., 0] < 1278) & (pixels[..., 1] < 718)
    outside = (pixels < -1.5).any(-1) | (pixels[..., 0] > 1280.5) | (pixels[..., 1] > 720.5)
    assert ground.valid[inside].all()
    assert not ground.valid[outside].any()
    assert (ground.values[~ground.valid] == 0).all()
    assert ground.valid.mean() > 0.5


def test_the_raster_is_bounded_and_below_the_drone_when_very_high() -> None:
    ground = rectify(np.full((720, 1280, 3), 90, np.uint8), CAMERA, MapPose(5, -7, 300, 0, 0, 1.0))
    assert (ground.values.shape[1], ground.values.shape[0]) == MAXIMUM_PIXELS
    middle = ground.map_points((np.array(MAXIMUM_PIXELS) - 1.0) / 2)
    np.testing.assert_allclose(middle, (5, -7), atol=0.1)


def test_flat_rays_are_left_out() -> None:
    ground = rectify(np.full((720, 1280, 3), 90, np.uint8), CAMERA, MapPose(0, 0, 20, 0, 0.8, 0))
    rows, columns = np.nonzero(ground.valid)
    away = np.hypot(*ground.map_points(np.stack([columns, rows], -1).astype(float)).T)
    assert away.max() < 20 * math.tan(math.radians(58)) + 0.2


def test_a_smaller_picture_of_the_same_view_gives_the_same_ground() -> None:
    pose = MapPose(3, 4, 40, 0.1, -0.05, 2.0)
    rng = np.random.default_rng(0)
    coarse = rng.integers(0, 255, (18, 32, 3), np.uint8)
    image = np.asarray(cv2.resize(coarse, (1280, 720), interpolation=cv2.INTER_CUBIC), np.uint8)
    half = np.asarray(cv2.resize(image, (640, 360), interpolation=cv2.INTER_AREA), np.uint8)
    a, b = rectify(image, CAMERA, pose), rectify(half, CAMERA, pose)
    np.testing.assert_allclose(a.to_map, b.to_map, atol=1e-6)
    both = a.valid & b.valid
    assert np.abs(a.values[both].astype(float) - b.values[both]).mean() < 3


@pytest.mark.slow
def test_the_lens_correction_is_kept_and_follows_the_camera() -> None:
    keeper = Rectifier()
    pose = MapPose(0, 0, 30, 0, 0, 0)
    image = np.random.default_rng(1).integers(0, 255, (720, 1280, 3), np.uint8)
    for camera in (LENS, CAMERA, LENS):
        np.testing.assert_array_equal(keeper.rectify(image, camera, pose).values, rectify(image, camera, pose).values)


@pytest.mark.parametrize(
    ("pose", "words"),
    [
        (MapPose(0, 0, math.nan, 0, 0, 0), "not finite"),
        (MapPose(math.inf, 0, 30, 0, 0, 0), "not finite"),
        (MapPose(0, 0, 0.0, 0, 0, 0), "above the ground"),
        (MapPose(0, 0, -3, 0, 0, 0), "above the ground"),
        (MapPose(0, 0, 30, math.pi, 0, 0), "horizon"),
        (MapPose(0, 0, 1.0, 0, 0, 0), "too low"),
    ],
)
def test_poses_that_show_no_ground_are_refused_with_the_reason(pose: MapPose, words: str) -> None:
    with pytest.raises(RectifyError, match=words):
        rectify(np.zeros((720, 1280, 3), np.uint8), CAMERA, pose)


def test_a_grey_picture_is_refused() -> None:
    with pytest.raises(RectifyError, match="BGR"):
        rectify(np.zeros((720, 1280), np.uint8), CAMERA, MapPose(0, 0, 30, 0, 0, 0))


@pytest.mark.parametrize("camera", [CAMERA, LENS])
@pytest.mark.parametrize("height", [15.0, 35.0, 60.0])
def test_the_camera_s_own_picture_shows_a_ground_point_at_its_place(camera: CameraModel, height: float) -> None:
    pose, point = MapPose(10.0, -20.0, height, 0.05, -0.08, 0.7), np.array([12.0, -18.0])
    image = np.zeros((720, 1280, 3), np.uint8)
    column, row = np.round(project(point, camera, pose)).astype(int)
    cv2.circle(image, (int(column), int(row)), 4, (255, 255, 255), -1)
    view = rectify(image, camera, pose).view
    assert view is not None
    x, y, depth = view.to_image @ (*point, 1.0)
    rows, columns = np.nonzero(view.image[..., 0] > 100)
    assert (columns.mean(), rows.mean()) == pytest.approx((x / depth, y / depth), abs=1.0)

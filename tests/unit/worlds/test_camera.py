import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.model.pictures import CameraModel
from hawk.worlds.camera import Lens, WorldCamera
from hawk.worlds.scene.facets import HeightLayer, flat_layer
from hawk.worlds.world import World

CAMERA = CameraModel(320, 180, 230.0, 230.0, 159.5, 89.5)
CLEAN = Lens(blur=0, noise=0, vignette=0)
ANGLES = st.floats(-0.4, 0.4)


def _rng() -> np.random.Generator:
    return np.random.default_rng(0)


def _world(**changes: object) -> World:
    ground = np.full((400, 600, 3), 90, np.uint8)
    fields: dict[str, object] = {"name": "plain", "metres_per_pixel": 0.1, "ground": ground, **changes}
    return World(**fields)  # type: ignore[arg-type]


def _marked(x: float, y: float, colour: tuple[int, int, int] = (0, 0, 255)) -> World:
    world = _world()
    column, row = round(x / 0.1), round(y / 0.1)
    world.ground[row - 3 : row + 3, column - 3 : column + 3] = colour
    return world


def _red_centre(frame: np.ndarray) -> np.ndarray:
    rows, columns = np.nonzero((frame[..., 2] > 180) & (frame[..., 0] < 60))
    assert len(rows), "the mark is not in the picture"
    return np.array([columns.mean(), rows.mean()])


def _by_hand(point: np.ndarray, place: np.ndarray, roll: float, pitch: float, yaw: float) -> np.ndarray:
    """Project (x east, y south, z up) by successive turns, independently of the camera's matrices."""
    north, east, down = -(point[1] - place[1]), point[0] - place[0], -(point[2] - place[2])
    front, right = (
        north * math.cos(yaw) + east * math.sin(yaw),
        -north * math.sin(yaw) + east * math.cos(yaw),
    )
    front, down = front * math.cos(pitch) - down * math.sin(pitch), front * math.sin(pitch) + down * math.cos(pitch)
    right, down = right * math.cos(roll) + down * math.sin(roll), -right * math.sin(roll) + down * math.cos(roll)
    return np.array([CAMERA.cx + CAMERA.fx * right / down, CAMERA.cy - CAMERA.fy * front / down])


@pytest.mark.slow
def test_level_north_up_picture() -> None:
    world = _marked(35.0, 12.0)  # 5 m east and 8 m north of the drone
    frame = WorldCamera(world, CAMERA, CLEAN).render(30.0, 20.0, 25.0, 0, 0, 0, rng=_rng())
    expected = (CAMERA.cx + 230 * 5 / 25, CAMERA.cy - 230 * 8 / 25)
    assert _red_centre(frame) == pytest.approx(expected, abs=0.6)


@pytest.mark.slow
def test_yaw_turns_the_nose_to_the_east() -> None:
    world = _marked(36.0, 20.0)  # 6 m east
    frame = WorldCamera(world, CAMERA, CLEAN).render(30.0, 20.0, 25.0, 0, 0, math.pi / 2, rng=_rng())
    assert _red_centre(frame) == pytest.approx((CAMERA.cx, CAMERA.cy - 230 * 6 / 25), abs=0.6)


@pytest.mark.slow
def test_nose_up_looks_ahead_and_right_side_down_looks_left() -> None:
    camera = WorldCamera(_marked(30.0, 20.0), CAMERA, CLEAN)
    nose_up = _red_centre(camera.render(30.0, 20.0, 25.0, 0, 0.2, 0, rng=_rng()))
    rolled_right = _red_centre(camera.render(30.0, 20.0, 25.0, 0.2, 0, 0, rng=_rng()))
    assert nose_up[1] == pytest.approx(CAMERA.cy + 230 * math.tan(0.2), abs=0.8)
    assert rolled_right[0] == pytest.approx(CAMERA.cx + 230 * math.tan(0.2), abs=0.8)


@settings(max_examples=60)
@given(ANGLES, ANGLES, st.floats(-7, 7), st.floats(-8, 8), st.floats(-8, 8), st.floats(0, 5))
def test_projection_agrees_with_independent_formula(
    roll: float, pitch: float, yaw: float, dx: float, dy: float, z: float
) -> None:
    camera = _PLAIN
    place, point = np.array([30.0, 20.0, 25.0]), np.array([30.0 + dx, 20.0 + dy, z])
    image = camera.projection(30.0, 20.0, 25.0, roll, pitch, yaw) @ [*point, 1.0]
    assert image[2] > 0
    assert image[:2] / image[2] == pytest.approx(_by_hand(point, place, roll, pitch, yaw), abs=1e-6)


@pytest.mark.slow
def test_high_things_lean_away_from_the_middle() -> None:
    pixels = np.zeros((20, 20, 4), np.uint8)
    pixels[..., 2:] = 255
    layer = flat_layer(pixels, (40.0, 20.0), 0.3, (2.0, 2.0), 5.0, "car")
    camera = WorldCamera(_world(layers=(layer,)), CAMERA, CLEAN)
    frame = camera.render(30.0, 20.0, 25.0, 0, 0, 0, rng=_rng())
    assert _red_centre(frame) == pytest.approx((CAMERA.cx + 230 * 10 / 20, CAMERA.cy), abs=0.6)


@pytest.mark.nightly
def test_edges_are_not_darkened() -> None:
    pixels = np.full((10, 10, 4), 90, np.uint8)
    pixels[..., 3] = 255
    layer = flat_layer(pixels, (31.0, 21.0), 0.4, (3.0, 3.0), 1.0, "car")
    camera = WorldCamera(_world(layers=(layer,)), CAMERA, CLEAN)
    assert (camera.render(30.0, 20.0, 12.3, 0.1, 0.05, 0.3, rng=_rng()) == 90).all()
    assert (camera.render(0.0, 20.0, 12.3, 0.1, 0.05, 0.3, rng=_rng()) == 90).all()  # over the world's edge too


@pytest.mark.slow
def test_a_wall_is_seen_from_its_side() -> None:
    wall = np.array([[35.0, 15.0, 4.0], [35.0, 25.0, 4.0], [35.0, 25.0, 0.0], [35.0, 15.0, 0.0]])
    red = HeightLayer(wall, np.array([[[0, 0, 255, 255]]], np.uint8), "wall")
    camera = WorldCamera(_world(layers=(red,)), CAMERA, CLEAN)
    columns = _red_columns(camera.render(30.0, 20.0, 20.0, 0, 0, 0, rng=_rng()))
    assert columns[0] == pytest.approx(CAMERA.cx + 230 * 5 / 20, abs=1.5)  # its foot
    assert columns[1] == pytest.approx(CAMERA.cx + 230 * 5 / 16, abs=1.5)  # its top leans outwards


def _red_columns(frame: np.ndarray) -> tuple[int, int]:
    columns = np.nonzero((frame[..., 2] > 180) & (frame[..., 0] < 60))[1]
    return int(columns.min()), int(columns.max())


@pytest.mark.slow
def test_fine_layers_are_left_out_from_afar_only() -> None:
    pixels = np.zeros((20, 20, 4), np.uint8)
    pixels[..., 2:] = 255
    layer = flat_layer(pixels, (30.0, 20.0), 0.0, (8.0, 8.0), 2.0, "tree", fine=True)
    camera = WorldCamera(_world(layers=(layer,)), CAMERA, CLEAN)
    near = camera.render(30.0, 20.0, 12.0, 0, 0, 0, rng=_rng())
    far = camera.render(30.0, 20.0, 40.0, 0, 0, 0, rng=_rng())
    assert (near[90, 160] == (0, 0, 255)).all()
    assert (far == 90).all()


@pytest.mark.slow
def test_layers_behind_and_outside_are_left_out() -> None:
    pixels = np.full((4, 4, 4), 255, np.uint8)
    above = flat_layer(pixels, (30.0, 20.0), 0.0, (8.0, 8.0), 40.0, "roof")
    outside = flat_layer(pixels, (300.0, 20.0), 0.0, (2.0, 2.0), 1.0, "car")
    camera = WorldCamera(_world(layers=(above, outside)), CAMERA, CLEAN)
    frame = camera.render(30.0, 20.0, 25.0, 0, 0, 0, rng=_rng())
    assert (frame == 90).all()


@pytest.mark.slow
def test_beyond_the_edge_lies_blurred_ground_without_marks() -> None:
    world = _world()
    world.ground[:, ::12] = 255  # lines like those of stalls, also at the edge
    camera = WorldCamera(world, CAMERA, CLEAN)
    inside = camera.render(30.0, 20.0, 15.0, 0, 0, 0, rng=_rng())
    outside = camera.render(-12.0, 20.0, 15.0, 0, 0, 0, rng=_rng())
    assert inside.std() > 20
    assert outside.std() < 3
    assert outside.mean() == pytest.approx(inside.mean(), abs=12)


@pytest.mark.slow
def test_far_beyond_the_edge_and_on_the_ground_there_is_still_a_picture() -> None:
    camera = WorldCamera(_world(), CAMERA)
    for pose in (
        (5000.0, -4000.0, 60.0, 0.0, 0.0, 1.0),
        (30.0, 20.0, -0.3, 0.0, 0.0, 0.0),
        (30.0, 20.0, 9.0, 3.0, 0.0, 0.0),
    ):
        frame = camera.render(*pose, rng=_rng())
        assert frame.shape == (180, 320, 3)
        assert frame.dtype == np.uint8


@pytest.mark.slow
def test_upside_down_it_sees_the_sky() -> None:
    camera = WorldCamera(_world(), CAMERA, CLEAN)
    frame = camera.render(30.0, 20.0, 9.0, math.pi, 0.0, 0.0, rng=_rng())
    assert (frame == (214, 200, 190)).all()


@pytest.mark.slow
def test_noise_comes_from_the_generator() -> None:
    camera = WorldCamera(_world(), CAMERA)
    pose = (30.0, 20.0, 20.0, 0.0, 0.0, 0.0)
    first = camera.render(*pose, rng=np.random.default_rng(3))
    again = camera.render(*pose, rng=np.random.default_rng(3))
    other = camera.render(*pose, rng=np.random.default_rng(4))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)
    assert 1.0 < first[80:100, 150:170].astype(float).std() < 4.0
    assert first[90, 160].mean() > first[2, 2].mean() + 5  # less light in the corners


_PLAIN = WorldCamera(_world(), CAMERA, CLEAN)

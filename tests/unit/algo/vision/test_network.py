from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.algo.vision import network as network_module
from hawk.algo.vision.detection import GroundImage
from hawk.algo.vision.detector import StallDetector
from hawk.algo.vision.network import CHANNELS, StallNetwork, maps_from_output, sun_input
from hawk.algo.vision.network_file import VisionModelError, packaged_weights
from hawk.algo.vision.rectify import Rectifier, ground_homography
from hawk.model.pictures import CameraModel
from hawk.model.poses import MapPose
from hawk.worlds.plan import SitePlan
from training.scenes import SITES, Scene, SceneStall, draw_scene
from training.sites import plan_any_lot_site

DATA = Path(__file__).parent / "data"
NORTH_UP = np.array([[0.0, -0.1, 0.0], [0.1, 0.0, 0.0]])


@pytest.fixture(scope="module")
def network() -> StallNetwork:
    return StallNetwork.load()


@pytest.fixture(scope="module")
def lot() -> Scene:
    """A drawn lot, 38 x 29 m: 20 stalls, free and taken, wholly in sight, on ground that the shipped weights know.

    A usual lot, whatever else trainings draw.
    """

    def usual(rng: np.random.Generator) -> SitePlan:
        rng.random()
        return plan_any_lot_site(rng, (0.0, 0.0), SITES[int(rng.integers(len(SITES)))])

    scene = draw_scene(np.random.default_rng((503, 15)), (288, 384), plan_site=usual)
    assert len(whole(scene)) >= 20
    assert 4 <= sum(stall.taken for stall in whole(scene)) <= 16
    return scene


def whole(lot: Scene) -> list[SceneStall]:
    """Return the stalls that can be seen wholly."""
    height, width = lot.image.shape[:2]
    return [
        stall
        for stall in lot.stalls
        if ((stall.quad > 2) & (stall.quad < (width - 2, height - 2))).all()
        and stall.covered < 0.2
        and stall.lines_visible
    ]


@pytest.mark.nightly
def test_the_shipped_network_finds_painted_stalls_and_the_cars_in_them(network: StallNetwork, lot: Scene) -> None:
    ground = GroundImage(lot.image, NORTH_UP, np.ones(lot.image.shape[:2], np.bool_))
    found = StallDetector(network).detect(ground)
    stalls = whole(lot)
    places = ground.map_points(np.array([stall.quad.mean(axis=0) for stall in stalls]))
    apart = np.array([[math.hypot(s.north - n, s.east - e) for s in found.stalls] for n, e in places])
    seen = apart.min(axis=1) < 0.8
    assert seen.mean() >= 0.85
    taken = np.array([found.stalls[j].taken > 0.5 for j in apart.argmin(axis=1)])
    real = np.array([stall.taken for stall in stalls])
    assert 0 < real.sum() < len(real)
    assert (taken == real)[seen].mean() >= 0.85


@pytest.mark.parametrize(("ground", "paint"), [(110, (235, 235, 235)), (140, (60, 190, 225)), (60, (200, 200, 200))])
def test_two_rows_on_plain_ground_are_found_without_anything_around_them(
    network: StallNetwork, ground: int, paint: tuple[int, int, int]
) -> None:
    image = np.full((500, 520, 3), ground, np.uint8)
    for top in (140, 300):
        for column in range(130, 391, 26):
            cv2.rectangle(image, (column - 1, top), (column, top + 52), paint, -1)
    found = StallDetector(network).detect(GroundImage(image, NORTH_UP, np.ones(image.shape[:2], np.bool_))).stalls
    middles = [(-(top + 26) / 10, (column + 13) / 10) for top in (140, 300) for column in range(130, 390, 26)]
    near = [min(math.hypot(s.north - north, s.east - east) for s in found) < 0.5 for north, east in middles]
    assert sum(near) >= 18
    assert all(stall.taken < 0.5 for stall in found)


def test_blank_ground_shows_no_stall(network: StallNetwork) -> None:
    rng = np.random.default_rng(1)
    image = np.clip(rng.normal(100, 6, (256, 320, 3)), 0, 255).astype(np.uint8)
    ground = GroundImage(image, NORTH_UP, np.ones(image.shape[:2], np.bool_))
    assert StallDetector(network).detect(ground).stalls == ()


@pytest.mark.parametrize("size", [(33, 47), (64, 96), (101, 130)])
def test_maps_cover_a_picture_of_any_size(network: StallNetwork, size: tuple[int, int]) -> None:
    maps = network.run(np.full((*size, 3), 80, np.uint8))
    assert maps.lot.shape == maps.taken.shape == (-(-size[0] // 2), -(-size[1] // 2))
    for values in (maps.lot, maps.core, maps.car, maps.taken):
        assert values.dtype == np.float32
        assert (values >= 0).all()
        assert (values <= 1).all()


@pytest.mark.slow
def test_what_lies_beyond_the_camera_s_view_never_votes(network: StallNetwork, lot: Scene) -> None:
    image = lot.image
    valid = np.ones(image.shape[:2], np.bool_)
    valid[:, :200] = False
    core = StallDetector(network).detect(GroundImage(image, NORTH_UP, valid)).core
    assert not core.values[:, :100].any()
    assert core.values[:, 110:].max() > 0.5


@pytest.mark.slow
def test_the_same_picture_twice_gives_the_same_maps(network: StallNetwork, lot: Scene) -> None:
    one, two = (network.run(lot.image) for _ in range(2))
    np.testing.assert_array_equal(one.core, two.core)


def test_a_lot_seen_from_a_tilted_camera_lies_where_it_is(network: StallNetwork, lot: Scene) -> None:
    focal = 640 / math.tan(math.radians(35))
    camera = CameraModel(1280, 720, focal, focal, 639.5, 359.5)
    pose = MapPose(-14.0, 19.0, 36.0, 0.08, -0.06, 0.5)
    onto = ground_homography(camera, pose)
    texture = onto @ np.vstack([NORTH_UP, [0, 0, 1]])
    border = (95, 95, 95)
    frame = cv2.warpPerspective(lot.image, texture, (1280, 720), borderMode=cv2.BORDER_CONSTANT, borderValue=border)
    found = StallDetector(network).detect(Rectifier().rectify(np.asarray(frame, np.uint8), camera, pose))
    quads = np.array([stall.quad for stall in whole(lot)]) @ NORTH_UP[:, :2].T + NORTH_UP[:, 2]
    in_frame = cv2.perspectiveTransform(quads.reshape(1, -1, 2), onto).reshape(-1, 4, 2)
    in_view = quads.mean(1)[((in_frame > 0) & (in_frame < (1280, 720))).all((1, 2))]
    seen = [s for s in found.stalls if s.visible > 0.9]
    apart = np.array([min(math.hypot(s.north - n, s.east - e) for s in seen) for n, e in in_view])
    assert (apart < 0.6).sum() >= 12
    assert (apart < 0.6).mean() >= 0.9


def test_outputs_become_probabilities_cells_and_metres() -> None:
    raw = np.zeros((12, 2, 3), np.float32)
    raw[0], raw[5], raw[6], raw[7], raw[8] = 100.0, 0.5, -0.25, math.log(0.5), 9.0
    maps = maps_from_output(raw)
    assert maps.lot[0, 0] == pytest.approx(1.0)
    assert maps.core[0, 0] == pytest.approx(0.5)
    assert (maps.offset_column[0, 0], maps.offset_row[0, 0]) == (5.0, -2.5)
    assert maps.width[0, 0] == pytest.approx(1.3)
    assert maps.length[0, 0] == pytest.approx(5.2 * math.e, rel=1e-5)  # limited
    assert maps.shade[0, 0] == maps.cover[0, 0] == pytest.approx(0.5)


def test_vehicles_are_said_once_for_two_by_two_cells_also_of_a_part_of_a_picture() -> None:
    raw = np.zeros((23, 8, 12), np.float32)
    coarse = np.arange(24, dtype=np.float32).reshape(4, 6) / 24
    raw[12], raw[15] = coarse.repeat(2, 0).repeat(2, 1), 0.4
    maps = maps_from_output(raw)
    assert maps.vehicles is not None
    assert maps.vehicles.core == pytest.approx(1 / (1 + np.exp(-coarse)))
    assert maps.vehicles.offset_column[0, 0] == pytest.approx(2.0)  # 4 cells of the stalls' maps
    part = maps.part(slice(2, 7), slice(4, 12))
    assert part.vehicles is not None
    assert part.core.shape == (5, 8)
    assert part.vehicles.core == pytest.approx(1 / (1 + np.exp(-coarse[1:4, 2:6])))


def test_the_sun_s_input_points_as_shadows_do_and_grows_with_their_length() -> None:
    assert sun_input(np.zeros(2)).tolist() == [0.0, 0.0]
    short, long = sun_input(np.array([0.3, -0.4])), sun_input(np.array([3.0, -4.0]))
    assert short / np.hypot(*short) == pytest.approx([0.6, -0.8])
    assert np.hypot(*short) == pytest.approx(math.tanh(0.25))
    assert np.hypot(*short) < np.hypot(*long) < 1


def test_a_network_that_does_not_say_shade_and_cover_says_none() -> None:
    maps = maps_from_output(np.zeros((CHANNELS, 32, 48), np.float32))
    assert maps.shade.shape == maps.cover.shape == maps.core.shape
    assert maps.shade.max() < 1e-6
    assert maps.cover.max() < 1e-6


def test_the_network_of_the_package_takes_the_sun_and_says_shade_and_cover(network: StallNetwork) -> None:
    picture = np.random.default_rng(2).integers(60, 200, (64, 96, 3), np.uint8)
    dark, lit = network.run(picture), network.run(picture, sun_input(np.array([1.0, 0.0])))
    assert 0 < lit.shade.max() < 1
    assert 0 < lit.cover.max() < 1
    assert not np.array_equal(dark.core, lit.core)


def test_a_network_with_another_answer_is_refused_with_the_setting_s_name() -> None:
    with pytest.raises(VisionModelError, match=r"vision\.model: .*wrong_answer\.onnx answers with shape .* is needed"):
        StallNetwork.load(DATA / "wrong_answer.onnx")


def test_a_file_that_is_no_network_is_refused(tmp_path: Path) -> None:
    for content in (b"", b"junk" * 100, packaged_weights()[:5000]):
        path = tmp_path / "model.onnx"
        path.write_bytes(content)
        with pytest.raises(VisionModelError, match=r"vision\.model"):
            StallNetwork.load(path)


def test_a_folder_is_no_network(tmp_path: Path) -> None:
    with pytest.raises(VisionModelError, match="cannot be read"):
        StallNetwork.load(tmp_path)


def test_the_weights_are_small_enough_to_ship() -> None:
    assert len(packaged_weights()) < 5_000_000


@given(st.integers(32, 2000))
def test_the_parts_of_a_picture_cover_it_once_with_a_margin(side: int) -> None:
    parts = network_module._parts(side)
    assert parts[0][1][0] == 0
    assert parts[-1][1][1] == -(-side // 2)
    assert all(one[1][1] == two[1][0] for one, two in pairwise(parts))
    for pixels, (first, last) in parts:
        assert pixels.stop - pixels.start <= 576
        assert pixels.start % 4 == 0
        assert pixels.start <= 2 * first < 2 * last <= pixels.stop + 1
        assert pixels.start == 0 or 2 * first - pixels.start >= 30
        assert pixels.stop == side or pixels.stop - 2 * last >= 30


@pytest.mark.slow
def test_a_large_picture_shows_what_a_small_one_does(network: StallNetwork, lot: Scene) -> None:
    image = lot.image
    large = cv2.copyMakeBorder(image, 150, 150, 200, 200, cv2.BORDER_REFLECT_101)
    alone, within = network.run(image), network.run(np.asarray(large, np.uint8))
    inner = within.core[75 : 75 + 144, 100 : 100 + 192]
    both = np.minimum(alone.core > 0.5, inner > 0.5).sum() / np.maximum(alone.core > 0.5, inner > 0.5).sum()
    assert both > 0.8

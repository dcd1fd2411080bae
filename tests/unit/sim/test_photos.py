from __future__ import annotations

import itertools
import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.picture.photographs.folder import read_folder
from hawk.sim.photos import Errors, PhotoOptions, PhotosError, plan, write_photos
from hawk.sim.photos_tags import CAMERAS
from hawk.worlds.world import World, load_truth

EXACT = Errors(0.0, 0.0, 0.0, 0.0, 0.0)
SMALL = PhotoOptions(height=60.0, width=400, camera=CAMERAS["FC330"])
MARKS = np.array([[30.0, 28.0], [52.0, 61.0], [71.0, 33.0]])
"""Places of red marks, metres east and south."""


def _world(lot: Any = ((20, 20), (90, 20), (90, 70), (20, 70)), marks: Any = MARKS) -> World:
    ground = np.full((1000, 1200, 3), 90, np.uint8)
    for x, y in marks:
        column, row = round(x * 10), round(y * 10)
        ground[row - 6 : row + 6, column - 6 : column + 6] = (0, 0, 255)
    return World(name="plain", metres_per_pixel=0.1, ground=ground, lots=(np.array(lot, np.float64),))


def _truth(folder: Path) -> dict[str, Any]:
    return dict(json.loads((folder / "truth.json").read_text(encoding="utf-8"))["photos"])


def _expected(point: np.ndarray, shot: dict[str, Any], lens: dict[str, float]) -> np.ndarray:
    """Return the pixel of a point of the ground, by turns that are written out here."""
    north, east = shot["y_m"] - point[1], point[0] - shot["x_m"]
    yaw = math.radians(shot["yaw_deg"])
    ahead, right = north * math.cos(yaw) + east * math.sin(yaw), east * math.cos(yaw) - north * math.sin(yaw)
    scale = lens["fx"] / shot["height_m"]
    return np.array([lens["cx"] + scale * right, lens["cy"] - scale * ahead])


def _red(image: np.ndarray, near: np.ndarray) -> np.ndarray | None:
    """Return the middle of the red pixels about a place."""
    red = (image[..., 2].astype(int) - image[..., 0] > 60).astype(np.uint8)
    _, _, stats, middles = cv2.connectedComponentsWithStats(red)
    areas = [(float(np.hypot(*(middles[k] - near))), k) for k in range(1, len(stats)) if stats[k, 4] >= 4]
    return None if not areas else middles[min(areas)[1]]


@pytest.mark.slow
def test_marks_are_where_the_true_poses_and_the_true_lens_have_them(tmp_path: Path) -> None:
    options = replace(SMALL, errors=Errors(lens=20.0), noise_seed=3)
    assert write_photos(_world(), options, tmp_path) > 6
    truth, seen = _truth(tmp_path), 0
    assert abs(truth["lens"]["fx"] / truth["nominal_focal_px"] - 1.0) > 0.01
    for shot in truth["shots"]:
        image = cv2.imread(str(tmp_path / shot["name"]))
        assert image is not None
        for mark in MARKS:
            pixel = _expected(mark, shot, truth["lens"])
            if (pixel > 12).all() and (pixel < np.array([388, 288])).all():
                found = _red(image, pixel)
                assert found is not None
                assert found == pytest.approx(pixel, abs=0.6)
                seen += 1
    assert seen > 12


@pytest.mark.slow
def test_the_tags_without_errors_are_the_truth(tmp_path: Path) -> None:
    write_photos(_world(), replace(SMALL, errors=EXACT), tmp_path)
    found, truth = read_folder(tmp_path), _truth(tmp_path)
    assert [shot.name for shot in found.shots] == [shot["name"] for shot in truth["shots"]]
    for shot, true in zip(found.shots, truth["shots"], strict=True):
        assert (shot.latitude, shot.longitude) == pytest.approx((true["latitude"], true["longitude"]), abs=5e-8)
        assert (shot.height, shot.altitude) == pytest.approx((60.0, 160.0), abs=0.01)
        assert shot.attitude is not None
        assert shot.attitude[:2] == pytest.approx((0.0, 0.0), abs=1e-9)
        off = shot.attitude[2] - math.radians(true["yaw_deg"])
        assert math.degrees(math.remainder(off, math.tau)) == pytest.approx(0.0, abs=0.006)
        assert (shot.camera.fx, shot.camera.cx) == pytest.approx((truth["lens"]["fx"], truth["lens"]["cx"]), abs=1e-3)
    assert (found.left_out, all(shot.lens_is_known and shot.yaw_is_sure for shot in found.shots)) == ((), True)


@pytest.mark.nightly
@settings(max_examples=4, deadline=None)
@given(seed=st.integers(0, 10_000))
def test_the_tags_err_by_one_bias_one_factor_and_noise(tmp_path_factory: pytest.TempPathFactory, seed: int) -> None:
    folder = tmp_path_factory.mktemp("photos")
    options = replace(SMALL, width=320, noise_seed=seed, overlap=(0.8, 0.7))
    write_photos(_world(marks=()), options, folder)
    found, truth = read_folder(folder), _truth(folder)
    metre = 1 / 111_200.0
    off = np.array(
        [
            (s.latitude - t["latitude"], s.longitude - t["longitude"])
            for s, t in zip(found.shots, truth["shots"], strict=True)
        ]
    )
    off = off / [metre, metre / math.cos(math.radians(43.26))]
    assert math.hypot(*truth["errors"]["bias"]) == pytest.approx(2.0)
    assert off.mean(axis=0) == pytest.approx(truth["errors"]["bias"], abs=4 * 1.5 / math.sqrt(len(off)))
    assert 0.9 < off.std(axis=0).mean() < 2.1
    yaws = [
        math.degrees(math.remainder((s.attitude or (0, 0, 0))[2] - math.radians(t["yaw_deg"]), math.tau))
        for s, t in zip(found.shots, truth["shots"], strict=True)
    ]
    assert max(map(abs, yaws)) <= 3.01
    assert max(yaws) - min(yaws) > 0.5
    assert {shot.height for shot in found.shots} == {round(60.0 * truth["errors"]["height"], 2)}
    assert 0.95 <= truth["errors"]["height"] <= 1.05
    assert 0.98 <= truth["lens"]["fx"] / found.shots[0].camera.fx <= 1.02


@settings(max_examples=40, deadline=None)
@given(
    along=st.floats(0.2, 0.9),
    between=st.floats(0.2, 0.9),
    camera=st.sampled_from(sorted(CAMERAS)),
    turn=st.floats(0.0, math.pi),
    height=st.floats(30.0, 120.0),
)
def test_neighbours_overlap_as_asked_and_the_lot_is_covered(
    along: float, between: float, camera: str, turn: float, height: float
) -> None:
    turned = np.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]])
    lot = np.array([[-35, -20], [35, -20], [35, 20], [-35, 20]]) @ turned.T + [60, 50]
    options = replace(SMALL, overlap=(along, between), camera=CAMERAS[camera], height=height)
    poses = plan(_world(lot, ()), options)
    focal = options.camera.focal_px(options.width)
    seen = np.array([options.camera.height_px(400), 400]) / focal * height
    places = np.array([(pose.x_east, pose.y_south) for pose in poses])
    lanes = np.cumsum([0, *(abs(np.cos(b.yaw - a.yaw) + 1) < 1e-6 for a, b in itertools.pairwise(poses))])
    for lane in set(lanes.tolist()):
        steps = np.linalg.norm(np.diff(places[lanes == lane], axis=0), axis=1)
        assert steps == pytest.approx([(1 - along) * seen[0]] * len(steps))
    if lanes[-1]:
        last = places[lanes == 0][-1]
        assert np.hypot(*(places[lanes == 1][0] - last)) == pytest.approx((1 - between) * seen[1])
    ahead = np.array([math.sin(poses[0].yaw), -math.cos(poses[0].yaw)])
    right = np.array([-ahead[1], ahead[0]])
    for corner in lot:
        off = np.column_stack([(corner - places) @ ahead, (corner - places) @ right])
        assert (np.abs(off) <= seen / 2 + 1e-6).all(axis=1).any()


@pytest.mark.nightly
def test_the_same_seed_gives_the_same_bytes_and_another_one_others(tmp_path: Path) -> None:
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        write_photos(_world(), replace(SMALL, width=320, noise_seed=seed), tmp_path / name)
    files = {name: {p.name: p.read_bytes() for p in (tmp_path / name).iterdir()} for name in "abc"}
    assert files["a"] == files["b"]
    assert all(files["a"][name] != files["c"][name] for name in files["a"])


@pytest.mark.slow
def test_the_truth_is_read_as_every_world_s(tmp_path: Path) -> None:
    write_photos(_world(), replace(SMALL, width=320), tmp_path)
    truth = load_truth(tmp_path / "truth.json")
    assert truth.metres_per_pixel == 0.1
    assert truth.lots[0] == pytest.approx(_world().lots[0])


def test_a_world_without_lots_is_flown_over_whole() -> None:
    world = replace(_world(), lots=())
    poses = plan(world, SMALL)
    width, height = world.size_m
    assert max(pose.x_east for pose in poses) >= width - 1e-6 or max(pose.y_south for pose in poses) >= height - 1e-6


def test_too_many_photographs_are_refused() -> None:
    with pytest.raises(PhotosError, match=r"--height: \d+ photographs, more than 3000; fly higher"):
        plan(_world(), replace(SMALL, height=5.0, overlap=(0.95, 0.95)))

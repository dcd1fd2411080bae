from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hawk.model.pictures import CameraModel
from hawk.picture.reconstruction.bundle_adjust import BundleSolution, Priors, Projections, bundle_adjust
from hawk.picture.reconstruction.camera_pose import CameraPose

CAMERA = CameraModel(1000, 750, 800.0, 800.0, 499.5, 374.5)
COUNT = 9


def _true(line_s: float = 0.0) -> list[CameraPose]:
    rng = np.random.default_rng(3)
    poses = []
    for k in range(COUNT):
        roll, pitch = rng.normal(0, 0.02, 2).tolist()
        turning = tuple(rng.normal(0, 0.2, 3).tolist()) if line_s else (0.0, 0.0, 0.0)
        place = (20.0 * (k % 3 - 1), 20.0 * (k // 3 - 1))
        poses.append(CameraPose(CAMERA, *place, 60.0, (roll, pitch, 0.3), turning, (8.0, 0.0), line_s))
    return poses


def _sights(true: list[CameraPose], wrong: int = 0) -> tuple[Projections, np.ndarray]:
    rng = np.random.default_rng(4)
    places = np.column_stack([rng.uniform(-50, 50, (300, 2)), np.abs(rng.normal(0, 2, 300))])
    shot, point, pixels = [], [], []
    for k, posed in enumerate(true):
        shown = posed.pixels(places)
        for p in np.flatnonzero(((shown > 0) & (shown < (999, 749))).all(axis=1)):
            shot.append(k)
            point.append(p)
            pixels.append(shown[p])
    seen = np.array(pixels) + rng.normal(0, 0.3, (len(pixels), 2))
    seen[:wrong] += 60
    return Projections(np.array(shot), np.array(point), seen, len(places)), places


def _said(true: list[CameraPose]) -> list[CameraPose]:
    rng = np.random.default_rng(5)
    return [
        replace(
            one, north=one.north + n, east=one.east + e, height=58.0, attitude=(0.0, 0.0, 0.3 + y), turning=(0, 0, 0)
        )
        for one, (n, e), y in zip(true, rng.normal(0, 1.5, (COUNT, 2)), rng.normal(0, 0.05, COUNT), strict=True)
    ]


def _trust(*, turns: bool = False) -> Priors:
    turning = np.full((COUNT, 3), 0.3 if turns else 1e-6)
    return Priors(np.full((COUNT, 3), (1.5, 1.5, 3.0)), np.full((COUNT, 3), 0.05), turning, np.full(5, 0.01), 20.0)


def _apart(settled: BundleSolution, places: np.ndarray, sights: Projections) -> np.ndarray:
    """Return how far the places that are seen twice lie from the true ones, after the best shift, turn and scale."""
    seen = np.bincount(sights.point, minlength=len(places)) > 1
    own, true = settled.points[seen, :2] @ (1, 1j), places[seen, :2] @ (1, 1j)
    factor, shift = np.polyfit(own, true, 1)
    return np.asarray(np.abs(own * factor + shift - true))


def test_poses_that_err_by_metres_lie_right_to_each_other_afterwards() -> None:
    true = _true()
    sights, places = _sights(true)
    settled = bundle_adjust(_said(true), sights, _trust(), 1.0)
    assert np.median(settled.off) < 0.6
    assert np.percentile(_apart(settled, places, sights), 95) < 0.1
    assert np.std([one.height for one in settled.posed]) < 0.3


@pytest.mark.slow
def test_wrong_ties_bend_nothing() -> None:
    true = _true()
    sights, places = _sights(true, wrong=60)
    settled = bundle_adjust(_said(true), sights, _trust(), 1.0)
    assert np.percentile(_apart(settled, places, sights), 90) < 0.5
    assert np.median(settled.off[:60]) > 10


@pytest.mark.slow
def test_an_aircraft_that_turns_while_the_lines_are_read_is_followed() -> None:
    true = _true(line_s=2e-4)
    sights, places = _sights(true)
    settled = bundle_adjust(_said(true), sights, _trust(turns=True), 1.0)
    assert np.percentile(_apart(settled, places, sights), 95) < 0.3
    assert [one.turning[2] for one in settled.posed] == pytest.approx([one.turning[2] for one in true], abs=0.03)


def test_the_lens_of_all_is_found_with_the_poses() -> None:
    true = [
        replace(one, camera=replace(CAMERA, fx=820.0, fy=820.0, distortion=(-0.03, 0.0, 0.0, 0.0, 0.0)))
        for one in _true()
    ]
    sights, places = _sights(true)
    said = [replace(one, camera=CAMERA) for one in _said(true)]
    trust = replace(_trust(), lens=np.array([0.05, 0.01, 0.01, 0.1, 0.1]))
    settled = bundle_adjust(said, sights, trust, 1.0)
    assert settled.posed[0].camera.distortion[0] == pytest.approx(-0.03, abs=0.01)
    assert np.percentile(_apart(settled, places, sights), 95) < 0.1


@pytest.mark.slow
def test_it_goes_on_from_an_earlier_outcome() -> None:
    true = _true()
    sights, _ = _sights(true)
    first = bundle_adjust(_said(true), sights, _trust(), 1.0)
    again = bundle_adjust(_said(true), sights, _trust(), 1.0, first)
    assert [one.north for one in again.posed] == pytest.approx([one.north for one in first.posed], abs=0.02)

from __future__ import annotations

import math

import numpy as np
import pytest

from benchmarks.perception import relief
from benchmarks.perception.relief import Offsets
from hawk.algo.vision.decode import NetworkFinder
from hawk.algo.vision.rectify import Rectifier
from hawk.algo.vision.seen import Found, GroundImage, StallSeen
from hawk.model.pictures import CameraModel
from hawk.model.poses import MapPose
from hawk.worlds.generate import generate_world


def test_the_height_is_that_whose_relief_explains_the_errors() -> None:
    rng = np.random.default_rng(0)
    places = rng.uniform(-15, 15, (400, 2))
    taken = np.arange(400) % 2 == 0
    errors = places * np.where(taken, 0.5, 0.1)[:, None] / 35.0 + rng.normal(0, 0.1, (400, 2))
    errors[::50] = 5.0  # another stall
    offsets = Offsets(places, errors, taken)
    for state, true in ((True, 0.5), (False, 0.1)):
        found, error, count = offsets.height(35.0, taken=state)
        assert found == pytest.approx(true, abs=3 * error)
        assert error < 0.05
        assert count in (192, 200)
    assert math.isnan(Offsets(places, errors, np.zeros(400, np.bool_)).height(35.0, taken=True)[0])


class Sees(NetworkFinder):
    """Finds the true stalls of a world, too far out by the relief of a height."""

    def __init__(self, seed: int, rise_m: float, height_m: float) -> None:
        self.stalls = [stall for stall in generate_world(seed).stalls if not stall.hidden]
        self.share = rise_m / height_m
        self.below = np.zeros(2)

    def find(self, picture: GroundImage) -> Found:
        rows, columns = picture.valid.shape
        found = []
        for stall in self.stalls:
            corners = np.stack([-stall.corners[:, 1], stall.corners[:, 0]], axis=1)
            col, row = picture.pixel_points(corners).T
            if (col < 5).any() or (row < 5).any() or (col > columns - 5).any() or (row > rows - 5).any():
                continue
            along, across = corners[2] - corners[1], corners[1] - corners[0]
            north, east = corners.mean(axis=0) + self.share * (corners.mean(axis=0) - self.below)
            angle = math.atan2(along[1], along[0]) % math.pi
            found.append(StallSeen(north, east, angle, math.hypot(*across), math.hypot(*along), 0.9, 0.5, 1.0))
        return Found(tuple(found), picture, picture, picture)


def test_a_finder_that_leaves_relief_is_found_out(monkeypatch: pytest.MonkeyPatch) -> None:
    finder = Sees(3, 0.6, 35.0)
    seen = Rectifier.rectify

    def rectify(self: Rectifier, image: np.ndarray, camera: CameraModel, pose: MapPose) -> GroundImage:
        finder.below = np.array([pose.north, pose.east])
        return seen(self, image, camera, pose)

    monkeypatch.setattr(Rectifier, "rectify", rectify)
    offsets = relief.measure(finder, [generate_world(3)], 35.0, count=3)
    for taken in (False, True):
        assert offsets.height(35.0, taken=taken)[0] == pytest.approx(0.6, abs=0.02)


def test_a_command_without_worlds_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        relief.main([])
    assert "name --seeds or --places" in capsys.readouterr().err

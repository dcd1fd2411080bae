"""Poses, ground, tracks and bundles of drawn photographs, as numbers that another computer finds too."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hawk.model.pictures import CameraModel
from hawk.picture.reconstruction.bundle_adjust import bundle_adjust
from hawk.picture.reconstruction.camera_pose import CameraPose
from hawk.picture.reconstruction.features import Features, Ties
from hawk.picture.reconstruction.headings import NeighbourHeadings, correct_headings
from hawk.picture.reconstruction.terrain import fit_terrain
from hawk.picture.reconstruction.tracks import drop_outliers, largest_group
from tests.golden import check_values
from tests.unit.picture.reconstruction.test_bundle_adjust import _said, _sights, _true, _trust

HERE = Path(__file__).parent / "drawn"
LENS = CameraModel(640, 480, 500.0, 510.0, 320.0, 238.0, (0.05, -0.02, 0.001, 0.0005, 0.01), 0.02, -0.03, 1.2)


def test_what_a_pose_shows() -> None:
    still = CameraPose(LENS, 3.0, -7.0, 60.0, (0.05, -0.1, 1.2))
    poses = {
        "still": still,
        "above a slope": replace(still, level=4.0, slope=(0.1, -0.05)),
        "while lines are read": replace(still, turning=(0.2, -0.1, 0.3), velocity=(9.0, -4.0), line_s=5e-5, level=1.0),
        "to the horizon": replace(still, attitude=(0.0, 1.5, 0.0)),
    }
    pixels = np.array([(10.0, 20.0), (320.0, 240.0), (600.0, 30.0), (50.0, 470.0)])
    places = np.array([(0.0, 0.0, 0.0), (10.0, -20.0, 3.5), (-5.0, 4.0, -1.0)])
    found = {
        name: [
            each.round(5).tolist()
            for each in (
                pose.rays(pixels),
                pose.ground(pixels),
                pose.ground_height(places[:, :2]),
                pose.pixels(places),
                pose.pixels(places[:, :2]),
            )
        ]
        + [round(pose.reach(), 5)]
        for name, pose in poses.items()
        if name != "to the horizon"
    } | {"to the horizon": poses["to the horizon"].ground(pixels).round(0).tolist()}
    check_values(HERE / "poses.json", found, digits=5)


def test_the_ground_below_photographs() -> None:
    rng = np.random.default_rng(5)
    places = rng.uniform(-100, 100, (300, 2))
    hill = np.column_stack([places, 2.0 + places @ (-0.036, 0.01) + rng.normal(0, 0.05, 300)])
    roof = np.column_stack([rng.uniform(30, 50, (80, 2)), np.full(80, 3.9)])
    posed = [
        CameraPose(LENS, north, east, 60.0, (0.0, 0.0, 0.0))
        for north, east in ((40.0, 40.0), (-60.0, 10.0), (900.0, 0.0))
    ]
    found = {
        name: [[round(one.level, 4), *(round(each, 5) for each in one.slope)] for one in fit_terrain(posed, points)]
        for name, points in {
            "hill": hill,
            "with a roof": np.concatenate([hill, roof]),
            "twelve": hill[:12],
            "eleven": hill[:11],
        }.items()
    }
    check_values(HERE / "terrain.json", found, digits=5)


def test_places_that_ties_connect() -> None:
    features = Features(np.arange(40.0).reshape(-1, 2), np.zeros((20, 128), np.uint8))

    def ties(first: int, second: int, *pairs: tuple[int, int]) -> Ties:
        here, there = np.array(pairs).T
        return Ties(first, second, here, there)

    chain = [
        ties(0, 1, (2, 3), (5, 5), (7, 1)),
        ties(1, 2, (3, 7), (5, 6)),
        ties(0, 2, (9, 6), (11, 12)),
        ties(4, 5, (0, 0)),
    ]
    group = largest_group(chain, 6, lambda _: features)
    assert group is not None
    dropped = drop_outliers(group.sights, group.sights.pixels[:, 0] > 20)
    found = {
        name: [sights.shot.tolist(), sights.point.tolist(), sights.pixels.tolist(), sights.points]
        for name, sights in {"all": group.sights, "without": dropped}.items()
    }
    check_values(HERE / "tracks.json", found | {"members": group.members.tolist()})
    assert largest_group([], 3, lambda _: features) is None


@pytest.mark.slow
def test_an_adjusted_bundle() -> None:
    true = _true(line_s=2e-4)
    sights, _ = _sights(true, wrong=5)
    trust = replace(_trust(turns=True), lens=np.array([0.05, 0.01, 0.01, 0.1, 0.1]))
    settled = bundle_adjust(_said(true), sights, trust, 1.0)
    found = {
        "poses": [[round(each, 3) + 0.0 for each in (one.north, one.east, one.height)] for one in settled.posed],
        "attitudes": [[round(each, 3) + 0.0 for each in one.attitude] for one in settled.posed],
        "shared": settled.shared.round(3).tolist(),
        "off": [round(float(np.median(settled.off[part])), 1) for part in (slice(5), slice(5, None))],
    }
    check_values(HERE / "bundle.json", found, digits=3)


def test_headings_and_heights_of_couples() -> None:
    heights = ((58.0, 10.0), (61.0, 30.0), (62.0, 15.0), (300.0, 4.0))
    assert NeighbourHeadings({}, heights).height == 61.0
    assert NeighbourHeadings({}, heights[:2]).height == 61.0
    assert NeighbourHeadings({}, heights[:1]).height is None
    posed = [CameraPose(LENS, 0.0, 0.0, 60.0, (0.1, 0.2, yaw)) for yaw in (3.0, 0.0, 0.0)]
    corrected = correct_headings(posed, {0: -3.0, 1: 0.79, 2: 0.78})
    assert {number: one.attitude for number, one in corrected.items()} == {1: (0.0, 0.0, 0.79)}

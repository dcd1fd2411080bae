from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pymap3d
import pytest
from shapely.geometry import Point, shape

from hawk.model.lot_map import StallState
from hawk.model.poses import GlobalPose
from hawk.survey.truth import TruthError, parse_truth, read_truth

ORIGIN = GlobalPose(43.2609, -79.9192, 0.0)
SQUARE = [[10.0, 20.0], [12.5, 20.0], [12.5, 25.0], [10.0, 25.0]]


def world(**changes: Any) -> dict[str, Any]:
    return {
        "metres_per_pixel": 0.1,
        "stalls": [
            {"corners_m": SQUARE, "state": "free", "covered": 0.0},
            {"corners_m": SQUARE, "state": "taken"},
            {"corners_m": SQUARE, "state": "unclear", "hidden": True},
        ],
        "lots_m": [[[0, 0], [60, 0], [60, 40], [0, 40]], [[80, 0], [90, 0], [90, 40], [80, 40]]],
        "origin": {"latitude": ORIGIN.latitude, "longitude": ORIGIN.longitude},
        **changes,
    }


def test_states_and_stalls_that_nobody_can_judge() -> None:
    truth = parse_truth(world())
    assert truth.states == (StallState.FREE, StallState.TAKEN, None)
    assert truth.hidden == (False, False, True)


def test_the_size_of_the_picture_says_what_was_labelled() -> None:
    places = np.array([[0.0, 0.0], [59.9, 39.9], [60.1, 1.0], [1.0, 40.1], [-0.1, 1.0]])
    sized = parse_truth(world(size_px=[600, 400]))
    assert sized.size == (60.0, 40.0)
    assert sized.in_picture(places).tolist() == [True, True, False, False, False]
    assert parse_truth(world()).in_picture(places).all()
    with pytest.raises(TruthError, match="size_px"):
        parse_truth(world(size_px=[0, 400]))


def test_map_places_are_found_in_the_world_again() -> None:
    truth = parse_truth(world())
    # a datum 30 m south and 40 m east of the picture's corner
    latitude, longitude, _ = pymap3d.ned2geodetic(-30.0, 40.0, 0.0, ORIGIN.latitude, ORIGIN.longitude, 0.0)
    found = truth.to_world(np.array([[0.0, 0.0], [5.0, -2.0]]), GlobalPose(float(latitude), float(longitude), 100.0))
    assert found == pytest.approx(np.array([[40.0, 30.0], [38.0, 25.0]]), abs=1e-3)


def test_the_fence_runs_around_all_lots_together() -> None:
    truth = parse_truth(world())
    fence = shape(truth.fence(15.0)["geometry"])

    def at(x: float, y: float) -> Point:
        latitude, longitude, _ = pymap3d.ned2geodetic(-y, x, 0.0, ORIGIN.latitude, ORIGIN.longitude, 0.0)
        return Point(float(longitude), float(latitude))

    assert fence.contains(at(-14, 20))
    assert fence.contains(at(70, 20))
    assert fence.contains(at(104, 20))
    assert not fence.contains(at(-16, 20))
    assert not fence.contains(at(30, 56))


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"stalls": [{"corners_m": SQUARE[:3], "state": "free"}]}, "stalls.0.corners_m: a stall has 4 corners"),
        ({"stalls": [{"corners_m": SQUARE}]}, "stalls.0.state"),
        ({"lots_m": "x"}, "lots_m"),
    ],
)
def test_a_wrong_truth_names_the_field(change: dict[str, Any], named: str) -> None:
    with pytest.raises(TruthError, match=named):
        parse_truth(world(**change))


def test_a_truth_without_origin_says_so_when_it_is_needed() -> None:
    truth = parse_truth(world(origin=None))
    with pytest.raises(TruthError, match="origin"):
        truth.to_world(np.zeros((1, 2)), ORIGIN)


def test_files_are_named_in_errors(tmp_path: Path) -> None:
    path = tmp_path / "truth.json"
    path.write_text(json.dumps(world()))
    assert len(read_truth(path).stalls) == 3
    path.write_text("[1]")
    with pytest.raises(TruthError, match=r"truth\.json"):
        read_truth(path)
    with pytest.raises(TruthError, match=r"absent\.json"):
        read_truth(tmp_path / "absent.json")

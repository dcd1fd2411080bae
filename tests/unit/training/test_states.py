"""The fit of the states of stalls to what the network says of them."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from benchmarks.perception.places import Place, read_lots, state_array
from hawk.algo.vision.decode import STATE_FEATURES
from hawk.model.lot_map import StallState
from hawk.survey.accuracy import LabelledPlace
from tests.unit.training.test_agreement import BrightStalls
from training.states import DUTCH_STATES, Judged, drawn, fit, joined, judged, regions, right

FREE, TAKEN, UNKNOWN = StallState.FREE, StallState.TAKEN, StallState.UNKNOWN


def place(states: tuple[StallState, ...] = (FREE, TAKEN, UNKNOWN)) -> Place:
    """A row of three bright stalls side by side, 0.1 m a pixel; the first one looks free, which shows the row."""
    image = np.full((201, 261, 3), 40, np.uint8)
    corners = []
    for left in (60, 90, 120):
        image[70:122, left : left + 26] = (120, 200, 200) if left == 60 else 200
        corners.append([(left, 70), (left + 26, 70), (left + 26, 122), (left, 122)])
    return Place("row", image, 0.1, LabelledPlace(np.array(corners, float) * 0.1, state_array(list(states)), ()))


def test_stalls_with_a_known_state_are_judged() -> None:
    found = judged(place(), BrightStalls(), None)  # type: ignore[arg-type]
    assert found.features.shape == (2, len(STATE_FEATURES))
    assert sorted(found.taken.tolist()) == [False, True]


def test_stalls_that_an_edge_cuts_are_not_judged() -> None:
    whole = place()
    shifted = LabelledPlace(whole.truth.stalls - (5.9, 0.0), whole.truth.states, ())
    cut = replace(whole, image=np.ascontiguousarray(whole.image[:, 59:]), truth=shifted)
    assert len(judged(cut, BrightStalls(), None).taken) == 1  # type: ignore[arg-type]


def test_the_fit_finds_the_weights_that_made_the_states() -> None:
    rng = np.random.default_rng(1)
    features = rng.normal(size=(6000, len(STATE_FEATURES)))
    true = np.array([0.3, 1.5, -1.0, 2.0])
    given = Judged(features, rng.random(6000) < 1 / (1 + np.exp(-(true[0] + features @ true[1:]))))
    found = fit(given)
    np.testing.assert_allclose(found, true, atol=0.2)
    assert 0.75 < right(given, found) < 0.95
    assert right(given, -found) == pytest.approx(1 - right(given, found))
    assert np.isnan(right(joined([]), found))


@pytest.mark.nightly
def test_a_drawn_scene_is_a_place_with_its_sun_and_states() -> None:
    scenes = list(drawn(991, 3))
    assert len(scenes) == 3
    states = {str(state) for scene, _ in scenes for state in scene.truth.states}
    assert {"free", "taken"} <= states
    assert all(cast is not None and cast.shape == (2,) for _, cast in scenes)
    again, _ = next(iter(drawn(991, 1)))
    np.testing.assert_array_equal(again.truth.stalls, scenes[0][0].truth.stalls)


def write_region(folder: Path) -> None:
    cv2.imwrite(str(folder / "here.jpg"), place().image)
    stalls = [{"corners_m": quad.tolist(), "state": "unclear"} for quad in place().truth.stalls]
    (folder / "here.json").write_text(json.dumps({"metres_per_pixel": 0.1, "stalls": stalls, "lots_m": []}))


def test_a_region_gets_its_states_from_the_file(tmp_path: Path) -> None:
    write_region(tmp_path)
    assert {str(state) for found in read_lots(tmp_path) for state in found.truth.states} == {"unknown"}
    labels = tmp_path / "states"
    labels.write_text(json.dumps({"states": {"here": {"free": [2], "taken": [0]}, "elsewhere": {}}}))
    (found,) = regions(tmp_path, labels)
    assert [str(state) for state in found.truth.states] == ["taken", "unknown", "free"]


def test_a_state_of_a_stall_that_is_not_there_is_refused(tmp_path: Path) -> None:
    write_region(tmp_path)
    labels = tmp_path / "states"
    labels.write_text(json.dumps({"states": {"here": {"free": [3], "taken": []}}}))
    with pytest.raises(ValueError, match="here has no stall 3"):
        list(regions(tmp_path, labels))


def test_no_dutch_stall_is_both_free_and_taken() -> None:
    for states in json.loads(DUTCH_STATES.read_text())["states"].values():
        every = [*states["free"], *states["taken"]]
        assert len(set(every)) == len(every)

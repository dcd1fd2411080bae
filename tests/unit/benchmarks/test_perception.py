from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.perception import sections
from benchmarks.perception.eyes import NetworkEye, Result, as_shown
from benchmarks.perception.measures import Judged, calibration_error, false_alarms, measure
from benchmarks.perception.places import Place, coarser, read_lots, read_tiles, state_array
from hawk.algo.vision.network import StallNetwork
from hawk.model.lot_map import StallState
from hawk.survey.accuracy import Finding, LabelledPlace, match
from tests.drawn_worlds import drawn_world

ROW = np.array([[[5 + 3 * k, 5], [7.5 + 3 * k, 5], [7.5 + 3 * k, 10], [5 + 3 * k, 10]] for k in range(6)], float)
STATES = state_array([StallState.FREE, StallState.TAKEN] * 3)
LOT = np.array([[0, 0], [30, 0], [30, 20], [0, 20]], float)


class Oracle:
    """Finds the given stalls, whatever the picture; at another scale it finds nothing."""

    def __init__(self, stalls: NDArray[np.float64], taken: NDArray[np.float64]) -> None:
        self._stalls, self._taken = stalls, taken

    def look(self, image: NDArray[np.uint8], metres_per_pixel: float, *, scale: float = 1.0) -> Result:
        count = len(self._stalls) if scale == 1.0 else 0
        states = [StallState.TAKEN if p > 0.5 else StallState.FREE for p in self._taken[:count]]
        lot = np.ones((50, 75), np.bool_)
        return Result(Finding(self._stalls[:count], state_array(states)), self._taken[:count], lot)


def place(stalls: NDArray[np.float64] = ROW) -> Place:
    return Place("row", np.zeros((200, 300, 3), np.uint8), 0.1, LabelledPlace(stalls, STATES[: len(stalls)], (LOT,)))


@pytest.fixture(scope="module")
def ground() -> Place:
    """A corner of a drawn world's lot without its cars: every stall is free."""
    world = drawn_world(3)
    corners = np.array([stall.corners for stall in world.stalls])
    low = corners.mean(axis=(0, 1)) - 17.5
    column, row = np.round(low / world.metres_per_pixel).astype(int)
    side = round(35 / world.metres_per_pixel)
    picture = np.ascontiguousarray(world.ground[row : row + side, column : column + side])
    inside = ((corners > low) & (corners < low + 35)).all(axis=(1, 2))
    stalls = corners[inside] - low
    states = state_array([StallState.FREE] * len(stalls))
    return Place("ground", picture, world.metres_per_pixel, LabelledPlace(stalls, states, tuple(world.lots)))


def _label(x: float) -> str:
    """Return a stall's line: class, then the polygon in fractions."""
    points = ((x, 0.1), (x + 0.05, 0.1), (x + 0.05, 0.2), (x, 0.2))
    return "3 " + " ".join(f"{value:.2f}" for point in points for value in point)


def test_what_is_found_rightly_measures_one() -> None:
    measured = measure(Oracle(ROW, np.array([0.0, 1.0] * 3)), [place()])
    for name in ("precision", "recall", "recall_whole", "free_recall", "state_accuracy", "found_over_labelled"):
        assert measured[name] == 1.0, name
    assert measured["lot_iou"] > 0.95
    assert measured["state_ece"] == 0.0


def test_what_is_missed_and_called_wrongly_costs() -> None:
    measured = measure(Oracle(ROW[:3], np.array([0.0, 0.0, 0.0])), [place()])
    assert measured["recall"] == 0.5
    assert measured["state_accuracy"] == pytest.approx(2 / 3)
    assert measured["state_ece"] == pytest.approx(1 / 3)
    assert measure(Oracle(ROW, np.zeros(6)), [place()], scale=0.8)["recall"] == 0.0


def test_how_far_centres_lie_from_their_labels_is_measured_along_and_across() -> None:
    lengthened = ROW.copy()
    lengthened[:, 2:, 1] += 0.4
    measured = measure(Oracle(lengthened + np.array([0.3, 0.0]), np.zeros(6)), [place()])
    assert measured["centre_along_p95_m"] == pytest.approx(0.2)
    assert measured["centre_across_p95_m"] == pytest.approx(0.3)
    assert measured["centre_p95_m"] == pytest.approx(0.13**0.5)
    assert measured["length_sigma_m"] == pytest.approx(0.0, abs=1e-6)
    assert "centre_p95_m" not in measure(Oracle(ROW[:0], np.zeros(0)), [place()])


def test_false_alarms_are_a_mean_over_pictures() -> None:
    pictures = [(name, np.zeros((100, 100, 3), np.uint8)) for name in ("a", "b")]
    assert false_alarms(Oracle(ROW, np.zeros(6)), pictures, 0.1) == {"false_per_negative": 6.0}
    assert false_alarms(Oracle(ROW, np.zeros(6)), [], 0.1) == {}


def test_probabilities_that_are_meant_have_no_calibration_error() -> None:
    said, true = np.repeat([0.25, 0.75], 4), np.array([1, 0, 0, 0, 1, 1, 1, 0], bool)
    assert calibration_error([Judged(said, true)]) == pytest.approx(0.0)
    assert calibration_error([Judged(np.full(4, 0.9), np.zeros(4, bool))]) == pytest.approx(0.9)
    assert math.isnan(calibration_error([]))


def test_places_are_read(tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "lot.jpg"), np.zeros((100, 100, 3), np.uint8))
    stalls = [{"corners_m": quad.tolist(), "state": "unclear"} for quad in ROW]
    labels = {"metres_per_pixel": 0.2, "stalls": stalls, "lots_m": [LOT.tolist()]}
    (tmp_path / "lot.json").write_text(json.dumps(labels))
    (found,) = read_lots(tmp_path)
    assert found.metres_per_pixel == 0.2
    assert set(found.truth.states) == {"unknown"}


def test_tiles_are_read_with_what_the_cars_cover(tmp_path: Path) -> None:
    write_tiles(tmp_path, {"many": 5, "few": 4}, ["0 0.025 0.15 0.05 0.1"])
    (tile,) = read_tiles(tmp_path)
    assert list(tile.truth.states) == ["taken", "free", "free", "free", "free"]


def test_stalls_of_a_tile_whose_cars_were_not_labelled_have_no_state(tmp_path: Path) -> None:
    write_tiles(tmp_path, {"many": 5}, [])
    (tile,) = read_tiles(tmp_path)
    assert set(tile.truth.states) == {"unknown"}


def write_tiles(folder: Path, stalls: Mapping[str, int], others: list[str]) -> None:
    """Write black tiles with N labelled stalls each, by name, and other labels."""
    for part in ("images", "labels"):
        (folder / part).mkdir(parents=True)
    for name, count in stalls.items():
        cv2.imwrite(str(folder / "images" / f"{name}.jpg"), np.zeros((640, 640, 3), np.uint8))
        lines = [*(_label(0.1 * k) for k in range(count)), *others]
        (folder / "labels" / f"{name}.txt").write_text("\n".join(lines))


def test_stalls_are_cut_at_the_edge_of_the_picture() -> None:
    stalls = np.array([[[x, 1.0], [x + 2.5, 1.0], [x + 2.5, 6.0], [x, 6.0]] for x in (5.0, -1.0, -2.3, 8.0, 12.0)])
    cut, is_shown = as_shown(stalls, (10.0, 20.0))
    assert is_shown.tolist() == [True, True, False, True, False]
    assert cut[0] == pytest.approx(stalls[0])
    for quad, (low, high) in zip(cut[1:], ((0.0, 1.5), (8.0, 10.0)), strict=True):
        assert (quad[:, 0].min(), quad[:, 0].max()) == pytest.approx((low, high))
        assert (quad[:, 1].min(), quad[:, 1].max()) == pytest.approx((1.0, 6.0))


@pytest.mark.nightly
@pytest.mark.slow
def test_a_stall_that_the_picture_s_edge_cuts_is_found(ground: Place) -> None:
    """Half of a stall is shown: found as half a stall, in its state."""
    stalls, scale = ground.truth.stalls, ground.metres_per_pixel
    first = stalls[np.argsort(stalls[:, :, 0].mean(1))[0]]
    left = round(first[:, 0].mean() / scale)
    found = NetworkEye(StallNetwork.load()).look(np.ascontiguousarray(ground.image[:, left:]), scale).finding
    half, _ = as_shown(first[None] - (left * scale, 0), (1e3, 1e3))
    (number,) = match(found.stalls, half).found
    assert found.states[number] == StallState.FREE


def test_a_picture_of_nothing_shows_nothing() -> None:
    image = np.full((256, 256, 3), 110, np.uint8)
    assert len(NetworkEye(StallNetwork.load()).look(image, 0.1).finding.stalls) == 0


def test_a_place_is_averaged_and_keeps_its_ground() -> None:
    image, missing = np.zeros((100, 200, 3), np.uint8), np.zeros((100, 200), np.bool_)
    image[:, 100:], missing[:50] = 200, True
    fine = replace(place(), image=image, missing=missing)
    coarse = coarser(fine, 0.2)
    assert coarse.image.shape == (50, 100, 3)
    assert (coarse.metres_per_pixel, coarse.image[:, 49].max(), coarse.image[:, 50].min()) == (0.2, 0, 200)
    assert coarse.missing is not None
    assert coarse.missing.mean() == 0.5
    assert coarser(fine, 0.1) is fine


@pytest.mark.slow
def test_coarser_places_stand_beside_those_as_they_are(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cv2.imwrite(str(tmp_path / "lot.jpg"), np.zeros((100, 100, 3), np.uint8))
    stall = {"corners_m": [[1, 1], [3.5, 1], [3.5, 6], [1, 6]], "state": "free"}
    (tmp_path / "lot.json").write_text(json.dumps({"metres_per_pixel": 0.1, "stalls": [stall], "lots_m": []}))
    monkeypatch.setattr(sections, "frame_ms", lambda _: 1.0)
    found = sections.network_sections(StallNetwork.load(), sections.Material(lots=tmp_path, coarser=(0.2,)))
    by_key = {figure.key: figure for section in found for figure in section.figures}
    assert by_key["lots_at_20_cm_recall"].value == by_key["lots_recall"].value == 0.0
    assert by_key["lots_at_20_cm_recall"].reference is not None


class Doubtful:
    """Finds rows of which it misses the more stalls the less sure it is of those that it finds; or the reverse."""

    def __init__(self, *, is_honest: bool) -> None:
        self._is_honest = is_honest

    def look(self, image: NDArray[np.uint8], metres_per_pixel: float, *, scale: float = 1.0) -> Result:
        del scale, metres_per_pixel
        missed = int(image[0, 0, 0])
        stalls = TEN[missed:]
        doubt = missed if self._is_honest else 8 - missed
        ones = np.ones(len(stalls))
        finding = Finding(stalls, state_array([StallState.FREE] * len(stalls)))
        return Result(finding, 0 * ones, np.ones((50, 75), np.bool_), score=ones - 0.1 * doubt)


TEN = np.array([[[2 + 3 * k, 5], [4.5 + 3 * k, 5], [4.5 + 3 * k, 10], [2 + 3 * k, 10]] for k in range(10)], float)


def row_with(missed: int) -> Place:
    """Return a row of ten free stalls of which `Doubtful` misses some."""
    truth = LabelledPlace(TEN, state_array([StallState.FREE] * 10), (LOT,))
    return Place(f"row {missed}", np.full((200, 400, 3), missed, np.uint8), 0.1, truth)


@pytest.mark.parametrize(("is_honest", "rank"), [(True, 1.0), (False, -1.0)])
def test_doubt_is_judged_by_the_errors_of_the_squares(is_honest: bool, rank: float) -> None:
    found = measure(Doubtful(is_honest=is_honest), [row_with(missed) for missed in range(8)])
    assert found["unsure_squares"] == 8
    assert found["unsure_rank"] == pytest.approx(rank)
    assert found["unsure_rank_least"] == pytest.approx(rank)


def test_an_eye_that_says_no_score_has_no_doubt_to_judge() -> None:
    assert "unsure_rank" not in measure(Oracle(ROW, np.array([0.1, 0.9] * 3)), [place()] * 8)

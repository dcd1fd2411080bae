from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.model.lot_map import CELL_M, TILE_CELLS, Cell, Stall, StallState
from hawk.model.poses import GlobalPose
from hawk.results.survey_map import SurveyMap
from hawk.survey.report import compare, counts, finite, in_range, map_offset
from hawk.survey.truth import GroundTruth

ORIGIN = GlobalPose(43.2609, -79.9192, 0.0)
WIDTH, LENGTH = 2.6, 5.2


def rows() -> list[tuple[float, float]]:
    """Centres (x, y) in the world of two rows of twelve stalls."""
    return [(4.0 + 2.6 * k, y) for y in (6.0, 18.0) for k in range(12)]


def quad(x: float, y: float) -> np.ndarray:
    return np.array([[x - 1.3, y - 2.6], [x + 1.3, y - 2.6], [x + 1.3, y + 2.6], [x - 1.3, y + 2.6]])


def truth(free: int = 10) -> GroundTruth:
    places = rows()
    states = [StallState.FREE if k < free else StallState.TAKEN for k in range(len(places))]
    lot = np.array([[0.0, 0.0], [40.0, 0.0], [40.0, 24.0], [0.0, 24.0]])
    return GroundTruth(tuple(quad(*p) for p in places), tuple(states), (False,) * len(places), (lot,), ORIGIN)


def survey(free: int = 10, shift: tuple[float, float] = (0.0, 0.0), leave_out: int = 0, extra: int = 0) -> SurveyMap:
    """A perfect survey of `truth`, with its faults: the datum lies in the world's corner."""
    stalls = {}
    for k, (x, y) in enumerate(rows()[leave_out:], start=leave_out):
        state = StallState.FREE if k < free else StallState.TAKEN
        stalls[k] = Stall(k, -y + shift[1], x + shift[0], 0.0, WIDTH, LENGTH, 0.5, state, 0.9, 3, 0.0, 1)
    for k in range(100, 100 + extra):
        stalls[k] = Stall(k, 50.0 + 6 * k, 0.0, 0.0, WIDTH, LENGTH, 0.1, StallState.FREE, 0.9, 3, 0.0, 1)
    tiles = {(0, c): np.full((TILE_CELLS, TILE_CELLS), Cell.NON_LOT, np.uint8) for c in (0, 1)}
    tiles[0, 0][: round(24 / CELL_M)] = Cell.LOT
    tiles[0, 1][: round(24 / CELL_M), : round((40 - 25.6) / CELL_M)] = Cell.LOT
    return SurveyMap(ORIGIN, stalls, tiles)


def test_a_perfect_survey() -> None:
    found = compare(survey(), truth())
    for key in ("stall_precision", "stall_recall", "stall_f1", "recall_whole", "free_recall", "state_accuracy"):
        assert found[key] == 1.0, key
    assert found["free_count_error"] == 0.0
    assert found["lot_iou"] == pytest.approx(1.0, abs=0.03)
    assert found["position_error_p95_m"] < 0.01


def test_a_constant_position_error_is_taken_out_and_reported() -> None:
    found = compare(survey(shift=(0.8, -0.5)), truth())
    assert found["stall_f1"] == 1.0
    assert found["map_offset_east_m"] == pytest.approx(-0.8, abs=0.02)
    assert found["map_offset_north_m"] == pytest.approx(0.5, abs=0.02)
    assert found["position_error_p95_m"] < 0.02


def test_missed_and_invented_stalls_and_wrong_counts_show() -> None:
    found = compare(survey(leave_out=4, extra=2), truth())
    assert found["stall_recall"] == pytest.approx(20 / 24)
    assert found["stall_precision"] == pytest.approx(20 / 22)
    assert found["free_recall"] == pytest.approx(6 / 10)
    assert found["free_count_error_stalls"] == 2
    assert found["free_count_error"] == pytest.approx(0.2)


def test_suggested_stalls_are_neither_found_nor_false() -> None:
    plain = survey()
    aside = Stall(900, 60.0, 0.0, 0.0, WIDTH, LENGTH, 1.0, StallState.SUGGESTED, 0.48, 2, 0.0, 1)
    more = SurveyMap(ORIGIN, {900: aside, **plain.stalls}, plain.tiles)
    assert compare(more, truth()) == compare(plain, truth())
    assert counts(more) == {**counts(plain), "suggested": 1}
    assert more.counts.free_variance == plain.counts.free_variance


def test_unknown_is_wrong_in_state_and_missed_in_free_recall() -> None:
    seen = survey()
    stalls = dict(seen.stalls)
    for key in range(5):
        one = stalls[key]
        stalls[key] = Stall(key, one.north, one.east, 0.0, WIDTH, LENGTH, 0.5, StallState.UNKNOWN, 0.9, 3, 0.0, 1)
    found = compare(SurveyMap(seen.datum, stalls, seen.tiles), truth())
    assert found["state_accuracy"] == pytest.approx(19 / 24)
    assert found["free_recall"] == pytest.approx(0.5)
    assert found["unknown_share"] == pytest.approx(5 / 24)


def test_a_wrong_lot_outline_shows() -> None:
    seen = survey()
    tiles = {key: tile.copy() for key, tile in seen.tiles.items()}
    tiles[0, 1][:] = Cell.NON_LOT
    assert compare(SurveyMap(seen.datum, seen.stalls, tiles), truth())["lot_iou"] == pytest.approx(25.6 / 40, abs=0.03)


def test_what_lies_beyond_the_worlds_picture_does_not_count() -> None:
    """The picture ends at x = 23.6 m, so nobody labelled the lot and the stalls that go on there."""
    seen, whole = survey(extra=2), truth()
    shown = [k for k, quad in enumerate(whole.stalls) if quad[:, 0].max() < 23.6]
    lot = np.array([[0.0, 0.0], [23.6, 0.0], [23.6, 24.0], [0.0, 24.0]])
    labelled = GroundTruth(
        tuple(whole.stalls[k] for k in shown),
        tuple(whole.states[k] for k in shown),
        (False,) * len(shown),
        (lot,),
        ORIGIN,
    )
    found = compare(seen, replace(labelled, size=(23.6, 24.0)))
    assert found["stall_recall"] == 1.0
    assert found["found_stalls"] == len(shown)
    assert found["lot_iou"] == pytest.approx(1.0, abs=0.03)
    unlimited = compare(seen, labelled)
    assert unlimited["found_stalls"] == 26
    assert unlimited["lot_iou"] == pytest.approx(23.6 / 40, abs=0.03)


def test_stalls_ever_in_view_are_reported_beside_those_found_of_them() -> None:
    """The map knows the first 25.6 m of 40 m: nine whole stalls of each row, of which the first four were not found."""
    whole = compare(survey(), truth())
    assert (whole["lot_seen"], whole["stalls_seen"], whole["stall_recall_seen"]) == pytest.approx(
        (1.0, 1.0, 1.0), abs=0.01
    )
    seen = survey(leave_out=4)
    tiles = {key: tile.copy() for key, tile in seen.tiles.items()}
    tiles[0, 1][:] = Cell.UNKNOWN
    for known in (tiles, {(0, 0): tiles[0, 0]}):
        found = compare(SurveyMap(seen.datum, seen.stalls, known), truth())
        assert found["lot_seen"] == pytest.approx(25.6 / 40, abs=0.01)
        inside = sum(x + 1.3 <= 25.6 for x, _ in rows())
        assert found["stalls_seen"] == pytest.approx(inside / 24)
        assert found["stall_recall_seen"] == pytest.approx((inside - 4) / inside)
    moved = compare(survey(shift=(0.8, -0.5)), truth())
    assert moved["stalls_seen"] == 1.0, "the constant part of the position error is taken out"


def test_a_survey_that_saw_nothing_had_nothing_in_view() -> None:
    found = finite(compare(SurveyMap(ORIGIN, {}, {}), truth()))
    assert (found["lot_seen"], found["stalls_seen"], found["stall_recall_seen"]) == (0.0, 0.0, None)


def test_a_survey_that_found_nothing_is_null_not_a_crash() -> None:
    found = finite(compare(SurveyMap(ORIGIN, {}, {}), truth()))
    assert found["stall_recall"] == 0.0
    assert found["stall_precision"] is None
    json.dumps(found, allow_nan=False)
    assert counts(SurveyMap(ORIGIN, {}, {})) == dict.fromkeys(("stalls", "free", "taken", "unknown", "suggested"), 0)


@given(st.floats(-1.1, 1.1), st.floats(-1.1, 1.1))
def test_the_offset_of_a_displaced_map_is_found(dx: float, dy: float) -> None:
    true = np.array(rows())
    found = np.add(true, (dx, dy))
    shift = map_offset(found, true)
    if math.hypot(dx, dy) < 1.0:
        assert shift == pytest.approx(np.array([-dx, -dy]), abs=0.02)
    assert np.hypot(*shift) <= 5.0


def test_a_few_stalls_are_no_ground_for_moving_a_map() -> None:
    assert map_offset(np.zeros((3, 2)), np.ones((3, 2))) == pytest.approx(np.zeros(2))


def test_an_interval_holds_the_true_number_at_its_bounds_and_between() -> None:
    assert [in_range(true, (66, 77)) for true in (65.0, 66.0, 70.0, 77.0, 78.0)] == [False, True, True, True, False]
    assert in_range(70.0, None) is None

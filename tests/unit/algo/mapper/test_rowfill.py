from __future__ import annotations

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from hawk.algo.ground import Window
from hawk.algo.mapper.evidence import EVIDENCE_M, CellEvidence
from hawk.algo.mapper.grid import EvidenceGrid
from hawk.algo.mapper.rowfill import RowFiller
from hawk.algo.mapper.stalls import Look, StallTracker
from hawk.algo.mapper.table import FREE, TAKEN, Detections
from hawk.algo.vision.detection import Detection
from tests.unit.algo.synthetic import stall_corners

WINDOW = Window.around(np.array([[-25.0, -25.0], [25.0, 25.0]]), EVIDENCE_M)
ROW = np.array([[0.0, 2.6 * i - 13, 0.0, 2.6, 5.2] for i in range(11)])


def drawn(stalls: NDArray[np.float64]) -> NDArray[np.float32]:
    layer = np.zeros(WINDOW.shape, np.float32)
    for quad in stall_corners(stalls):
        cells = WINDOW.cells_of(quad[:, 0], quad[:, 1])
        cv2.fillConvexPoly(layer, np.round(cells).astype(np.int32), (0.9,))
    return layer


def grid_of(stalls: NDArray[np.float64], cars: NDArray[np.float64]) -> EvidenceGrid:
    grid, full = EvidenceGrid(), np.full(WINDOW.shape, 2, np.uint8)
    grid.fuse(CellEvidence(WINDOW, drawn(stalls), drawn(stalls), drawn(cars), full), 1.0, 1)
    return grid


def tracker_of(stalls: NDArray[np.float64], frames: int = 5) -> StallTracker:
    tracker = StallTracker()
    see(tracker, stalls, frames)
    return tracker


def see(tracker: StallTracker, stalls: NDArray[np.float64], frames: int) -> None:
    found = Detections.of([Detection(n, e, a, w, length, 0.9, 0.05, 1.0) for n, e, a, w, length in stalls.tolist()])
    for version in range(1, frames + 1):
        everything = np.arange(len(tracker.rows))
        tracker.fuse(Look(found, 0.5, 0.1 * version, lambda p: np.zeros(len(p), np.bool_), version), everything)


def run(tracker: StallTracker, grid: EvidenceGrid, times: int = 3) -> None:
    for i in range(times):
        finish(RowFiller(34.0), tracker, grid, (0.0, 0.0), 100 + i)


def finish(
    filler: RowFiller, tracker: StallTracker, grid: EvidenceGrid, middle: tuple[float, float], version: int
) -> None:
    filler.begin(tracker, grid, middle)
    end(filler, tracker, version)


def end(filler: RowFiller, tracker: StallTracker, version: int) -> None:
    while filler.is_under_way:
        filler.go_on(tracker, version)


def test_a_hole_in_a_row_is_filled_when_the_ground_bears_it_out() -> None:
    tracker = tracker_of(np.delete(ROW, 5, 0))
    run(tracker, grid_of(ROW, ROW[5:6]))
    inferred = tracker.confirmed[tracker.confirmed["inferred"]]
    assert len(inferred) == 1
    assert abs(inferred["east"][0] - ROW[5, 1]) < 0.1
    assert inferred["state"][0] == TAKEN


def test_an_inferred_stall_without_a_car_is_free() -> None:
    tracker = tracker_of(np.delete(ROW, 5, 0))
    run(tracker, grid_of(ROW, ROW[:0]))
    assert tracker.confirmed["state"][tracker.confirmed["inferred"]].tolist() == [FREE]


def test_an_island_in_a_row_is_not_filled() -> None:
    tracker = tracker_of(np.delete(ROW, 5, 0))
    run(tracker, grid_of(np.delete(ROW, 5, 0), ROW[:0]))
    assert not tracker.rows["inferred"].any()


def test_one_run_is_not_enough_to_count() -> None:
    tracker = tracker_of(np.delete(ROW, 5, 0))
    run(tracker, grid_of(ROW, ROW[:0]), 1)
    assert tracker.rows["inferred"].sum() == 1
    assert not tracker.confirmed["inferred"].any()


@pytest.mark.slow
def test_an_inferred_stall_goes_when_the_row_implies_it_no_longer() -> None:
    tracker = tracker_of(np.delete(ROW, 5, 0))
    run(tracker, grid_of(ROW, ROW[:0]))
    (inferred,) = tracker.rows["id"][tracker.rows["inferred"]].tolist()
    run(tracker, grid_of(np.delete(ROW, 5, 0), ROW[:0]), 5)
    assert not tracker.rows["inferred"].any()
    assert inferred in tracker.gone


def test_a_find_of_its_own_makes_an_inferred_stall_real_under_the_same_id() -> None:
    tracker = tracker_of(np.delete(ROW, 5, 0))
    run(tracker, grid_of(ROW, ROW[:0]))
    (inferred,) = tracker.rows["id"][tracker.rows["inferred"]].tolist()
    see(tracker, ROW, 1)
    row = tracker.rows[tracker.rows["id"] == inferred][0]
    assert not row["inferred"]
    assert row["confirmed"]
    assert len(tracker.rows) == len(ROW)


@pytest.mark.slow
def test_rows_are_not_doubled_by_runs_from_other_places() -> None:
    tracker, grid = tracker_of(ROW), grid_of(ROW, ROW[:0])
    for i, east in enumerate(np.linspace(-40, 40, 17)):
        finish(RowFiller(20.0), tracker, grid, (0.0, float(east)), 100 + i)
    assert len(tracker.rows) == len(ROW)


def test_a_car_in_the_aisle_that_looks_like_a_stall_does_not_count() -> None:
    alone = np.array([[9.0, 0.0, np.pi / 2, 2.5, 5.0]])
    tracker = tracker_of(np.vstack([ROW, alone]))
    run(tracker, grid_of(ROW, ROW[:0]))
    assert len(tracker.confirmed) == len(ROW)
    assert tracker.rows["lone"].sum() == 1


def test_stalls_are_drawn_onto_their_row() -> None:
    crooked = ROW.copy()
    crooked[:, 0] += np.where(np.arange(11) % 2, 0.3, -0.3)
    tracker = tracker_of(crooked)
    run(tracker, grid_of(ROW, ROW[:0]), 8)
    assert np.abs(tracker.rows["north"]).max() < 0.1


def test_nothing_known_gives_nothing() -> None:
    tracker = StallTracker()
    run(tracker, EvidenceGrid())
    assert len(tracker.rows) == 0


def test_stalls_that_come_and_go_during_a_run_are_left_to_the_next_one() -> None:
    tracker, grid, filler = tracker_of(np.delete(ROW, 5, 0)), grid_of(ROW, ROW[:0]), RowFiller(34.0)
    filler.begin(tracker, grid, (0.0, 0.0))
    for _ in range(2):
        filler.go_on(tracker, 100)
    gone, kept = int(tracker.rows["id"][0]), tracker.rows["id"][1:].tolist()
    tracker.remove(np.array([0]), 100)
    see(tracker, np.array([[0.0, 40.0, 0.0, 2.6, 5.2]]), 5)
    end(filler, tracker, 101)
    ids = tracker.rows["id"].tolist()
    assert gone not in ids
    assert set(kept) < set(ids)
    assert tracker.rows["inferred"].sum() == 1


def test_a_run_takes_several_steps_and_changes_stalls_in_the_last_one_alone() -> None:
    tracker, grid, filler = tracker_of(np.delete(ROW, 5, 0)), grid_of(ROW, ROW[:0]), RowFiller(34.0)
    before = tracker.rows.copy()
    filler.begin(tracker, grid, (0.0, 0.0))
    steps = 0
    while filler.is_under_way:
        assert (tracker.rows == before).all()
        filler.go_on(tracker, 101)
        steps += 1
    assert steps > 2
    assert len(tracker.rows) == len(ROW)


def test_a_dropped_run_changes_nothing() -> None:
    tracker, grid, filler = tracker_of(np.delete(ROW, 5, 0)), grid_of(ROW, ROW[:0]), RowFiller(34.0)
    before = tracker.rows.copy()
    filler.begin(tracker, grid, (0.0, 0.0))
    filler.drop()
    filler.go_on(tracker, 101)
    assert not filler.is_under_way
    assert (tracker.rows == before).all()

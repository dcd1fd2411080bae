"""Labels that a picture's edge or missing ground cuts, and places without an outline."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.perception.edges import counted, cut_labels
from benchmarks.perception.eyes import Result
from benchmarks.perception.measures import look, measure, pooled
from benchmarks.perception.places import Place, missing_ground, state_array
from hawk.model.lot_map import StallState
from hawk.survey.accuracy import Finding, LabelledPlace

STALLS = np.array([[[3 * k, 5], [3 * k + 2.5, 5], [3 * k + 2.5, 10], [3 * k, 10]] for k in range(10)], float)
"""A row of ten; the first begins at the left edge of a picture of 40 m x 20 m."""
LOT = np.array([[0, 0], [40, 0], [40, 20], [0, 20]], float)


class Finder:
    """Finds the given stalls, all of them free."""

    def __init__(self, stalls: NDArray[np.float64]) -> None:
        self._stalls = stalls

    def look(self, image: NDArray[np.uint8], metres_per_pixel: float, *, scale: float = 1.0) -> Result:
        return found(self._stalls)


def found(stalls: NDArray[np.float64]) -> Result:
    return Result(
        Finding(stalls, state_array([StallState.FREE] * len(stalls))),
        np.zeros(len(stalls)),
        np.ones((50, 100), np.bool_),
    )


def place(
    stalls: NDArray[np.float64] = STALLS, lots: tuple[NDArray[np.float64], ...] = (LOT,), name: str = "row"
) -> Place:
    truth = LabelledPlace(stalls, state_array([StallState.FREE] * len(stalls)), lots)
    return Place(name, np.zeros((200, 400, 3), np.uint8), 0.1, truth)


def test_a_cut_label_is_neither_missed_nor_false_when_found() -> None:
    missed, there = (pooled(look(Finder(stalls), [place()])) for stalls in (STALLS[1:], STALLS))
    for measured in (missed, there):
        assert (measured["recall"], measured["precision"], measured["recall_whole"]) == (1.0, 1.0, 1.0)
        assert (measured["labels"], measured["labels_cut"]) == (9, 1)


def test_a_find_within_a_cut_label_that_it_does_not_match_is_not_false() -> None:
    sliver = STALLS[:1] * np.array([0.3, 1.0])
    measured = measure(Finder(np.concatenate([STALLS[1:], sliver])), [place()])
    assert measured["precision"] == 1.0
    beside = STALLS[:1] + np.array([0.0, 7.0])
    assert measure(Finder(np.concatenate([STALLS[1:], beside])), [place()])["precision"] == 0.9, "no label lies there"


def test_a_label_that_counts_keeps_its_match_beside_a_cut_one() -> None:
    """The find lies half in a cut label and matches its whole neighbour."""
    labels = np.concatenate([STALLS[:1] * np.array([1.6, 1.0]), STALLS[1:]])
    kept = counted(found(STALLS[1:]), place(labels))
    assert kept.cut.tolist() == [True] + [False] * 9
    assert len(kept.result.finding.stalls) == len(kept.result.taken) == 9


@pytest.mark.parametrize("shift", [(-2.9, 0.0), (0.0, -5.0), (10.5, 0.0), (0.0, 10.0)])
def test_every_edge_cuts(shift: tuple[float, float]) -> None:
    assert cut_labels(place(STALLS[1:] + shift)).any()
    assert not cut_labels(place(STALLS[1:])).any()


def test_missing_ground_cuts_labels() -> None:
    rng = np.random.default_rng(0)
    image = rng.integers(60, 200, (200, 400, 3)).astype(np.uint8)
    assert missing_ground(image) is None
    image[:, 150:] = 110
    image[150:, :150] = 255  # a bright roof is no missing ground
    missing = missing_ground(image)
    assert missing is not None
    assert missing[:140, 160:].all()
    assert not missing[:, :140].any()
    shown = Place("cut", image, 0.1, place().truth, missing=missing)
    assert cut_labels(shown).tolist() == [True] + [False] * 4 + [True] * 5


def test_a_place_without_an_outline_has_no_lot_iou() -> None:
    outlined, bare = place(), place(lots=())
    both = measure(Finder(STALLS), [outlined, bare])
    assert both["lot_iou"] == measure(Finder(STALLS), [outlined])["lot_iou"] > 0.9
    assert (both["places"], both["lots_outlined"]) == (2, 1)
    assert math.isnan(measure(Finder(STALLS), [bare])["lot_iou"])


def test_halves_of_a_stall_at_a_seam_of_tiles_are_cut() -> None:
    upper, lower = STALLS[4:5].copy(), STALLS[4:5].copy()
    upper[:, 2:, 1], lower[:, :2, 1] = 7.4, 7.5
    labels = np.concatenate([STALLS[1:4], upper, lower, STALLS[5:]])
    assert cut_labels(place(labels)).tolist() == [False] * 3 + [True] * 2 + [False] * 5
    measured = measure(Finder(STALLS[1:]), [place(labels)])
    assert (measured["recall"], measured["precision"]) == (1.0, 1.0)
    beside = STALLS[3:7] * np.array([0.5, 1.0]) + np.array([8.0, 0.0])
    assert not cut_labels(place(beside)).any(), "two narrow stalls side by side are as wide as one"

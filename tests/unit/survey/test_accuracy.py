from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.survey.accuracy import (
    Finding,
    FloatArray,
    LabelledPlace,
    Tally,
    counted_false_alarms,
    is_whole,
    mask_iou,
    match,
    tally,
)

FREE, TAKEN, UNKNOWN = "free", "taken", "unknown"
LOT = np.array([(-5.0, -5.0), (60, -5), (60, 40), (-5, 40)])


def stall(x: float, y: float, angle: float = 0.0, width: float = 2.6, length: float = 5.2) -> FloatArray:
    u, v = np.array([math.cos(angle), math.sin(angle)]) * length / 2, np.array([-math.sin(angle), math.cos(angle)])
    v = v * width / 2
    return np.asarray(np.array([x, y]) + np.array([-u - v, v - u, u + v, u - v]))


def row(count: int, y: float = 0.0, x: float = 0.0) -> FloatArray:
    return np.array([stall(x + 2.6 * k, y, math.pi / 2) for k in range(count)])


def states(*values: str) -> np.ndarray[tuple[int, ...], np.dtype[np.object_]]:
    return np.array(values, dtype=object)


def test_everything_right_scores_one() -> None:
    stalls, said = row(4), states(FREE, TAKEN, FREE, TAKEN)
    measures = tally(Finding(stalls, said), LabelledPlace(stalls, said, (LOT,))).measures()
    ones = {k: v for k, v in measures.items() if k not in ("unknown_share", "free_count_error")}
    assert all(v == 1.0 for v in ones.values())
    assert measures["unknown_share"] == measures["free_count_error"] == 0


@given(st.floats(0, 2.6))
@settings(max_examples=40)
def test_a_shift_across_matches_exactly_up_to_an_overlap_of_one_half(shift: float) -> None:
    overlap = (2.6 - shift) / (2.6 + shift)
    if abs(overlap - 0.5) < 1e-6:
        return
    assert len(match(row(1, x=shift), row(1))) == (overlap >= 0.5)


def test_the_order_of_the_corners_does_not_matter() -> None:
    quad = row(1)
    assert len(match(quad[:, ::-1], np.roll(quad, 2, axis=1))) == 1
    assert len(match(quad[:, [0, 2, 1, 3]], quad)) == 1  # crossed corners are taken as the hull


def test_a_true_stall_is_matched_once_and_the_rest_are_false_alarms() -> None:
    found = np.concatenate([row(1), row(1, x=0.2), row(1, y=0.3)])
    matches = match(found, row(1))
    assert matches.found.tolist() == [0]
    counts = tally(Finding(found, states(FREE, FREE, FREE)), LabelledPlace(row(1), states(FREE), (LOT,)))
    assert (counts.matched, counts.counted) == (1, 2)
    assert counts.precision == pytest.approx(1 / 3)


def test_matching_prefers_more_matches_over_better_ones() -> None:
    true = np.concatenate([row(1), row(1, x=1.0)])
    found = np.concatenate([row(1, x=0.45), row(1, x=-0.4)])
    assert len(match(found, true)) == 2


def test_a_row_that_nobody_labelled_does_not_count_but_alarms_near_labels_and_outside_do() -> None:
    truth = LabelledPlace(row(3), states(FREE, FREE, FREE), (LOT,))
    unlabelled, beside, outside = row(1, y=20.0), row(1, x=-2.0), row(1, x=-30.0)
    found = np.concatenate([row(3), unlabelled, beside, outside])
    alarms = counted_false_alarms(found, match(found, truth.stalls), truth)
    assert alarms.tolist() == [False, False, False, False, True, True]
    counts = tally(Finding(found, states(*[FREE] * 6)), truth)
    assert counts.precision == pytest.approx(3 / 6)
    assert counts.precision_star == pytest.approx(3 / 5)
    assert counts.free_precision_star == pytest.approx(3 / 5)


def test_without_an_outline_every_false_alarm_counts() -> None:
    found = row(1, y=20.0)
    truth = LabelledPlace(row(3), states(FREE, FREE, FREE))
    assert counted_false_alarms(found, match(found, truth.stalls), truth).tolist() == [True]


def test_unknown_is_wrong_as_a_state_and_missed_as_free() -> None:
    stalls = row(4)
    counts = tally(
        Finding(stalls, states(FREE, UNKNOWN, UNKNOWN, FREE)),
        LabelledPlace(stalls, states(FREE, FREE, TAKEN, TAKEN), (LOT,)),
    )
    assert counts.state_accuracy == 0.25
    assert counts.free_recall == 0.5
    assert counts.free_precision_star == 0.5
    assert counts.unknown_share == 0.5
    assert counts.free_count_error == 0


def test_labels_of_unclear_state_count_as_stalls_only() -> None:
    counts = tally(Finding(row(2), states(FREE, TAKEN)), LabelledPlace(row(2), states(UNKNOWN, TAKEN), (LOT,)))
    assert (counts.recall, counts.judged, counts.state_accuracy) == (1.0, 1, 1.0)


def test_only_whole_labels_count_for_recall_whole() -> None:
    small = np.array([stall(20, 0, 0, 1.5, 4.5), stall(24, 9, 0.3, 2.5, 3.5), stall(30, 20, 1, 4.0, 5.0)])
    truth = np.concatenate([row(2), small])
    assert is_whole(truth).tolist() == [True, True, False, False, False]
    counts = tally(Finding(row(1), states(FREE)), LabelledPlace(truth, states(*[FREE] * 5), (LOT,)))
    assert (counts.recall, counts.recall_whole) == (0.2, 0.5)


def test_free_counts_are_compared() -> None:
    counts = tally(Finding(row(5), states(*[FREE] * 5)), LabelledPlace(row(3), states(FREE, TAKEN, TAKEN), (LOT,)))
    assert counts.free_count_error == 4


def test_tallies_of_places_add_up() -> None:
    one = tally(Finding(row(2), states(FREE, FREE)), LabelledPlace(row(4), states(*[FREE] * 4), (LOT,)))
    two = tally(Finding(row(4), states(*[FREE] * 4)), LabelledPlace(row(2), states(FREE, FREE), (LOT,)))
    assert (one + two).f1 == pytest.approx(8 / 12)
    assert one + Tally() == one


def test_nothing_found_and_nothing_there() -> None:
    nothing = np.zeros((0, 4, 2))
    counts = tally(Finding(nothing, states()), LabelledPlace(row(2), states(FREE, TAKEN), (LOT,)))
    assert math.isnan(counts.precision)
    assert (counts.recall, counts.f1, counts.unknown_share) == (0.0, 0.0, 0.0)
    assert tally(Finding(row(1), states(FREE)), LabelledPlace(nothing, states())).counted == 1


def test_masks_are_compared() -> None:
    mask = np.arange(6).reshape(2, 3)
    assert mask_iou(mask < 4, mask >= 2) == pytest.approx(2 / 6)


@pytest.mark.slow
@given(st.floats(0, math.pi))
@settings(max_examples=40)
def test_touching_neighbours_are_never_matched(angle: float) -> None:
    place = np.array([-math.sin(angle), math.cos(angle)]) * 2.6
    stalls = np.array([stall(10 + place[0] * k, -20 + place[1] * k, angle) for k in range(12)])
    assert len(match(stalls[::2], stalls[1::2])) == 0
    assert match(stalls, stalls).found.tolist() == match(stalls, stalls).true.tolist() == list(range(12))

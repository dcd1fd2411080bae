from __future__ import annotations

import math

import numpy as np
import pytest

from hawk.algo.rows.evidence import BEYOND, FEATURES, STEPS, WEIGHTS, Strip, strip
from hawk.algo.rows.fit import Finds, Row, fit_row
from tests.unit.algo.rows.parking import LENGTH, WIDTH, finds_at, ground_of, joined, row_at

ANGLE = 0.3 + math.pi / 2


def row_of(finds: Finds) -> Row:
    row = fit_row(finds, np.arange(len(finds)))
    assert row is not None
    return row


def read(truth: np.ndarray, finds: Finds, cars: np.ndarray | None = None) -> tuple[Row, Strip]:
    row = row_of(finds)
    return row, strip(row, ground_of(truth, ANGLE, cars), finds)


def feature(read_: Strip, name: str, t: float) -> float:
    return float(read_.features[int(np.abs(read_.t - t).argmin()), FEATURES.index(name)])


def test_a_strip_reaches_past_the_ends_of_its_row_in_steps_of_a_share_of_a_stall() -> None:
    truth = row_at(8)
    row, found = read(truth, finds_at(truth, ANGLE))
    assert found.step == pytest.approx(row.pitch / STEPS)
    assert found.features.shape == (len(found.t), len(FEATURES))
    assert len(WEIGHTS) == len(FEATURES) + 1
    assert found.t[0] <= row.low - (BEYOND - 0.1) * row.pitch
    assert found.t[-1] >= row.high + (BEYOND - 0.1) * row.pitch
    assert (found.seen == 1).all()


def test_at_a_stall_the_inside_shows_and_half_a_stall_on_the_rims_do() -> None:
    truth = row_at(8)
    row, found = read(truth, finds_at(truth, ANGLE))
    at, between = float(row.place(truth)[0][3]), float(row.place(truth)[0][3]) + row.pitch / 2
    assert feature(found, "core", at) > 0.85
    assert feature(found, "core less rims", at) > 0.7
    assert feature(found, "core less rims", between) < 0
    assert feature(found, "found", at) > 0.85
    assert feature(found, "found", between) == 0
    odds = found.log_odds()
    assert odds[np.abs(found.t - at).argmin()] > 2 > -1 > odds[np.abs(found.t - between).argmin()]


def test_what_lies_deeper_than_the_stalls_shows_at_their_ends() -> None:
    truth = row_at(6)
    row, found = read(np.concatenate([truth, truth + 0.5 * LENGTH * np.array([math.cos(ANGLE), math.sin(ANGLE)])]),
                      finds_at(truth, ANGLE))  # fmt: skip
    assert feature(found, "core at the ends", float(row.place(truth)[0][2])) > 0.2


def test_cars_show_in_their_stalls() -> None:
    truth = row_at(6)
    row, found = read(truth, finds_at(truth, ANGLE), cars=truth[2:3])
    t = row.place(truth)[0]
    assert feature(found, "car", float(t[2])) > 0.8
    assert feature(found, "car less rims", float(t[2])) > 0.6
    assert feature(found, "car", float(t[4])) == 0


def test_finds_at_the_back_beside_and_on_both_sides_support_a_stall() -> None:
    truth = row_at(6)
    back = truth + LENGTH * np.array([math.cos(ANGLE), math.sin(ANGLE)])
    finds = joined(finds_at(truth[[0, 1, 3, 4]], ANGLE), finds_at(back[2:3], ANGLE, 0.7))
    row = row_of(finds[:4])
    found = strip(row, ground_of(truth, ANGLE), finds)
    t = row.place(truth)[0]
    assert feature(found, "found", float(t[2])) == 0
    assert feature(found, "found at the back", float(t[2])) == pytest.approx(0.7, abs=0.1)
    assert feature(found, "found on both sides", float(t[2])) == pytest.approx(0.9, abs=0.1)
    assert feature(found, "found beside", float(t[5])) == pytest.approx(0.9, abs=0.1)
    assert feature(found, "found on both sides", float(t[5])) < 0.1


def test_a_find_of_another_direction_supports_nothing() -> None:
    truth = row_at(6)
    row = row_of(finds_at(truth, ANGLE))
    across = finds_at(truth, ANGLE + 0.8)
    found = strip(row, ground_of(truth, ANGLE), across)
    assert not found.features[:, [3, 4, 9, 10, 11]].any()


def test_ground_that_nobody_saw_is_not_seen() -> None:
    truth = row_at(6)
    finds = finds_at(truth, ANGLE)
    whole = ground_of(truth, ANGLE)

    def half(places: np.ndarray) -> object:
        ground = whole(places)
        ground.seen[row_of(finds).place(places.reshape(-1, 2))[0].reshape(places.shape[:-1]) > 0] = 0
        return ground

    found = strip(row_of(finds), half, finds)  # type: ignore[arg-type]
    assert found.seen[found.t < -WIDTH].min() == 1
    assert found.seen[found.t > WIDTH].max() == 0

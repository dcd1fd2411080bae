from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.algo.rows.fit import fit_row, fit_rows, row_of
from hawk.algo.vision import quads
from tests.unit.algo.rows.parking import LENGTH, WIDTH, finds_at, joined, row_at

LEANS = [math.pi / 2, math.radians(60), math.radians(45), math.radians(120)]


@pytest.mark.parametrize("lean", LEANS)
@given(direction=st.floats(0, math.pi), seed=st.integers(0, 99))
@settings(max_examples=20)
def test_a_row_has_the_line_the_pitch_and_the_size_of_its_finds(lean: float, direction: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    truth = row_at(12, direction, lean)
    kept = np.sort(rng.choice(12, 9, replace=False))
    finds = finds_at(truth[kept] + rng.normal(0, 0.05, (9, 2)), direction + lean)
    (row,) = fit_rows(finds, 0.3)
    assert row.pitch == pytest.approx(WIDTH / math.sin(lean), rel=0.02)
    assert row.width == pytest.approx(WIDTH, rel=0.03)
    assert row.length == pytest.approx(LENGTH)
    assert float(quads.angle_between(row.angle, direction + lean)) < 0.01
    _, aside = row.place(truth)
    assert np.abs(aside).max() < 0.15
    assert row.bend == 0


def test_one_stall_out_of_line_does_not_turn_the_row() -> None:
    truth = row_at(10, 0.0, origin=(0, 0))
    crooked = truth.copy()
    crooked[9] += (0.0, 1.2)
    row = fit_row(finds_at(crooked, math.pi / 2), np.arange(10))
    assert row is not None
    assert np.abs(row.place(truth)[1]).max() < 0.2


def test_a_row_on_an_arc_bends_and_its_stalls_turn_with_it() -> None:
    turn = np.linspace(-0.5, 0.5, 14)
    radius = 13 * WIDTH
    centres = radius * np.column_stack([np.sin(turn), 1 - np.cos(turn)])
    finds = finds_at(centres, math.pi / 2 + turn)
    (row,) = fit_rows(finds, 0.3)
    assert row.bend != 0
    t, aside = row.place(centres)
    assert np.abs(aside).max() < 0.6
    sides = row.sides(t)
    middle = np.abs(t) < 10
    assert quads.angle_between(np.arctan2(sides[:, 1], sides[:, 0]), finds.angle)[middle].max() < 0.1


def test_centres_and_places_are_each_other_s_inverse() -> None:
    row = fit_row(finds_at(row_at(6, 1.1), 1.1 + math.pi / 2), np.arange(6))
    assert row is not None
    t = np.linspace(-20, 20, 9)
    place, aside = row.place(row.centres(t))
    np.testing.assert_allclose(place, t, atol=1e-9)
    np.testing.assert_allclose(aside, 0, atol=1e-9)


def test_two_rows_back_to_back_are_two_rows() -> None:
    first = row_at(6, 0.0, origin=(0, 0))
    both = finds_at(np.concatenate([first, first + np.array([0.0, LENGTH])]), math.pi / 2)
    rows = row_of(both)
    assert len(set(rows[:6])) == len(set(rows[6:])) == 1
    assert rows[0] != rows[6]
    assert len(fit_rows(both, 0.3)) == 2


@pytest.mark.parametrize(("island", "count"), [(0.0, 1), (1.3, 1), (9.0, 1), (20.0, 2)])
def test_rows_that_go_on_in_one_line_are_one_row_unless_they_lie_far_apart(island: float, count: int) -> None:
    first = row_at(5, 0.0, origin=(0, 0))
    second = row_at(5, 0.0, origin=(5 * WIDTH + island, 0))
    assert len(fit_rows(finds_at(np.concatenate([first, second]), math.pi / 2), 0.3)) == count


@pytest.mark.parametrize("change", ["aside", "turned", "longer", "wider"])
def test_another_line_direction_length_or_pitch_is_another_row(change: str) -> None:
    first = finds_at(row_at(5, 0.0, origin=(0, 0)), math.pi / 2)
    begin = 5 * WIDTH + 9.5
    second = {
        "aside": finds_at(row_at(5, 0.0, origin=(begin, 1.5)), math.pi / 2),
        "turned": finds_at(row_at(5, 0.0, math.radians(70), (begin, 0)), math.radians(70)),
        "longer": finds_at(row_at(5, 0.0, origin=(begin, 0)), math.pi / 2),
        "wider": finds_at(np.array([begin, 0]) + np.arange(5)[:, None] * np.array([3.2, 0.0]), math.pi / 2),
    }[change]
    if change == "longer":
        second = finds_at(second.centres, math.pi / 2)
        second.length[:] = 7.0
    assert len(fit_rows(joined(first, second), 0.3)) == 2


def test_stalls_one_behind_the_other_and_of_no_stall_s_width_make_no_row() -> None:
    in_line = np.array([[0.0, 0.0], [6.0, 0.3]])
    assert fit_row(finds_at(in_line, 0.0), np.arange(2)) is not None, "each by itself side by side"
    narrow = finds_at(np.arange(5)[:, None] * np.array([1.4, 0.0]), math.pi / 2)
    narrow.width[:] = 1.4
    assert fit_row(narrow, np.arange(5)) is None


def test_weak_finds_make_no_rows() -> None:
    assert fit_rows(finds_at(row_at(5), 0.3 + math.pi / 2, 0.2), 0.3) == []
    assert fit_rows(finds_at(np.zeros((0, 2)), 0.0), 0.3) == []

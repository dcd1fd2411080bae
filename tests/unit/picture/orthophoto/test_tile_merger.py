"""Windows merged at their seams."""

from __future__ import annotations

import random
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from hawk.algo.vision import quads
from hawk.picture.orthophoto.grid import Box
from hawk.picture.orthophoto.source import open_orthophoto
from hawk.picture.orthophoto.tile_detector import TileVehicles
from hawk.picture.orthophoto.tile_merger import SAME, Stalls, merge_tiles
from hawk.picture.orthophoto.windows import Window, WindowStalls, map_window, windows_of
from tests.unit.picture.orthophoto.drawn import detector, lot_file

METRES = (0.1, 0.1)
CORE, MARGIN = 400, 160
Floats = NDArray[np.float64]


def window_at(column: int, row: int) -> Window:
    core: Box = (column * CORE, row * CORE, (column + 1) * CORE, (row + 1) * CORE)
    return Window(core, (core[0] - MARGIN, core[1] - MARGIN, core[2] + MARGIN, core[3] + MARGIN))


def seen_by(window: Window, middles: Floats, score: Floats | None = None, length: float = 50.0) -> WindowStalls:
    """Return the stalls (N, 2), standing upright, of those that a window reports."""
    near = (middles >= np.array(window.core[:2]) - 45).all(1) & (middles < np.array(window.core[2:]) + 45).all(1)
    at = middles[near]
    corners = quads.corners(at[:, 0], at[:, 1], *(np.full(len(at), v) for v in (np.pi / 2, 25.0, length)))
    scores = np.full(len(middles), 0.9) if score is None else score
    mask = np.zeros((2, 2), np.bool_)
    return WindowStalls(window, corners, np.full(len(at), 0.2), scores[near], np.zeros((0, 4, 2)), mask, mask)


def test_a_vehicle_that_two_windows_saw_is_found_once() -> None:
    parts, nothing = [], np.zeros((0, 2))
    for column, (x, probability) in enumerate([(CORE - 2.0, 0.6), (CORE + 1.0, 0.9)]):
        corners = quads.corners(
            np.array([x, 100.0 + 700 * column]), np.full(2, 200.0), *np.array([[0.0] * 2, [19] * 2, [46] * 2])
        )
        vehicles = TileVehicles(corners, np.array([probability, 0.8]), np.array([0, 1]))
        parts.append(replace(seen_by(window_at(column, 0), nothing), vehicles=vehicles))
    merged = merge_tiles(parts, METRES).vehicles
    assert merged is not None
    assert sorted(zip(merged.probability.tolist(), merged.kind.tolist(), strict=True)) == [(0.8, 1), (0.8, 1), (0.9, 0)]
    assert merge_tiles([seen_by(window_at(0, 0), nothing)], METRES).vehicles is None


def same(one: Stalls, other: Stalls) -> bool:
    names = ("corners", "taken", "score", "suggested")
    return all(np.array_equal(getattr(one, name), getattr(other, name)) for name in names)


@pytest.mark.slow
@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0, 0.25))
def test_each_stall_is_found_once_whichever_windows_saw_it(seed: int, noise: float) -> None:
    rng = np.random.default_rng(seed)
    columns, rows = np.meshgrid(np.arange(-10.0, 1200.0, 25.0), np.arange(-10.0, 800.0, 60.0))
    truth = np.column_stack([columns.ravel(), rows.ravel()]) + rng.uniform(0, 20, 2)
    truth = truth[rng.random(len(truth)) < 0.7]
    truth = truth[(truth >= 0).all(1) & (truth < (1200, 800)).all(1)]
    spread = noise / METRES[0]
    parts = [
        seen_by(window_at(column, row), truth + np.clip(rng.normal(0, spread, truth.shape), -2 * spread, 2 * spread))
        for column in range(3)
        for row in range(2)
    ]
    found = merge_tiles(parts, METRES)
    apart = np.hypot(*(found.corners.mean(axis=1)[:, None] - truth[None]).transpose(2, 0, 1))
    assert len(found) == len(truth)
    assert sorted(apart.argmin(axis=0).tolist()) == list(range(len(truth)))
    assert apart.min(axis=0).max() <= 2 * spread * np.sqrt(2) + 1e-9
    random.Random(seed).shuffle(parts)
    assert same(merge_tiles(parts, METRES), found)


def test_a_stall_that_each_window_puts_on_the_other_side_is_kept_once() -> None:
    left, right = window_at(0, 0), window_at(1, 0)
    found = merge_tiles([seen_by(left, np.array([(402.0, 200.0)])), seen_by(right, np.array([(398.0, 200.0)]))], METRES)
    assert len(found) == 1
    only = merge_tiles([seen_by(left, np.array([(402.0, 200.0)])), seen_by(right, np.zeros((0, 2)))], METRES)
    assert only.corners.mean(axis=1).tolist() == [[402.0, 200.0]]


def test_a_window_keeps_its_own_stall_over_that_of_its_neighbour() -> None:
    left, right = window_at(0, 0), window_at(1, 0)
    score = np.array([0.99])
    found = merge_tiles(
        [seen_by(left, np.array([(405.0, 200.0)]), score), seen_by(right, np.array([(410.0, 200.0)]))], METRES
    )
    assert found.corners.mean(axis=1).tolist() == [[410.0, 200.0]]


def test_stalls_side_by_side_on_a_seam_are_two() -> None:
    parts = [seen_by(window_at(column, 0), np.array([(387.5, 200.0), (412.5, 200.0)])) for column in (0, 1)]
    assert len(merge_tiles(parts, METRES)) == 2


def test_without_a_window_or_a_stall_there_is_nothing() -> None:
    assert len(merge_tiles([], METRES)) == 0
    assert len(merge_tiles([seen_by(window_at(0, 0), np.zeros((0, 2)))], METRES)) == 0


@pytest.mark.nightly
@pytest.mark.slow
def test_twenty_thousand_stalls_are_merged_within_seconds() -> None:
    columns, rows = np.meshgrid(np.arange(12.0, 8000.0, 25.0), np.arange(30.0, 4000.0, 61.0))
    truth = np.column_stack([columns.ravel(), rows.ravel()])
    parts = [seen_by(window_at(column, row), truth) for column in range(20) for row in range(10)]
    begun = time.process_time()
    found = merge_tiles(parts, METRES)
    assert time.process_time() - begun < 8
    assert len(found) == len(truth) > 20_000


@pytest.mark.nightly
def test_a_lot_in_small_windows_has_the_stalls_that_it_has_as_a_whole(tmp_path: Path) -> None:
    source = open_orthophoto(lot_file(tmp_path))
    whole, parts = (
        [map_window(source, window, detector()) for window in windows_of(source, core_m=core)] for core in (128.0, 24.0)
    )
    assert (len(whole), len(parts)) == (1, 6)
    expected, found = merge_tiles(whole, source.grid.metres), merge_tiles(parts, source.grid.metres)
    assert same(merge_tiles(parts[::-1], source.grid.metres), found)
    i, j = quads.near_pairs(expected.corners.mean(axis=1), found.corners.mean(axis=1), 20.0)
    overlap = quads.overlaps(expected.corners[i], found.corners[j])
    assert (overlap > 0.5).sum() >= len(expected) - 1
    assert abs(len(found) - len(expected)) <= 1
    pairs = np.array([(a, b) for a in range(len(found)) for b in range(a)])
    assert quads.overlaps(found.corners[pairs[:, 0]], found.corners[pairs[:, 1]]).max() < SAME / 2

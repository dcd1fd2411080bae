from __future__ import annotations

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from hawk.algo.mapper.table import pair

Floats = NDArray[np.float64]


def row(count: int, angle: float = 0.0) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """A row of 2.6 m wide stalls, turned."""
    at = np.arange(count, dtype=np.float64) * 2.6
    ones = np.ones(count, np.float64)
    return -at * math.sin(angle), at * math.cos(angle), ones * angle, ones * 2.6, ones * 5.2


@given(st.floats(-1.2, 1.2), st.floats(-2.0, 2.0), st.floats(0, math.pi - 0.01))
def test_a_row_is_found_again_within_half_a_pitch(across: float, along: float, angle: float) -> None:
    known = row(12, angle)
    c, s = math.cos(angle), math.sin(angle)
    north, east = known[0] + along * c - across * s, known[1] + along * s + across * c
    order = np.random.default_rng(0).permutation(12)
    k, f = pair(known, (north[order], east[order], known[2]))
    assert len(k) == 12
    assert (order[f] == k).all()


def test_a_pair_needs_a_common_direction_and_place() -> None:
    known = row(1)
    for north, east, angle in ((0.0, 1.5, 0.0), (2.6, 0.0, 0.0), (0.0, 0.0, 0.5)):
        assert len(pair(known, (np.array([north]), np.array([east]), np.array([angle])))[0]) == 0


def test_directions_are_equal_modulo_pi() -> None:
    k, _ = pair(row(1), (np.zeros(1), np.zeros(1), np.array([math.pi - 0.05])))
    assert len(k) == 1


def test_each_is_paired_once() -> None:
    found = (np.zeros(3), np.array([0.0, 0.3, -0.3]), np.zeros(3))
    k, f = pair(row(1), found)
    assert k.tolist() == [0]
    assert f.tolist() == [0]


def test_nothing_pairs_with_nothing() -> None:
    none = np.zeros(0)
    assert len(pair(row(3), (none, none, none))[0]) == 0
    assert len(pair(row(0), (np.zeros(2), np.zeros(2), np.zeros(2)))[0]) == 0

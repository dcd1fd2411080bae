from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binomtest

from hawk.lots.storage.database import Database
from hawk.model.lot_map import StallState
from hawk.stats.queries import share_bounds, stalls_use
from tests.unit.stats.test_panel import EVER, later, lot_of, seen


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Database]:
    opened = Database(tmp_path / "lots.db")
    yield opened
    opened.close()


def test_heat_is_the_share_of_surveys_that_saw_a_stall_taken(store: Database) -> None:
    taken, unknown = StallState.TAKEN, StallState.UNKNOWN
    lot = lot_of(store, seen({1: taken, 2: taken}), later(seen({1: taken, 2: unknown}), 1))
    with store.reading() as connection:
        found = stalls_use(connection, lot, EVER).model_dump(mode="json")
    assert found["surveys_in_period"] == 2
    assert dict(zip(found["labels"][:3], zip(found["surveys"], found["share"], strict=True), strict=False)) == {
        "A 1": (2, 1.0), "A 2": (1, 1.0), "A 3": (2, 0.0),
    }  # fmt: skip
    assert all(
        low <= share <= high for low, share, high in zip(found["low"], found["share"], found["high"], strict=True)
    )
    assert found["low"][1] < found["low"][0]  # fewer looks, a wider interval


def test_shares_have_four_decimals(store: Database) -> None:
    lot = lot_of(store, seen({1: StallState.TAKEN}), later(seen({}), 1), later(seen({}), 2))
    with store.reading() as connection:
        found = stalls_use(connection, lot, EVER)
    assert (found.share[0], found.share[1]) == (0.3333, 0.0)
    assert all(each == round(each or 0.0, 4) for each in (*found.low, *found.high))


def test_a_stall_that_no_survey_saw_has_no_share(store: Database) -> None:
    lot = lot_of(store, seen({3: StallState.UNKNOWN}))
    with store.reading() as connection:
        found = stalls_use(connection, lot, EVER).model_dump(mode="json")
    assert (found["surveys"][2], found["share"][2], found["low"][2], found["high"][2]) == (0, None, None, None)


@given(st.integers(1, 200).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n))))
def test_without_doubt_the_interval_is_that_of_wilson(counts: tuple[int, int]) -> None:
    taken, looks = counts
    low, high = share_bounds(np.array([float(taken)]), np.array([float(looks)]), np.zeros(1))
    wanted = binomtest(taken, looks).proportion_ci(0.9, "wilson")
    assert (low[0], high[0]) == pytest.approx((wanted.low, wanted.high), abs=1e-4)


def test_doubtful_states_widen_the_interval() -> None:
    sure, doubtful = (share_bounds(np.array([5.0]), np.array([10.0]), np.array([wrong])) for wrong in (0.0, 2.0))
    assert doubtful[0] < sure[0]
    assert sure[1] < doubtful[1]

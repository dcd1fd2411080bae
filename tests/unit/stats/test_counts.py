from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.model.lot_map import SPREADS, free_variance
from hawk.stats.counts import count
from hawk.stats.values import FREE, TAKEN, UNSEEN
from tests.unit.stats.panels import at, everything, panel


def test_the_share_is_of_stalls_with_a_state_and_its_interval_is_that_of_the_count_of_free_ones() -> None:
    seen = panel([at(9)], [[TAKEN] * 6 + [FREE] * 4], sure=0.9)
    found = count(seen, everything(seen)).shares()[0]
    off = SPREADS * (10 * free_variance(1.0, 0.9)) ** 0.5 / 10
    assert (found.value, found.surveys) == (0.6, 1)
    assert (found.low, found.high) == pytest.approx((0.6 - off, 0.6 + off))


def test_unseen_stalls_widen_the_interval_up_to_all_free_and_all_taken() -> None:
    whole = panel([at(9)], [[TAKEN] * 50 + [FREE] * 50])
    gaps = panel([at(9)], [[TAKEN] * 40 + [FREE] * 40 + [UNSEEN] * 20])
    narrow, wide = (count(each, everything(each)).shares()[0] for each in (whole, gaps))
    assert narrow.low is not None
    assert narrow.high is not None
    assert wide.low is not None
    assert wide.high is not None
    assert wide.value == 0.5
    assert 0.4 <= wide.low < narrow.low
    assert narrow.high < wide.high <= 0.6 + 0.02


def test_a_group_of_which_nothing_was_seen_has_no_figure() -> None:
    none = panel([at(9)], [[UNSEEN] * 5])
    found = count(none, everything(none)).shares()[0]
    assert (found.value, found.low, found.high, found.surveys) == (None, None, None, 0)


@given(states=st.lists(st.sampled_from([FREE, TAKEN, UNSEEN]), min_size=1, max_size=60), sure=st.floats(0.5, 1.0))
def test_the_interval_holds_its_value_and_what_all_unseen_stalls_allow_bounds_it(
    states: list[int], sure: float
) -> None:
    seen = panel([at(9)], [states], sure=sure)
    counted = count(seen, everything(seen))
    found = counted.shares()[0]
    if found.value is None or found.low is None or found.high is None:
        assert set(states) == {UNSEEN}
        return
    assert 0 <= found.low <= found.value + 1e-9
    assert found.value - 1e-9 <= found.high <= 1
    if sure == 1.0:
        assert found.low >= states.count(TAKEN) / len(states) - 1e-9
        assert found.high <= 1 - states.count(FREE) / len(states) + 1e-9


@pytest.mark.slow
def test_unseen_stalls_drawn_at_random_are_within_the_interval_in_nine_of_ten_draws_or_more() -> None:
    rng, held = np.random.default_rng(1), 0
    for _ in range(300):
        real = (rng.random(80) < 0.6).astype(int)
        seen = np.where(rng.random(80) < 0.3, UNSEEN, real)
        each = panel([at(9)], [seen.tolist()])
        found = count(each, everything(each)).shares()[0]
        assert found.low is not None
        assert found.high is not None
        held += found.low <= real.mean() <= found.high
    assert held >= 270

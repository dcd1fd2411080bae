from __future__ import annotations

import numpy as np
import pytest

from hawk.stats.values import DEVIATIONS, LEVEL, NOTHING, Estimate, total_of


def held(*, is_common: bool) -> tuple[float, float]:
    """Return the share of drawn groups of lots whose true total lies within each interval: ``alike``, ``apart``."""
    rng = np.random.default_rng(3)
    counts = np.zeros(2)
    rounds = 4000
    for _ in range(rounds):
        truth, sigma = rng.uniform(20, 400, 12), rng.uniform(1, 9, 12)
        error = sigma * (rng.normal() if is_common else rng.normal(size=12))
        lots = [
            Estimate(value, value - off, value + off, 1)
            for value, off in zip((truth + error).tolist(), (DEVIATIONS * sigma).tolist(), strict=True)
        ]
        found = total_of(lots)
        ends = [((each.low or 0.0), (each.high or 0.0)) for each in (found.alike, found.apart)]
        counts += [low <= truth.sum() <= high for low, high in ends]
    alike, apart = (counts / rounds).tolist()
    return alike, apart


def test_a_total_of_lots_that_err_each_for_itself_holds_within_the_narrow_interval() -> None:
    alike, apart = held(is_common=False)
    assert apart == pytest.approx(LEVEL, abs=0.02)
    assert alike > 0.99


def test_a_total_of_lots_that_err_alike_holds_within_the_wide_interval_alone() -> None:
    alike, apart = held(is_common=True)
    assert alike == pytest.approx(LEVEL, abs=0.02)
    assert apart < 0.5


def test_a_figure_without_a_value_is_in_no_total() -> None:
    one = Estimate(10.0, 7.0, 14.0, 1)
    assert total_of([NOTHING, one]).alike == one
    assert total_of([NOTHING, one]).apart == one
    assert total_of([NOTHING]).alike == NOTHING
    assert total_of([]).apart == NOTHING

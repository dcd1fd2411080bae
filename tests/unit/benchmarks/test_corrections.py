"""The benchmark of corrections measures every operation, on a small lot."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.corrections import LIMITS_MS, figures, measure
from hawk.lots.plan.operations import NAMES


@pytest.mark.nightly
@pytest.mark.slow
def test_each_operation_of_a_small_lot_costs_something(tmp_path: Path) -> None:
    measured = measure(tmp_path, 300)
    assert all(done > 0 and again > 0 for done, again in measured.values())
    measured_ones = {name for name in NAMES if any(each.startswith(name) for each in measured)}
    assert measured_ones == {*NAMES} - {"allow", "confirm", "erase_zone"}  # as forbid, set_kind and draw_zone


def test_an_operation_that_takes_too_long_misses_its_limit_and_one_on_a_whole_lot_has_none() -> None:
    costs = {"remove": (14.0, 16.0), "set_kind_of_all": (900.0, 900.0)}
    assert {figure.key: figure.passed for figure in figures({300: costs})} == {
        "remove_300_ms": True,
        "remove_again_300_ms": False,
        "set_kind_of_all_300_ms": None,
        "set_kind_of_all_again_300_ms": None,
    }
    assert LIMITS_MS == {300: 15.0, 20_000: 100.0}

from __future__ import annotations

import io
import json
import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console

from benchmarks.figures import (
    Figure,
    Limit,
    Reference,
    Section,
    flat,
    interval_jitter,
    number,
    print_table,
    write_json,
)


@pytest.mark.parametrize(
    ("limit", "value", "holds"),
    [
        (Limit(highest=10.0), 10.0, True),
        (Limit(highest=10.0), 10.1, False),
        (Limit(lowest=8.0), 7.9, False),
        (Limit(4.9, 5.1), 5.0, True),
        (Limit(0, 0), 1.0, False),
        (Limit(highest=10.0), None, False),
        (Limit(highest=10.0), math.nan, False),
    ],
)
def test_a_limit_holds_only_for_what_was_measured_within_it(limit: Limit, value: float | None, holds: bool) -> None:
    assert limit.holds(value) is holds
    assert Figure("key", "text", value, limit=limit).passed is holds


def test_a_figure_without_a_limit_neither_passes_nor_fails() -> None:
    assert Figure("key", "text", 1.0).passed is None


@pytest.mark.parametrize(
    ("value", "reference", "ratio"),
    [
        (6.0, Reference("idle", 2.0), 3.0),
        (6.0, None, None),
        (None, Reference("idle", 2.0), None),
        (6.0, Reference("idle", 0.0), None),
        (6.0, Reference("idle", None), None),
    ],
)
def test_a_ratio_needs_both_sides(value: float | None, reference: Reference | None, ratio: float | None) -> None:
    assert Figure("key", "text", value, reference=reference).ratio == ratio


def test_jitter_is_how_far_each_interval_is_off() -> None:
    assert interval_jitter([0.0, 0.2, 0.43, 0.6], 0.2) == pytest.approx([0.0, 30.0, 30.0])
    assert interval_jitter([1.0], 0.2) == []


@given(st.lists(st.floats(0, 100), min_size=2, max_size=20), st.floats(-1e3, 1e3))
def test_jitter_does_not_depend_on_when_it_began(times: list[float], shift: float) -> None:
    ordered = sorted(times)
    moved = [time + shift for time in ordered]
    assert interval_jitter(moved, 0.2) == pytest.approx(interval_jitter(ordered, 0.2), abs=1e-6)


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0, "0"), (0.01234, "0.0123"), (1.0, "1"), (12.345, "12.3"), (123.4, "123"), (None, "–"), (math.nan, "–")],
)
def test_numbers_have_three_digits(value: float | None, text: str) -> None:
    assert number(value) == text


def test_the_json_object_is_flat_and_finite(tmp_path: Path) -> None:
    sections = [
        Section("one", [Figure("a", "", 1.5), Figure("b", "", None)]),
        Section("two", [Figure("c", "", math.nan)], "void"),
    ]
    write_json(tmp_path / "out.json", flat(sections))
    assert json.loads((tmp_path / "out.json").read_text()) == {"a": 1.5, "b": None, "c": None}


def test_two_figures_cannot_share_a_key() -> None:
    with pytest.raises(ValueError, match="two figures are called a"):
        flat([Section("one", [Figure("a", "", 1.0)]), Section("two", [Figure("a", "", 2.0)])])


def test_the_table_has_figure_reference_ratio_limit_and_what_was_void() -> None:
    figure = Figure("lag", "loop lag", 30.0, "ms", Reference("idle loop", 10.0), Limit(highest=20.0))
    out = io.StringIO()
    print_table([Section("latency", [figure], "VOID: [others] worked")], Console(file=out, width=120))
    printed = out.getvalue()
    for part in ("loop lag", "30", "ms", "idle loop 10", "3.00", "≤ 20", "MISSED", "latency: VOID: [others] worked"):
        assert part in printed

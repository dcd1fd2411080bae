"""The map of all lots is judged after a change of the lots, and where nothing changed."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from benchmarks.many_lots_page import Paints, figures, measure
from benchmarks.many_lots_store import fill
from hawk.lots.store import FILE


def test_a_slow_map_after_a_change_is_no_worse_hidden_by_a_fast_one_without() -> None:
    section = figures(10, Paints(first=3.0, changed=[1.2, 1.1, 0.9], again=[0.4, 0.5, 0.6]))
    shown = {each.key: (each.value, each.passed) for each in section.figures}
    assert shown == {
        "map_paint_s": (1.1, False), "map_paint_again_s": (0.5, True), "map_paint_first_s": (3.0, None),
    }  # fmt: skip


@pytest.mark.nightly
@pytest.mark.skipif(shutil.which("chromium") is None, reason="Chromium is not there: make setup browser")
async def test_the_map_of_a_desk_is_drawn_each_time(tmp_path: Path) -> None:
    fill(tmp_path / FILE, 3, 1, 40)
    times = await measure(tmp_path, 1)
    assert min(times.first, *times.changed, *times.again) > 0

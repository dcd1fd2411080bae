"""Frames of the map: what is made of the times at which they were drawn."""

from __future__ import annotations

import pytest

from benchmarks.figures import BenchmarkError
from benchmarks.map_frames import CASES, figures_of, paint_figures


def test_frames_a_second_count_every_interval_and_are_held_against_the_limit() -> None:
    times = [0.0]
    for _ in range(9):
        times += [times[-1] + 10.0, times[-1] + 40.0]
    rate, p95, longest = figures_of(CASES[0], times, 40.0)
    assert rate.value == pytest.approx(50.0)
    assert rate.passed is True
    assert [p95.value, longest.value] == pytest.approx([30.0, 30.0])
    assert figures_of(CASES[0], times, 58.0)[0].passed is False
    assert figures_of(CASES[0], times, None)[0].passed is None


def test_one_long_frame_shows() -> None:
    times = [each * 16.0 for each in range(30)]
    times.append(times[-1] + 400.0)
    assert figures_of(CASES[0], times, None)[2].value == pytest.approx(400.0)


def test_a_browser_that_drew_nothing_is_no_result() -> None:
    with pytest.raises(BenchmarkError, match="3 frames"):
        figures_of(CASES[0], [0.0, 16.0, 32.0], 40.0)


def test_every_case_has_figures_of_its_own() -> None:
    keys = [figure.key for case in CASES for figure in figures_of(case, [each * 16.0 for each in range(20)], None)]
    assert len(keys) == len(set(keys))


def test_the_first_paint_is_the_median_of_the_loads_beside_a_page_of_one_word() -> None:
    first, longest = paint_figures([900.0, 300.0, 400.0], [30.0, 50.0, 40.0])
    assert (first.value, first.ratio, first.passed) == (400.0, 10.0, True)
    assert longest.value == 900.0
    assert paint_figures([1001.0], [40.0])[0].passed is False

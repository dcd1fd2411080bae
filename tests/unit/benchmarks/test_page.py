"""The figures of the page's benchmark, and the addresses that it opens."""

from __future__ import annotations

from benchmarks.page import CALM, LOADS, VIEWS, Minute, Site, figures, lag_figures

TIMES = {view: (100.0 * k, 50.0) for k, view in enumerate(VIEWS, 1)}


def test_the_slowest_other_view_counts_and_the_flight_by_itself() -> None:
    found = {each.key: each for each in figures(TIMES, 40.0, 60.0, 290.0)}
    slowest = max((view for view in VIEWS if view != "flight"), key=lambda view: TIMES[view][0])
    assert found["views_cold_ms_max"].value == found[f"{slowest}_cold_ms"].value == TIMES[slowest][0]
    assert found["flight_cold_ms"].value == TIMES["flight"][0]
    assert all(each.passed for each in found.values() if each.limit is not None)
    late = figures({**TIMES, "report": (701.0, 0.0)}, 29.0, 60.0, 301.0)
    assert {each.key for each in late if each.passed is False} == {"views_cold_ms_max", "pan_fps", "first_kb"}


def test_the_lag_of_a_flight_stands_beside_that_of_a_calm_minute() -> None:
    account = {"loop_lag_p50_ms": 1.0, "loop_lag_p99_ms": 21.0, "loop_lag_max_ms": 40.0, "vision_fps": 9.0}
    minutes = {load: Minute({**account, "loop_lag_p99_ms": 21.0 if load != CALM else 6.0}, 7) for load in LOADS}
    found = {each.key: each for each in lag_figures(minutes)}
    assert {key for key, each in found.items() if each.passed is False} == {
        "flown_views_lag_p99_ms", "flown_report_lag_p99_ms",
    }  # fmt: skip
    reference = found["flown_views_lag_p99_ms"].reference
    assert reference is not None
    assert reference.value == 6.0


def test_each_view_is_opened_by_its_address() -> None:
    site = Site("http://drone/", "L", "B", "A")
    assert [site.address(view).removeprefix(site.url) for view in ("lots", "compare", "recordings")] == [
        "#/lots/L/A", "#/compare/L/B/A", "#/recordings/L",
    ]  # fmt: skip

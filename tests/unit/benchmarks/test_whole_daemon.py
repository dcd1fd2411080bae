from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from benchmarks.figures import Figure
from benchmarks.processes import CpuTime
from benchmarks.whole_daemon import Run, Sample, figures, parse_metrics, void
from hawk.survey.stack import Ready

PERFORMANCE = {
    "loop_lag_p50_ms": 0.5, "loop_lag_p99_ms": 6.0, "loop_lag_max_ms": 20.0, "frame_to_map_p50_ms": 150.0,
    "frame_to_map_p95_ms": 220.0, "vision_fps": 9.0, "frames_dropped_share": 0.4, "tick_p99_ms": 3.0,
    "steps_p50_ms": {"vision": 60.0, "path plan": 1.0},
}  # fmt: skip
IDLE = {"lag_p50_ms": 0.2, "lag_p99_ms": 2.0, "lag_max_ms": 5.0, "jitter_p99_ms": 1.0}
BEATS = {"jitter_p50_ms": 1.0, "jitter_p99_ms": 8.0, "rate_hz": 5.0}


def sample(at: float, drawn: int, late: int, pictures: float, daemon: float, machine: float) -> Sample:
    return Sample(
        CpuTime(at, {"daemon": daemon}, machine),
        {"frames_due": drawn, "frames_drawn": drawn, "frames_late": late},
        {"hawk_video_frames_total": pictures},
    )


def run(**changes: Any) -> Run:
    """Return a quiet minute: 15 pictures a second, the daemon at 0.8 cores."""
    made = Run(
        Ready("http://127.0.0.1:1/", 1.5), sample(10.0, 100, 0, 50.0, 1.0, 5.0),
        sample(70.0, 1000, 5, 650.0, 49.0, 54.0), PERFORMANCE, IDLE, BEATS,
    )  # fmt: skip
    return replace(made, **changes)


def by_key(found: list[Figure]) -> dict[str, Figure]:
    return {figure.key: figure for figure in found}


def test_every_figure_that_the_issue_names_is_there() -> None:
    found = by_key(figures(run()))
    wanted = {"loop_lag_p99_ms", "loop_lag_idle_p99_ms", "frame_to_map_p95_ms", "vision_fps", "start_to_first_tick_s"}
    wanted |= {"heartbeat_jitter_p99_ms", "heartbeat_jitter_idle_p99_ms", "frames_dropped_share", "late_frames"}
    assert wanted <= found.keys()
    assert all(figure.passed is not False for figure in found.values())
    assert found["vision_fps"].ratio == pytest.approx(9.0 / 15.0)
    assert found["late_frames"].value == pytest.approx(5 / 900)
    assert found["page_video_fps"].value == pytest.approx(10.0)
    assert found["step_path_plan_p50_ms"].value == 1.0
    assert found["cores_daemon"].value == pytest.approx(0.8)
    assert found["cores_others"].value == pytest.approx(1 / 60)


@pytest.mark.parametrize(
    ("idle_p99", "lag_p99", "passes"), [(2.0, 10.0, True), (2.0, 10.1, False), (8.0, 16.0, True), (8.0, 16.1, False)]
)
def test_loop_lag_may_be_ten_milliseconds_or_twice_the_idle_loops(
    idle_p99: float, lag_p99: float, passes: bool
) -> None:
    made = run(idle={**IDLE, "lag_p99_ms": idle_p99}, performance={**PERFORMANCE, "loop_lag_p99_ms": lag_p99})
    assert by_key(figures(made))["loop_lag_p99_ms"].passed is passes


@pytest.mark.parametrize(("jitter", "passes"), [(21.0, True), (21.1, False), (None, False)])
def test_heartbeats_may_jitter_twenty_milliseconds_more_than_the_idle_timer(jitter: float | None, passes: bool) -> None:
    found = by_key(figures(run(heartbeats={**BEATS, "jitter_p99_ms": jitter})))
    assert found["heartbeat_jitter_p99_ms"].passed is passes


def test_a_quiet_run_counts() -> None:
    assert void(run()) == ""


@pytest.mark.parametrize(
    ("after", "reason"),
    [
        (sample(70.0, 1000, 10, 650.0, 49.0, 54.0), "late"),
        (sample(70.0, 100, 0, 650.0, 49.0, 54.0), "late"),  # nothing was drawn at all
        (sample(70.0, 1000, 0, 50.0, 49.0, 54.0), "no video"),
        (sample(70.0, 1000, 0, 650.0, 49.0, 70.0), "other programs"),
        (sample(15.0, 1000, 0, 650.0, 2.0, 6.0), "explored for 5.0 s only"),
    ],
)
def test_a_disturbed_run_is_void_with_the_reason(after: Sample, reason: str) -> None:
    assert reason in void(run(after=after))


def test_metrics_without_labels_are_read() -> None:
    text = '# HELP hawk_clients x\n# TYPE hawk_clients gauge\nhawk_clients 2.0\nhawk_stalls{state="free"} 3\n'
    assert parse_metrics(text) == {"hawk_clients": 2.0}

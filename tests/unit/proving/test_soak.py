from __future__ import annotations

import asyncio
import os
import signal
from collections.abc import Callable
from pathlib import Path

import pytest

from benchmarks.figures import BenchmarkError, Figure
from proving.soak import (
    COUNTS,
    LEAST_MIN,
    WARM_UP_MIN,
    Flights,
    Sample,
    after_warm_up,
    ended_by_hand,
    figures,
    floor,
    growth,
    main,
    parser_of,
    problem,
    read_lines,
    read_metrics,
    slope,
)

Curve = Callable[[float], float]


def run(minutes: int, memory: Curve = lambda _: 200.0, heap: Curve = lambda _: 5.0, **counts: Curve) -> list[Sample]:
    flat: dict[str, Curve] = {name: lambda _: 20.0 for name in COUNTS} | counts
    return [
        Sample(float(m), memory(m), heap(m), {name: curve(m) for name, curve in flat.items()})
        for m in range(minutes + 1)
    ]


def by_key(samples: list[Sample], flights: Flights | None = None) -> dict[str, Figure]:
    return {figure.key: figure for figure in figures(samples, flights or Flights(finished=9))}


def test_a_run_in_which_nothing_grows_passes() -> None:
    found = by_key(run(120))
    assert all(figure.passed is not False for figure in found.values())
    assert found["soak_memory_slope"].value == pytest.approx(0.0, abs=1e-9)
    assert problem(run(120), Flights(finished=9)) == ""


def test_memory_that_fills_in_the_warm_up_is_no_growth() -> None:
    assert by_key(run(120, memory=lambda m: 100.0 + 10 * min(m, 15)))["soak_memory_slope"].passed is True


@pytest.mark.parametrize(("per_hour", "passed"), [(0.9, True), (1.1, False)])
def test_memory_and_heap_may_grow_by_one_per_cent_an_hour(per_hour: float, passed: bool) -> None:
    def rising(minute: float) -> float:
        return 200.0 * (1 + per_hour / 100 * (minute - 70) / 60)

    assert by_key(run(120, memory=rising))["soak_memory_slope"].passed is passed
    assert by_key(run(120, heap=rising))["soak_heap_slope"].passed is passed


@pytest.mark.parametrize("name", COUNTS)
def test_a_leak_of_two_a_minute_is_found(name: str) -> None:
    found = by_key(run(120, **{name: lambda minute: 20.0 + 2 * minute}))
    assert found[f"soak_{name}_growth"].passed is False


def test_the_heap_of_a_drone_in_flight_is_no_growth_and_does_not_hide_one() -> None:
    """Two of three samples are taken in flight, later ones ever oftener."""

    def in_flight(minute: float) -> float:
        return 1.5 * (int(minute * 7) % 3 > 0) * (1 + minute / 60)

    assert by_key(run(120, heap=lambda m: 5.0 + in_flight(m)))["soak_heap_slope"].passed is True
    leaking = by_key(run(120, heap=lambda m: 5.0 * (1 + 0.012 * (m - 75) / 60) + in_flight(m)))
    assert leaking["soak_heap_slope"].passed is False


def test_of_each_five_minutes_the_least_heap_counts() -> None:
    heaps = [9, 8, 5, 8, 9, 9, 4, 9, 9, 9, 1]
    assert [sample.heap_mb for sample in floor(run(10, heap=lambda m: float(heaps[int(m)])))] == [5.0, 4.0]
    assert floor([]) == []


def test_what_a_run_has_printed_can_be_judged_again() -> None:
    lines = [
        "minute  memory   heap  tasks  threads  files  sockets  queued  flights",
        "   0.0   183.7   2.63     27       12     24       16       0    0 + 0 failed",
        "  61.0   284.5  14.30     28       14     25       16      18  101 + 2 failed",
        "soak: VOID: nothing of this is a sample",
    ]
    samples, flights = read_lines("\n".join(lines))
    assert samples[1] == Sample(61.0, 284.5, 14.3, dict(zip(COUNTS, (28.0, 14.0, 25.0, 16.0, 18.0), strict=True)))
    assert [sample.minute for sample in samples] == [0.0, 61.0]
    assert (flights.finished, flights.failed) == (101, ["2 flights failed"])
    with pytest.raises(BenchmarkError, match="no line of a soak"):
        read_lines("minute  memory")


def test_a_log_that_is_not_there_is_named_with_the_remedy(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--judge", str(tmp_path / "none.log")]) == 1
    error = capsys.readouterr().err
    assert error.startswith(f"soak: --judge {tmp_path / 'none.log'}: cannot be read")
    assert "name the file" in error


def test_a_thread_that_is_left_is_found_and_one_that_is_there_for_a_moment_is_not() -> None:
    passing = by_key(run(120, threads=lambda m: 14.0 + (m in (100, 110))))
    assert passing["soak_threads_growth"].value == 0.0
    left = by_key(run(120, threads=lambda m: 14.0 + (m > 75)))
    assert left["soak_threads_growth"].passed is False


def test_a_short_run_is_not_judged() -> None:
    found = by_key(run(5, memory=lambda m: 100.0 + 50 * m))
    assert found["soak_memory_slope"].passed is None
    assert found["soak_tasks_growth"].passed is None
    assert "VOID" in problem(run(5), Flights(finished=1))
    assert LEAST_MIN <= 120 - WARM_UP_MIN


def test_no_flight_is_a_failure_and_failed_ones_are_reported() -> None:
    assert by_key(run(120), Flights())["soak_flights"].passed is False
    assert "the link was lost" in problem(run(120), Flights(3, ["the link was lost"]))


def test_too_few_samples_have_no_slope() -> None:
    assert after_warm_up([]) == []
    assert slope(run(1), lambda s: s.memory_mb) is None
    assert growth(run(1), "tasks") is None
    assert by_key([])["soak_minutes"].value is None


def test_metrics_with_labels_are_added_up() -> None:
    text = '# TYPE hawk_queued gauge\nhawk_queued{queue="a"} 3.0\nhawk_queued{queue="b"} 4.0\nhawk_tasks 12.0\n'
    assert read_metrics(text) == {"queued": 7.0, "tasks": 12.0}


@pytest.mark.parametrize("speed", ["0.4", "4.1", "fast"])
def test_a_speed_that_the_simulator_does_not_have_is_refused(speed: str) -> None:
    with pytest.raises(SystemExit):
        parser_of().parse_args(["--speed", speed])


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
async def test_a_signal_ends_the_sampling_and_not_the_program(number: signal.Signals) -> None:
    ended = ended_by_hand()
    os.kill(os.getpid(), number)
    async with asyncio.timeout(5.0):
        await ended.wait()

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from hawk.ddc.restart import FLIGHT_KEPT_S, RestartRule
from hawk.model.operation import FlightSoFar
from hawk.starts import Starts
from hawk.store.journal import FlightJournal

FLIGHT = FlightSoFar(30.0, 40.0, 1000.0)
Run = Callable[[Starts], None]


async def run(folder: Path, at: float, flight: FlightSoFar | None, *steps: Run) -> RestartRule:
    """Run the program once, beginning at a wall clock time; return its rule."""
    journal = FlightJournal(folder, wall=lambda: at)
    if flight is not None:
        journal.set_flight(flight)
        await journal.flush()
        await journal.close()
        journal = FlightJournal(folder, wall=lambda: at)
    starts = Starts(journal, journal.state, 1.0, wall=lambda: at)
    rule = starts.rule
    for step in steps:
        step(starts)
    await journal.close()
    return rule


def in_air(starts: Starts) -> None:
    starts.found_in_air()


CRASHES: dict[str, tuple[Run, ...]] = {"before the link": (), "after it was found in the air": (in_air,)}


@pytest.mark.parametrize("steps", CRASHES.values(), ids=CRASHES)
async def test_crashes_in_a_flight_count_with_and_without_a_link(tmp_path: Path, steps: tuple[Run, ...]) -> None:
    rules = [await run(tmp_path, 1001.0 + n, FLIGHT if n == 0 else None, *steps) for n in range(4)]
    assert rules == [RestartRule.ADOPT, RestartRule.RETURN_HOME, RestartRule.STAY_AWAY, RestartRule.STAY_AWAY]


@pytest.mark.parametrize("end", [Starts.found_disarmed, Starts.ended_in_order])
async def test_a_start_on_the_ground_and_an_orderly_end_do_not_count(tmp_path: Path, end: Run) -> None:
    rules = [await run(tmp_path, 1001.0 + n, FLIGHT if n == 0 else None, end) for n in range(4)]
    assert rules == [RestartRule.ADOPT] * 4


async def test_a_start_in_the_air_counts_although_it_lands_afterwards(tmp_path: Path) -> None:
    await run(tmp_path, 1001.0, FLIGHT, in_air, Starts.found_disarmed)
    assert await run(tmp_path, 1002.0, None) is RestartRule.RETURN_HOME


async def test_without_a_flight_under_way_only_a_drone_found_in_the_air_counts(tmp_path: Path) -> None:
    late = FLIGHT.at + FLIGHT_KEPT_S + 1.0
    assert await run(tmp_path, late, FLIGHT) is RestartRule.ADOPT
    assert await run(tmp_path, late + 1.0, None, in_air) is RestartRule.ADOPT
    assert await run(tmp_path, late + 2.0, None) is RestartRule.RETURN_HOME


@pytest.mark.parametrize(
    ("times", "counts"), [((1001.0, 1030.0, 1060.9), [1, 2, 3]), ((1001.0, 1030.0, 1061.0), [1, 2, 2])]
)
async def test_a_start_found_in_the_air_tells_how_many_there_were_within_a_minute(
    tmp_path: Path, times: tuple[float, ...], counts: list[int]
) -> None:
    told: list[int] = []
    for at in times:
        await run(tmp_path, at, FLIGHT if at == times[0] else None, lambda starts: told.append(starts.found_in_air()))
    assert told == counts


@pytest.mark.parametrize(("again", "rule"), [(1060.9, RestartRule.RETURN_HOME), (1061.0, RestartRule.ADOPT)])
async def test_a_start_counts_for_a_minute(tmp_path: Path, again: float, rule: RestartRule) -> None:
    await run(tmp_path, 1001.0, FLIGHT)
    assert await run(tmp_path, again, None) is rule


async def test_starts_of_more_than_a_minute_ago_are_forgiven(tmp_path: Path) -> None:
    for n in range(3):
        await run(tmp_path, 1001.0 + n, FLIGHT if n == 0 else None)
    assert await run(tmp_path, 1070.0, None) is RestartRule.ADOPT

from __future__ import annotations

import pytest

from benchmarks.pace import SPEEDS, in_time
from hawk.sim.launch import SLOWEST
from hawk.survey.run import LATE_FRAMES_LIMIT

pytestmark = pytest.mark.asyncio


async def flown(late_at: dict[float, float]) -> tuple[list[float], float]:
    """Return the speeds flown at, and that of the flight that counts, when so much is late at each speed."""
    speeds: list[float] = []

    async def fly(speed: float) -> float:
        speeds.append(speed)
        return speed

    return speeds, await in_time("world 3", fly, late_at.__getitem__)


@pytest.mark.parametrize("flights", [1, 2, 3])
async def test_a_late_flight_is_flown_again_slower_and_one_in_time_counts(
    flights: int, capsys: pytest.CaptureFixture[str]
) -> None:
    late = {speed: 0.3 if number < flights else LATE_FRAMES_LIMIT for number, speed in enumerate(SPEEDS, 1)}
    assert await flown(late) == ([*SPEEDS[:flights]], SPEEDS[flights - 1])
    assert capsys.readouterr().err.count("30% of the pictures came late") == flights - 1


async def test_the_slowest_flight_counts_as_late_as_it_is() -> None:
    assert await flown(dict.fromkeys(SPEEDS, 1.0)) == ([*SPEEDS], SPEEDS[-1])


async def test_no_flight_is_faster_than_figures_count_at_or_slower_than_can_be_flown() -> None:
    assert max(SPEEDS) == SPEEDS[0] == 2.0
    assert min(SPEEDS) == SPEEDS[-1] >= SLOWEST
    assert sorted(SPEEDS, reverse=True) == [*SPEEDS]

"""Ground that rises under the drone: the whole daemon over hawk-sim with a rangefinder, judged by the true position."""

from __future__ import annotations

from collections.abc import AsyncIterator

import pytest
import pytest_asyncio

from hawk.comm.protocol.commands import CompulsiveMove
from hawk.model.operation import StateName
from hawk.survey.stack import SimulatedStack
from tests.integration.daemon_support import Operator, health, operator, over_a_picture

pytestmark = [pytest.mark.integration, pytest.mark.asyncio(loop_scope="module")]
RISE = 0.30
"""Metres a metre to the north. Des is 8 m: a straight path north meets the ground after 27 m."""


@pytest_asyncio.fixture(loop_scope="module", scope="module")
async def standing(tmp_path_factory: pytest.TempPathFactory) -> AsyncIterator[tuple[SimulatedStack, Operator]]:
    """A drone with a rangefinder at the foot of a slope."""
    stack = over_a_picture(tmp_path_factory.mktemp("slope"), slope=f"{RISE * 100:g},0", rangefinder=40.0, start="30,58")
    try:
        async with operator((await stack.start()).url) as pilot:
            yield stack, pilot
    finally:
        await stack.stop()


async def test_the_slope_is_reported_before_arm_and_refuses_nothing(standing: tuple[SimulatedStack, Operator]) -> None:
    _, pilot = standing
    beat = await pilot.until(lambda b: any(check.name == "Slope" for check in b.checks))
    check = next(check for check in beat.checks if check.name == "Slope")
    assert check.passed
    assert check.value.startswith("stands on a slope of 30 % up to the north: the ground may be ")
    await pilot.take_off()


@pytest.mark.fault("a task flies closer over something than the least clearance")
@pytest.mark.nightly
async def test_a_move_into_the_slope_ends_above_it(standing: tuple[SimulatedStack, Operator]) -> None:
    stack, pilot = standing
    assert pilot.beat.height_above_ground == pytest.approx(8.0, abs=1.5)
    assert health(pilot.beat, "rangefinder").healthy
    await pilot.order(CompulsiveMove(x=45.0, y=0.0))
    beat = await pilot.until_said("Only ")
    assert beat.state == StateName.HOVER
    risen = await pilot.until(lambda b: b.time > beat.time + 8.0)
    assert risen.state == StateName.HOVER
    position = (await stack.status())["position"]
    over = position["height"] - RISE * (58.0 - position["y"])
    assert over == pytest.approx(5.0, abs=1.2), "Min above the ground"
    await pilot.come_home()

"""GNSS that is off and a home that was moved: the whole daemon over hawk-sim, judged by the true position."""

from __future__ import annotations

import math
from collections.abc import AsyncIterator
from typing import Any

import aiohttp
import pytest
import pytest_asyncio

from hawk.comm.protocol.commands import CompulsiveMove, ReturnToLaunch
from hawk.model.operation import StateName
from hawk.survey.stack import SimulatedStack
from tests.integration.daemon_support import Operator, health, operator, over_a_picture

pytestmark = [pytest.mark.integration, pytest.mark.nightly, pytest.mark.asyncio(loop_scope="module")]


async def fault(stack: SimulatedStack, **fields: Any) -> None:
    """Inject a fault into the simulator."""
    assert stack.address is not None
    async with (
        aiohttp.ClientSession() as session,
        session.post(f"{stack.address.http}/fault", json=fields) as response,
    ):
        response.raise_for_status()


async def true_place(stack: SimulatedStack) -> tuple[float, float]:
    """Return the true position, metres north and east."""
    position = (await stack.status())["position"]
    return -position["y"], position["x"]


@pytest_asyncio.fixture(loop_scope="module", scope="module")
async def flown(tmp_path_factory: pytest.TempPathFactory) -> AsyncIterator[tuple[SimulatedStack, Operator]]:
    """A drone that holds 10 m north of where it took off."""
    stack = over_a_picture(tmp_path_factory.mktemp("estimate"))
    try:
        async with operator((await stack.start()).url) as pilot:
            await pilot.take_off()
            await pilot.order(CompulsiveMove(x=10.0, y=0.0))
            await pilot.until_state(StateName.HOVER)
            yield stack, pilot
    finally:
        await stack.stop()


@pytest.mark.fault(
    "local and global position jump together by 25 m (EKF reset after a GPS glitch) while the drone holds "
    "(Hover, CommunicationLost)",
    "the goal is formed again at the new estimate; the true drone stays (within 2 m)",
)
async def test_a_held_drone_stays_when_its_estimate_jumps_by_25_metres(flown: tuple[SimulatedStack, Operator]) -> None:
    stack, pilot = flown
    before = await true_place(stack)
    await fault(stack, gps_glitch=[25.0, 0.0, 0.0])
    await pilot.until(lambda b: "GPS glitch" in health(b, "position").reason)
    beat = await pilot.until_said("estimate jumped by 25 m")
    assert beat.state == StateName.HOVER
    await pilot.until(lambda b: b.time > beat.time + 8.0)  # long enough to fly 25 m
    assert math.dist(await true_place(stack), before) < 2.0
    assert "jumped by 25 m against the map" in health(pilot.beat, "mapper").reason
    await fault(stack, gps_glitch=[0.0, 0.0, 0.0])
    await pilot.until(lambda b: b.time > beat.time + 9.0 and "against the map" not in health(b, "mapper").reason)
    await pilot.until(lambda b: health(b, "position").healthy)
    assert math.dist(await true_place(stack), before) < 3.0


@pytest.mark.fault("another station moves home in flight (300 m, or up or down)")
async def test_a_home_that_was_moved_is_set_back_and_the_return_ends_at_the_arm_place(
    flown: tuple[SimulatedStack, Operator],
) -> None:
    stack, pilot = flown
    place = await true_place(stack)
    await fault(stack, home=[place[0] + 300.0, place[1], 0.0])
    await pilot.until_said("Home was moved.")
    await pilot.until_said("Home is at the arm place again.")
    await pilot.order(ReturnToLaunch())
    await pilot.until_down()
    there = await true_place(stack)
    assert math.dist(there, place) == pytest.approx(10.0, abs=3.0)
    assert there[0] < place[0]

"""An outline that an operator gives is surveyed and no more, and a daemon that is killed goes on with it."""

from __future__ import annotations

import math
from collections.abc import AsyncIterator
from pathlib import Path

import pytest
import pytest_asyncio

from hawk.comm.protocol.commands import AutonomousExplore, SetOutline
from hawk.comm.protocol.heartbeat import FenceCorner
from hawk.ddc.fence.geometry import ring_from_map
from hawk.model.operation import StateName
from hawk.model.poses import GlobalPose
from hawk.survey.stack import SimulatedStack
from tests.integration.daemon_support import Operator, kill_daemon, operator, over_a_picture, until_journalled

pytestmark = [pytest.mark.integration, pytest.mark.alone, pytest.mark.nightly, pytest.mark.asyncio]

SETTINGS = """
[heights]
minimum_m = 15.0
desired_m = 30.0
maximum_m = 35.0
[fence]
radius_m = 25.0
"""
"""The circle's own limit lies 20 m about the arm place."""
REACH_M = 20.5
NEAR_M, FAR_M, HALF_M = 8.0, 45.0, 8.0
"""The outline, from the arm place northwards, and half of its width: the fence cuts it off at 25 m."""


@pytest_asyncio.fixture
async def stack(tmp_path: Path) -> AsyncIterator[tuple[SimulatedStack, str]]:
    made = over_a_picture(tmp_path, SETTINGS)
    yield made, (await made.start()).url
    await made.stop()


def northwards(place: GlobalPose) -> SetOutline:
    corners = ((NEAR_M, -HALF_M), (NEAR_M, HALF_M), (FAR_M, HALF_M), (FAR_M, -HALF_M))
    ring = [FenceCorner(latitude=lat, longitude=lon) for lat, lon in ring_from_map(place, corners)]
    return SetOutline(polygons=[ring])


async def test_an_outline_without_a_lot_is_seen_whole_inside_the_fence_also_after_a_crash(
    stack: tuple[SimulatedStack, str], tmp_path: Path
) -> None:
    (flown, url), folder = stack, tmp_path / "run" / "store"
    async with operator(url) as pilot:
        await _give_outline(pilot)
    await until_journalled(folder, lambda kept: kept.outline is not None)
    await kill_daemon(flown)
    async with operator((await flown.start_daemon()).url) as pilot:
        await pilot.until(lambda b: b.connected and b.outline_area is not None)
        await pilot.take_off()
        beat = pilot.beat
        assert beat.outline_area == pytest.approx(2 * HALF_M * 16.9, rel=0.1)
        assert beat.outline_outside == pytest.approx(2 * HALF_M * 20.1, rel=0.1)
        await pilot.order(AutonomousExplore())
        await pilot.until_state(StateName.AUTONOMOUS_EXPLORE)
        end = await pilot.until_state(StateName.HOVER, 240.0)
        assert end.explore_done
        assert end.outline_unseen == 0.0
        places = [(point.north, point.east) for point in pilot.drone.trail]
        assert max(math.hypot(*place) for place in places) <= REACH_M
        assert any("outside the fence were left out" in entry.text for entry in pilot.drone.log)
        await pilot.come_home()


async def _give_outline(pilot: Operator) -> None:
    beat = await pilot.until(lambda b: b.connected and b.latitude is not None and b.longitude is not None)
    assert beat.latitude is not None
    assert beat.longitude is not None
    await pilot.take_control()
    await pilot.order(northwards(GlobalPose(beat.latitude, beat.longitude, 0.0)))
    await pilot.until(lambda b: b.outline_area is not None)
    assert pilot.drone.outline_setup is not None
    assert pilot.drone.outline_setup.source == "set"

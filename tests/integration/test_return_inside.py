"""Return To Launch in a bent fence: the whole daemon over hawk-sim, judged by the true position."""

from __future__ import annotations

import math
from collections.abc import AsyncIterator
from itertools import pairwise

import pytest
import pytest_asyncio

from hawk.comm.protocol.commands import CompulsiveMove, ReturnToLaunch, SetFence
from hawk.comm.protocol.heartbeat import FenceCorner, Heartbeat, Point
from hawk.ddc.fence.geometry import Ring, ring_from_map
from hawk.model.operation import StateName
from hawk.model.poses import GlobalPose
from hawk.survey.stack import SimulatedStack
from tests.integration.daemon_support import Operator, operator, over_a_picture

pytestmark = [pytest.mark.integration, pytest.mark.asyncio(loop_scope="module")]

U_SHAPE: Ring = (
    (15.0, -15.0), (15.0, 15.0), (-30.0, 15.0), (-30.0, 45.0),
    (15.0, 45.0), (15.0, 75.0), (-60.0, 75.0), (-60.0, -15.0),
)  # fmt: skip
"""Two arms to the north, 30 m apart; north and east of the drone, which stands in the west arm."""
PATH_OUT = ((-45.0, 0.0), (-45.0, 60.0), (5.0, 60.0))
CEILING_M = 40.0


def on_globe(beat: Heartbeat, ring: Ring) -> Ring:
    """Return (north, east) of the drone, metres, as (latitude, longitude)."""
    assert beat.latitude is not None
    assert beat.longitude is not None
    return ring_from_map(GlobalPose(beat.latitude, beat.longitude, 0.0), ring)


async def draw(pilot: Operator, ring: Ring) -> None:
    """Put a fence around the drone on the ground."""
    beat = await pilot.until(lambda b: b.latitude is not None and b.connected)
    await pilot.take_control()
    corners = [FenceCorner(latitude=lat, longitude=lon) for lat, lon in on_globe(beat, ring)]
    await pilot.order(SetFence(corners=corners, ceiling=CEILING_M))
    await pilot.until(lambda b: b.state == StateName.IDLE and "saved" in b.detail)


async def fly_to_the_other_arm(pilot: Operator) -> None:
    for north, east in PATH_OUT:
        await pilot.order(CompulsiveMove(x=north, y=east, frame="Map"))
        await pilot.until_state(StateName.COMPULSIVE_MOVE)
        await pilot.until_state(StateName.HOVER)


def long(route: tuple[Point, ...] | list[Point]) -> float:
    return sum(math.dist((a.north, a.east), (b.north, b.east)) for a, b in pairwise(route))


@pytest_asyncio.fixture(loop_scope="module", scope="module")
async def in_the_other_arm(
    tmp_path_factory: pytest.TempPathFactory,
) -> AsyncIterator[tuple[SimulatedStack, Operator]]:
    """A drone that holds in the east arm; home is in the west arm."""
    stack = over_a_picture(tmp_path_factory.mktemp("bent"))
    try:
        async with operator((await stack.start()).url) as pilot:
            await draw(pilot, U_SHAPE)
            await pilot.take_off()
            beat = pilot.beat
            assert beat.datum is not None
            limit = tuple((corner.north, corner.east) for corner in beat.fence)
            await stack.watch_fence(list(ring_from_map(GlobalPose(*beat.datum, 0.0), limit)), CEILING_M)
            await fly_to_the_other_arm(pilot)
            yield stack, pilot
    finally:
        await stack.stop()


@pytest.mark.fault(
    "a return in a bent fence: the straight line home leaves it",
    "a path inside it by targets, 2 m from our limit, until home is in straight sight; then RTL; the true "
    "position never leaves the fence",
)
@pytest.mark.nightly
async def test_a_return_between_two_arms_of_the_fence_ends_at_home_and_never_leaves_it(
    in_the_other_arm: tuple[SimulatedStack, Operator],
) -> None:
    stack, pilot = in_the_other_arm
    await pilot.order(ReturnToLaunch())
    begun = await pilot.until(lambda b: b.state == StateName.RETURN_TO_LAUNCH and len(b.route) > 2)
    assert begun.ardupilot_state == "GUIDED"
    assert begun.detail.startswith("Returning home inside the fence, 1")
    assert long(begun.route) == pytest.approx(125.0, abs=5.0)
    straight = await pilot.until(lambda b: b.ardupilot_state == "RTL")
    assert straight.state == StateName.RETURN_TO_LAUNCH
    assert not straight.route
    assert straight.east is not None
    assert straight.east < 20.0, "RTL took over in the west arm"
    await pilot.until_down()
    status = await stack.status()
    assert (status["fence"], status["excursions"], status["crashed"]) == (True, 0, False)
    home = pilot.beat
    assert home.north is not None
    assert home.east is not None
    assert math.hypot(home.north, home.east) < 3.0

"""The autopilot hears the daemon and is not heard: hawk-sim is mute, the real MAVSDK and daemon fly it."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from dataclasses import dataclass
from typing import Any

import pytest
import pytest_asyncio

from hawk.comm.protocol.commands import Ack, Hold, Land
from hawk.model.operation import StateName
from hawk.survey.stack import SimulatedStack
from tests.integration.daemon_support import eventually, operator, over_a_picture
from tests.integration.sim_support import get_json
from tests.pace import PATIENCE_S

pytestmark = [pytest.mark.integration, pytest.mark.asyncio(loop_scope="module")]


@dataclass(frozen=True)
class Flown:
    """A stack that runs, and the page's address."""

    stack: SimulatedStack
    url: str

    async def put(self, **fields: Any) -> None:
        """Inject a fault."""
        assert self.stack.address is not None
        await asyncio.get_running_loop().run_in_executor(None, get_json, f"{self.stack.address.http}/fault", fields)

    async def until(self, reached: Callable[[dict[str, Any]], bool], timeout_s: float = PATIENCE_S) -> None:
        """Wait for the simulator's account of the flight."""
        await eventually(self.stack.status, reached, timeout_s)


@pytest_asyncio.fixture(loop_scope="module", scope="module")
async def flown(tmp_path_factory: pytest.TempPathFactory) -> AsyncIterator[Flown]:
    stack = over_a_picture(tmp_path_factory.mktemp("unheard"))
    try:
        yield Flown(stack, (await stack.start()).url)
    finally:
        await stack.stop()


@pytest.mark.fault("downlink dead, and RTL messages are lost too")
@pytest.mark.fault("downlink dead, uplink alive, in the air")
async def test_a_mute_autopilot_is_sent_home_landed_by_hand_and_heard_again(flown: Flown) -> None:
    await flown.put(late_parameters_s=2.0)  # the failsafes are set all the same
    async with operator(flown.url) as pilot:
        await pilot.take_off()
        await flown.put(link="mute")
        await flown.until(lambda s: s["mode"] == "RTL")
        unheard = await pilot.until_state(StateName.RETURN_TO_LAUNCH)
        assert "no word from the autopilot" in unheard.detail
        await flown.until(lambda s: s["gcs_failsafe"])
        answer = await pilot.drone.ask(Land())
        assert isinstance(answer, Ack)
        assert answer.accepted
        assert answer.reason == "Sent without an answer: no word from the autopilot."
        await flown.until(lambda s: s["mode"] == "LAND")
        await flown.put(link="ok")
        await pilot.until(lambda b: b.connected)
        await flown.until(lambda s: not s["gcs_failsafe"])
        await pilot.until_down()
    assert not (await flown.stack.status())["crashed"]


async def test_a_drone_whose_link_is_back_can_be_held(flown: Flown) -> None:
    async with operator(flown.url) as pilot:
        await pilot.take_off()
        await flown.put(link="mute")
        await flown.until(lambda s: s["mode"] == "RTL")
        await flown.put(link="ok")
        await pilot.until(lambda b: b.connected and b.state == StateName.RETURN_TO_LAUNCH)
        await pilot.order(Hold())
        await pilot.until_state(StateName.HOVER)
        await pilot.come_home()
    assert not (await flown.stack.status())["crashed"]

"""The daemon dies, is ended, loses its operator, and starts again: the drone is in the air each time."""

from __future__ import annotations

import asyncio
import signal
from collections.abc import AsyncIterator
from dataclasses import dataclass
from pathlib import Path

import pytest
import pytest_asyncio

from hawk.model.operation import StateName
from hawk.survey.stack import SimulatedStack
from tests.integration.daemon_support import (
    SPEED,
    SPEED_ASKED,
    Operator,
    end_daemon,
    eventually,
    health,
    kill_daemon,
    low,
    operator,
    over_a_picture,
)

pytestmark = [pytest.mark.integration, pytest.mark.asyncio(loop_scope="module")]

TAKEN_UP_S = 3.0 * SPEED_ASKED / SPEED
"""A daemon that starts in the air acts within 3 s; on a slow computer the simulation is as much slower."""
STOP_S = 10.0
"""The service manager kills what has not ended by then (TimeoutStopSec)."""
OVER_HOME_MS = 30_000.0
"""RTL_LOIT_TIME of the drone here: it is in the air yet when the daemon has started for the third time."""
OPERATOR_TIMEOUT_S, OPERATOR_HOLD_S = 4.0, 20.0
"""A drone that is taken up holds so long: on a busy computer an operator's first heartbeat comes seconds after that."""


@dataclass(frozen=True)
class Flown:
    """A stack that runs; the daemon's address stays over restarts."""

    stack: SimulatedStack
    url: str

    async def start_again(self) -> float:
        """Start the daemon; return when its process began, on the loop's clock."""
        began = asyncio.get_running_loop().time()
        await self.stack.start_daemon()
        return began

    def seconds_since(self, began: float) -> float:
        """Return real seconds since then, without those in which the daemon waited for a core that others had."""
        assert self.stack.daemon is not None
        return asyncio.get_running_loop().time() - began - waited_for_a_core(self.stack.daemon.pid)


def waited_for_a_core(pid: int) -> float:
    """Return seconds that a process' main thread stood ready and was not run (Linux' sched-stats.rst, field 2)."""
    path = Path(f"/proc/{pid}/schedstat")
    return int(path.read_text().split()[1]) / 1e9 if path.exists() else 0.0


@pytest_asyncio.fixture(loop_scope="module", scope="module")
async def flown(tmp_path_factory: pytest.TempPathFactory) -> AsyncIterator[Flown]:
    settings = low(OPERATOR_TIMEOUT_S, OPERATOR_HOLD_S)
    stack = over_a_picture(tmp_path_factory.mktemp("life"), settings)
    try:
        yield Flown(stack, (await stack.start()).url)
    finally:
        await stack.stop()


async def test_killed_again_and_again_in_the_air(flown: Flown) -> None:
    """Taken up at the first start, brought home at the second, left to the autopilot at the third."""
    await flown.stack.inject({"parameters": {"RTL_LOIT_TIME": OVER_HOME_MS}})
    async with operator(flown.url) as pilot:
        await pilot.take_off()
        before = await pilot.until(lambda b: (b.flight_time or 0) > 5)
        await kill_daemon(flown.stack)
    began = await flown.start_again()
    async with operator(flown.url) as pilot:
        after = await pilot.until_state(StateName.COMMUNICATION_LOST)
        assert flown.seconds_since(began) < TAKEN_UP_S
        assert after.flight_time is not None
        assert before.flight_time is not None
        assert after.flight_time > before.flight_time, "the flight goes on"
        assert (after.distance_flown or 0) >= (before.distance_flown or 0) - 3
        await pilot.take_control()
        await pilot.until_state(StateName.HOVER)
        assert (await flown.stack.status())["mode"] == "GUIDED"
        await kill_daemon(flown.stack)
    began = await flown.start_again()
    await eventually(flown.stack.status, lambda s: s["mode"] == "RTL")
    assert flown.seconds_since(began) < TAKEN_UP_S
    await kill_daemon(flown.stack)
    await flown.start_again()
    async with operator(flown.url) as pilot:
        await stays_away_until_disarmed(flown.stack, pilot)
        await pilot.until(lambda b: b.connected and b.state == StateName.IDLE)
    await flown.stack.inject({"parameters": {"RTL_LOIT_TIME": 5_000.0}})


async def stays_away_until_disarmed(stack: SimulatedStack, pilot: Operator) -> None:
    """Watch the drone come down by itself while the daemon says nothing to it."""
    status = await stack.status()
    assert not status["disarmed"]
    while not status["disarmed"]:
        beat = await pilot.hand.next()
        assert not beat.connected or (await stack.status())["disarmed"]
        status = await stack.status()
        assert status["mode"] in ("RTL", "LAND")
    assert not status["crashed"]


@pytest.mark.fault("SIGHUP in the air (a lost terminal)")
async def test_without_its_operator_it_holds_and_then_comes_home(flown: Flown) -> None:
    assert flown.stack.daemon is not None
    async with operator(flown.url) as watcher:
        async with operator(flown.url) as pilot:
            await pilot.take_off()
            flown.stack.daemon.send_signal(signal.SIGHUP)  # a lost terminal
            gone = pilot.beat.time
        lost = await watcher.until_state(StateName.COMMUNICATION_LOST)
        assert OPERATOR_TIMEOUT_S - 2 < lost.time - gone < OPERATOR_TIMEOUT_S + 2
        assert lost.ardupilot_state == "GUIDED"
        assert lost.return_in is not None
        assert lost.return_in <= OPERATOR_HOLD_S
        home = await watcher.until_state(StateName.RETURN_TO_LAUNCH)
        assert OPERATOR_HOLD_S - 1 < home.time - lost.time < OPERATOR_HOLD_S + 2
        await watcher.until_down()
    assert not (await flown.stack.status())["crashed"]


async def test_a_daemon_that_is_stopped_in_the_air_sends_the_drone_home_first(flown: Flown) -> None:
    async with operator(flown.url) as pilot:
        await pilot.take_off()
    async with asyncio.timeout(STOP_S):
        assert await end_daemon(flown.stack) == 0
    assert (await flown.stack.status())["mode"] == "RTL"
    down = await eventually(flown.stack.status, lambda s: s["disarmed"])
    assert not down["crashed"]
    await flown.start_again()
    async with operator(flown.url) as pilot:
        idle = await pilot.until(lambda b: b.connected and b.state == StateName.IDLE)
        assert health(idle, "link").healthy

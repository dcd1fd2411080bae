"""A daemon that crashes again and again before it has found its autopilot, while the drone flies or stands."""

from __future__ import annotations

import asyncio
import contextlib
import signal
import sys
from collections.abc import AsyncIterator, Iterator
from pathlib import Path

import pytest

from hawk.ddc.rules.follower import RESTART_WINDOW_S
from hawk.model.moment import this_moment
from hawk.model.operation import FlightSoFar
from hawk.model.poses import GlobalPose
from hawk.sim.launch import free_udp_port
from hawk.store.journal import FlightJournal
from tests.integration.sim_support import free_tcp_port
from tests.pace import PATIENCE_S

pytestmark = [pytest.mark.integration]

CRASHED = 70
PROGRAM = f"""
import os, sys
import hawk.cli
from hawk.comm.autopilot.autopilot import MavsdkAutopilot

async def crash(self):
    os._exit({CRASHED})

MavsdkAutopilot.start = crash
sys.exit(hawk.cli.main(["run", *sys.argv[1:]]))
"""
WAITS = "import sys, hawk.cli; sys.exit(hawk.cli.main(['run', *sys.argv[1:]]))"
IGNORES = "import signal; signal.signal(signal.SIGHUP, signal.SIG_IGN); " + WAITS
STAYS_AWAY = "the autopilot's failsafe has the drone"


@pytest.fixture(autouse=True)
def _a_terminal_can_be_lost() -> Iterator[None]:
    """Tests under nohup ignore SIGHUP, and the programs that they start would, too."""
    before = signal.signal(signal.SIGHUP, signal.SIG_DFL)
    yield
    signal.signal(signal.SIGHUP, before)


async def journal_of_a_flight(folder: Path, age_s: float, starts: int = 0) -> None:
    """Write what a daemon has journalled that crashed in the air at this age, after some starts in the air."""
    journal = FlightJournal(folder / "journal")
    journal.set_datum(GlobalPose(43.26, -79.92, 100.0))
    journal.set_flight(FlightSoFar(30.0, 40.0, this_moment().before(age_s)))
    for _ in range(starts):
        journal.add_start_in_air(this_moment())
    await journal.close()


@contextlib.asynccontextmanager
async def started(
    folder: Path, program: str = PROGRAM, *more: str, autopilot: str = ""
) -> AsyncIterator[asyncio.subprocess.Process]:
    own = ["--store", str(folder), "--port", str(free_tcp_port()), "--camera", f"http://127.0.0.1:{free_tcp_port()}/"]
    made = await asyncio.create_subprocess_exec(
        sys.executable, "-c", program, *own, *more,
        "--autopilot", autopilot or f"udpin://127.0.0.1:{free_udp_port()}",
        stdout=asyncio.subprocess.PIPE, stderr=asyncio.subprocess.PIPE,
    )  # fmt: skip
    try:
        yield made
    finally:
        if made.returncode is None:
            made.kill()
        await made.wait()


async def stays_away(made: asyncio.subprocess.Process) -> bool:
    """Return True when it leaves the drone to the autopilot, False when it crashed."""
    assert made.stderr is not None
    async with asyncio.timeout(PATIENCE_S):
        while line := await made.stderr.readline():
            if STAYS_AWAY in line.decode():
                return True
        assert await made.wait() == CRASHED
    return False


@pytest.mark.fault(
    "the program crashes again and again in the air before it has found the link",
    "each start is on the disk before the link is opened; the third within a minute opens none",
)
@pytest.mark.fault(
    "SIGHUP in the air (a lost terminal)",
    "logged, the flight goes on; on the ground the program ends in order",
)
async def test_crashes_before_the_link_is_found_count_while_the_flight_goes_on(tmp_path: Path) -> None:
    await journal_of_a_flight(tmp_path, age_s=1.0, starts=1)
    async with started(tmp_path) as made:
        assert not await stays_away(made)
    async with started(tmp_path) as made:
        assert await stays_away(made)
        await goes_on_without_a_terminal(made)
        made.send_signal(signal.SIGTERM)
        async with asyncio.timeout(PATIENCE_S):
            assert await made.wait() == 0
    async with started(tmp_path) as made:
        assert await stays_away(made), "an orderly end takes nothing back but its own start"


async def goes_on_without_a_terminal(made: asyncio.subprocess.Process) -> None:
    """Take its terminal away from a program whose flight goes on: it says so, and does not end."""
    made.send_signal(signal.SIGHUP)
    assert made.stderr is not None
    async with asyncio.timeout(PATIENCE_S):
        while b"the flight goes on" not in await made.stderr.readline():
            assert made.returncode is None


@pytest.mark.parametrize(("program", "status"), [(WAITS, 0), (IGNORES, -signal.SIGKILL)])
async def test_on_the_ground_a_lost_terminal_ends_it_in_order_unless_nohup_says_no(
    tmp_path: Path, program: str, status: int
) -> None:
    async with started(tmp_path, program) as made:
        assert made.stdout is not None
        async with asyncio.timeout(PATIENCE_S):
            await made.stdout.readline()  # the page's address: it runs
        made.send_signal(signal.SIGHUP)
        if status != 0:
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(1.0):
                    await made.wait()
            made.kill()
        async with asyncio.timeout(PATIENCE_S):
            assert await made.wait() == status


@pytest.mark.fault(
    "the computer lets the program wait for seconds",
    "on the ground it goes on; where a flight may be under way the watchdog ends it after 1.2 s",
)
@pytest.mark.parametrize("age_s", [500.0, 1.0])
async def test_a_program_that_had_to_wait_goes_on_unless_a_flight_may_be_under_way(
    tmp_path: Path, age_s: float
) -> None:
    await journal_of_a_flight(tmp_path, age_s)
    async with started(tmp_path, WAITS) as made:
        assert made.stdout is not None
        async with asyncio.timeout(PATIENCE_S):
            await made.stdout.readline()
        made.send_signal(signal.SIGSTOP)
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(3.0):
                await made.wait()
        made.send_signal(signal.SIGCONT)
        if age_s < RESTART_WINDOW_S:
            async with asyncio.timeout(PATIENCE_S):
                assert await made.wait() in {1, -signal.SIGALRM}
        else:
            made.terminate()
            async with asyncio.timeout(PATIENCE_S):
                assert await made.wait() == 0


async def test_on_the_ground_every_start_opens_the_link(tmp_path: Path) -> None:
    await journal_of_a_flight(tmp_path, age_s=500.0)
    for _ in range(3):
        async with started(tmp_path) as made:
            assert not await stays_away(made)


@pytest.mark.fault(
    "a second daemon is started on the store of one that runs",
    "it ends with status 2 and names the first; one journal",
)
@pytest.mark.fault(
    "a second daemon of this computer on the same serial line, TCP or UDP address",
    "it does not open the link, names the first, and opens it when that one has ended",
)
async def test_a_second_daemon_on_one_store_or_one_autopilot_names_the_first(tmp_path: Path) -> None:
    autopilot, store = f"tcpout://127.0.0.1:{free_tcp_port()}", tmp_path / "one"
    async with started(store, WAITS, autopilot=autopilot) as first:
        assert first.stdout is not None
        async with asyncio.timeout(PATIENCE_S):
            await first.stdout.readline()  # the page's address: it runs
        async with started(store, WAITS) as second, asyncio.timeout(PATIENCE_S):
            _, words = await second.communicate()
        assert second.returncode == 2
        assert f"store.directory: {store} is in use by another hawk-drone (process {first.pid}, " in words.decode()
        assert len(list((store / "journal").iterdir())) == 1, "one journal"
        async with started(tmp_path / "two", WAITS, autopilot=autopilot) as second, asyncio.timeout(PATIENCE_S):
            assert second.stderr is not None
            while f"in use by another hawk-drone (process {first.pid}, ".encode() not in await second.stderr.readline():
                assert second.returncode is None

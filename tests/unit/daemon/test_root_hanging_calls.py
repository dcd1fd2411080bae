"""The daemon when calls into MAVSDK hang, and when one of its tasks ends."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from pathlib import Path

import pytest

from hawk.config.sections import Config, StoreSettings, WatchdogSettings
from hawk.daemon import monitor as daemon_module
from hawk.daemon.options import DaemonOptions
from hawk.daemon.root import Daemon
from hawk.model.operation import StateName
from hawk.model.vehicle import CopterMode, LandedState, VehicleState
from hawk.runtime.program_log import ProgramLog


class Rig:
    """A daemon that was not started: its parts are there, and nothing is open."""

    def __init__(self, folder: Path, left: list[str]) -> None:
        self.left = left
        self.output = ProgramLog("info")
        config = Config(store=StoreSettings(directory=folder), watchdog=WatchdogSettings(enabled=False))
        self.daemon = Daemon(config, DaemonOptions(), self.output)

    def hear(self, *, armed: bool, landed: LandedState) -> None:
        now = self.daemon.clock()
        self.daemon.vehicle.state.publish(VehicleState(True, armed, CopterMode.GUIDED, landed, now, now))
        self.daemon.manager.process()

    def hang(self, name: str) -> None:
        self.daemon.autopilot.calls.note_overdue(name)

    def reason(self, part: str) -> str:
        return dict(self.daemon.topics.get_part_healths())[part].reason

    @property
    def log(self) -> list[tuple[str, str]]:
        return [(entry.text, entry.details) for entry in self.daemon.manager.log.entries]


@pytest.fixture
async def rig(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[Rig]:
    left: list[str] = []
    monkeypatch.setattr(daemon_module, "leave_at_once", left.append)
    made = Rig(tmp_path, left)
    yield made
    await made.daemon._close()
    made.output.close()


@pytest.mark.slow
@pytest.mark.fault(
    "a second call hangs in the air",
    "the program ends at once with status 70, so that failsafe and restart act",
)
async def test_the_first_in_the_air_is_shown_and_the_second_ends_the_program(rig: Rig) -> None:
    rig.hear(armed=True, landed=LandedState.IN_AIR)
    assert rig.daemon.manager.state.identity is StateName.COMMUNICATION_LOST
    rig.hang("set_mode")
    assert "MAVSDK does not return: set_mode" in rig.reason("requests")
    assert ("A request hangs in MAVSDK.", "set_mode") in rig.log
    assert rig.left == []
    rig.hang("PARAM_SET")
    assert len(rig.left) == 1
    assert "PARAM_SET" in rig.left[0]


@pytest.mark.slow
@pytest.mark.fault("calls hang on the ground", "shown; the program goes on")
async def test_on_the_ground_it_is_shown_and_the_program_goes_on(rig: Rig) -> None:
    rig.hear(armed=False, landed=LandedState.ON_GROUND)
    for _ in range(5):
        rig.hang("find")
    assert "find" in rig.reason("requests")
    assert rig.left == []


@pytest.mark.slow
@pytest.mark.fault("the link task, or another long-running task, ends")
async def test_a_task_that_ends_is_shown_and_started_again(rig: Rig) -> None:
    runs = asyncio.Event()
    ends = [ValueError("broken")]

    async def work() -> None:
        for end in ends:
            ends.clear()
            raise end
        runs.set()
        await asyncio.Event().wait()

    rig.daemon._supervisor._pause = 0.0
    rig.daemon._own("map-keeper", work)
    async with asyncio.timeout(5.0):
        await runs.wait()
    assert rig.reason("tasks") == "map-keeper ended: ValueError: broken"
    assert ("A part of the program ended and is started again.", "map-keeper: ValueError: broken") in rig.log

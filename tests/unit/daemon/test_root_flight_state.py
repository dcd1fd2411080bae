"""The daemon says whether the drone may fly, where the service's folder in /run is."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from dataclasses import replace
from pathlib import Path

import pytest

from hawk.config.sections import Config, StoreSettings, WatchdogSettings
from hawk.daemon.options import DaemonOptions
from hawk.daemon.root import Daemon
from hawk.model.operation import StateName
from hawk.model.vehicle import VehicleState
from hawk.runtime.process import GROUND_S
from hawk.runtime.program_log import ProgramLog
from hawk.versions.flight_state import FoundState, read_flight_state

GROUND = VehicleState(connected=True, armed=False)


@pytest.fixture
async def daemon(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[Daemon]:
    (tmp_path / "run").mkdir()
    monkeypatch.setenv("RUNTIME_DIRECTORY", str(tmp_path / "run"))
    output = ProgramLog("info")
    store = StoreSettings(directory=tmp_path / "store")
    made = Daemon(Config(store=store, watchdog=WatchdogSettings(enabled=False)), DaemonOptions(), output)
    monitor = asyncio.create_task(made._monitor.run())
    yield made
    monitor.cancel()
    await asyncio.gather(monitor, return_exceptions=True)
    await made._close()
    output.close()


async def state_after_a_look(daemon: Daemon, folder: Path) -> FoundState:
    """Return the state after the monitor's next look."""
    looked = asyncio.Event()
    end = daemon.inputs.camera_health.listen(lambda _health: looked.set())
    await looked.wait()
    end()
    return read_flight_state(folder)


def may_fly(found: FoundState) -> bool:
    """Return the state of a daemon that holds its file."""
    assert found.is_held
    assert found.state is not None
    return found.state.may_fly


@pytest.mark.nightly
async def test_an_armed_drone_may_fly_until_it_is_disarmed(daemon: Daemon, tmp_path: Path) -> None:
    run = tmp_path / "run"
    assert not may_fly(await state_after_a_look(daemon, run))  # no autopilot was found, and none flew lately
    daemon.vehicle.state.publish(replace(GROUND, armed=True))
    assert may_fly(await state_after_a_look(daemon, run))
    daemon.vehicle.state.publish(replace(GROUND, connected=False, armed=True))  # lost in the air
    assert may_fly(await state_after_a_look(daemon, run))
    daemon.vehicle.state.publish(GROUND)
    assert not may_fly(await state_after_a_look(daemon, run))


@pytest.mark.slow
async def test_the_state_is_written_with_the_publication_that_arms(daemon: Daemon, tmp_path: Path) -> None:
    """Without waiting for the next look: a version is never switched in between."""
    assert not may_fly(await state_after_a_look(daemon, tmp_path / "run"))
    daemon.vehicle.state.publish(replace(GROUND, armed=True))
    assert may_fly(read_flight_state(tmp_path / "run"))


@pytest.mark.slow
@pytest.mark.fault("a busy computer lets the program wait for seconds while the drone stands on the ground")
async def test_a_tick_of_a_drone_that_may_fly_gives_the_program_a_second_and_one_on_the_ground_longer(
    daemon: Daemon, monkeypatch: pytest.MonkeyPatch
) -> None:
    given: list[float] = []
    monkeypatch.setattr("hawk.runtime.process.end_within", lambda seconds, _stream: given.append(seconds))
    monkeypatch.setattr(daemon._watchdog, "_enabled", True)
    for state in (GROUND, replace(GROUND, armed=True), replace(GROUND, connected=False, armed=True), GROUND):
        daemon.vehicle.state.publish(state)
        daemon._tick()
    monkeypatch.setattr(daemon._watchdog, "_enabled", False)
    assert given == [pytest.approx(1.2 * GROUND_S), pytest.approx(1.2), pytest.approx(1.2 * GROUND_S)]


@pytest.mark.slow
async def test_one_late_disarmed_ends_no_flight_and_the_state_that_follows_a_landing_does(daemon: Daemon) -> None:
    state, said = daemon.topics.curr_state_pub, daemon.vehicle.state

    def flies() -> tuple[bool, bool]:
        return daemon._lots.keeper.is_armed, daemon._flights.may_fly

    said.publish(replace(GROUND, armed=True))
    state.publish(StateName.AUTONOMOUS_EXPLORE)
    said.publish(GROUND)
    assert flies() == (True, True)
    state.publish(StateName.IDLE)
    assert flies() == (False, False)

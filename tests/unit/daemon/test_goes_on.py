"""The survey of the run before goes on after a fault, also over a simulated world, which is else new at each start."""

from __future__ import annotations

from pathlib import Path

import pytest

from hawk.config import Config, StoreSettings, WatchdogSettings
from hawk.daemon import Daemon, DaemonOptions
from hawk.model import GlobalPose, Outline
from hawk.program_log import ProgramLog
from hawk.simulation import SimulationOptions
from hawk.store.journal import FlightJournal

DATUM = GlobalPose(43.26, -79.92, 100.0)


async def datum_after(folder: Path, options: DaemonOptions) -> GlobalPose | None:
    """Return the datum of a daemon that starts after a run that journalled `DATUM`."""
    journal = FlightJournal(folder / "journal")
    journal.set_datum(DATUM)
    await journal.close()
    output = ProgramLog("info")
    config = Config(store=StoreSettings(directory=folder), watchdog=WatchdogSettings(enabled=False))
    daemon = Daemon(config, options, output)
    try:
        return daemon.autopilot.datum
    finally:
        await daemon._close()
        output.close()


@pytest.mark.parametrize(
    ("options", "goes_on"),
    [
        (DaemonOptions(), True),
        (DaemonOptions(simulation=SimulationOptions()), False),
        (DaemonOptions(simulation=SimulationOptions(), is_again=True), True),
    ],
    ids=["real drone", "simulated world", "simulated world after a fault"],
)
async def test_whose_survey_goes_on(tmp_path: Path, options: DaemonOptions, goes_on: bool) -> None:
    assert await datum_after(tmp_path, options) == (DATUM if goes_on else None)


async def test_an_outline_that_was_given_before_the_first_flight_goes_on(tmp_path: Path) -> None:
    given = Outline((((43.26, -79.92), (43.27, -79.92), (43.27, -79.91)),))
    journal = FlightJournal(tmp_path / "journal")
    journal.set_outline(given)
    journal.put_map({"meta": b"{}"})  # that of an empty map
    await journal.close()
    output = ProgramLog("info")
    config = Config(store=StoreSettings(directory=tmp_path), watchdog=WatchdogSettings(enabled=False))
    daemon = Daemon(config, DaemonOptions(), output)
    try:
        assert daemon.manager.outlines.outline == given
    finally:
        await daemon._close()
        output.close()

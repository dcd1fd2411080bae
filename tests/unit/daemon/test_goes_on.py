"""The survey of the run before goes on after a fault, also over a simulated world, which is else new at each start."""

from __future__ import annotations

from pathlib import Path

import pytest

from hawk.config import Config, StoreSettings, WatchdogSettings
from hawk.daemon import Daemon, DaemonOptions
from hawk.model.limits import Outline
from hawk.model.operation import FlightDrain
from hawk.model.poses import ArmPlace, GlobalPose
from hawk.program_log import ProgramLog
from hawk.simulation import SimulationOptions
from hawk.starts import CONTINUE_S, survey_at_start
from hawk.store.journal import FlightJournal
from hawk.store.journal_state import JournalState

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


async def survey_after(folder: Path, age_s: float, **journalled: object) -> JournalState:
    """Return the survey of a start at this age of the journal's newest write."""
    journal = FlightJournal(folder / "journal")
    for name, value in journalled.items():
        getattr(journal, name)(value)
    await journal.close()
    again = FlightJournal(folder / "journal")
    try:
        written = again.state.last_written
        return survey_at_start(again, is_new_world=False, wall=lambda: written + age_s)
    finally:
        await again.close()


@pytest.mark.parametrize(("age_s", "goes_on"), [(CONTINUE_S - 1, True), (CONTINUE_S + 1, False)])
async def test_a_survey_goes_on_for_half_an_hour(tmp_path: Path, age_s: float, goes_on: bool) -> None:
    drain = FlightDrain(0.05, 400.0, 1_700_000_000.0)
    kept = await survey_after(tmp_path, age_s, set_datum=DATUM, put_map={"meta": b"{}"}, set_drains=(drain,))
    assert (kept.datum, dict(kept.map_parts)) == ((DATUM, {"meta": b"{}"}) if goes_on else (None, {}))
    assert kept.drains == (drain,), "what earlier flights used is known to every survey"


async def test_an_old_outline_without_a_flight_stays_and_its_arm_place_does_not(tmp_path: Path) -> None:
    given = Outline((((43.26, -79.92), (43.27, -79.92), (43.27, -79.91)),))
    place = ArmPlace(43.26, -79.92, 100.0, 0.0, 0.0, 0.0, 1_700_000_000)
    kept = await survey_after(tmp_path, CONTINUE_S + 1, set_outline=given, set_arm_place=place)
    assert (kept.outline, kept.arm_place) == (given, None)

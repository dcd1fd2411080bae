"""The survey of the run before goes on after a fault, also over a simulated world, which is else new at each start."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from hawk.config.sections import Config, ConfigError, StoreSettings, WatchdogSettings
from hawk.daemon.options import DaemonOptions
from hawk.daemon.root import Daemon
from hawk.daemon.starts import CONTINUE_S, SurveyAtStart, survey_at_start
from hawk.model.moment import Moment, this_moment
from hawk.model.operation import FlightDrain, FlightSoFar
from hawk.model.plans import Outline
from hawk.model.poses import ArmPlace, GlobalPose
from hawk.runtime.program_log import ProgramLog
from hawk.sim.launch import SimulationOptions
from hawk.store.journal import FlightJournal
from hawk.store.journal_state import JournalState
from hawk.store.run_notes import Notes, RunNotes, notes_file

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


@pytest.mark.slow
@pytest.mark.parametrize(
    ("options", "goes_on"),
    [
        (DaemonOptions(), True),
        (DaemonOptions(simulation=SimulationOptions()), False),
        (DaemonOptions(simulation=SimulationOptions(), is_again=True), True),
    ],
    ids=["real drone", "simulated world", "simulated world after a fault"],
)
async def test_options_decide_whether_a_survey_goes_on(tmp_path: Path, options: DaemonOptions, goes_on: bool) -> None:
    assert await datum_after(tmp_path, options) == (DATUM if goes_on else None)


@pytest.mark.slow
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
        assert written is not None
        return survey_at_start(again, flies=False, is_new_world=False, moment=lambda: written.before(-age_s)).kept
    finally:
        await again.close()


@pytest.mark.parametrize(("age_s", "goes_on"), [(1799.9, True), (1800.1, False)])
async def test_a_survey_goes_on_for_half_an_hour(tmp_path: Path, age_s: float, goes_on: bool) -> None:
    drain = FlightDrain(0.05, 400.0, 1_700_000_000.0)
    kept = await survey_after(tmp_path, age_s, set_datum=DATUM, put_map={"meta": b"{}"}, set_drains=(drain,))
    assert (kept.datum, dict(kept.map_parts)) == ((DATUM, {"meta": b"{}"}) if goes_on else (None, {}))
    assert kept.drains == (drain,), "what earlier flights used is known to every survey"


async def test_a_start_on_the_ground_before_any_flight_is_no_survey_to_set_aside(tmp_path: Path) -> None:
    journal = FlightJournal(tmp_path / "journal", moment=lambda: NOW)
    journal.put_map({"meta": b"{}"})  # an empty map has one, too
    await journal.close()
    again = FlightJournal(tmp_path / "journal", moment=lambda: NOW)
    try:
        found = survey_at_start(again, flies=False, is_new_world=False, moment=lambda: NOW)
    finally:
        await again.close()
    assert (found.words, found.kept.survey_id) == ("", journal.state.survey_id)


async def test_an_old_outline_without_a_flight_stays_and_its_arm_place_does_not(tmp_path: Path) -> None:
    given = Outline((((43.26, -79.92), (43.27, -79.92), (43.27, -79.91)),))
    place = ArmPlace(43.26, -79.92, 100.0, 0.0, 0.0, 0.0)
    kept = await survey_after(tmp_path, CONTINUE_S + 1, set_outline=given, set_arm_place=place)
    assert (kept.outline, kept.arm_place) == (given, None)


NOW = Moment("boot", 9000.0, 1_800_000_000.0)
DAY = 86400.0


async def started(folder: Path, now: Moment, *, flies: bool = False, continues: bool = False) -> SurveyAtStart:
    """Return the survey of a start at a moment; the run before journalled the datum and a map at `NOW`."""
    journal = FlightJournal(folder / "journal", moment=lambda: NOW)
    journal.set_datum(DATUM)
    journal.put_map({"meta": b"{}"})
    await journal.close()
    again = FlightJournal(folder / "journal", moment=lambda: now)
    try:
        return survey_at_start(again, flies=flies, is_new_world=False, continues=continues, moment=lambda: now)
    finally:
        await again.close()


async def test_only_a_young_survey_has_the_same_cars(tmp_path: Path) -> None:
    def later(seconds: float) -> Moment:
        return NOW.before(-seconds)

    assert (await started(tmp_path / "a", later(CONTINUE_S - 1))).is_young
    assert not (await started(tmp_path / "b", later(CONTINUE_S + 1), continues=True)).is_young
    assert not (await started(tmp_path / "c", later(CONTINUE_S + 1), flies=True)).is_young


@pytest.mark.fault(
    "the wall clock steps by 3 days between two starts on the ground",
    "the survey goes on; one that is set aside is shown in log and page",
)
@pytest.mark.parametrize("step", [31 * 60.0, 3 * DAY, -3 * DAY, 40 * 365 * DAY])
async def test_a_step_of_the_wall_clock_begins_no_survey_and_makes_none_young(tmp_path: Path, step: float) -> None:
    young = replace(NOW.before(-100.0), utc=NOW.utc + step)
    assert (await started(tmp_path, young)).kept.datum == DATUM
    old = replace(NOW.before(-CONTINUE_S), utc=NOW.utc + step)
    assert (await started(tmp_path, old)).kept.datum is None


@pytest.mark.parametrize(
    ("up", "wall", "goes_on"),
    [
        (40.0, 300.0, True),
        (40.0, -3 * DAY, True),
        (40.0, 2 * CONTINUE_S, False),
        (CONTINUE_S, 300.0, False),
        (CONTINUE_S - 1, CONTINUE_S - 1, True),
    ],
    ids=["battery swapped", "a clock that lost its time", "an hour later", "up for half an hour", "just young enough"],
)
async def test_after_a_boot_a_survey_is_as_old_as_the_boot_at_least(
    tmp_path: Path, up: float, wall: float, goes_on: bool
) -> None:
    found = await started(tmp_path, Moment("next", up, NOW.utc + wall))
    assert (found.kept.datum is not None, not found.words) == (goes_on, goes_on)


@pytest.mark.parametrize("option", ["flies", "continues"])
async def test_a_survey_in_the_air_and_one_that_an_operator_continues_go_on_whatever_their_age(
    tmp_path: Path, option: str
) -> None:
    found = await started(tmp_path, Moment("next", 40.0, NOW.utc + 3 * DAY), **{option: True})
    assert (found.kept.datum, dict(found.kept.map_parts), found.words) == (DATUM, {"meta": b"{}"}, "")


@pytest.mark.parametrize(
    ("now", "age"),
    [
        (Moment("next", 40.0, NOW.utc + 3 * DAY), "3 days ago by the wall clock, and the computer was started since"),
        (Moment("boot", NOW.seconds + 4 * 3600.0, 0.0), "4 hours ago"),
        (Moment("boot", NOW.seconds + 2400.0, 0.0), "40 minutes ago"),
    ],
)
async def test_a_survey_that_is_set_aside_is_reported_with_its_name_and_age(
    tmp_path: Path, now: Moment, age: str
) -> None:
    found = await started(tmp_path, now)
    (first, *_) = sorted(path.name for path in (tmp_path / "journal").iterdir())
    begins = f"A new survey begins: the last one, {first}, was written {age}"
    assert found.words == f"{begins}. It is kept in the folder journal of the store"
    assert found.kept.survey_id != first


@pytest.mark.slow
@pytest.mark.fault("the wall clock steps by 3 days between two starts on the ground")
async def test_the_page_shows_a_survey_that_was_set_aside(tmp_path: Path) -> None:
    old = this_moment().before(2 * DAY)
    journal = FlightJournal(tmp_path / "journal", moment=lambda: old)
    journal.set_datum(DATUM)
    await journal.close()
    output = ProgramLog("info")
    config = Config(store=StoreSettings(directory=tmp_path), watchdog=WatchdogSettings(enabled=False))
    daemon = Daemon(config, DaemonOptions(), output)
    try:
        assert [entry.text for entry in daemon.manager.log.entries if "A new survey begins" in entry.text]
    finally:
        await daemon._close()
        output.close()


async def test_an_empty_journal_is_of_no_age(tmp_path: Path) -> None:
    journal = FlightJournal(tmp_path / "journal")
    try:
        assert survey_at_start(journal, flies=False, is_new_world=False).words == ""
    finally:
        await journal.close()


async def test_a_new_simulated_world_sets_a_survey_aside_without_a_word(tmp_path: Path) -> None:
    journal = FlightJournal(tmp_path / "journal")
    journal.set_datum(DATUM)
    await journal.close()
    again = FlightJournal(tmp_path / "journal")
    try:
        found = survey_at_start(again, flies=True, is_new_world=True)
        assert (found.kept.datum, found.words) == (None, "")
    finally:
        await again.close()


@pytest.mark.slow
@pytest.mark.fault("the store became read-only in the air", "the start goes on without it")
@pytest.mark.parametrize("flies", [True, False])
async def test_a_store_that_cannot_be_written_stops_no_start_in_the_air(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, flies: bool
) -> None:
    monkeypatch.setenv("RUNTIME_DIRECTORY", str(tmp_path))
    store = tmp_path / "store"
    store.mkdir()
    notes = notes_file(store, {"RUNTIME_DIRECTORY": str(tmp_path)})
    RunNotes(notes).put(Notes(flight=FlightSoFar(30.0, 40.0, this_moment()) if flies else None))

    def refuse(setting: str, directory: Path) -> None:
        raise ConfigError(f"{setting}: {directory} cannot be used")

    monkeypatch.setattr("hawk.daemon.root.make_folder", refuse)
    output = ProgramLog("info")
    config = Config(store=StoreSettings(directory=store), watchdog=WatchdogSettings(enabled=False))
    try:
        if not flies:
            with pytest.raises(ConfigError, match=r"store\.directory"):
                Daemon(config, DaemonOptions(), output)
            return
        daemon = Daemon(config, DaemonOptions(), output)
        assert daemon.flew_lately
        await daemon._close()
    finally:
        output.close()

from __future__ import annotations

import asyncio
import errno
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import AsyncIterator, Callable
from pathlib import Path
from typing import IO, Any

import pytest

from hawk.model.moment import Moment
from hawk.model.operation import Fall, FlightDrain, FlightSoFar, SurveyLeft
from hawk.model.plans import Outline
from hawk.model.poses import ArmPlace, GlobalPose
from hawk.store.journal import FlightJournal
from hawk.store.journal_state import JournalState, pack, read_survey, surveys_of

DATUM = GlobalPose(43.2609, -79.9192, 100.25)
PLACE = ArmPlace(43.26, -79.92, 101.5, 1.25, -2.5, 0.125, Moment("host", 77.5, 1_800_000_000.0))
FLIGHT = FlightSoFar(312.5, 850.25, Moment("host", 477.5, 1_800_000_400.5))
OUTLINE = Outline((((43.25, -79.5), (43.25, -79.25), (43.5, -79.25)),), ())
NOW = Moment("boot", 5000.125, 1_800_000_000.5)
LEFT = SurveyLeft(0.75, 4_200.5, 130.25, flown_s=61.5)
DRAIN = FlightDrain(0.125, 240.0, 1_800_000_300.0)
Make = Callable[..., FlightJournal]


@pytest.fixture
async def make(tmp_path: Path) -> AsyncIterator[Make]:
    made: list[FlightJournal] = []

    def make_it(**options: Any) -> FlightJournal:
        made.append(FlightJournal(tmp_path / "journal", **options))
        return made[-1]

    yield make_it
    for journal in made:
        await journal.close()


def folder(tmp_path: Path) -> Path:
    return tmp_path / "journal"


def read_journal(directory: Path) -> JournalState:
    """Read the newest survey as the next start of the daemon does."""
    surveys = surveys_of(directory)
    return read_survey(surveys[-1])[1] if surveys else JournalState()


def test_where_there_is_no_journal_there_is_nothing(tmp_path: Path) -> None:
    assert read_journal(tmp_path / "none") == JournalState()


async def test_everything_that_was_put_is_there_again(make: Make, tmp_path: Path) -> None:
    journal = make()
    journal.set_datum(DATUM)
    journal.set_arm_place(PLACE)
    journal.set_flight(FLIGHT)
    journal.set_left(LEFT)
    journal.set_drains([DRAIN])
    journal.set_outline(OUTLINE)
    journal.put_map({"grid/0,0": b"tile", "stall/7": b"stall"})
    assert await journal.flush()
    state = read_journal(folder(tmp_path))
    assert (state.datum, state.arm_place, state.flight) == (DATUM, PLACE, FLIGHT)
    assert (state.left, state.drains, state.outline) == (LEFT, (DRAIN,), OUTLINE)
    assert state.map_parts == {"grid/0,0": b"tile", "stall/7": b"stall"}
    assert (state.lost_bytes, state.problem) == (0, "")
    assert state.survey_id == journal.survey_id


async def test_the_newest_value_wins_and_an_empty_one_ends_it(make: Make, tmp_path: Path) -> None:
    journal = make()
    for number in range(5):
        journal.put_map({"a": str(number).encode(), "gone": b"here"})
        await journal.flush()
    journal.put_map({"gone": b""})
    journal.set_datum(DATUM)
    journal.set_datum(None)
    journal.set_flight(FLIGHT)
    journal.set_flight(None)
    await journal.close()
    state = read_journal(folder(tmp_path))
    assert state.map_parts == {"a": b"4"}
    assert state.datum is None
    assert state.flight is None


async def test_the_next_run_goes_on_with_it(make: Make, tmp_path: Path) -> None:
    first = make()
    first.set_datum(DATUM)
    first.put_map({"a": b"1", "b": b"1"})
    await first.close()
    second = make()
    assert second.state.datum == DATUM
    assert second.state.map_parts == {"a": b"1", "b": b"1"}
    second.put_map({"b": b"2"})
    await second.close()
    state = read_journal(folder(tmp_path))
    assert state.map_parts == {"a": b"1", "b": b"2"}
    assert state.survey_id == first.survey_id == second.survey_id
    assert len(list((folder(tmp_path) / state.survey_id).iterdir())) == 1  # compacted at the start


async def test_a_new_survey_is_empty_and_the_old_one_is_kept(make: Make, tmp_path: Path) -> None:
    journal = make()
    journal.set_datum(DATUM)
    journal.set_left(LEFT)
    journal.set_drains([DRAIN])
    journal.set_outline(OUTLINE)
    journal.put_map({"old": b"1"})
    old = journal.survey_id
    new = journal.new_survey()
    journal.put_map({"new": b"1"})
    await journal.flush()
    assert new != old
    assert journal.survey_id == new
    state = read_journal(folder(tmp_path))
    assert (state.survey_id, state.datum, dict(state.map_parts)) == (new, None, {"new": b"1"})
    assert (state.left, state.outline, state.drains) == (
        None,
        None,
        (DRAIN,),
    )  # the battery stays
    (kept,) = (folder(tmp_path) / old).iterdir()
    assert b"old" in kept.read_bytes()


async def test_motors_that_went_off_in_the_air_are_kept_for_every_survey_until_they_are_cleared(
    make: Make, tmp_path: Path
) -> None:
    journal, fall = make(), Fall(1_800_000_000.0, 43.26, -79.92, 17.7)
    journal.set_datum(DATUM)
    journal.set_fall(fall)
    await journal.flush()
    assert read_journal(folder(tmp_path)).fall == fall
    journal.new_survey()
    await journal.flush()
    assert read_journal(folder(tmp_path)).fall == fall
    journal.set_fall(None)
    await journal.flush()
    assert read_journal(folder(tmp_path)).fall is None


async def test_only_the_last_surveys_are_kept(make: Make, tmp_path: Path) -> None:
    journal = make(keep=2)
    for number in range(5):
        journal.new_survey()
        journal.put_map({"n": str(number).encode()})
        await journal.flush()
    await journal.close()
    names = sorted(path.name for path in folder(tmp_path).iterdir())
    assert len(names) == 3
    assert read_journal(folder(tmp_path)).map_parts == {"n": b"4"}


async def test_starts_in_the_air_are_kept_over_runs_and_surveys_for_ten_minutes(make: Make) -> None:
    for number in range(3):
        now = NOW.before(-20.0 * number)
        journal = make(moment=lambda now=now: now)
        assert journal.state.starts_in_air == tuple(NOW.before(-20.0 * n) for n in range(number))
        journal.add_start_in_air(now)
        if number == 1:
            journal.new_survey()
        await journal.close()
    late = make(moment=lambda: NOW.before(-640.0))
    await late.close()
    assert make().state.starts_in_air == (NOW.before(-40.0),)


@pytest.mark.parametrize(("up", "kept"), [(600.0, (NOW,)), (601.0, ())])
async def test_starts_of_another_boot_are_kept_for_ten_minutes_of_this_one(
    make: Make, up: float, kept: tuple[Moment, ...]
) -> None:
    journal = make(moment=lambda: NOW)
    journal.add_start_in_air(NOW)
    await journal.close()
    again = make(moment=lambda: Moment("next", up, 0.0))
    await again.close()
    assert make().state.starts_in_air == kept


async def test_a_start_in_the_air_is_on_disk_when_flush_returns(
    make: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("hawk.store.journal.SYNC_S", 60.0)
    journal = make(moment=lambda: NOW)
    journal.put_map({"a": b"1"})
    await journal.flush()
    journal.add_start_in_air(NOW)
    before = time.perf_counter()
    assert await journal.flush(30.0)
    assert time.perf_counter() - before < 30.0, "it waited for the time of the next sync"
    assert read_journal(folder(tmp_path)).starts_in_air == (NOW,)


async def test_a_start_in_the_air_does_not_wait_for_the_next_write(
    make: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("hawk.store.journal.SYNC_S", 3600.0)
    journal = make(moment=lambda: NOW)
    journal.add_start_in_air(NOW)
    async with asyncio.timeout(5.0):
        while read_journal(folder(tmp_path)).starts_in_air != (NOW,):  # noqa: ASYNC110 - a disk sends no event
            await asyncio.sleep(0.01)


async def test_the_run_before_gives_its_age(make: Make) -> None:
    now = [NOW]
    journal = make(moment=lambda: now[0])
    assert journal.state.last_written is None
    journal.set_datum(DATUM)
    assert await journal.flush()
    now[0] = NOW.before(-7.0)
    journal.try_disk()
    await journal.close()
    again = make(moment=lambda: NOW.before(-60.0))
    await again.flush()
    assert again.state.last_written == NOW.before(-7.0)


async def test_a_journal_that_does_not_note_its_time_is_as_old_as_its_file(make: Make, tmp_path: Path) -> None:
    survey = folder(tmp_path) / "000001-old"
    survey.mkdir(parents=True)
    (survey / "000001.journal").write_bytes(pack("start/1800000000.000", b"1"))
    os.utime(survey / "000001.journal", (5000.0, 5000.0))
    state = make().state
    assert (state.last_written, state.starts_in_air, state.problem) == (Moment(utc=5000.0), (), "")


@pytest.mark.slow
async def test_whether_the_disk_can_be_written_is_known_at_once(make: Make) -> None:
    journal = make(opener=full_disk)
    journal.try_disk()
    assert not await journal.flush(0.5)
    sound = make()
    sound.try_disk()
    assert await sound.flush(0.5)


def full_disk(path: Path) -> IO[bytes]:
    raise OSError(errno.ENOSPC, "No space left on device", str(path))


async def test_flush_with_nothing_to_write_returns_at_once(make: Make) -> None:
    assert await make().flush(0.5)


async def test_a_torn_tail_is_dropped_and_reported(make: Make, tmp_path: Path) -> None:
    journal = make()
    journal.put_map({"a": b"1"})
    await journal.close()
    (segment,) = (folder(tmp_path) / journal.survey_id).iterdir()
    with segment.open("ab") as file:
        file.write(pack("map/b", b"torn")[:-2])
    state = read_journal(folder(tmp_path))
    assert state.map_parts == {"a": b"1"}
    assert state.lost_bytes > 0


async def test_a_value_that_cannot_be_read_costs_only_itself(make: Make, tmp_path: Path) -> None:
    journal = make()
    journal.set_arm_place(PLACE)
    journal.put_map({"a": b"1"})
    await journal.close()
    (segment,) = (folder(tmp_path) / journal.survey_id).iterdir()
    with segment.open("ab") as file:
        file.write(pack("datum", b'{"latitude": "x"}'))
    state = read_journal(folder(tmp_path))
    assert (state.datum, state.arm_place, dict(state.map_parts)) == (None, PLACE, {"a": b"1"})
    assert "GlobalPose in the journal cannot be read" in state.problem


async def test_a_segment_that_grew_is_compacted_while_it_is_written(make: Make, tmp_path: Path) -> None:
    journal = make(compact_bytes=50_000)
    for number in range(30):
        journal.put_map({"tile": bytes([number]) * 10_000})
        await journal.flush()
    await journal.close()
    files = list((folder(tmp_path) / journal.survey_id).iterdir())
    assert sum(file.stat().st_size for file in files) < 100_000
    assert read_journal(folder(tmp_path)).map_parts == {"tile": bytes([29]) * 10_000}


async def test_a_start_in_the_air_reads_ten_megabytes_at_most_of_a_small_map(make: Make, tmp_path: Path) -> None:
    journal = make()
    for number in range(40):
        journal.put_map({"tile": bytes([number]) * 500_000})
        assert await journal.flush()
    await journal.close()
    files = list((folder(tmp_path) / journal.survey_id).iterdir())
    assert sum(file.stat().st_size for file in files) < 10_000_000
    assert read_journal(folder(tmp_path)).map_parts == {"tile": bytes([39]) * 500_000}


async def test_what_is_put_while_the_disk_is_slow_is_merged_by_key(make: Make, tmp_path: Path) -> None:
    release = threading.Event()

    def slow(path: Path) -> IO[bytes]:
        release.wait(10)
        return path.open("xb", buffering=0)

    journal = make(opener=slow)
    before = time.perf_counter()
    for number in range(2000):
        journal.put_map({"tile": number.to_bytes(2, "big") * 1000})
    assert time.perf_counter() - before < 9.0, "it waited for the disk"
    assert len(journal._pending) == 1
    release.set()
    assert await journal.flush()
    assert read_journal(folder(tmp_path)).map_parts["tile"] == (1999).to_bytes(2, "big") * 1000


class Disk:
    """Opens segments on a disk that can be full."""

    def __init__(self) -> None:
        self.full = False

    def open(self, path: Path) -> IO[bytes]:
        file = path.open("xb", buffering=0)
        disk = self

        class Segment:
            def write(self, data: memoryview) -> int:
                if disk.full:
                    file.write(data[: len(data) // 2])
                    raise OSError(errno.ENOSPC, "No space left on device")
                return file.write(data)

            def fileno(self) -> int:
                return file.fileno()

            def close(self) -> None:
                file.close()

        return Segment()  # type: ignore[return-value]


@pytest.mark.slow
async def test_a_full_disk_is_reported_and_nothing_is_lost_when_there_is_room_again(make: Make, tmp_path: Path) -> None:
    disk = Disk()
    journal = make(opener=disk.open)
    journal.put_map({"a": b"1" * 100})
    assert await journal.flush()
    disk.full = True
    journal.put_map({"b": b"2" * 100})
    assert not await journal.flush(0.3)
    assert "No space left on device" in journal.health.reason
    assert read_journal(folder(tmp_path)).map_parts == {"a": b"1" * 100}
    journal.put_map({"c": b"3" * 100})
    disk.full = False
    assert await journal.flush(5.0)
    assert journal.health.is_healthy
    assert read_journal(folder(tmp_path)).map_parts == {"a": b"1" * 100, "b": b"2" * 100, "c": b"3" * 100}


@pytest.mark.slow
async def test_after_a_wait_for_the_disk_the_journal_is_healthy(make: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    disk = Disk()
    journal = make(opener=disk.open)
    healthy: list[bool] = []
    wake = journal._wake_synced

    def watched(target: int) -> None:
        healthy.append(journal.health.is_healthy)
        wake(target)

    monkeypatch.setattr(journal, "_wake_synced", watched)
    disk.full = True
    journal.put_map({"a": b"1" * 100})
    assert not await journal.flush(0.3)
    disk.full = False
    assert await journal.flush(5.0)
    assert healthy == [True]


@pytest.mark.slow
async def test_a_disk_that_stays_full_does_not_fill_with_pieces(make: Make, tmp_path: Path) -> None:
    disk = Disk()
    journal = make(opener=disk.open)
    journal.put_map({"a": b"1" * 100})
    await journal.flush()
    disk.full = True
    for _ in range(3):
        journal.put_map({"b": b"2" * 100})
        await journal.flush(0.05)
    assert len(list((folder(tmp_path) / journal.survey_id).iterdir())) <= 2


@pytest.mark.slow
async def test_a_folder_that_cannot_be_made_is_reported_and_puts_go_on(tmp_path: Path) -> None:
    (tmp_path / "journal").write_text("a file in its place")
    journal = FlightJournal(tmp_path / "journal")
    journal.put_map({"a": b"1"})
    assert not await journal.flush(0.2)
    assert not journal.health.is_healthy
    assert "journal" in journal.health.reason
    before = time.perf_counter()
    await journal.close()
    assert time.perf_counter() - before < 5.0


async def test_keys_and_values_beyond_the_format_are_refused_at_once(make: Make) -> None:
    journal = make()
    with pytest.raises(ValueError, match="bytes"):
        journal.put_map({"k" * 2000: b"1"})
    with pytest.raises(ValueError, match="Out of range"):
        journal.set_datum(GlobalPose(float("nan"), 0.0, 0.0))
    assert await journal.flush()


async def test_closing_twice_is_fine_and_ends_the_thread(make: Make) -> None:
    journal = make()
    journal.put_map({"a": b"1"})
    await journal.close()
    await journal.close()
    assert not journal._thread.is_alive()


@pytest.mark.slow
def test_a_killed_process_loses_less_than_a_second(tmp_path: Path) -> None:
    """The real thing: a child that writes is ended by SIGKILL, and everything older than a second is there."""
    child = subprocess.Popen(
        [sys.executable, "-m", "tests.unit.store.killed_writer", str(folder(tmp_path))],
        stdout=subprocess.PIPE,
        text=True,
    )
    put: list[tuple[int, float]] = []
    try:
        assert child.stdout is not None
        deadline = time.monotonic() + 20.0
        while len(put) < 120 and time.monotonic() < deadline:
            number, at = child.stdout.readline().split()
            put.append((int(number), float(at)))
        killed = time.monotonic()
        child.send_signal(signal.SIGKILL)
        rest, _ = child.communicate(timeout=10)
    finally:
        child.kill()
        child.wait()
    assert len(put) == 120
    put += [(int(line.split()[0]), float(line.split()[1])) for line in rest.splitlines() if line.count(" ") == 1]
    state = read_journal(folder(tmp_path))
    kept = {int(key.removeprefix("stall/")) for key in state.map_parts if key.startswith("stall/")}
    assert {number for number, at in put if at < killed - 1.0} <= kept
    assert kept == set(range(1, max(kept) + 1))  # nothing is missing in between
    assert state.datum == GlobalPose(43.0, -79.0, 100.0)
    assert state.arm_place is not None
    assert state.problem == ""


async def test_puts_never_hold_up_the_loop(make: Make) -> None:
    journal = make()
    tile = bytes(200_000)
    worst = 0.0
    for number in range(100):
        before = time.perf_counter()
        journal.put_map({f"grid/{number % 10},0": tile})
        worst = max(worst, time.perf_counter() - before)
        await asyncio.sleep(0)
    assert worst < 0.05


async def test_a_start_can_be_taken_back(make: Make, tmp_path: Path) -> None:
    journal = make(moment=lambda: NOW)
    journal.add_start_in_air(NOW)
    journal.add_start_in_air(NOW.before(-3.0))
    assert await journal.flush()
    assert read_journal(folder(tmp_path)).starts_in_air == (NOW, NOW.before(-3.0))
    journal.withdraw_start(NOW)
    journal.withdraw_start(NOW)
    assert await journal.flush()
    assert read_journal(folder(tmp_path)).starts_in_air == (NOW.before(-3.0),)

from __future__ import annotations

import errno
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import IO

import pytest

from hawk.daemon.starts import Starts
from hawk.ddc.rules.follower import FLIGHT_KEPT_S, RestartRule
from hawk.model.moment import Moment
from hawk.model.operation import FlightSoFar
from hawk.store.journal import FlightJournal
from hawk.store.run_notes import Notes, RunNotes

NOW = Moment("boot", 5000.0, 1_800_000_000.0)
FLIGHT = FlightSoFar(30.0, 40.0, NOW)
ADOPT, RETURN_HOME, STAY_AWAY = RestartRule
Run = Callable[[Starts], object]


def full_disk(path: Path) -> IO[bytes]:
    raise OSError(errno.ENOSPC, "No space left on device", str(path))


@dataclass
class Computer:
    """A folder on a disk and a file in memory, each of which may fail; each run is a program of its own."""

    folder: Path
    disk_works: bool = True
    memory_works: bool = True
    is_read: bool = True

    def journal(self, at: Moment) -> FlightJournal:
        return FlightJournal(self.folder / "journal", moment=lambda: at, opener=None if self.disk_works else full_disk)

    def notes(self) -> RunNotes:
        return RunNotes(self.folder / "notes.json" if self.memory_works else self.folder / "none" / "notes.json")

    def boot(self) -> None:
        (self.folder / "notes.json").unlink(missing_ok=True)

    @asynccontextmanager
    async def running(self, at: Moment, flight: FlightSoFar | None = None, **options: bool) -> AsyncIterator[Starts]:
        """``flight``: what the run before journalled."""
        if flight is not None:
            before = self.journal(at)
            before.set_flight(flight)
            await before.close()
        journal = self.journal(at)
        if not self.is_read:
            journal.state = replace(journal.state, is_read=False)
        starts = Starts(journal, self.notes(), 1.0, moment=lambda: at, **options)
        try:
            await starts.settle(0.3 if self.disk_works else 0.02)
            yield starts
        finally:
            await journal.close()

    async def run(self, at: Moment, flight: FlightSoFar | None = None, *steps: Run) -> RestartRule:
        """Run the program once; return its rule at the start."""
        async with self.running(at, flight) as starts:
            rule = starts.rule
            for step in steps:
                step(starts)
            return rule

    async def found(self, at: Moment, flight: FlightSoFar | None = None) -> int:
        """Run the program once, which finds the drone in the air; return the number of its start."""
        async with self.running(at, flight) as starts:
            return starts.found_in_air()


@pytest.fixture(params=["disk and memory", "disk", "memory"])
def computer(request: pytest.FixtureRequest, tmp_path: Path) -> Computer:
    return Computer(tmp_path, disk_works="disk" in request.param, memory_works="memory" in request.param)


@pytest.fixture
def sound(tmp_path: Path) -> Computer:
    return Computer(tmp_path)


def after(seconds: float, *, step: float = 0.0) -> Moment:
    """Return the moment that long after `NOW`, with the wall clock stepped."""
    later = NOW.before(-seconds)
    return replace(later, utc=later.utc + step)


def in_air(starts: Starts) -> None:
    starts.found_in_air()


def flying(starts: Starts) -> None:
    starts.keep_flight(FLIGHT)


CRASHES: dict[str, tuple[Run, ...]] = {"before the link": (), "after it was found in the air": (in_air,)}


@pytest.mark.nightly
@pytest.mark.parametrize("steps", CRASHES.values(), ids=CRASHES)
async def test_crashes_in_a_flight_count_on_disk_and_in_memory(computer: Computer, steps: tuple[Run, ...]) -> None:
    await computer.run(NOW, None, flying)
    rules = [await computer.run(after(1.0 + n), None, *steps) for n in range(4)]
    assert rules == [ADOPT, RETURN_HOME, STAY_AWAY, STAY_AWAY]


@pytest.mark.slow
@pytest.mark.fault(
    "the wall clock steps by 31 minutes or 3 days in the air, forward or back",
    "crash count, flight, map and arm place stay",
)
@pytest.mark.parametrize("step", [31 * 60.0, -31 * 60.0, 3 * 86400.0, -3 * 86400.0])
async def test_a_step_of_the_wall_clock_loses_no_crash(computer: Computer, step: float) -> None:
    await computer.run(NOW, None, flying)
    rules = [await computer.run(after(1.0 + n, step=n * step)) for n in range(3)]
    assert rules == [ADOPT, RETURN_HOME, STAY_AWAY]


@pytest.mark.slow
@pytest.mark.parametrize("end", [Starts.found_disarmed, Starts.ended_in_order])
async def test_a_start_on_the_ground_and_an_orderly_end_do_not_count(computer: Computer, end: Run) -> None:
    await computer.run(NOW, None, flying)
    assert [await computer.run(after(1.0 + n), None, end, end) for n in range(4)] == [ADOPT] * 4


async def test_a_start_in_the_air_counts_although_it_lands_afterwards(sound: Computer) -> None:
    await sound.run(after(1.0), FLIGHT, in_air, Starts.found_disarmed)
    assert await sound.run(after(2.0)) is RETURN_HOME


@pytest.mark.nightly
async def test_a_landing_ends_the_flight_on_disk_and_in_memory(computer: Computer) -> None:
    await computer.run(NOW, None, flying, lambda starts: starts.keep_flight(None))
    async with computer.running(after(1.0)) as starts:
        assert not starts.flew_lately
    assert not (computer.folder / "notes.json").exists(), "nothing is left behind in the memory"


async def test_without_a_flight_under_way_only_a_drone_found_in_the_air_counts(sound: Computer) -> None:
    late = FLIGHT_KEPT_S + 1.0
    assert await sound.run(after(late), FLIGHT) is ADOPT
    assert await sound.run(after(late + 1.0), None, in_air) is ADOPT
    assert await sound.run(after(late + 2.0)) is RETURN_HOME


@pytest.mark.nightly
@pytest.mark.parametrize(("times", "counts"), [((1.0, 30.0, 60.9), [1, 2, 3]), ((1.0, 30.0, 61.0), [1, 2, 2])])
async def test_a_start_found_in_the_air_counts_those_within_a_minute(
    computer: Computer, times: tuple[float, ...], counts: list[int]
) -> None:
    await computer.run(NOW, None, flying)
    assert [await computer.found(after(at)) for at in times] == counts


async def test_a_start_counts_once(sound: Computer) -> None:
    async with sound.running(after(1.0), FLIGHT) as starts:
        assert [starts.found_in_air(), starts.found_in_air()] == [1, 1]
    assert await sound.found(after(2.0)) == 2


@pytest.mark.nightly
@pytest.mark.parametrize(("again", "rule"), [(60.9, RETURN_HOME), (61.0, ADOPT)])
async def test_a_start_counts_for_a_minute(computer: Computer, again: float, rule: RestartRule) -> None:
    await computer.run(NOW, None, flying)
    await computer.run(after(1.0))
    assert await computer.run(after(again)) is rule


# -- where a start may be missing -------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.fault(
    "six crashes in the air on a full disk, and the memory cannot be written either",
    "every start counts as the second: Return To Launch, never GUIDED again",
)
async def test_six_crashes_on_a_full_disk_without_memory_end_in_a_return_each(tmp_path: Path) -> None:
    broken = Computer(tmp_path, disk_works=False, memory_works=False)
    assert [await broken.found(after(1.0 + n)) for n in range(6)] == [2] * 6


@pytest.mark.slow
@pytest.mark.fault(
    "six crashes in the air on a full disk",
    "the starts are counted in memory: adopt, return home, then the drone is left to the autopilot",
)
async def test_six_crashes_on_a_full_disk_are_counted_in_memory(tmp_path: Path) -> None:
    full = Computer(tmp_path, disk_works=False)
    counts, rules = [], []
    for n in range(6):
        async with full.running(after(1.0 + n)) as starts:
            rules.append(starts.rule)
            counts.append(starts.found_in_air())
            starts.keep_flight(replace(FLIGHT, moment=after(1.0 + n)))
    assert counts == [1, 2, 3, 4, 5, 6]
    assert rules == [ADOPT, RETURN_HOME, *[STAY_AWAY] * 4]


@pytest.mark.slow
@pytest.mark.parametrize(("up", "count"), [(59.9, 2), (60.0, 1)])
async def test_the_memory_of_a_computer_that_booted_a_moment_ago_is_no_witness(
    tmp_path: Path, up: float, count: int
) -> None:
    full = Computer(tmp_path, disk_works=False)
    assert await full.found(Moment("boot", up, NOW.utc)) == count


@pytest.mark.slow
async def test_notes_that_cannot_be_read_count_as_a_start_while_the_disk_fails(tmp_path: Path) -> None:
    full = Computer(tmp_path, disk_works=False)
    (tmp_path / "notes.json").write_text("{")
    assert await full.found(NOW) == 2, "also after this start was noted"


async def test_a_journal_that_cannot_be_read_may_lack_a_start(tmp_path: Path) -> None:
    unread = Computer(tmp_path, memory_works=False, is_read=False)
    assert await unread.found(NOW) == 2
    assert await Computer(tmp_path, is_read=False).found(after(100.0)) == 1, "the memory knows all"


async def test_without_the_kernels_name_of_the_boot_each_start_is_the_second(sound: Computer) -> None:
    assert await sound.found(replace(NOW, boot_id="")) == 2


# -- the computer boots in the air ------------------------------------------------------------------------------------


@pytest.mark.fault(
    "the companion computer boots in the air",
    "the flight goes on, crashes before the boot count; the arm place stays where two clocks say that the "
    "autopilot ran on",
)
async def test_a_boot_in_the_air_counts_with_the_crashes_before_it(sound: Computer) -> None:
    await sound.run(after(-30.0), None, in_air)
    await sound.run(after(-10.0), None, in_air, flying)
    sound.boot()
    next_boot = Moment("next", 15.0, NOW.utc + 20.0)
    async with sound.running(next_boot) as starts:
        assert starts.flew_lately
        assert starts.rule is STAY_AWAY
        assert starts.found_in_air() == 3


async def test_a_boot_after_a_landing_forgives(sound: Computer) -> None:
    await sound.run(after(-30.0), None, in_air)
    await sound.run(after(-10.0), None, in_air, lambda starts: starts.keep_flight(None))
    sound.boot()
    async with sound.running(Moment("next", 15.0, NOW.utc + 20.0)) as starts:
        assert not starts.flew_lately
        assert starts.rule is ADOPT


# -- which flight -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("newer", ["disk", "memory"])
async def test_the_newer_word_on_the_flight_counts(sound: Computer, newer: str) -> None:
    old, new = FLIGHT, FlightSoFar(50.0, 60.0, after(20.0))
    sound.notes().put(Notes(flight=new if newer == "memory" else old))
    async with sound.running(after(21.0), old if newer == "memory" else new) as starts:
        assert starts.flight == new


async def test_the_flight_of_this_boot_counts_before_one_of_another(sound: Computer) -> None:
    sound.notes().put(Notes(flight=FLIGHT))
    async with sound.running(after(1.0), replace(FLIGHT, moment=Moment("former", 9000.0, NOW.utc))) as starts:
        assert starts.flight == FLIGHT


async def test_the_drone_of_a_new_simulated_world_has_no_past(sound: Computer) -> None:
    await sound.run(after(1.0), None, flying, in_air)
    async with sound.running(after(2.0), is_new_world=True) as starts:
        assert (starts.flight, starts.flew_lately, starts.rule) == (None, False, ADOPT)
        assert starts.found_in_air() == 1


@pytest.mark.fault("a second copter on the link")
async def test_a_flight_that_goes_on_keeps_its_vehicle(sound: Computer) -> None:
    await sound.run(NOW, None, lambda starts: starts.keep_flight(FLIGHT, 7), in_air)
    async with sound.running(after(1.0)) as starts:
        assert starts.flown_id == 7
        starts.found_in_air()
        starts.keep_flight(None, 7)
    async with sound.running(after(2.0)) as starts:
        assert starts.flown_id is None

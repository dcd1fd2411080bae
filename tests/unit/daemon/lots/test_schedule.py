from __future__ import annotations

import asyncio
import os
from collections.abc import AsyncIterator
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from functools import partial
from pathlib import Path
from zoneinfo import ZoneInfo

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.config.loader import load_config
from hawk.config.sections import DAYS, ConfigError, ScheduledSurvey
from hawk.daemon.lots.schedule import EARLY, LATE, Schedule, Timetable, is_flown, moment_due, moments_due
from hawk.lots import commands
from hawk.lots.documents.lot_document import LotDue
from hawk.lots.ingest import save
from hawk.lots.known_lot import newest_survey
from hawk.lots.store import LotStore
from hawk.lots.survey.source import PictureSource, SourceKind
from hawk.model.poses import GlobalPose
from tests.unit.lots import surveys
from tests.unit.lots.surveys import BEGAN, box, survey

ENDED = BEGAN + 900
"""End of the lot's only survey."""
NOW = datetime.fromtimestamp(ENDED, UTC)
AT = f"{NOW - timedelta(minutes=15):%H:%M}"


def entry(**values: object) -> ScheduledSurvey:
    return ScheduledSurvey.model_validate({"lot": "Lot 1", "at": AT, "time_zone": "UTC", **values})


class Page:
    """A schedule over a store with one survey, and what it said."""

    def __init__(self, store: LotStore, *entries: ScheduledSurvey) -> None:
        self.now = NOW
        self.is_armed = False
        self.said: list[tuple[str, str, str]] = []
        self.timetable = Timetable(entries)
        self.schedule = Schedule(
            store, self.timetable, lambda: self.now.timestamp(), lambda: self.is_armed,
            lambda level, text, details: self.said.append((level, text, details)),
        )  # fmt: skip

    async def at(self, moment: datetime) -> list[str]:
        self.now = moment
        await self.schedule.look()
        return [text for _, text, _ in self.said]


@pytest.fixture
async def store(tmp_path: Path) -> AsyncIterator[LotStore]:
    made = LotStore(tmp_path / "lots.db")
    await made.write(partial(save, survey=survey()))
    yield made
    await made.close()


async def test_a_survey_that_was_flown_is_not_due_and_the_next_day_s_is_once(store: LotStore) -> None:
    page = Page(store, entry())
    assert await page.at(NOW) == []
    tomorrow = NOW + timedelta(days=1)
    for later in (timedelta(0), timedelta(minutes=5), timedelta(hours=2)):
        said = await page.at(tomorrow + later)
    assert said == [f"A survey of Lot 1 is due since {AT}."]
    assert "nothing flies by itself" in page.said[0][2]


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("ended", "is_sure"), [(2_916_000_000.0, True), (2_916_000_000.0, False), (ENDED + 86_400, False)]
)
async def test_pictures_whose_time_is_not_sure_are_no_survey_that_was_due(
    store: LotStore, ended: float, *, is_sure: bool
) -> None:
    source = PictureSource(SourceKind.ORTHOPHOTO, "town.tif")
    wrong = replace(survey(), name="x", began=ended, ended=ended, time_is_sure=is_sure, pictures=source)
    await store.write(partial(save, survey=wrong))
    assert await Page(store, entry()).at(NOW + timedelta(days=1)) == [f"A survey of Lot 1 is due since {AT}."]


async def test_a_lot_that_is_not_known_is_named_with_the_remedy(store: LotStore) -> None:
    page = Page(store, entry(lot="Nowhere"), entry())
    for hours in (5, 9, 25):  # before it is due, too, and once
        said = await page.at(NOW - timedelta(hours=hours))
    assert said == ["The schedule names a lot that is not known: Nowhere."]
    assert page.said[0][2] == "schedule: no lot has the name or id Nowhere: write one of Lot 1."


async def test_a_name_that_is_gone_is_said_once_and_again_when_it_is_gone_again(store: LotStore) -> None:
    page = Page(store, entry())
    lot = (await store.read(lambda connection: newest_survey(connection, "Lot 1")) or ("",))[0]
    names = ("Lot 1", "Nord", "Lot 1", "Nord")
    counts = []
    for name in names:
        await store.write(partial(commands.rename, lot_id=lot, name=name, who="Ada", now=ENDED))
        counts += [len(await page.at(NOW)) for _ in range(2)]
    assert counts == [0, 0, 1, 1, 1, 1, 2, 2]
    assert page.said[0] == (
        "warning",
        "The schedule names a lot that is not known: Lot 1.",
        "schedule: no lot has the name or id Lot 1: write one of Nord.",
    )


async def test_a_name_that_two_lots_have_is_said_once_with_the_ids_to_write(store: LotStore) -> None:
    far = GlobalPose(52.05, 5.0, 0.0)
    ground = box(-20, -3, 40, 50, far)
    other = replace(surveys.later(survey(), 2), datum=far, outline=ground, seen_ground=ground)
    first = (await store.read(lambda connection: newest_survey(connection, "Lot 1")) or ("",))[0]
    second = (await store.write(partial(save, survey=other))).lot or ""
    page = Page(store, entry(), entry(lot=second))
    assert await page.at(NOW) == []
    await store.write(partial(commands.rename, lot_id=second, name="Lot 1", who="Ada", now=ENDED))
    for _ in range(2):
        assert await page.at(NOW) == ["The schedule names Lot 1, and more than one lot is called so."]
    ids = ", ".join(sorted((first, second)))
    assert page.said[0][2] == f"schedule: more than one lot is called Lot 1: write the id of one: {ids}."
    said = await Page(store, entry()).at(NOW + timedelta(days=1))
    assert said == ["The schedule names Lot 1, and more than one lot is called so."], "none of them is due"
    await store.write(partial(commands.rename, lot_id=second, name="Nord", who="Ada", now=ENDED))
    await store.write(partial(commands.rename, lot_id=first, name="Süd", who="Ada", now=ENDED))
    assert (await page.at(NOW))[1:] == ["The schedule names a lot that is not known: Lot 1."]


async def test_a_schedule_without_any_lot_says_that_the_first_one_is_surveyed_first(tmp_path: Path) -> None:
    store = LotStore(tmp_path / "none.db")
    page = Page(store, entry(lot="North"))
    await page.at(NOW)
    await store.close()
    assert page.said[0][2] == "schedule: no lot has the name or id North, and there is none: survey it first."


async def test_nothing_is_asked_while_the_motors_are_on_and_no_entry_needs_no_store(tmp_path: Path) -> None:
    store = LotStore(tmp_path / "none.db")
    flown = Page(store, entry())
    flown.is_armed = True
    for page in (flown, Page(store)):
        task = asyncio.create_task(page.schedule.run())
        await asyncio.sleep(0.05)
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)
        assert page.said == []
    assert not store.is_open
    await store.close()


@given(st.integers(1_767_000_000, 1_800_000_000), st.sampled_from(DAYS), st.integers(0, 23))
def test_a_moment_is_on_its_day_and_not_over(seconds: int, day: str, hour: int) -> None:
    now = datetime.fromtimestamp(seconds, ZoneInfo("Europe/Amsterdam"))
    found = moment_due(entry(days=[day], at=f"{hour:02d}:15"), now)
    if found is not None:
        assert DAYS[found.weekday()] == day
        assert (found.hour, found.minute) == (hour, 15)
        assert found <= now < found + LATE


def test_a_survey_of_late_evening_is_due_after_midnight() -> None:
    late = entry(days=["mon"], at="23:00")
    found = moment_due(late, datetime(2026, 5, 5, 2, 0, tzinfo=UTC))
    assert found == datetime(2026, 5, 4, 23, 0, tzinfo=UTC)
    assert moment_due(late, datetime(2026, 5, 5, 5, 1, tzinfo=UTC)) is None


def test_a_survey_a_little_before_its_time_counts() -> None:
    assert is_flown((NOW - EARLY).timestamp(), NOW)
    assert not is_flown((NOW - EARLY).timestamp() - 1, NOW)
    assert not is_flown(None, NOW)


def test_what_is_due_is_what_comes_and_what_has_come_and_is_not_flown() -> None:
    now = datetime(2026, 5, 4, 11, 0, tzinfo=UTC)
    entries = (entry(at="10:30"), entry(lot="ID", at="15:00", days=["mon", "wed"]), entry(lot="Other", at="12:00"))

    def due(last: datetime | None) -> list[str]:
        moments = moments_due(entries, "ID", "Lot 1", None if last is None else last.timestamp(), now.timestamp(), 2)
        return [f"{each:%d %H}" for each in moments]

    assert due(now - timedelta(days=1)) == ["04 10", "04 15", "05 10", "06 10"]
    assert due(now - timedelta(minutes=20)) == ["04 15", "05 10", "06 10"]
    assert due(None) == due(now - timedelta(days=1))
    assert moments_due(entries, "X", "Y", None, now.timestamp(), 2) == []


@pytest.mark.parametrize(("written", "is_due"), [(timedelta(minutes=-1), True), (timedelta(minutes=1), False)])
def test_what_came_before_the_newest_change_of_the_settings_was_not_due(
    tmp_path: Path, written: timedelta, *, is_due: bool
) -> None:
    path = tmp_path / "config.toml"
    path.write_text('[[schedule]]\nlot = "Lot 1"\nat = "10:30"\ntime_zone = "UTC"\n')
    moment = datetime(2026, 5, 4, 10, 30, tzinfo=UTC)
    os.utime(path, times=((moment + written).timestamp(),) * 2)
    entries = load_config(path, environment={}).schedule
    later = moment + timedelta(minutes=5)
    assert moment_due(entries[0], later) == (moment if is_due else None)
    found = moments_due(entries, "ID", "Lot 1", None, later.timestamp(), 1)
    assert found == [moment, moment + timedelta(days=1)][0 if is_due else 1 :]


GOOD = '[[schedule]]\nlot = "North"\nat = "10:30"\n\n[[schedule]]\nlot = "South"\nat = "18:00"\ndays = ["sat"]\n'


def test_the_settings_hold_a_block_for_each(tmp_path: Path) -> None:
    (tmp_path / "config.toml").write_text(GOOD)
    found = load_config(tmp_path / "config.toml", {}).schedule
    assert [(each.lot, each.at, each.days) for each in found] == [
        ("North", "10:30", DAYS),
        ("South", "18:00", ("sat",)),
    ]
    assert found[0].clock() is not None


@pytest.mark.parametrize(
    ("line", "wrong", "words"),
    [
        (7, 'at = "25:00"', "schedule.1.at: "), (8, 'days = ["monday"]', "schedule.1.days.0: "),
        (8, 'time_zone = "Mars"', "schedule.1.time_zone: must be a name of the time zone database"),
        (8, "hour = 5", "schedule.1.hour: is not a setting"),
    ],
)  # fmt: skip
def test_a_wrong_entry_is_named_with_its_line(tmp_path: Path, line: int, wrong: str, words: str) -> None:
    lines = GOOD.splitlines()
    lines[line - 1] = wrong
    (tmp_path / "config.toml").write_text("\n".join(lines))
    with pytest.raises(ConfigError) as caught:
        load_config(tmp_path / "config.toml", {})
    assert f"line {line}: {words}" in str(caught.value)


def at_desk(lot: str, *moments: datetime, last: datetime | None = None) -> LotDue:
    seconds = tuple(each.timestamp() for each in moments)
    return LotDue(lot=lot, last=None if last is None else last.timestamp(), moments=seconds)


LOT = "3f2504e0-4f89-41d3-9a0c-0305e82c3301"


def test_what_is_due_at_the_desk_is_due_here_until_it_is_flown_or_over() -> None:
    timetable, tomorrow = Timetable((), has_desk=True), NOW + timedelta(days=1)
    assert not timetable.is_empty
    assert not timetable.is_due(LOT, "North", None, NOW.timestamp())
    timetable.take([at_desk(LOT, NOW, tomorrow)])

    def due(after: timedelta, last: datetime | None = None) -> bool:
        return timetable.is_due(LOT, "North", None if last is None else last.timestamp(), (NOW + after).timestamp())

    assert [due(timedelta(seconds=second)) for second in (-1, 0)] == [False, True]
    assert [due(LATE - timedelta(seconds=1)), due(LATE)] == [True, False]
    assert not due(timedelta(hours=1), last=NOW - EARLY)
    assert not timetable.is_due("other", "North", None, NOW.timestamp())
    week = timetable.moments(LOT, "North", None, NOW.timestamp(), 7)
    assert [each.astimezone(UTC) for each in week] == [NOW, tomorrow]
    assert timetable.lots() == [LOT]
    timetable.take([])
    assert not due(timedelta(0))


def test_what_another_drone_has_flown_is_due_no_more_by_the_settings_of_this_one() -> None:
    timetable = Timetable([entry(at=f"{NOW:%H:%M}", lot="North")], has_desk=True)
    begun = NOW.replace(second=0, microsecond=0).timestamp()
    assert timetable.is_due(LOT, "North", None, begun)
    timetable.take([at_desk(LOT, last=NOW - timedelta(minutes=5))])
    assert not timetable.is_due(LOT, "North", None, begun)
    assert timetable.is_due(LOT, "North", begun - 86_400.0, begun + 86_400.0)


async def test_a_survey_that_is_due_at_the_desk_is_said_once(store: LotStore) -> None:
    lot = (await store.read(lambda connection: newest_survey(connection, "Lot 1")) or ("",))[0]
    page, tomorrow = Page(store), NOW + timedelta(days=1)
    await store.write(partial(commands.choose_time_zone, lot_id=lot, name="Asia/Tokyo", who="Ada", now=ENDED))
    page.timetable.take([at_desk(lot, NOW, tomorrow), at_desk(LOT, tomorrow)])
    assert await page.at(NOW) == []  # flown
    for later in (timedelta(0), timedelta(minutes=5)):
        said = await page.at(tomorrow + later)
    assert said == [f"A survey of Lot 1 is due since {tomorrow.astimezone(ZoneInfo('Asia/Tokyo')):%H:%M}."]
    page.timetable.take([at_desk(lot, tomorrow + timedelta(days=1), last=tomorrow + timedelta(days=1))])
    assert len(await page.at(tomorrow + timedelta(days=1))) == 1  # another drone has flown it


async def test_a_survey_that_is_due_by_settings_and_desk_at_one_moment_is_said_once(store: LotStore) -> None:
    lot = (await store.read(lambda connection: newest_survey(connection, "Lot 1")) or ("",))[0]
    tomorrow = NOW.replace(second=0, microsecond=0) + timedelta(days=1)
    clock = ZoneInfo("Europe/Amsterdam")
    at = f"{tomorrow.astimezone(clock):%H:%M}"
    page = Page(store, entry(at=at, time_zone=clock.key), entry(lot=lot, at=f"{tomorrow:%H:%M}"))
    page.timetable.take([at_desk(lot, tomorrow)])
    for later in (timedelta(0), timedelta(minutes=5)):
        said = await page.at(tomorrow + later)
    assert said == [f"A survey of Lot 1 is due since {at}."]

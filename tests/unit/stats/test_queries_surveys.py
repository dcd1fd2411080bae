from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from datetime import datetime, timedelta
from pathlib import Path

import pytest
from sqlalchemy import insert, select, update

from hawk.lots import commands
from hawk.lots.storage.database import Database
from hawk.lots.storage.schema import LAYOUT, STALL, SURVEY
from hawk.lots.survey.counts import COUNTS, counts_of
from hawk.lots.survey.source import PictureSource, SourceKind
from hawk.lots.values import FinishedSurvey, NotFoundError
from hawk.model.lot_map import StallState
from hawk.stats.answers import SurveysUse
from hawk.stats.period import period_of
from hawk.stats.queries import ask, surveys_use
from hawk.stats.use_query import Asked
from tests.unit.lots import surveys, whole
from tests.unit.stats.test_panel import EVER, later, lot_of, seen


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Database]:
    opened = Database(tmp_path / "lots.db")
    yield opened
    opened.close()


def test_surveys_are_listed_with_their_share_the_newest_first(store: Database) -> None:
    half = dict.fromkeys(range(1, 11), StallState.TAKEN)
    lot = lot_of(store, seen({}), later(seen(half), 1))
    with store.reading() as connection:
        found = surveys_use(connection, lot, EVER).model_dump(mode="json")
    newest, first = found["surveys"]
    assert (newest["free"], newest["taken"], newest["left_out"], newest["placed"]) == (10, 10, "", "registered")
    assert newest["occupancy"]["value"] == 0.5
    assert newest["occupancy"]["low"] < 0.5 < newest["occupancy"]["high"]
    assert first["occupancy"]["value"] == 0.0
    assert first["ended"] < newest["ended"]


def test_a_survey_is_shown_by_the_moment_of_its_looks_and_one_that_no_figure_uses_by_its_end(store: Database) -> None:
    lot = lot_of(store, flown_on(1), replace(flown_on(2), time_is_sure=False))
    with store.reading() as connection:
        unsure, sure = surveys_use(connection, lot, EVER).surveys
        asked = ask(connection, lot, EVER, Asked())
    assert unsure.at == unsure.ended
    assert sure.at == sure.ended - timedelta(seconds=60)
    assert [datetime.fromisoformat(each.at) for each in asked.surveys] == [sure.at]


def test_pictures_of_an_earlier_day_are_listed_at_their_date(store: Database) -> None:
    source = PictureSource(SourceKind.PHOTOGRAPHS, "flight", ())
    lot = lot_of(store, later(seen({}), 2), replace(seen({}), pictures=source))
    with store.reading() as connection:
        listed = surveys_use(connection, lot, EVER).model_dump(mode="json")["surveys"]
    assert [each["kind"] for each in listed] == ["flown", "picture"]
    assert listed[0]["ended"] > listed[1]["ended"]


@pytest.mark.slow
def test_a_survey_that_no_figure_uses_says_why_and_has_no_share(store: Database) -> None:
    lot = lot_of(store, seen({}), later(replace(seen({}), time_is_sure=False), 1))
    with store.writing() as connection:
        connection.execute(update(SURVEY).where(SURVEY.c.seq == 1).values(placed="unregistered"))
        newest, first = surveys_use(connection, lot, EVER).model_dump(mode="json")["surveys"]
    assert (newest["left_out_code"], first["left_out_code"]) == ("no_time", "unregistered")
    assert "neither GNSS nor a time server" in newest["left_out"]
    assert newest["occupancy"] == first["occupancy"] == {"value": None, "low": None, "high": None, "surveys": 0}


@pytest.mark.slow
def test_a_deleted_survey_is_in_no_list_and_comes_back_whole(store: Database) -> None:
    lot = lot_of(store, seen({}), later(seen({1: StallState.TAKEN}), 1))
    with store.writing() as connection:
        before = surveys_use(connection, lot, EVER).model_dump(mode="json")
        stalls = whole.stalls(connection, lot)
        done = commands.delete(connection, before["surveys"][0]["id"], "operator", 1.8e9)
        (left,) = surveys_use(connection, lot, EVER).model_dump(mode="json")["surveys"]
        assert left == before["surveys"][1]
        assert all(each["state"] == "free" for each in whole.stalls(connection, lot))
        assert commands.undo(connection, done.seq, 1.8e9 + 1) == "delete"
        assert surveys_use(connection, lot, EVER).model_dump(mode="json") == before
        assert whole.stalls(connection, lot) == stalls


@pytest.mark.slow
def test_counts_by_the_looks_of_a_panel_are_those_that_the_store_gives_of_each_survey(store: Database) -> None:
    taken, unknown = StallState.TAKEN, StallState.UNKNOWN
    states = ({1: taken}, {2: taken, 3: unknown}, {4: unknown}, {5: taken, 6: taken}, {7: unknown})
    some = [later(seen(each), number) for number, each in enumerate(states)]
    part = later(replace(seen({1: taken, 8: unknown}), stalls=seen({1: taken, 8: unknown}).stalls[:12]), 5)
    lot = lot_of(store, *some, part)
    with store.writing() as connection:
        row = {"lot": lot, "version": 2, "valid_from": 1.8e9, "why": "", "who": ""}
        connection.execute(insert(LAYOUT).values(**row))
        connection.execute(update(STALL).where(STALL.c.key == 2).values(ends=2))
        changed: tuple[dict[str, object], ...] = ({"placed": "unregistered"}, {"time_is_sure": False}, {"layout": None})
        for seq, values in enumerate(changed, 3):
            connection.execute(update(SURVEY).where(SURVEY.c.seq == seq).values(**values))
        connection.execute(update(SURVEY).where(SURVEY.c.seq == 6).values(layout=2))
        rows = [dict(row) for row in connection.execute(select(SURVEY)).mappings()]
        expected = {row["id"]: each for row, each in zip(rows, counts_of(connection, rows), strict=True)}
        found = surveys_use(connection, lot, EVER)
    assert {each.id: {name: getattr(each, name) for name in COUNTS} for each in found.surveys} == expected
    assert len({tuple(each.items()) for each in expected.values()}) > 3


def test_a_lot_that_is_not_there_is_named(store: Database) -> None:
    with store.reading() as connection, pytest.raises(NotFoundError, match="there is no lot with this id"):
        surveys_use(connection, "0" * 36, EVER).model_dump(mode="json")


@pytest.mark.slow
def test_one_survey_the_newest_and_those_of_a_period_say_which_lie_beside_them(store: Database) -> None:
    lot = lot_of(store, *(flown_on(day) for day in range(4)))
    with store.reading() as connection:
        ids = [each.id for each in surveys_use(connection, lot, EVER).surveys]
        one = surveys_use(connection, lot, EVER, survey=ids[1])
        newest = surveys_use(connection, lot, EVER, newest=2)
        day = period_of("2026-02-03", "2026-02-03", "UTC")
        some, none = (
            surveys_use(connection, lot, day),
            surveys_use(connection, lot, period_of("2026-02-09", None, "UTC")),
        )
    found = [([each.id for each in use.surveys], beside(use)) for use in (one, newest, some, none)]
    assert found == [
        ([ids[1]], (ids[2], ids[0])),
        (ids[:2], (ids[2], None)),
        ([ids[2]], (ids[3], ids[1])),
        ([], (ids[0], None)),
    ]


def flown_on(day: int) -> FinishedSurvey:
    """Return a survey of some day, its looks too."""
    one = surveys.later(seen({}), day, 24.0 * day)
    return replace(one, stalls=tuple(replace(stall, looked_at=one.ended - 60) for stall in one.stalls))


def beside(use: SurveysUse) -> tuple[str | None, str | None]:
    """Return the ids of the surveys beside those of an answer."""
    return (None if use.before is None else use.before.id), (None if use.after is None else use.after.id)

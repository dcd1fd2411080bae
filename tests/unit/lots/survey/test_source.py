from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import Connection, select

from hawk.exports.features import Choice, surveys
from hawk.exports.records import read_survey
from hawk.exports.text_files import about_survey
from hawk.lots.ingest import save
from hawk.lots.storage.backup import backup, restore
from hawk.lots.storage.database import Database
from hawk.lots.storage.schema import OUTBOX, SURVEY
from hawk.lots.survey.source import LIMIT_WORDS, Limit, PictureSource, SourceKind, SurveyKind
from hawk.lots.values import LONGEST_NAME, FinishedSurvey, fitting_name
from tests.unit.lots import whole
from tests.unit.lots.surveys import later, survey

ORTHOPHOTO = PictureSource(SourceKind.ORTHOPHOTO, "north.tif", (Limit.COARSE, Limit.PARTLY))
OF_VERSION_9 = """
INSERT INTO survey (id, origin, placed, candidates, began, ended, time_is_sure, latitude, longitude, outline, free,
  taken, unknown, stalls, program, simulated) VALUES ('a', 'b 1 2', 'nothing', '[]', 0, 1, 1, 52, 5, '{}', 0, 0, 0,
  x'00', '0.3.0', 0)
"""


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Database]:
    opened = Database(tmp_path / "lots.db")
    yield opened
    opened.close()


def of_pictures(number: int = 1, title: str = "", **more: Any) -> FinishedSurvey:
    return replace(later(survey(), number), pictures=ORTHOPHOTO, title=title, **more)


def sources(connection: Connection) -> list[PictureSource | None]:
    rows = connection.execute(select(SURVEY).order_by(SURVEY.c.seq)).mappings().all()
    return [PictureSource.read(row) for row in rows]


def test_the_source_is_stored_and_shown_wherever_a_survey_is(store: Database) -> None:
    with store.writing() as connection:
        saved = save(connection, of_pictures())
        assert sources(connection) == [ORTHOPHOTO]
        (feature,) = surveys(connection, Choice()).features
        shown = whole.surveys(connection, saved.lot)[0]
        about = about_survey(read_survey(connection, saved.survey))
        message = json.loads(connection.execute(select(OUTBOX.c.body).where(OUTBOX.c.kind == "survey")).scalar_one())
    wanted = {"kind": "picture", "source": "orthophoto", "source_name": "north.tif", "limits": ["coarse", "partly"]}
    for each in (feature.properties, shown):
        assert {name: each[name] for name in wanted} == wanted
    assert (about["survey_kind"], about["survey_source"]) == ("picture", "orthophoto north.tif")
    assert about["survey_limits"] == f"{LIMIT_WORDS[Limit.COARSE]} {LIMIT_WORDS[Limit.PARTLY]}"
    assert message["kind"] == "picture"


def test_a_flown_survey_has_no_source(store: Database) -> None:
    with store.writing() as connection:
        saved = save(connection, survey())
        about = about_survey(read_survey(connection, saved.survey))
        assert sources(connection) == [None]
    assert (survey().kind, about["survey_kind"]) == (SurveyKind.FLOWN, "flown")
    assert about["survey_source"] == about["survey_limits"] == ""


def test_a_backup_keeps_the_source(store: Database, tmp_path: Path) -> None:
    with store.writing() as connection:
        save(connection, of_pictures())
    backup(store.path, tmp_path / "kept.db")
    store.close()
    store.path.unlink()
    restore(store.path, tmp_path / "kept.db")
    opened = Database(store.path)
    with opened.reading() as connection:
        assert sources(connection) == [ORTHOPHOTO]
    opened.close()


def test_pictures_are_stored_in_any_order_and_no_landing_is_doubted_for_them(store: Database) -> None:
    with store.writing() as connection:
        save(connection, later(survey(), 1))
        before = of_pictures(2, began=1e9, ended=1e9 + 60)
        after = of_pictures(3, began=1.79e9, ended=1.79e9 + 60)
        for each in (
            before,
            replace(after, time_is_sure=False),
            replace(after, name="x"),
            later(survey(), 4, hours=48),
        ):
            save(connection, each)
        found = connection.execute(select(SURVEY.c.time_is_sure).order_by(SURVEY.c.seq)).scalars().all()
    assert found == [True, True, False, True, True]


def test_pictures_that_are_mapped_again_have_the_time_of_the_last_run(store: Database) -> None:
    first = of_pictures()
    again = replace(first, began=first.began + 18_000.0, ended=first.ended + 18_000.0)
    with store.writing() as connection:
        save(connection, first)
        save(connection, again)
        row = connection.execute(select(SURVEY)).mappings().one()
    assert (row["began"], row["ended"]) == (again.began, again.ended)


@pytest.mark.slow
def test_a_new_lot_has_the_title_of_its_pictures_once(store: Database) -> None:
    far = [
        replace(of_pictures(k, title="North  Street\n"), datum=replace(survey().datum, latitude=53.0 + k))
        for k in range(3)
    ]
    with store.writing() as connection:
        names = [save(connection, _there(each)).lot_name for each in far]
        unnamed = _there(replace(far[0], name="y", title="\ud800", datum=replace(far[0].datum, latitude=10.0)))
        last = save(connection, unnamed)
    assert names == ["North Street", "North Street 2", "North Street 3"]
    assert last.lot_name == "Lot 4"


def _there(given: FinishedSurvey) -> FinishedSurvey:
    """Return a survey with its ground at its datum."""
    off = given.datum.latitude - survey().datum.latitude
    rings = tuple(tuple((a + off, b) for a, b in ring) for ring in given.outline.polygons)
    return replace(given, outline=replace(given.outline, polygons=rings))


def test_a_title_is_cut_to_what_a_lot_may_be_called(store: Database) -> None:
    assert fitting_name(" a\tb ") == "a b"
    assert len(fitting_name("é" * 200)) == LONGEST_NAME
    with store.writing() as connection:
        long = _there(replace(of_pictures(1, title="n" * 200), datum=replace(survey().datum, latitude=40.0)))
        other = _there(replace(of_pictures(2, title="n" * 200), datum=replace(survey().datum, latitude=41.0)))
        names = [save(connection, each).lot_name for each in (long, other)]
    assert names == ["n" * LONGEST_NAME, "n" * (LONGEST_NAME - 2) + " 2"]

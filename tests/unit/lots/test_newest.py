from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from sqlalchemy import select

from hawk.daemon.lot_keeper import find_stalls
from hawk.exports.features import Choice, lots, stalls
from hawk.exports.reading import survey_of, surveys_of
from hawk.lots import reading
from hawk.lots.database import Database
from hawk.lots.newest import newest_first, newest_look
from hawk.lots.saving import save
from hawk.lots.source import PictureSource, SourceKind
from hawk.lots.tables import OBSERVATION, STALL, SURVEY
from hawk.lots.values import FinishedSurvey, Placed, Saved, utc
from tests.unit.lots.surveys import later, survey


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Database]:
    opened = Database(tmp_path / "lots.db")
    yield opened
    opened.close()


def saved(store: Database, given: FinishedSurvey) -> Saved:
    with store.writing() as connection:
        return save(connection, given, find_stalls)


def pictures(number: int, hours: float) -> FinishedSurvey:
    """Return a survey by photographs of the same lot, some hours after the first landing."""
    source = PictureSource(SourceKind.PHOTOGRAPHS, "flight", ())
    found = later(survey(seed=2), number, hours)
    return replace(found, pictures=source, stalls=tuple(replace(each, looked=found.ended) for each in found.stalls))


def test_pictures_of_an_earlier_day_that_are_stored_later_are_not_the_last_survey(store: Database) -> None:
    saved(store, survey())
    last = saved(store, later(survey(seed=2), 2, 48.0))
    earlier = saved(store, pictures(3, 24.0))
    assert last.placed == earlier.placed == Placed.REGISTERED
    assert last.lot is not None
    ended = utc(later(survey(), 2, 48.0).ended)
    with store.reading() as connection:
        lot = reading.lot(connection, last.lot)
        assert lot["last_survey"]["id"] == last.survey
        assert lot["newest_registered"]["survey"] == last.survey
        assert survey_of(connection, last.lot) == last.survey
        assert surveys_of(connection, last.lot)[1] == earlier.survey
        assert [each["properties"]["surveyed"] for each in lots(connection, Choice()).features] == [ended]
        shown = {stall["id"]: stall["looked"] for stall in lot["stalls"]}
        of_last = OBSERVATION.c.survey.in_(select(SURVEY.c.seq).where(SURVEY.c.id == last.survey))
        looks = STALL.join(OBSERVATION, OBSERVATION.c.stall == STALL.c.key)
        seen = connection.execute(select(STALL.c.id, OBSERVATION.c.looked).select_from(looks).where(of_last)).all()
        assert len(seen) > 30
        assert all(shown[stall] == utc(looked) for stall, looked in seen)
        exported = {each["id"]: each["properties"]["looked"] for each in stalls(connection, Choice()).features}
        assert all(exported[stall] == utc(looked) for stall, looked in seen)


def test_pictures_of_a_later_day_are_the_last_survey(store: Database) -> None:
    saved(store, survey())
    last = saved(store, pictures(2, 24.0))
    assert last.lot is not None
    with store.reading() as connection:
        assert reading.lot(connection, last.lot)["last_survey"]["id"] == last.survey


def test_a_landing_follows_those_before_it_whatever_its_clock_says(store: Database) -> None:
    saved(store, survey())
    stepped = saved(store, later(survey(seed=2), 2, -1000.0))
    with store.reading() as connection:
        assert stepped.lot is not None
        assert reading.lot(connection, stepped.lot)["last_survey"]["id"] == stepped.survey
    earlier = saved(store, pictures(3, -10.0))
    with store.reading() as connection:
        order = connection.execute(select(SURVEY.c.id).order_by(*newest_first())).scalars().all()
    assert order.index(stepped.survey) == 0
    assert order.index(earlier.survey) == 2


def test_without_pictures_a_look_is_found_by_the_index(store: Database) -> None:
    with store.reading() as connection:
        fast = str(newest_look(connection, STALL.c.key))
    saved(store, pictures(1, 0.0))
    with store.reading() as connection:
        exact = str(newest_look(connection, STALL.c.key))
    assert "max(" in fast
    assert "ORDER BY" in exact

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest
from sqlalchemy import select

from hawk.lots.storage.database import Database
from hawk.lots.storage.schema import STALL, SURVEY
from hawk.lots.store import lots_file
from hawk.lots.survey.landing import finished, seen_ground
from hawk.lots.survey.pictures import pictures_of
from hawk.picture.ingest import store_survey
from hawk.picture.values import PictureError
from hawk.results.survey_map import SurveyMap
from tests.unit.picture.surveys import ORIGIN, mapped


def test_a_survey_is_stored_with_its_stalls_and_its_picture(tmp_path: Path) -> None:
    stored = store_survey(mapped().landed, tmp_path)
    assert "as the first survey of" in stored.words
    store = lots_file(tmp_path)
    database = Database(store)
    with database.reading() as connection:
        surveys = connection.execute(select(SURVEY)).mappings().all()
        stalls = connection.execute(select(STALL)).mappings().all()
    database.close()
    assert [(row["stalls"] is not None, round(row["latitude"], 6)) for row in surveys] == [(True, ORIGIN[0])]
    assert len(stalls) == 8
    assert stored.lot == surveys[0]["lot"]
    assert pictures_of(store).surveys() == {surveys[0]["id"]}


@pytest.mark.slow
def test_a_later_survey_joins_the_lot(tmp_path: Path) -> None:
    store_survey(mapped().landed, tmp_path)
    later = dataclasses.replace(mapped().landed, name="later")
    assert "as a survey of yard" in store_survey(later, tmp_path).words  # one row alone fits itself at every pitch


@pytest.mark.nightly
def test_a_survey_whose_place_the_store_doubts_says_so_in_its_files(tmp_path: Path) -> None:
    assert store_survey(mapped().landed, tmp_path).said_of(mapped()).survey.doubt == ""
    stored = store_survey(dataclasses.replace(mapped().landed, name="later"), tmp_path)
    assert "whose place is not certain" in stored.words
    assert stored.said_of(mapped()).survey.doubt == ("unregistered: its place among the lot's stalls is not certain")


def test_the_ground_that_was_seen_is_the_pictures(tmp_path: Path) -> None:
    landed = mapped().landed
    survey = SurveyMap.of(landed.datum, landed.current)
    assert (survey.cells().values != 0).sum() * 0.01 == pytest.approx(1600.0, rel=0.01)
    assert seen_ground(survey).polygons
    assert len(finished(landed).stalls) == 8


def test_a_store_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(PictureError, match="--store"):
        store_survey(mapped().landed, tmp_path / "file")


@pytest.mark.slow
def test_a_known_lot_keeps_its_name_and_it_is_said(tmp_path: Path) -> None:
    assert "keeps its name" not in store_survey(mapped().landed, tmp_path, "yard").words
    later = dataclasses.replace(mapped().landed, name="later", title="North")
    words = store_survey(later, tmp_path, "North").words
    assert "The lot keeps its name yard, --name North is not used" in words
    assert "keeps its name" not in store_survey(later, tmp_path, "yard").words

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from sqlalchemy import Connection, select, update

from hawk.daemon.lots.keeper import find_stalls
from hawk.exports.features import Choice, lots, surveys
from hawk.exports.records import read_survey
from hawk.lots import lists
from hawk.lots.ingest import save
from hawk.lots.schema import SURVEY
from hawk.lots.storage.database import Database
from hawk.lots.survey.counts import counts_of
from hawk.lots.values import FinishedSurvey, Placed
from hawk.model.lot_map import StallState
from hawk.stats.queries import surveys_use
from tests.unit.lots import whole
from tests.unit.lots.surveys import later, survey
from tests.unit.stats.test_panel import EVER


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Database]:
    opened = Database(tmp_path / "lots.db")
    yield opened
    opened.close()


def beside(found: FinishedSurvey) -> FinishedSurvey:
    """Return a survey that missed a stall, and found a car twenty metres beside the lot."""
    last = found.stalls[-1]
    car = replace(last, id=9999, north=last.north + 20.0, state=StallState.TAKEN, taken_probability=0.99, known="")
    return replace(found, stalls=(*found.stalls[:12], *found.stalls[13:], car))


def counted(connection: Connection, seq: int) -> dict[str, int]:
    rows = connection.execute(select(SURVEY).where(SURVEY.c.seq == seq)).mappings().all()
    return counts_of(connection, rows)[0]


@pytest.mark.slow
def test_a_survey_on_the_layout_counts_the_stalls_of_the_lot_everywhere_as_in_its_files(store: Database) -> None:
    with store.writing() as connection:
        first = save(connection, survey(), find_stalls)
        last = save(connection, beside(later(survey(seed=2), 2, 48.0)), find_stalls)
    assert first.lot is not None
    assert last.placed is Placed.REGISTERED
    with store.reading() as connection:
        exported = read_survey(connection, last.survey)
        wanted = {name: exported.count(name) for name in ("free", "taken", "unknown")}
        own = connection.execute(select(SURVEY.c.free, SURVEY.c.taken, SURVEY.c.unknown).where(SURVEY.c.seq == 2)).one()
        assert sum(wanted.values()) == len(survey().stalls)
        assert wanted["unknown"] >= 1
        assert wanted != own._asdict()
        assert counted(connection, 2) == wanted
        shown = (
            whole.lot(connection, first.lot)["last_survey"],
            lists.surveys(connection, lists.Asked()).items[1].model_dump(),
            lists.survey(connection, last.survey).model_dump(),
            surveys_use(connection, first.lot, EVER).model_dump(mode="json")["surveys"][0],
            lots(connection, Choice()).features[0].properties,
            surveys(connection, Choice()).features[1].properties,
        )
        assert [{name: each[name] for name in wanted} for each in shown] == [wanted] * len(shown)


def test_a_survey_whose_place_is_not_certain_has_the_counts_of_its_own_map(store: Database) -> None:
    with store.writing() as connection:
        save(connection, survey(), find_stalls)
        connection.execute(update(SURVEY).values(placed=Placed.UNREGISTERED.value, free=3, taken=2, unknown=1))
        assert counted(connection, 1) == {"free": 3, "taken": 2, "unknown": 1}

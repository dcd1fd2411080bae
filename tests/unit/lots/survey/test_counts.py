from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sqlalchemy import Connection, create_engine, insert, select, update

from hawk.daemon.lots.keeper import find_stalls
from hawk.exports.features import Choice, lots, surveys
from hawk.exports.records import read_survey
from hawk.lots import lists
from hawk.lots.ingest import save
from hawk.lots.storage.database import Database
from hawk.lots.storage.schema import LAYOUT, METADATA, OBSERVATION, STALL, SURVEY
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


@pytest.mark.nightly
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


_VERSIONS = st.integers(1, 4)
_STALLS = st.lists(
    st.tuples(st.integers(0, 2), _VERSIONS, st.none() | st.integers(1, 5), st.sampled_from(["", "free", "taken"])),
    max_size=12,
)


@given(stalls=_STALLS, layouts=st.lists(st.tuples(st.integers(0, 2), _VERSIONS), min_size=1, max_size=8))
@settings(max_examples=60, deadline=None)
def test_stalls_of_the_layout_of_each_survey_are_counted_and_no_others(
    stalls: list[tuple[int, int, int | None, str]], layouts: list[tuple[int, int]]
) -> None:
    """A stall has a lot, a first version, the one that ends it, and a state, "" for one that no survey looked at."""
    engine = create_engine("sqlite://")
    with engine.begin() as connection:
        METADATA.create_all(connection)
        numbers = [*layouts, *((lot, max(begins, ends or 1)) for lot, begins, ends, _ in stalls)]
        newest = {lot: max(number for of, number in numbers if of == lot) for lot, _ in numbers}
        for lot, last in newest.items():
            shown = {"valid_from": 0.0, "why": "", "who": ""}
            for version in range(1, last + 1):
                connection.execute(insert(LAYOUT).values(lot=str(lot), version=version, **shown))
        for key, (lot, begins, ends, _) in enumerate(stalls, 1):
            shape = dict.fromkeys(("north", "east", "angle", "width", "length"), 1.0)
            row = {"key": key, "id": str(key), "lot": str(lot), "label": "", "kind": "", "is_confirmed": False}
            connection.execute(insert(STALL).values(**row, **shape, begins=begins, ends=ends))
        rows = []
        for seq, (lot, version) in enumerate(layouts, 1):
            rows.append({"seq": seq, "lot": str(lot), "layout": version, "placed": Placed.REGISTERED.value})
            for key, (_, _, _, state) in enumerate(stalls, 1):
                look = {"looked_at": 0.0, "taken_probability": 0.5, "picture_count": 1, "state": state}
                if state:
                    connection.execute(insert(OBSERVATION).values(survey=seq, stall=key, **look))
        there = [
            [state for of, begins, ends, state in stalls if of == lot and begins <= version < (ends or 9)]
            for lot, version in layouts
        ]
        wanted = [{"free": s.count("free"), "taken": s.count("taken"), "unknown": s.count("")} for s in there]
        assert counts_of(connection, rows) == wanted
    engine.dispose()

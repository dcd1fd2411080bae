from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from sqlalchemy import delete, select, text, update

from hawk.lots.ingest import save
from hawk.lots.storage.database import Database
from hawk.lots.storage.schema import LOOKS, OBSERVATION, STALL
from hawk.lots.survey.observations import keep_looks, looks_of, missing_looks, pack_looks, unpack_looks
from hawk.lots.values import LotStoreError
from tests.unit.lots.surveys import later, survey


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Database]:
    opened = Database(tmp_path / "lots.db")
    yield opened
    opened.close()


def test_a_saved_survey_keeps_its_looks_in_one_piece_which_says_what_the_observations_say(store: Database) -> None:
    with store.writing() as connection:
        saved = save(connection, survey(stalls=40))
    with store.reading() as connection:
        assert missing_looks(connection, saved.lot or "") == []
        found = looks_of(connection, [saved.seq])
        rows = connection.execute(select(OBSERVATION).order_by(OBSERVATION.c.stall)).all()
    assert found.stall.tolist() == [row.stall for row in rows]
    assert found.taken_probability.tolist() == pytest.approx([row.taken_probability for row in rows], abs=6e-5)
    assert found.state.tolist() == [{"free": 0, "taken": 1, "unknown": 2}[row.state] for row in rows]
    assert found.at.tolist() == pytest.approx([sum(row.looked_at for row in rows) / len(rows)])


@pytest.mark.parametrize("does", ["insert", "update", "delete"])
def test_a_piece_goes_when_an_observation_changes_and_is_made_again(store: Database, does: str) -> None:
    with store.writing() as connection:
        saved = save(connection, survey(stalls=40))
        lot = saved.lot or ""
        first = connection.execute(select(STALL.c.key).order_by(STALL.c.key)).scalars().first()
        is_it = (OBSERVATION.c.stall == first) & (OBSERVATION.c.survey == saved.seq)
        row = dict(connection.execute(select(OBSERVATION).where(is_it)).mappings().one())
        if does == "update":
            connection.execute(update(OBSERVATION).where(is_it).values(taken_probability=0.25, state="unknown"))
        else:
            connection.execute(delete(OBSERVATION).where(is_it))
        if does == "insert":
            keep_looks(connection, [saved.seq])
            connection.execute(OBSERVATION.insert().values({**row, "taken_probability": 0.25, "state": "unknown"}))
        assert missing_looks(connection, lot) == [saved.seq]
        made = looks_of(connection, [saved.seq])
        keep_looks(connection, [saved.seq])
        assert missing_looks(connection, lot) == []
        kept = looks_of(connection, [saved.seq])
    assert made.taken_probability.tolist() == kept.taken_probability.tolist()
    assert len(kept.stall) == (39 if does == "delete" else 40)
    if does != "delete":
        assert (kept.taken_probability[0], kept.state[0]) == (0.25, 2)


def test_looks_come_in_the_order_that_is_asked_for_without_surveys_that_have_none(store: Database) -> None:
    with store.writing() as connection:
        first = save(connection, survey(stalls=20))
        lone = save(connection, later(survey(stalls=20), 2))  # not registered: it looked at no stall of the lot
        found = looks_of(connection, [lone.seq, first.seq])
    assert found.surveys == (first.seq,)
    assert len(found.line) == 20


def test_a_survey_that_is_saved_again_has_the_looks_of_its_newest_save(store: Database) -> None:
    whole = survey(stalls=20)
    with store.writing() as connection:
        save(connection, whole)
        free = tuple(replace(stall, taken_probability=0.0) for stall in whole.stalls)
        saved = save(connection, replace(whole, stalls=free))
        assert looks_of(connection, [saved.seq]).taken_probability.tolist() == [0.0] * 20


def test_a_damaged_piece_is_refused_with_a_remedy() -> None:
    whole = pack_looks([(7, 0.25, "free"), (9, 0.75, "taken")])
    for broken in (whole[:-1], whole[:-1] + b"\xff"):
        with pytest.raises(LotStoreError, match=r"looks of surveys cannot be read: .* Restore a backup"):
            unpack_looks([(1, 0.0, broken)])


def test_a_store_of_an_earlier_version_has_no_pieces_and_reads_the_same(tmp_path: Path) -> None:
    path = tmp_path / "lots.db"
    opened = Database(path)
    with opened.writing() as connection:
        saved = save(connection, survey(stalls=20))
        before = looks_of(connection, [saved.seq])
        connection.execute(delete(LOOKS))
        after = looks_of(connection, [saved.seq])
    opened.close()
    assert before.taken_probability.tolist() == after.taken_probability.tolist()


def _table(*looks: tuple[int, int, int]) -> bytes:
    return np.array(list(looks), [("stall", "<u4"), ("taken_probability", "<u2"), ("state", "u1")]).tobytes()


@pytest.mark.parametrize(
    "changes",
    [
        {"stalls": _table((1, 5000, 1))[:-1]},
        {"stalls": "text"},
        {"stalls": _table((1, 5000, 9))},
        {"stalls": _table((1, 10_001, 1))},
        {"stalls": _table((0xFFFF_FFFF, 5000, 1))},
        {"at": "text"},
        {"at": math.inf},
    ],
)
def test_a_damaged_piece_is_made_from_the_observations(store: Database, changes: dict[str, object]) -> None:
    with store.writing() as connection:
        first = save(connection, survey(stalls=40)).seq
        whole = looks_of(connection, [first])
        ((name, value),) = changes.items()
        connection.execute(text(f"UPDATE looks SET {name} = :value"), {"value": value})  # noqa: S608 - our own words
        found = looks_of(connection, [first])
    assert found.surveys == whole.surveys == (first,)
    for name in ("at", "line", "stall", "taken_probability", "state"):
        assert getattr(found, name).tolist() == getattr(whole, name).tolist(), name

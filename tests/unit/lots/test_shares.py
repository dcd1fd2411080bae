from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from sqlalchemy import select

from hawk.lots import commands
from hawk.lots.ingest import save
from hawk.lots.shares import DAY_S, LARGEST, LONGEST_DAYS, lot_of, share, shares, take_back
from hawk.lots.storage.database import Database
from hawk.lots.storage.schema import SHARE
from hawk.lots.values import LotInputError, LotStoreError, NotFoundError, moment
from hawk.model.poses import GlobalPose
from tests.unit.lots.survey.test_last_surveys import digests_and_states, make_version_8
from tests.unit.lots.surveys import box, later, survey

NOW = 1.8e9
FAR = GlobalPose(52.05, 5.0, 0.0)


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Database]:
    opened = Database(tmp_path / "lots.db")
    yield opened
    opened.close()


@pytest.fixture
def lot(store: Database) -> str:
    with store.writing() as connection:
        saved = save(connection, survey())
    assert saved.lot is not None
    return saved.lot


def test_a_link_opens_its_lot_until_it_ends(store: Database, lot: str) -> None:
    with store.writing() as connection:
        made = share(connection, lot, {"days": 2}, NOW)
    with store.reading() as connection:
        assert lot_of(connection, made.token, NOW + 2 * DAY_S - 1) == lot
        assert lot_of(connection, made.token, NOW + 2 * DAY_S) is None
        assert lot_of(connection, made.token + "x", NOW) is None


def test_a_link_that_was_taken_back_opens_nothing_and_stays_so(store: Database, lot: str) -> None:
    with store.writing() as connection:
        made = share(connection, lot, {"days": 2}, NOW)
        take_back(connection, made.id, NOW + 1)
        take_back(connection, made.id, NOW + 5)
        assert lot_of(connection, made.token, NOW + 2) is None
        (shown,) = shares(connection, lot, NOW + 2).shares
    assert (shown.open, shown.taken_back) == (False, moment(NOW + 1))


def test_the_store_does_not_hold_the_token(store: Database, lot: str, tmp_path: Path) -> None:
    with store.writing() as connection:
        made = share(connection, lot, {"days": 2}, NOW)
        row = connection.execute(select(SHARE)).mappings().one()
        assert made.token not in str(dict(row))
    store.close()
    assert made.token.encode() not in b"".join(path.read_bytes() for path in tmp_path.iterdir())


@given(st.one_of(st.none(), st.text(), st.booleans(), st.floats(max_value=0), st.floats(min_value=LONGEST_DAYS + 0.1)))
def test_days_that_are_none_are_refused_by_name(days: object) -> None:
    with pytest.raises(LotInputError, match=f"days: must be a number of days above 0 and at most {LONGEST_DAYS}"):
        share(None, "", {"days": days}, NOW)  # type: ignore[arg-type]


@pytest.mark.slow
def test_a_lot_has_a_limited_number_of_open_links(store: Database, lot: str) -> None:
    with store.writing() as connection:
        made = [share(connection, lot, {"days": 1}, NOW) for _ in range(LARGEST)]
        with pytest.raises(LotStoreError, match="take one back first"):
            share(connection, lot, {"days": 1}, NOW)
        take_back(connection, made[0].id, NOW)
        share(connection, lot, {"days": 1}, NOW)


def test_lots_and_links_that_are_not_there_are_named(store: Database) -> None:
    with store.writing() as connection:
        with pytest.raises(NotFoundError, match="lot: there is no lot with this id"):
            share(connection, "0" * 36, {"days": 1}, NOW)
        with pytest.raises(NotFoundError, match="lot: there is no lot with this id"):
            shares(connection, "0" * 36, NOW)
        with pytest.raises(NotFoundError, match="share: there is no link with this id"):
            take_back(connection, "0" * 36, NOW)


@pytest.mark.slow
def test_the_link_of_a_lot_that_was_merged_away_opens_nothing(store: Database, lot: str) -> None:
    with store.writing() as connection:
        made = share(connection, lot, {"days": 2}, NOW)
        far = replace(survey(), datum=FAR, outline=box(-20, -3, 40, 50, FAR), seen_ground=box(-20, -3, 40, 50, FAR))
        other = save(connection, later(far, 1))
        assert other.lot is not None
        commands.merge(connection, other.lot, lot, "operator", NOW)
        assert lot_of(connection, made.token, NOW) is None


@pytest.mark.fault(
    "a person with a role for some lots made a link, and has no token any more, or one for other lots",
    "the link opens nothing, and is listed as shut with the person's name; that of a role for all lots opens",
)
def test_the_link_of_a_person_opens_as_long_as_the_role_is_for_its_lot(store: Database, lot: str) -> None:
    people = {"Ada": [lot], "Ben": ["o" * 36]}
    with store.writing() as connection:
        made = {who: share(connection, lot, {"days": 2}, NOW, who, people.__getitem__) for who in ("", "Ada")}
    for reached, is_open in (([lot], True), (["o" * 36], False), ([], False)):
        people["Ada"] = reached
        with store.reading() as connection:
            found = [lot_of(connection, made[who].token, NOW, people.__getitem__) for who in ("", "Ada")]
            listed = shares(connection, lot, NOW, people.__getitem__).shares
            assert lot_of(connection, made["Ada"].token, NOW) is None, "who does not say who may read opens nothing"
        assert found == [lot, lot if is_open else None]
        assert {each.who: each.open for each in listed} == {None: True, "Ada": is_open}


@pytest.mark.fault(
    "a store of version 8 with links is upgraded, one of its lots is damaged on the disk",
    "the other lot is whole, without a new state; the damaged one stays so",
)
@pytest.mark.parametrize("is_damaged", [False, True])
def test_a_lot_with_links_is_whole_after_an_upgrade(store: Database, lot: str, is_damaged: bool) -> None:
    with store.writing() as connection:
        made = share(connection, lot, {"days": 2}, NOW)
    store.close()
    states = digests_and_states(store.path)
    make_version_8(store.path)
    if is_damaged:
        with closing(sqlite3.connect(store.path)) as opened, opened:
            (trigger,) = opened.execute("SELECT sql FROM sqlite_master WHERE name = 'digest_share_update'").fetchone()
            opened.execute("DROP TRIGGER digest_share_update")
            opened.execute("UPDATE share SET ends = ends + 1e9")
            opened.execute(trigger)
    with closing(Database(store.path)) as upgraded:
        assert bool(upgraded.damage) == is_damaged
        with upgraded.reading() as connection:
            assert lot_of(connection, made.token, NOW) == (None if is_damaged else lot)
    assert is_damaged or digests_and_states(store.path) == states

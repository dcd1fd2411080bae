from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest
from sqlalchemy import select

from hawk.lots import commands, outbox
from hawk.lots.ingest import save
from hawk.lots.outbox import DAY_S, KEPT_S, TRIED_S, WAITS_S
from hawk.lots.storage.database import Database
from hawk.lots.storage.schema import DELIVERY, OUTBOX
from hawk.lots.storage.states import KINDS
from tests.unit.lots import whole
from tests.unit.lots.surveys import BEGAN, box, later, survey

NOW = BEGAN + 1000
ONE, OTHER = "1" * 16, "2" * 16
IS_REPORT = OUTBOX.c.kind.not_in(KINDS)


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Database]:
    opened = Database(tmp_path / "lots.db")
    with opened.writing() as connection:
        save(connection, survey())
    yield opened
    opened.close()


def test_a_survey_and_a_layout_are_messages_of_their_own_transaction(store: Database) -> None:
    with store.writing() as connection:
        save(connection, later(survey(), 1))
        rows = connection.execute(select(OUTBOX.c.kind, OUTBOX.c.body).where(IS_REPORT).order_by(OUTBOX.c.seq)).all()
    assert [row.kind for row in rows] == ["layout", "survey", "survey"]
    assert json.loads(rows[0].body)["version"] == 1
    assert json.loads(rows[1].body)["placed"] == "first"


def test_a_change_of_the_layout_is_a_message(store: Database) -> None:
    with store.writing() as connection:
        lot = whole.lots(connection)[0]["id"]
        part = [list(corner) for corner in box(-10, -4, 15, 10).polygons[0]]
        commands.split(connection, lot, {"name": "South", "outline": part}, "operator", NOW)
        bodies = [json.loads(row) for row in connection.execute(select(OUTBOX.c.body).where(IS_REPORT)).scalars()]
    assert {each["version"] for each in bodies if each.get("lot") == lot and "version" in each} == {1, 2}


def test_each_receiver_gets_every_message_in_its_order(store: Database) -> None:
    with store.writing() as connection:
        seen = []
        while message := outbox.due(connection, ONE, NOW):
            seen.append(message.kind)
            outbox.note_sent(connection, message, ONE, NOW)
        assert seen == ["layout", "survey"]
        assert outbox.due(connection, ONE, NOW + TRIED_S * 2) is None
        other = outbox.due(connection, OTHER, NOW)
    assert other is not None
    assert other.kind == "layout"


def test_a_failed_message_waits_and_the_next_one_goes_before_it(store: Database) -> None:
    with store.writing() as connection:
        first = outbox.due(connection, ONE, NOW)
        assert first is not None
        assert not outbox.note_failed(connection, first, ONE, NOW)
        second = outbox.due(connection, ONE, NOW + WAITS_S[0] - 1)
        assert second is not None
        assert second.seq > first.seq
        again = outbox.due(connection, ONE, NOW + WAITS_S[0])
    assert again is not None
    assert (again.seq, again.tries) == (first.seq, 1)


@pytest.mark.nightly
def test_waits_grow_to_an_hour_and_trying_ends_after_seven_days(store: Database) -> None:
    now, tries, waits = NOW, 0, []
    with store.writing() as connection:
        while message := outbox.due(connection, ONE, now):
            if message.kind == "survey":
                outbox.note_sent(connection, message, ONE, now)
                continue
            tries += 1
            is_over = outbox.note_failed(connection, message, ONE, now)
            again = connection.execute(select(DELIVERY.c.next).where(DELIVERY.c.message == message.seq)).scalar_one()
            waits.append(again - now)
            now = again
            assert is_over == (now - WAITS_S[-1] - NOW >= TRIED_S)
        is_open = DELIVERY.c.sent.is_(None) & DELIVERY.c.given_up.is_(None)
        assert connection.execute(select(DELIVERY).where(is_open)).all() == []
        assert outbox.due(connection, ONE, now + 365 * DAY_S) is None
    assert waits[: len(WAITS_S)] == pytest.approx(WAITS_S)
    assert waits[-1] == pytest.approx(3600)
    assert tries > 7 * 24


@pytest.mark.slow
def test_a_clock_that_jumps_gives_nothing_up_at_once(store: Database) -> None:
    with store.writing() as connection:
        first = outbox.due(connection, ONE, NOW)
        assert first is not None
        outbox.note_failed(connection, first, ONE, NOW)
        second = outbox.due(connection, ONE, NOW + 50 * DAY_S)
        assert second is not None
        assert second.tries == 1
        assert not outbox.note_failed(connection, second, ONE, NOW + 50 * DAY_S)


@pytest.mark.slow
def test_a_new_receiver_gets_the_messages_of_seven_days_and_old_ones_are_removed(store: Database) -> None:
    with store.writing() as connection:
        assert outbox.due(connection, ONE, NOW + TRIED_S + 1000) is None
        save(connection, later(survey(), 1, hours=24 * 40))
        now = NOW + 40 * DAY_S
        message = outbox.due(connection, ONE, now)
        assert message is not None
        assert now - message.made < KEPT_S
        outbox.note_sent(connection, message, ONE, now)
        assert connection.execute(select(OUTBOX.c.seq).where(IS_REPORT)).scalars().all() == [message.seq]


@pytest.mark.slow
def test_what_came_after_the_last_sent_message_is_due_at_any_age(store: Database) -> None:
    with store.writing() as connection:
        while message := outbox.due(connection, ONE, NOW):
            outbox.note_sent(connection, message, ONE, NOW)
        save(connection, later(survey(), 1))
        after_a_jump = NOW + 400 * DAY_S
        message = outbox.due(connection, ONE, after_a_jump)
        assert message is not None
        assert outbox.due(connection, OTHER, after_a_jump) is None
        outbox.note_sent(connection, message, ONE, after_a_jump)
        assert outbox.due(connection, ONE, after_a_jump) is None


@pytest.mark.slow
def test_messages_age_from_when_they_were_stored(store: Database) -> None:
    with store.writing() as connection:
        first = outbox.last(connection)
        before = connection.execute(select(OUTBOX.c.made).where(IS_REPORT)).scalars().all()
        save(connection, later(survey(), 1))
        outbox.date(connection, first, NOW + 400 * DAY_S)
        made = connection.execute(select(OUTBOX.c.made).where(IS_REPORT).order_by(OUTBOX.c.seq)).scalars().all()
        message = outbox.due(connection, ONE, NOW + 401 * DAY_S)
    assert made == [*before, NOW + 400 * DAY_S]
    assert message is not None
    assert message.seq > first


@pytest.mark.slow
def test_a_message_that_is_given_up_is_due_no_more(store: Database) -> None:
    with store.writing() as connection:
        message = outbox.due(connection, ONE, NOW)
        assert message is not None
        outbox.give_up(connection, message, ONE, NOW)
        following = outbox.due(connection, ONE, NOW + DAY_S)
    assert following is not None
    assert following.seq > message.seq

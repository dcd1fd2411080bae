"""The outbox: messages to others, written in the transaction that they report, and their deliveries.

Reports are sent in their order for seven days. States of surveys and lots (`hawk.lots.storage.states`) are sent for
ever, the newest first and then the oldest: a newer one takes the place of the one before.

A delivery is noted after the receiver's answer. A program that is killed in between sends the message again, with the
same id. Times are UTC, Unix seconds.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field
from typing import Any, Final

from sqlalchemy import ColumnElement, Connection, Row, Select, and_, delete, func, select, update
from sqlalchemy.dialects.sqlite import insert

from hawk.lots.storage import states
from hawk.lots.storage.schema import DELIVERY, OUTBOX

DAY_S: Final = 86_400.0
TRIED_S: Final = 7 * DAY_S
"""Time for which a message is tried; a new receiver gets messages of this age at most."""
KEPT_S: Final = 30 * DAY_S
"""Age at which messages are removed."""
WAITS_S: Final = (10.0, 30.0, 60.0, 300.0, 900.0, 3600.0)
"""Waits after the first tries; the last one is that of every later try."""


@dataclass(frozen=True, slots=True)
class Message:
    """A message of the outbox. ``body``: JSON of what it reports. ``tries``: those that failed for this receiver."""

    seq: int
    kind: str
    body: str = field(repr=False)
    made: float
    tries: int


def last(connection: Connection) -> int:
    """Return the number of the newest message, 0 without one."""
    return connection.execute(select(func.max(OUTBOX.c.seq))).scalar() or 0


def date(connection: Connection, after: int, now: float) -> None:
    """Date the messages with a higher number: they age from when they were stored, whenever the survey was flown."""
    connection.execute(update(OUTBOX).where(OUTBOX.c.seq > after).values(made=now))


def due(connection: Connection, target: str, now: float) -> Message | None:
    """Return the oldest message that a receiver has not got and that is due now; None: nothing is due.

    What came after the last message that the receiver was sent is due at any age: a clock may have jumped since.
    """
    known = select(func.max(DELIVERY.c.message)).where(DELIVERY.c.target == target).scalar_subquery()
    is_new = DELIVERY.c.message.is_(None) & ((OUTBOX.c.made > now - TRIED_S) | (OUTBOX.c.seq > known))
    asked = _asked(target).where(OUTBOX.c.kind.not_in(states.KINDS), is_new | _is_again(now))
    return _first(connection, asked)


def due_state(connection: Connection, target: str, now: float) -> Message | None:
    """Return the newest state where it was not tried yet, else the oldest one that is due; None: nothing is due."""
    asked = _asked(target).where(OUTBOX.c.kind.in_(states.KINDS))
    newest = select(func.max(OUTBOX.c.seq)).where(OUTBOX.c.kind.in_(states.KINDS)).scalar_subquery()
    first = _first(connection, asked.where(OUTBOX.c.seq == newest, DELIVERY.c.message.is_(None)))
    return first or _first(connection, asked.where(DELIVERY.c.message.is_(None) | _is_again(now)))


def is_waiting(connection: Connection, kind: str, body: str, target: str) -> bool:
    """Return whether a receiver has not got a message with this body, and is to get it."""
    asked = _asked(target).where(OUTBOX.c.kind == kind, OUTBOX.c.body == body)
    is_open = DELIVERY.c.sent.is_(None) & DELIVERY.c.given_up.is_(None)
    return connection.execute(asked.where(is_open).limit(1)).first() is not None


_ASKED: Final = select(OUTBOX.c.seq, OUTBOX.c.kind, OUTBOX.c.body, OUTBOX.c.made, DELIVERY.c.tries)


def _asked(target: str) -> Select[Any]:
    """Return the query of messages with their deliveries to a receiver."""
    return _ASKED.outerjoin(DELIVERY, and_(DELIVERY.c.message == OUTBOX.c.seq, DELIVERY.c.target == target))


def _is_again(now: float) -> ColumnElement[bool]:
    is_open = DELIVERY.c.sent.is_(None) & DELIVERY.c.given_up.is_(None) & (DELIVERY.c.next <= now)
    return and_(is_open, DELIVERY.c.message.is_not(None))


def _message(row: Row[*tuple[Any, ...]]) -> Message:
    return Message(row.seq, row.kind, row.body, row.made, row.tries or 0)


def _first(connection: Connection, asked: Select[Any]) -> Message | None:
    row = connection.execute(asked.order_by(OUTBOX.c.seq).limit(1)).one_or_none()
    return None if row is None else _message(row)


def note_sent(connection: Connection, message: Message, target: str, now: float) -> None:
    """Note that a receiver has got a message, and remove messages that nobody waits for any more."""
    _put(connection, message, target, now, sent=now)
    is_old = (OUTBOX.c.made < now - KEPT_S) & (OUTBOX.c.seq < message.seq)
    connection.execute(delete(OUTBOX).where(is_old, OUTBOX.c.kind.not_in(states.KINDS)))


def note_states_sent(connection: Connection, states_sent: Collection[int], target: str, now: float) -> None:
    """Note that a receiver has got states of surveys and lots, by their numbers; those that are gone are left out."""
    asked = _asked(target).where(OUTBOX.c.seq.in_(states_sent), OUTBOX.c.kind.in_(states.KINDS))
    for row in connection.execute(asked).all():
        _put(connection, _message(row), target, now, sent=now)


def give_up(connection: Connection, message: Message, target: str, now: float) -> None:
    """Note that a message is sent no more."""
    _put(connection, message, target, now, tries=message.tries + 1)
    _end(connection, message, target, now)


def note_failed(connection: Connection, message: Message, target: str, now: float) -> bool:
    """Note that a try failed; return True when it was the last one."""
    _put(connection, message, target, now, tries=message.tries + 1)
    row = DELIVERY.c.message == message.seq, DELIVERY.c.target == target
    first = connection.execute(select(DELIVERY.c.first).where(*row)).scalar()
    if first is None or message.kind in states.KINDS:
        return False
    is_over = now - float(first) >= TRIED_S and message.tries + 1 >= len(WAITS_S)
    if is_over:
        _end(connection, message, target, now)
    return is_over


def _end(connection: Connection, message: Message, target: str, now: float) -> None:
    row = DELIVERY.c.message == message.seq, DELIVERY.c.target == target
    connection.execute(update(DELIVERY).where(*row).values(given_up=now))


def _put(
    connection: Connection, message: Message, target: str, now: float, *, sent: float | None = None, tries: int = 0
) -> None:
    """Note a delivery; a newer state may have taken the place of the message meanwhile."""
    if connection.execute(select(OUTBOX.c.seq).where(OUTBOX.c.seq == message.seq)).first() is None:
        return
    tried = tries or message.tries + 1
    wait = WAITS_S[min(tried, len(WAITS_S)) - 1]
    values = {"tries": tried, "next": now + wait, "sent": sent}
    row = {"message": message.seq, "target": target, "first": now, **values}
    statement = insert(DELIVERY).values(row)
    connection.execute(statement.on_conflict_do_update(index_elements=["message", "target"], set_=values))

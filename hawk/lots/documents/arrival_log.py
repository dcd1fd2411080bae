"""The log of arrivals: everything that drones and programs have sent to a desk, with what became of it.

The order of arrival is in no other table. The oldest rows go; those without a known sender are few, so that a stranger
moves out no row of a drone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from sqlalchemy import ColumnElement, Connection, delete, insert, select

from hawk.lots.documents.arrival import Arrival, ArrivalList, ListedArrival, Outcome, OutcomeName
from hawk.lots.documents.collection import is_erased
from hawk.lots.lists import Asked, behind, part_of
from hawk.lots.storage.schema import ARRIVAL
from hawk.lots.values import moment

MOST: Final = 100_000
"""Rows of senders that are known, which are kept: ten days of 500 lots with 20 surveys a day."""
MOST_UNKNOWN: Final = 1000
"""The same of senders that are not known."""
EVERY: Final = 100
"""Rows after which the oldest ones are removed."""
LONGEST: Final = 500
"""Characters of a reason."""


def note(connection: Connection, arrival: Arrival, now: float) -> None:
    """Note an arrival; a refusal like the sender's last one takes its place. ``now``: UTC, Unix seconds."""
    name, lot, reason = arrival.name, arrival.lot, arrival.reason
    if name and is_erased(connection, name):
        name, lot, reason = "", None, reason.replace(name, "")
    values = {
        "sender": arrival.sender, "kind": arrival.kind.value, "name": name, "lot": lot, "state": arrival.state,
        "outcome": arrival.outcome.value, "reason": reason[:LONGEST],
    }  # fmt: skip
    times = arrival.times
    if arrival.outcome is Outcome.REFUSED:
        last = select(ARRIVAL).where(ARRIVAL.c.sender == arrival.sender).order_by(ARRIVAL.c.seq.desc()).limit(1)
        row = connection.execute(last).mappings().first()
        if row is not None and all(row[column] == value for column, value in values.items()):
            connection.execute(delete(ARRIVAL).where(ARRIVAL.c.seq == row["seq"]))
            times += row["times"]
    inserted = connection.execute(insert(ARRIVAL).values(at=now, times=times, **values)).inserted_primary_key
    assert inserted is not None  # noqa: S101 - a row was inserted
    if inserted[0] % EVERY == 0:
        _remove_oldest(connection, ARRIVAL.c.sender != "", MOST)
        _remove_oldest(connection, ARRIVAL.c.sender == "", MOST_UNKNOWN)


def _remove_oldest(connection: Connection, is_of: ColumnElement[bool], most: int) -> None:
    first = select(ARRIVAL.c.seq).where(is_of).order_by(ARRIVAL.c.seq.desc()).offset(most).limit(1).scalar_subquery()
    connection.execute(delete(ARRIVAL).where(is_of, ARRIVAL.c.seq <= first))


def listed(
    connection: Connection, asked: Asked, sender: str | None = None, lot: str | None = None,
    outcome: OutcomeName | None = None,
) -> ArrivalList:  # fmt: skip
    """Return arrivals, the newest first; None: of every sender, lot or outcome. Raises LotInputError."""
    wanted = {"sender": sender, "lot": lot, "outcome": outcome}
    conditions: Sequence[ColumnElement[bool]] = [
        ARRIVAL.c[column] == value for column, value in wanted.items() if value is not None
    ]
    is_behind = behind(ARRIVAL.c.seq, replace(asked, newest_first=True))
    rows = select(ARRIVAL).where(*conditions, *is_behind).order_by(ARRIVAL.c.seq.desc())
    return part_of(
        ArrivalList, connection, rows, asked,
        lambda row: ListedArrival(**{**row._mapping, "at": moment(row.at)}), lambda row: str(row.seq),
    )  # fmt: skip

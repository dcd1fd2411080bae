"""Tables of a centre as values by ids alone: keys and numbers are of a store, and follow the order of arrival.

The log of arrivals is left out: it is that order, with each document that came twice.
"""

from __future__ import annotations

import json
from typing import Any

from sqlalchemy import Connection, Table, select

from hawk.lots.storage.schema import (
    DOCUMENT,
    FORMER,
    LAYOUT,
    LOOKS,
    LOT,
    LOT_DOCUMENT,
    OBSERVATION,
    PIN,
    SECTION,
    SECTION_LOOK,
    STALL,
    SURVEY,
    ZONE,
)
from hawk.lots.survey.observations import looks_of
from hawk.lots.survey.order import newest_first

_TABLES = (
    LOT, LAYOUT, STALL, FORMER, ZONE, SECTION, PIN, SURVEY, OBSERVATION, SECTION_LOOK, DOCUMENT, LOT_DOCUMENT,
)  # fmt: skip
_NUMBERS = {"key", "seq"}


def tables(connection: Connection) -> dict[str, list[str]]:
    """Return every row of every table that documents write, with ids in place of numbers, and the order of surveys."""
    stalls = {row.key: row.id for row in connection.execute(select(STALL.c.key, STALL.c.id))}
    surveys = {row.seq: row.id for row in connection.execute(select(SURVEY.c.seq, SURVEY.c.id))}
    found = {table.name: sorted(_rows(connection, table, stalls, surveys)) for table in _TABLES}
    found["order"] = [str(each) for each in connection.execute(select(SURVEY.c.id).order_by(*newest_first())).scalars()]
    looks = looks_of(connection, sorted(surveys))
    found["looks"] = sorted(
        f"{surveys[looks.surveys[line]]} {stalls[key]} {state} {taken:.4f}"
        for line, key, state, taken in zip(
            looks.line.tolist(), looks.stall.tolist(), looks.state.tolist(), looks.taken_probability.tolist(),
            strict=True,
        )
    )  # fmt: skip
    whole = {row.survey for row in connection.execute(select(LOOKS.c.survey))}
    found["in one piece"] = sorted(surveys[each] for each in whole)
    return found


def _rows(connection: Connection, table: Table, stalls: dict[int, str], surveys: dict[int, str]) -> list[str]:
    rows = []
    for row in connection.execute(select(table)).mappings():
        shown: dict[str, Any] = {name: value for name, value in row.items() if name not in _NUMBERS}
        if table is OBSERVATION or table is FORMER:
            shown["stall"] = stalls[shown["stall"]]
        if table is OBSERVATION or table is SECTION_LOOK or table is DOCUMENT:
            shown["survey"] = surveys[shown["survey"]]
        rows.append(json.dumps(shown, sort_keys=True, default=lambda value: value.hex()))
    return rows

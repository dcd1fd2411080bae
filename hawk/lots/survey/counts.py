"""Counts of surveys: of the lot's stalls where a survey lies on its layout, else of what it found itself."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from sqlalchemy import Connection, RowMapping, select

from hawk.lots.plan.queries import in_plan
from hawk.lots.schema import STALL
from hawk.lots.survey.observations import STATES, looks_of
from hawk.lots.values import PLACED
from hawk.model.lot_map import StallState


def counts_of(connection: Connection, surveys: Sequence[Mapping[str, Any] | RowMapping]) -> list[dict[str, Any]]:
    """Return ``free``, ``taken`` and ``unknown`` of surveys, in their order.

    ``surveys`` are rows of the table with ``seq``, ``lot``, ``layout``, ``placed`` and these counts, which are those of
    the flight's own map. A stall of the layout that a survey did not look at is unknown. So the counts are those of
    the files of a survey.
    """
    placed = [row for row in surveys if row["placed"] in PLACED and row["layout"] is not None]
    looks = looks_of(connection, sorted(row["seq"] for row in placed))
    line = {seq: number for number, seq in enumerate(looks.surveys)}
    layouts: dict[tuple[str, int], list[int]] = {}
    for row in placed:
        layouts.setdefault((row["lot"], row["layout"]), []).append(row["seq"])
    tally = np.zeros((len(looks.surveys), len(STATES)), np.int64)
    stalls: dict[int, int] = {}
    for (lot, version), numbers in layouts.items():
        keys = connection.execute(select(STALL.c.key).where(in_plan(STALL.c, lot, version))).scalars().all()
        stalls |= dict.fromkeys(numbers, len(keys))
        is_of = np.isin(looks.line, [line[seq] for seq in numbers if seq in line]) & np.isin(looks.stall, keys)
        np.add.at(tally, (looks.line[is_of], looks.state[is_of]), 1)
    columns = [STATES.index(state) for state in (StallState.FREE, StallState.TAKEN)]
    found = {seq: tally[number, columns].tolist() for seq, number in line.items()}
    return [_counts(row, stalls.get(row["seq"]), found.get(row["seq"], (0, 0))) for row in surveys]


def found_by(row: Mapping[str, Any] | RowMapping) -> int:
    """Return the number of stalls on the flight's own map, those that no layout has among them."""
    return int(row["free"] + row["taken"] + row["unknown"])


def _counts(row: Mapping[str, Any] | RowMapping, stalls: int | None, found: Sequence[int]) -> dict[str, Any]:
    if stalls is None:
        return {name: row[name] for name in ("free", "taken", "unknown")}
    free, taken = found
    return {"free": free, "taken": taken, "unknown": stalls - free - taken}

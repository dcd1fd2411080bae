"""Counts of surveys: of the lot's stalls where a survey lies on its layout, else of what it found itself."""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np
from sqlalchemy import Connection, RowMapping, select

from hawk.lots.rows import is_among
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
    starts = np.searchsorted(looks.line, np.arange(len(line) + 1))
    layouts: dict[tuple[str, int], list[int]] = {}
    for row in placed:
        layouts.setdefault((row["lot"], row["layout"]), []).append(row["seq"])
    plans = _plans(connection, {lot for lot, _ in layouts})
    tally = np.zeros((len(line), len(STATES)), np.int64)
    stalls: dict[int, int] = {}
    for (lot, version), numbers in layouts.items():
        keys = [key for key, begins, ends in plans[lot] if begins <= version and (ends is None or ends > version)]
        stalls |= dict.fromkeys(numbers, len(keys))
        lines = [line[seq] for seq in numbers if seq in line]
        among = np.concatenate([np.arange(starts[each], starts[each + 1]) for each in lines] or [np.zeros(0, np.int64)])
        among = among[np.isin(looks.stall[among], keys)]
        np.add.at(tally, (looks.line[among], looks.state[among]), 1)
    columns = [STATES.index(state) for state in (StallState.FREE, StallState.TAKEN)]
    found = {seq: tally[number, columns].tolist() for seq, number in line.items()}
    return [_counts(row, stalls.get(row["seq"]), found.get(row["seq"], (0, 0))) for row in surveys]


def _plans(connection: Connection, lots: Collection[str]) -> dict[str, list[tuple[int, int, int | None]]]:
    """Return key, first and last version of the layout of all stalls that lots ever had."""
    found: dict[str, list[tuple[int, int, int | None]]] = {lot: [] for lot in lots}
    columns = (STALL.c.lot, STALL.c.key, STALL.c.begins, STALL.c.ends)
    asked = select(*columns).where(is_among(STALL.c.lot)).order_by(STALL.c.key)
    for lot, *rest in connection.execute(asked, {"among": json.dumps([*lots])}):
        found[lot].append(tuple(rest))
    return found


def found_by(row: Mapping[str, Any] | RowMapping) -> int:
    """Return the number of stalls on the flight's own map, those that no layout has among them."""
    return int(row["free"] + row["taken"] + row["unknown"])


def _counts(row: Mapping[str, Any] | RowMapping, stalls: int | None, found: Sequence[int]) -> dict[str, Any]:
    if stalls is None:
        return {name: row[name] for name in ("free", "taken", "unknown")}
    free, taken = found
    return {"free": free, "taken": taken, "unknown": stalls - free - taken}

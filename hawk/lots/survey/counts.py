"""Counts of surveys: of the lot's stalls where a survey lies on its layout, else of what it found itself."""

from __future__ import annotations

import itertools
import json
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import Connection, RowMapping, func, select

from hawk.lots.plan.queries import hidden_stalls
from hawk.lots.storage.rows import is_among
from hawk.lots.storage.schema import LAYOUT, STALL
from hawk.lots.survey.observations import STATES, Looks, looks_of
from hawk.lots.values import PLACED
from hawk.model.lot_map import StallState

_Layout = tuple[str, int]
"""A lot, and the version of its layout."""
_Keys = NDArray[np.int64]
_NEVER: Final = 2**62
_VERSIONS: Final = select(LAYOUT.c.lot, func.max(LAYOUT.c.version)).where(is_among(LAYOUT.c.lot)).group_by(LAYOUT.c.lot)
COUNTS: Final = ("free", "taken", "unknown")
_KEYS: Final = (
    select(STALL.c.lot, func.count(), func.group_concat(STALL.c.key))
    .where(STALL.c.ends.is_(None), is_among(STALL.c.lot))
    .group_by(STALL.c.lot)
)


def counts_of(connection: Connection, surveys: Sequence[Mapping[str, Any] | RowMapping]) -> list[dict[str, Any]]:
    """Return ``free``, ``taken`` and ``unknown`` of surveys, in their order.

    ``surveys`` are rows of the table with ``seq``, ``lot``, ``layout``, ``placed`` and these counts, which are those of
    the flight's own map. A stall of the layout that a survey did not look at is unknown. So the counts are those of
    the files of a survey.
    """
    layout = {row["seq"]: (str(row["lot"]), int(row["layout"])) for row in surveys if is_by_layout(row)}
    plans = _plans(connection, set(layout.values()))
    looks = looks_of(connection, sorted(layout))
    columns = [STATES.index(state) for state in (StallState.FREE, StallState.TAKEN)]
    counted = dict(zip(looks.surveys, _tally(looks, layout, plans)[:, columns].tolist(), strict=True))
    stalls = {seq: len(plans[of]) for seq, of in layout.items()}
    return [_counts(row, stalls.get(row["seq"]), counted.get(row["seq"], (0, 0))) for row in surveys]


def is_by_layout(row: Mapping[str, Any] | RowMapping) -> bool:
    """Return whether a survey is counted by the stalls of its layout, not by its flight's own map."""
    return row["placed"] in PLACED and row["layout"] is not None


def _tally(looks: Looks, layout: Mapping[int, _Layout], plans: Mapping[_Layout, _Keys]) -> NDArray[np.int64]:
    """Return how many stalls of its layout each survey saw in each state, (S, states)."""
    number = {of: n for n, of in enumerate(plans)}
    wanted = np.array([number[layout[seq]] for seq in looks.surveys], np.int64)[looks.line]
    is_of_layout = np.zeros(len(looks.line), np.bool_)
    for each in _apart(plans):
        keys = np.concatenate([plans[of] for of in each])
        owner = np.full(max(keys.max(initial=0), looks.stall.max(initial=0)) + 1, -1)
        owner[keys] = np.repeat([number[of] for of in each], [len(plans[of]) for of in each])
        is_of_layout |= owner[looks.stall] == wanted
    cells = (looks.line * len(STATES) + looks.state)[is_of_layout]
    size = len(looks.surveys) * len(STATES)
    return np.bincount(cells, minlength=size).reshape(-1, len(STATES))


def _apart(layouts: Iterable[_Layout]) -> list[list[_Layout]]:
    """Return layouts in groups that have each lot once: a stall is in one layout of each group."""
    of_lots: dict[str, int] = {}
    groups: list[list[_Layout]] = []
    for lot, version in layouts:
        before = of_lots.get(lot, 0)
        of_lots[lot] = before + 1
        if before == len(groups):
            groups.append([])
        groups[before].append((lot, version))
    return groups


def _plans(connection: Connection, layouts: Collection[_Layout]) -> dict[_Layout, _Keys]:
    """Return the keys of the stalls of layouts: those of a lot's newest layout by their index alone."""
    among = {"among": json.dumps(list({lot for lot, _ in layouts}))}
    newest = {(str(lot), int(version)) for lot, version in connection.execute(_VERSIONS, among).all()}
    found = dict.fromkeys(layouts, np.zeros(0, np.int64))
    present = {lot: (lot, version) for lot, version in newest if (lot, version) in found}
    if rows := connection.execute(_KEYS, {"among": json.dumps(list(present))}).all():
        lots, sizes, texts = zip(*rows, strict=True)
        every = np.fromstring(",".join(texts), np.int64, sep=",")
        parts = np.split(every, np.cumsum(sizes)[:-1])
        found.update((present[lot], part) for lot, part in zip(lots, parts, strict=True))
    former: dict[str, list[int]] = {}
    for lot, version in found.keys() - newest:
        former.setdefault(lot, []).append(version)
    if former:
        columns = (STALL.c.lot, STALL.c.key, STALL.c.begins, STALL.c.ends)
        asked = select(*columns).where(is_among(STALL.c.lot)).order_by(STALL.c.lot)
        rows_of = connection.execute(asked, {"among": json.dumps(list(former))})
        for lot, stalls in itertools.groupby(rows_of, key=lambda row: str(row.lot)):
            key, begins, ends = np.array([(row[1], row[2], _NEVER if row[3] is None else row[3]) for row in stalls]).T
            for version in former[lot]:
                found[lot, version] = key[(begins <= version) & (ends > version)]
    if hidden := [*hidden_stalls(connection, {lot for lot, _ in layouts})]:
        return {of: keys[~np.isin(keys, hidden)] for of, keys in found.items()}
    return found


def found_by(row: Mapping[str, Any] | RowMapping) -> int:
    """Return the number of stalls on the flight's own map, those that no layout has among them."""
    return int(row["free"] + row["taken"] + row["unknown"])


def _counts(row: Mapping[str, Any] | RowMapping, stalls: int | None, found: Sequence[int]) -> dict[str, Any]:
    if stalls is None:
        return {name: row[name] for name in COUNTS}
    free, taken = found
    return {"free": free, "taken": taken, "unknown": stalls - free - taken}

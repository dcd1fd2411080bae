"""Surveys of a lot in a period, read from the store as a panel of looks."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import tzinfo
from typing import Final

import numpy as np
from sqlalchemy import ColumnElement, Connection, Row, select

from hawk.lots.labels import parts_of
from hawk.lots.looks import STATES, Looks, looks_of
from hawk.lots.plan import geometry
from hawk.lots.plan.versions import newest_layout
from hawk.lots.tables import LOT, NO_STALLS, STALL, SURVEY, ZONE
from hawk.lots.values import PLACED, NotFoundError
from hawk.model.lot_map import StallState
from hawk.stats.values import FREE, TAKEN, UNSEEN, CountedStall, CountedSurvey, Floats32, Ints, LeftOut, Panel, States

_SURVEY: Final = ("seq", "id", "began", "ended", "placed", "layout", "time_is_sure")
_STALL: Final = ("key", "id", "label", "kind", "north", "east", "begins", "ends")
UNREGISTERED: Final = "not registered: it is not certain where it lies on the lot; choose its place under Lots"
NO_TIME: Final = "its time is not sure: neither GNSS nor a time server had set the clock"
_NO_END: Final = np.iinfo(np.int64).max
NO_LOOKS: Final = "it looked at no stall of the lot"
CODES: Final = {UNREGISTERED: "unregistered", NO_TIME: "no_time", NO_LOOKS: "no_looks"}
"""Codes of the reasons why a survey is left out, for programs and translations."""


@dataclass(frozen=True, slots=True)
class Period:
    """A period: surveys that ended from ``begin`` on, before ``end``; Unix seconds, None without that end.

    ``clock``: the lot's time, called ``clock_name``.
    """

    begin: float | None
    end: float | None
    clock: tzinfo
    clock_name: str

    def holds(self, moment: ColumnElement[float]) -> list[ColumnElement[bool]]:
        """Return the conditions that a moment is one of the period."""
        begins = [] if self.begin is None else [moment >= self.begin]
        return begins if self.end is None else [*begins, moment < self.end]


def read_panel(connection: Connection, lot: str, period: Period) -> Panel:
    """Return the looks of a lot's surveys in a period. Surveys whose place or time is not sure are left out.

    A stall counts in the surveys whose layout has it. Raises NotFoundError, LotStoreError.
    """
    name = connection.execute(select(LOT.c.name).where(LOT.c.id == lot, LOT.c.merged_into.is_(None))).scalar()
    if name is None:
        raise NotFoundError("lot: there is no lot with this id; reload the list")
    asked = select(*(SURVEY.c[each] for each in _SURVEY)).where(SURVEY.c.lot == lot, *period.holds(SURVEY.c.ended))
    rows = connection.execute(asked.order_by(SURVEY.c.ended)).all()
    reasons = [_why_not(row) for row in rows]
    looks = looks_of(connection, [row.seq for row, why in zip(rows, reasons, strict=True) if not why])
    at = dict(zip(looks.surveys, looks.at.tolist(), strict=True))
    reasons = [why or ("" if row.seq in at else NO_LOOKS) for row, why in zip(rows, reasons, strict=True)]
    left_out = tuple(LeftOut(row.id, row.ended, why) for row, why in zip(rows, reasons, strict=True) if why)
    used = sorted((row for row in rows if row.seq in at), key=lambda row: at[row.seq])
    newest = newest_layout(connection, lot)
    layouts = np.array([newest if row.layout is None else row.layout for row in used], np.int64)
    stalls = connection.execute(
        select(*(STALL.c[each] for each in _STALL)).where(STALL.c.lot == lot).order_by(STALL.c.key)
    ).all()
    begins = np.array([row.begins for row in stalls], np.int64)
    ends = np.array([_NO_END if row.ends is None else row.ends for row in stalls], np.int64)
    is_there = (begins <= layouts[:, None]) & (layouts[:, None] < ends)
    kept = np.asarray(is_there.any(axis=0) if used else ends == _NO_END, np.bool_)
    shown = [row for row, is_kept in zip(stalls, kept.tolist(), strict=True) if is_kept]
    place = {row.seq: line for line, row in enumerate(used)}
    lines = np.array([place[survey] for survey in looks.surveys], np.int64)
    taken, state = _table(looks, lines, np.array([row.key for row in shown], np.int64))
    return Panel(
        lot, str(name), period.clock, period.clock_name,
        _counted(connection, lot, shown), tuple(CountedSurvey(row.id, at[row.seq]) for row in used),
        left_out, taken, state, is_there[:, kept],
    )  # fmt: skip


def _why_not(row: Row[tuple[object, ...]]) -> str:
    """Return why a survey is left out; nothing for one that counts."""
    if row.placed not in PLACED:
        return UNREGISTERED
    return "" if row.time_is_sure else NO_TIME


def _table(looks: Looks, lines: Ints, keys: Ints) -> tuple[Floats32, States]:
    """Return probability and state (S, N) of the stalls with some keys, which rise.

    ``lines``: where each survey of ``looks`` stands.
    """
    size = (len(lines), len(keys))
    taken, state = np.full(size, np.nan, np.float32), np.full(size, UNSEEN, np.int8)
    if not taken.size or not len(looks.stall):
        return taken, state
    highest = max(int(keys[-1]), int(looks.stall.max()))
    columns = np.full(highest + 1, -1, np.int64)
    columns[keys] = np.arange(len(keys))
    column, line = columns[looks.stall], lines[looks.line]
    is_known = column >= 0
    place = (line * len(keys) + column)[is_known]
    taken.reshape(-1)[place] = looks.taken[is_known]
    state.reshape(-1)[place] = np.array([_NUMBERS[each] for each in STATES], np.int8)[looks.state[is_known]]
    return taken, state


_NUMBERS: Final = {StallState.FREE: FREE, StallState.TAKEN: TAKEN, StallState.UNKNOWN: UNSEEN}


def _counted(connection: Connection, lot: str, rows: Sequence[Row[tuple[object, ...]]]) -> tuple[CountedStall, ...]:
    """Return stalls with their row, and the zones of the present plan that their middles lie in."""
    zones = connection.execute(
        select(ZONE.c.name, ZONE.c.outline)
        .where(ZONE.c.lot == lot, ZONE.c.kind != NO_STALLS, ZONE.c.ends.is_(None))
        .order_by(ZONE.c.name)
    ).all()
    places = np.array([(row.north, row.east) for row in rows], np.float64).reshape(-1, 2)
    inside = [(zone.name, geometry.within(json.loads(zone.outline), places)) for zone in zones]
    return tuple(
        CountedStall(
            row.id, row.label, _row_of(row.label), row.kind, tuple(name for name, lies in inside if lies[number])
        )
        for number, row in enumerate(rows)
    )


def _row_of(label: str) -> str:
    """Return the letter of a label's row; an owner's own label begins with those of its row, as "P12" with "P"."""
    parts = parts_of(label)
    return parts[0] if parts is not None else label.rstrip("0123456789 -.")

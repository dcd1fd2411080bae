"""Surveys of a lot in a period, read from the store as a panel of looks."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from datetime import tzinfo
from typing import Final

import numpy as np
from sqlalchemy import ColumnElement, Connection, Row, and_, func, or_, select

from hawk.lots.labels import parts_of
from hawk.lots.plan import geometry
from hawk.lots.plan.queries import hidden_stalls
from hawk.lots.plan.values import BARE
from hawk.lots.plan.versions import newest_layout
from hawk.lots.storage.database import version_of
from hawk.lots.storage.outlines import ring_of
from hawk.lots.storage.schema import LOOKS, LOT, SECTION_LOOK, STALL, SURVEY, ZONE
from hawk.lots.survey.observations import STATES, Looks, looks_of
from hawk.lots.survey.order import has_been, is_sure
from hawk.lots.values import PLACED, NotFoundError, moment
from hawk.model.lot_map import StallState
from hawk.results.label_parts import in_order
from hawk.stats.values import (
    FREE,
    NO_TIME,
    NOT_YET,
    TAKEN,
    UNSEEN,
    Bools,
    Floats,
    Floats32,
    Ints,
    LeftOut,
    Panel,
    PanelColumn,
    PanelRow,
    States,
)

_SURVEY: Final = ("seq", "id", "ended", "placed", "layout")
_STALL: Final = ("key", "id", "label", "kind", "north", "east", "angle", "width", "length", "begins", "ends")
UNREGISTERED: Final = "not registered: it is not certain where it lies on the lot; choose its place under Lots"
MOST_KEPT: Final = 4_000_000
"""Looks of the most surveys that are kept: 24 MB, and at most as much again for a part of them."""
_KEPT: Final = "hawk.stats.panel"
_NO_END: Final = np.iinfo(np.int64).max
NO_LOOKS: Final = "it looked at no stall of the lot"
CODES: Final = {UNREGISTERED: "unregistered", NO_TIME: "no_time", NOT_YET: "no_time", NO_LOOKS: "no_looks"}
"""Codes of the reasons why a survey is left out, for programs and translations."""


@dataclass(frozen=True, slots=True)
class Period:
    """A period from ``begin`` on, before ``end``; Unix seconds, None without that end.

    Figures have the surveys whose looks are of it by their mean time, and say which others that ended in it they leave
    out. ``clock``: the lot's time, called ``clock_name``.
    """

    begin: float | None
    end: float | None
    clock: tzinfo
    clock_name: str

    def holds(self, moment: ColumnElement[float]) -> list[ColumnElement[bool]]:
        """Return the conditions that a moment is one of the period."""
        begins = [] if self.begin is None else [moment >= self.begin]
        return begins if self.end is None else [*begins, moment < self.end]

    def may_have(self) -> list[ColumnElement[bool]]:
        """Return the conditions that the figures of the period may use a row of `SURVEY`, or leave it out.

        The moment of a survey whose looks are not in one piece is known when they are read.
        """
        if self.begin is None and self.end is None:
            return []
        moment = select(LOOKS.c.at).where(LOOKS.c.survey == SURVEY.c.seq).scalar_subquery()
        return [or_(moment.is_(None), and_(*self.holds(moment)), and_(*self.holds(SURVEY.c.ended)))]

    def has(self, moments: Floats) -> Bools:
        """Return which moments are of the period."""
        return np.asarray((moments >= self._ends[0]) & (moments < self._ends[1]), np.bool_)

    def is_within(self, other: Period) -> bool:
        """Return True when the other period has every moment of this one."""
        return other._ends[0] <= self._ends[0] and self._ends[1] <= other._ends[1]

    @property
    def _ends(self) -> tuple[float, float]:
        return -np.inf if self.begin is None else self.begin, np.inf if self.end is None else self.end


@dataclass(frozen=True, slots=True)
class _Looked:
    """Looks that the store has of a lot near a period: R surveys by their end, S of them with looks at N stalls.

    ``at`` (R,): mean moment of a survey's looks; the end of one that is left out. ``why``: why a survey is left out, ""
    for those with looks; ``line`` (R,): the line of these in ``surveys``, which are by time. ``is_present`` (N,):
    stalls of the newest layout. The tables are those of a `Panel`.
    """

    lot: str
    name: str
    ids: tuple[str, ...]
    at: Floats
    why: tuple[str, ...]
    line: Ints
    surveys: tuple[PanelRow, ...]
    stalls: tuple[PanelColumn, ...]
    is_present: Bools
    taken_probability: Floats32
    state: States
    is_there: Bools

    def panel(self, period: Period) -> Panel:
        """Return the panel of a period within that of these surveys; its tables are not copied where all are asked."""
        is_in = period.has(self.at)
        left_out = tuple(
            LeftOut(self.ids[number], moment(float(self.at[number])), self.why[number])
            for number in np.flatnonzero(is_in & (self.line < 0)).tolist()
        )
        lines = np.sort(self.line[is_in & (self.line >= 0)])
        surveys, tables = self.surveys, (self.taken_probability, self.state, self.is_there)
        if len(lines) < len(surveys):
            surveys = tuple(surveys[line] for line in lines.tolist())
            tables = self.taken_probability[lines], self.state[lines], self.is_there[lines]
        stalls, is_kept = self.stalls, tables[2].any(axis=0) if len(lines) else self.is_present
        if not is_kept.all():
            stalls = tuple(stalls[number] for number in np.flatnonzero(is_kept).tolist())
            tables = tables[0][:, is_kept], tables[1][:, is_kept], tables[2][:, is_kept]
        return Panel(self.lot, self.name, period.clock, period.clock_name, stalls, surveys, left_out, *tables)


@dataclass(frozen=True, slots=True)
class _Kept:
    """Surveys of a period that were read at a version of the store, and the panel that was asked for last."""

    version: str
    period: Period
    looked: _Looked
    asked: Period
    panel: Panel


def read_panel(
    connection: Connection, lot: str, period: Period, surveys: Collection[str] | None = None
) -> Panel:  # fmt: skip
    """Return the looks of a lot's surveys in a period, by the mean time of their looks. Surveys whose place or time is
    not sure are left out. ``surveys``: ids of some; these alone are read.

    A stall counts in the surveys whose layout has it. What was read is kept with the connection until the store
    changes or more is asked for: a page asks for parts of the same period, one by one. Raises NotFoundError,
    LotStoreError.
    """
    if surveys is not None:
        return _read(connection, lot, period, SURVEY.c.id.in_(surveys)).panel(period)
    version = version_of(connection)
    kept: _Kept | None = connection.info.get(_KEPT)
    if kept is not None and kept.version == version and kept.looked.lot == lot and period.is_within(kept.period):
        if kept.asked == period:
            return kept.panel
        read, looked = kept.period, kept.looked
    else:
        connection.info.pop(_KEPT, None)
        read, looked = period, _read(connection, lot, period)
    panel = looked.panel(period)
    if looked.taken_probability.size <= MOST_KEPT:
        for values in (panel.taken_probability, panel.state, panel.is_there):
            values.flags.writeable = False
        connection.info[_KEPT] = _Kept(version, read, looked, period, panel)
    return panel


def _read(connection: Connection, lot: str, period: Period, *of: ColumnElement[bool]) -> _Looked:
    name = connection.execute(select(LOT.c.name).where(LOT.c.id == lot, LOT.c.merged_into.is_(None))).scalar()
    if name is None:
        raise NotFoundError("lot: there is no lot with this id; reload the list")
    columns = (*(SURVEY.c[each] for each in _SURVEY), is_sure(), has_been())
    asked = select(*columns).where(SURVEY.c.lot == lot, *period.may_have(), *of)
    rows = connection.execute(asked.order_by(SURVEY.c.ended)).all()
    asked = select(*(STALL.c[each] for each in _STALL)).where(STALL.c.lot == lot).order_by(STALL.c.key)
    hidden = hidden_stalls(connection, [lot])
    stalls = in_order([row for row in connection.execute(asked) if row.key not in hidden])
    by_sections = {} if any(row.ends is None for row in stalls) else _section_moments(connection, lot)
    why = [
        _why_not(is_placed=row[3] in PLACED or row[0] in by_sections, time_is_sure=row[5], has_been=row[6])
        for row in rows
    ]
    looks = looks_of(connection, [row[0] for row, reason in zip(rows, why, strict=True) if not reason])
    at = {row[0]: by_sections[row[0]] for row, reason in zip(rows, why, strict=True)
          if not reason and row[0] in by_sections}  # fmt: skip
    at |= dict(zip(looks.surveys, looks.at.tolist(), strict=True))
    used = sorted((row for row in rows if row[0] in at), key=lambda row: at[row[0]])
    line = {row[0]: number for number, row in enumerate(used)}
    newest = newest_layout(connection, lot)
    layouts = np.array([newest if row[4] is None else row[4] for row in used], np.int64)
    begins = np.array([row.begins for row in stalls], np.int64)
    ends = np.array([_NO_END if row.ends is None else row.ends for row in stalls], np.int64)
    is_there = (begins <= layouts[:, None]) & (layouts[:, None] < ends)
    lines = np.array([line[survey] for survey in looks.surveys], np.int64)
    taken, state = _table(looks, lines, len(used), np.array([row.key for row in stalls], np.int64))
    return _Looked(
        lot, str(name), tuple(row[1] for row in rows), np.array([at.get(row[0], row[2]) for row in rows], np.float64),
        tuple(reason or ("" if row[0] in at else NO_LOOKS) for row, reason in zip(rows, why, strict=True)),
        np.array([line.get(row[0], -1) for row in rows], np.int64),
        tuple(PanelRow(row[1], at[row[0]]) for row in used), _counted(connection, lot, stalls),
        ends == _NO_END, taken, state, is_there,
    )  # fmt: skip


def _section_moments(connection: Connection, lot: str) -> dict[int, float]:
    """Return the mean moment of the looks at sections of a lot without stalls, by the number of the survey."""
    moments = select(SECTION_LOOK.c.survey, func.avg(SECTION_LOOK.c.looked_at)).group_by(SECTION_LOOK.c.survey)
    found = connection.execute(moments.join(SURVEY, SURVEY.c.seq == SECTION_LOOK.c.survey).where(SURVEY.c.lot == lot))
    return {int(survey): float(at) for survey, at in found}


def _why_not(*, is_placed: bool, time_is_sure: bool, has_been: bool) -> str:
    """Return why a survey is left out; nothing for one that counts."""
    if not is_placed:
        return UNREGISTERED
    return "" if time_is_sure else NO_TIME if has_been else NOT_YET


def _table(looks: Looks, lines: Ints, count: int, keys: Ints) -> tuple[Floats32, States]:
    """Return probability and state (S, N) of the stalls with some keys, S being the ``count`` of surveys.

    ``lines``: where each survey of ``looks`` stands.
    """
    size = (count, len(keys))
    taken, state = np.full(size, np.nan, np.float32), np.full(size, UNSEEN, np.int8)
    if not taken.size or not len(looks.stall):
        return taken, state
    highest = max(int(keys.max()), int(looks.stall.max()))
    columns = np.full(highest + 1, -1, np.int64)
    columns[keys] = np.arange(len(keys))
    column = columns[looks.stall]
    place = (lines * len(keys))[looks.line] + column
    chance, found = looks.taken_probability, _STATES_OF_LOOKS[looks.state]
    is_known = column >= 0
    if not is_known.all():
        place, chance, found = place[is_known], chance[is_known], found[is_known]
    taken.reshape(-1)[place] = chance
    state.reshape(-1)[place] = found
    return taken, state


_NUMBERS: Final = {StallState.FREE: FREE, StallState.TAKEN: TAKEN, StallState.UNKNOWN: UNSEEN}
_STATES_OF_LOOKS: Final = np.array([_NUMBERS[each] for each in STATES], np.int8)


def _counted(connection: Connection, lot: str, rows: Sequence[Row[tuple[object, ...]]]) -> tuple[PanelColumn, ...]:
    """Return stalls with their row, and the zones of the present plan that their middles lie in."""
    zones = connection.execute(
        select(ZONE.c.name, ZONE.c.outline)
        .where(ZONE.c.lot == lot, ZONE.c.kind.not_in(BARE), ZONE.c.ends.is_(None))
        .order_by(ZONE.c.name)
    ).all()
    places = np.array([(row.north, row.east) for row in rows], np.float64).reshape(-1, 2)
    inside = [(zone.name, geometry.within(ring_of(zone.outline), places)) for zone in zones]
    return tuple(
        PanelColumn(
            row.id,
            row.label,
            _row_of(row.label),
            row.kind,
            tuple(name for name, lies in inside if lies[number]),
            (row.north, row.east, row.angle, row.width, row.length),
        )
        for number, row in enumerate(rows)
    )


def _row_of(label: str) -> str:
    """Return the letter of a label's row; an owner's own label begins with those of its row, as "P12" with "P"."""
    parts = parts_of(label)
    return parts[0] if parts is not None else label.rstrip("0123456789 -.")

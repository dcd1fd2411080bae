"""Plans of documents in the tables of lots: each stall and zone is in the lot of the newest state that has it.

A stall that no plan has any more goes; the looks at it wait beside their surveys, loose, until a plan has it again. So
the tables follow from the documents alone, in whatever order they came. A stall that surveys of this store looked at
stays with its looks, in no version of the plan.
"""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

from sqlalchemy import Connection, Table, and_, bindparam, delete, insert, or_, select, text, update

from hawk.lots.documents.lot_document import LotPart, PlanSection, PlanZone, kept_lot, plan_digest
from hawk.lots.documents.parts import Ground
from hawk.lots.documents.source import lot_part
from hawk.lots.plan.versions import read_again
from hawk.lots.storage.outlines import outline_json
from hawk.lots.storage.rows import is_among
from hawk.lots.storage.schema import (
    CHANGE,
    DOCUMENT,
    FORMER,
    LAYOUT,
    LOT,
    LOT_DOCUMENT,
    OBSERVATION,
    PIN,
    SECTION,
    STALL,
    SURVEY,
    ZONE,
)
from hawk.lots.survey.observations import keep_looks
from hawk.model.plans import Outline

_SAID: Final = ("name", "time_zone")
_Values = dict[str, Any]


def store(connection: Connection, part: LotPart, writer: str) -> list[str]:
    """Write a state of a lot into its tables; return the other lots of which stalls went there, or came back.

    ``writer``: of the document. Lots of others are left as they are.
    """
    _store_lot(connection, part)
    contest = _contest(connection, part, writer)
    _store_stalls(connection, contest)
    _store_former(connection, contest)
    zones = _rows(connection, ZONE, contest.names)
    sync(connection, ZONE, ("id",), zones, [row for each in contest.parts for row in contest.won(_zone_rows(each))])
    _store_sections(connection, part)
    _fit_layouts(connection, part)
    for each in contest.parts:
        read_again(connection, each.id)
    return [each.id for each in contest.parts[1:]]


def name_lot(connection: Connection, part: LotPart) -> None:
    """Give a lot the name and the time zone of a state."""
    values = {name: getattr(part, name) for name in _SAID}
    is_other = or_(*(LOT.c[name].is_distinct_from(value) for name, value in values.items()))
    connection.execute(update(LOT).where(LOT.c.id == part.id, is_other).values(**values))


def outline_of(ground: Ground) -> Outline:
    """Return ground of a document as an outline."""
    return Outline(ground.polygons, ground.holes)


def sync(
    connection: Connection, table: Table, key: tuple[str, ...], there: Iterable[_Values], wanted: Iterable[_Values]
) -> None:
    """Bring rows of a table, ``there``, to those that are ``wanted``, by the columns of a key. Others are left."""
    before = {tuple(row[name] for name in key): row for row in there}
    after = {tuple(row[name] for name in key): row for row in wanted}
    is_row = and_(*(table.c[name] == bindparam(f"key_{name}") for name in key))
    gone = [_named(key, each) for each in before if each not in after]
    if gone:
        connection.execute(delete(table).where(is_row), gone)
    changed = [
        {**_named(key, each), **{f"new_{name}": value for name, value in row.items()}}
        for each, row in after.items()
        if each in before and any(before[each][name] != value for name, value in row.items())
    ]
    if changed:
        columns = [name.removeprefix("new_") for name in changed[0] if name.startswith("new_")]
        values: _Values = {name: bindparam(f"new_{name}") for name in columns}
        connection.execute(update(table).where(is_row).values(**values), changed)
    if new := [row for each, row in after.items() if each not in before]:
        connection.execute(insert(table), new)


def _named(key: tuple[str, ...], values: tuple[Any, ...]) -> _Values:
    return {f"key_{name}": value for name, value in zip(key, values, strict=True)}


def is_merged_here(connection: Connection, lot: str) -> bool:
    """Return whether a person here has made a lot part of another one, or another one part of it."""
    merged = select(CHANGE.c.seq).where(CHANGE.c.kind == "merge", CHANGE.c.state == "done")
    return connection.execute(merged.where(CHANGE.c.body.contains(lot, autoescape=True))).first() is not None


def _store_lot(connection: Connection, part: LotPart) -> None:
    values = {
        "id": part.id, "name": part.name, "outline": outline_json(outline_of(part.outline)), "made": part.made,
        "latitude": part.latitude, "longitude": part.longitude, "datum_is_pinned": part.datum_is_pinned,
        "time_zone": part.time_zone,
        "merged_into": None if _is_round(connection, part.id, part.merged_into) else part.merged_into,
    }  # fmt: skip
    there = [dict(row) for row in connection.execute(select(LOT).where(LOT.c.id == part.id)).mappings()]
    sync(connection, LOT, ("id",), there, [values])
    turns = [dict(row) for row in connection.execute(select(PIN).where(PIN.c.lot == part.id)).mappings()]
    sync(connection, PIN, ("lot",), turns, [{"lot": part.id, "turn": part.turn}] if part.turn else [])
    layouts = [{"lot": part.id, **each.model_dump()} for each in part.layouts]
    known = [dict(row) for row in connection.execute(select(LAYOUT).where(LAYOUT.c.lot == part.id)).mappings()]
    sync(connection, LAYOUT, ("lot", "version"), known, layouts)


def _is_round(connection: Connection, lot: str, into: str | None) -> bool:
    """Return whether a lot would become part of itself."""
    while into is not None and into != lot:
        into = connection.execute(select(LOT.c.merged_into).where(LOT.c.id == into)).scalar()
    return into == lot


@dataclass(frozen=True, slots=True)
class _Contest:
    """Stalls and zones that are stored, by their ids ``names``: those that a lot has, or had.

    ``parts``: the lots whose tables they may be in; ``owner``: the lot of each that is in a plan.
    """

    parts: tuple[LotPart, ...]
    names: frozenset[str]
    owner: Mapping[str, str]

    def won(self, rows: Iterable[_Values], key: str = "id") -> list[_Values]:
        """Return the rows of a lot that are stored there."""
        return [row for row in rows if row[key] in self.names and self.owner[row[key]] == row["lot"]]


def _contest(connection: Connection, part: LotPart, writer: str) -> _Contest:
    """Return which of the stalls and zones that a lot has, or had, are its own, and whose the others are.

    One that is in the tables of another lot is contested by it; one that the lot had and has not may be of any. A stall
    in a lot of another drone, or in one that a person here has changed, stays there.
    """
    own = _names(part)
    there = {**_lots_of(connection, STALL, own), **_lots_of(connection, ZONE, own)}
    rivals = {lot for lot in there.values() if lot != part.id}
    dropped = _names_there(connection, part.id) - own
    others: list[LotPart] = []
    if rivals or dropped:
        asked = select(LOT_DOCUMENT.c.plan, LOT_DOCUMENT.c.body).where(
            LOT_DOCUMENT.c.writer == writer, LOT_DOCUMENT.c.lot != part.id, LOT_DOCUMENT.c.plan != ""
        )
        if not dropped:
            asked = asked.where(LOT_DOCUMENT.c.lot.in_(rivals))
        for plan, body in connection.execute(asked.order_by(LOT_DOCUMENT.c.lot)).all():
            other = kept_lot(body)
            is_about = other.id in rivals or bool(_names(other) & (own | dropped))
            if is_about and plan_digest(lot_part(connection, other.id)) == plan.split()[-1]:
                others.append(other)
    parts = (part, *others)
    ours = {each.id for each in parts}
    names = frozenset(name for name in own | dropped if there.get(name, part.id) in ours)
    owner: dict[str, str] = {}
    for each in sorted(parts, key=lambda one: (one.state, one.id)):
        owner |= dict.fromkeys(_names(each) & names, each.id)
    return _Contest(parts, names, owner)


def _names(part: LotPart) -> set[str]:
    return {stall.id for stall in part.stalls} | {zone.id for zone in part.zones}


def _names_there(connection: Connection, lot: str) -> set[str]:
    return {
        name
        for table in (STALL, ZONE)
        for name in connection.execute(select(table.c.id).where(table.c.lot == lot)).scalars()
    }


def _lots_of(connection: Connection, table: Table, names: Collection[str]) -> dict[str, str]:
    asked = select(table.c.id, table.c.lot).where(is_among(table.c.id))
    return {row.id: row.lot for row in connection.execute(asked, {"among": json.dumps([*names])})}


def _rows(connection: Connection, table: Table, names: Collection[str]) -> list[_Values]:
    asked = select(table).where(is_among(table.c.id))
    return [dict(row) for row in connection.execute(asked, {"among": json.dumps([*names])}).mappings()]


def keys_of(connection: Connection, stalls: Collection[str]) -> dict[str, int]:
    """Return the keys of stalls by their ids, without those that are not there."""
    asked = select(STALL.c.id, STALL.c.key).where(is_among(STALL.c.id))
    return {row.id: row.key for row in connection.execute(asked, {"among": json.dumps([*stalls])})}


def _stall_rows(part: LotPart) -> list[_Values]:
    return [{**each.model_dump(), "lot": part.id} for each in part.stalls]


def _zone_rows(part: LotPart) -> list[_Values]:
    return _area_rows(part.zones, part.id)


def _area_rows(areas: Sequence[PlanZone | PlanSection], lot: str) -> list[_Values]:
    return [{**each.model_dump(), "lot": lot, "outline": json.dumps(each.outline)} for each in areas]


def _store_stalls(connection: Connection, contest: _Contest) -> None:
    """Write stalls, and remove those that are in no plan: their looks become loose.

    One that surveys of this store looked at stays, in no version.
    """
    there = _rows(connection, STALL, contest.names)
    rows = [row for each in contest.parts for row in contest.won(_stall_rows(each))]
    wanted = {row["id"] for row in rows}
    gone = {row["key"]: row["id"] for row in there if row["id"] not in wanted}
    kept = _seen_here(connection, gone)
    loosen(connection, {key: named for key, named in gone.items() if key not in kept})
    rows += [{**row, "ends": row["begins"]} for row in there if row["key"] in kept]
    sync(connection, STALL, ("id",), there, rows)
    if new := wanted - {row["id"] for row in there}:
        tie(connection, new)


def _seen_here(connection: Connection, stalls: Mapping[int, str]) -> set[int]:
    """Return the keys of those stalls that surveys of this store looked at."""
    came = select(DOCUMENT.c.survey)
    asked = select(OBSERVATION.c.stall).where(is_among(OBSERVATION.c.stall), OBSERVATION.c.survey.not_in(came))
    return {*connection.execute(asked.distinct(), {"among": json.dumps([*stalls])}).scalars()}


def loosen(connection: Connection, stalls: Mapping[int, str]) -> None:
    """Take the looks at stalls, key -> id, out of the table; those of documents wait beside their surveys."""
    if not stalls:
        return
    among = {"among": json.dumps([*stalls])}
    found: dict[int, list[_Values]] = defaultdict(list)
    for row in connection.execute(select(OBSERVATION).where(is_among(OBSERVATION.c.stall)), among).mappings():
        found[row["survey"]].append({**row, "stall": stalls[row["stall"]]})
    connection.execute(delete(OBSERVATION).where(is_among(OBSERVATION.c.stall)), among)
    connection.execute(delete(FORMER).where(is_among(FORMER.c.stall)), among)
    for survey, looks in found.items():
        asked = select(DOCUMENT.c.loose).where(DOCUMENT.c.survey == survey)
        if (loose := connection.execute(asked).scalar()) is not None:
            _keep_loose(connection, survey, [*json.loads(loose), *looks])
    keep_looks(connection, found)


def tie(connection: Connection, stalls: Collection[str]) -> None:
    """Bring loose looks at stalls, by id, into the table."""
    keys = keys_of(connection, stalls)
    waiting = select(DOCUMENT.c.survey, DOCUMENT.c.loose).where(DOCUMENT.c.loose != text("'[]'"))
    for survey, loose in connection.execute(waiting).all():
        looks = json.loads(loose)
        known = [look for look in looks if look["stall"] in keys]
        if known:
            observe(connection, survey, known, keys)
            _keep_loose(connection, survey, [look for look in looks if look["stall"] not in keys])
            keep_looks(connection, [survey])


def observe(connection: Connection, survey: int, looks: Iterable[_Values], keys: Mapping[str, int]) -> None:
    """Store looks of a survey at stalls, by their ids. ``keys``: id of a stall -> its key."""
    rows = [{**look, "survey": survey, "stall": keys[look["stall"]]} for look in looks]
    if rows:
        connection.execute(insert(OBSERVATION), rows)


def loose_text(looks: Iterable[_Values]) -> str:
    """Return loose looks as the store keeps them, in the order of their stalls' ids."""
    kept = [{name: value for name, value in look.items() if name != "survey"} for look in looks]
    return json.dumps(sorted(kept, key=lambda look: str(look["stall"])), allow_nan=False, sort_keys=True)


def _keep_loose(connection: Connection, survey: int, looks: Iterable[_Values]) -> None:
    connection.execute(update(DOCUMENT).where(DOCUMENT.c.survey == survey).values(loose=loose_text(looks)))


def _store_former(connection: Connection, contest: _Contest) -> None:
    keys = keys_of(connection, contest.names)
    former = select(FORMER).where(is_among(FORMER.c.stall))
    there = connection.execute(former, {"among": json.dumps([*keys.values()])}).mappings()
    wanted = [
        {**row, "stall": keys[row["stall"]]}
        for part in contest.parts
        for row in contest.won([{**each.model_dump(), "lot": part.id} for each in part.former], "stall")
    ]
    sync(connection, FORMER, ("lot", "stall", "ends"), [dict(row) for row in there], wanted)


def _store_sections(connection: Connection, part: LotPart) -> None:
    """Write the sections of a lot: some versions of one may have the same key, so all are written where one differs."""
    wanted = _area_rows(part.sections, part.id)
    columns = [column for column in SECTION.c if column.name != "key"]
    rows = connection.execute(select(*columns).where(SECTION.c.lot == part.id)).mappings()
    if sorted(_text(dict(row)) for row in rows) != sorted(map(_text, wanted)):
        connection.execute(delete(SECTION).where(SECTION.c.lot == part.id))
        if wanted:
            connection.execute(insert(SECTION), wanted)


def _fit_layouts(connection: Connection, part: LotPart) -> None:
    """Let surveys of this store name layouts that the lot has: it may have fewer than before."""
    newest = max((each.version for each in part.layouts), default=None)
    is_beyond = (SURVEY.c.lot == part.id) & (SURVEY.c.layout > newest) & SURVEY.c.seq.not_in(select(DOCUMENT.c.survey))
    connection.execute(update(SURVEY).where(is_beyond).values(layout=newest))


def _text(row: _Values) -> str:
    return json.dumps(row, sort_keys=True)

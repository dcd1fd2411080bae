"""Plans of lots as JSON values: all of a plan, its changes since a revision, and the plan of an earlier layout."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any, Final

from sqlalchemy import Connection, Row, RowMapping, select

from hawk.lots.answers import Layout
from hawk.lots.change_log import rows_touched, unpacked
from hawk.lots.plan import revisions
from hawk.lots.plan.queries import COLUMNS, all_stalls, named_zones, stalls_in, zones_of
from hawk.lots.plan.values import LASTING, PlanStall, Zone
from hawk.lots.plan.versions import edit_of
from hawk.lots.rows import is_among
from hawk.lots.schema import CHANGE, FORMER, LAYOUT, STALL
from hawk.lots.values import NotFoundError, moment, utc

_TOUCHED: Final = (
    select(*(STALL.c[name] for name in COLUMNS), STALL.c.ends).where(is_among(STALL.c.key)).order_by(STALL.c.key)
)


def plan(connection: Connection, lot: str, since: int | None = None) -> dict[str, Any]:
    """Return the plan: all of it, or the stalls that changed after a revision; ``whole`` says which.

    ``gone``: ids of stalls that are no part of the plan any more.
    """
    revision = revisions.revision_of(connection, lot)
    shown: dict[str, Any] = {"lot": lot, "revision": revision, "edit": edit_json(connection, lot)}
    if since is None or since < revisions.whole_since(connection, lot) or since > revision:
        stalls = [stall_json(each) for each in all_stalls(connection, lot)]
        shown |= {"whole": True, "stalls": stalls, "gone": []}
    else:
        steps = select(CHANGE.c.body).where(CHANGE.c.lot == lot, CHANGE.c.revision > since)
        bodies = connection.execute(steps).scalars()
        keys = rows_touched([group for body in bodies for group in unpacked(body)], STALL.name)
        shown |= {"whole": False, **touched_json(connection, keys)}
    return {**shown, **all_zones_json(connection, lot)}


def plan_of(connection: Connection, lot: str, version: int) -> dict[str, Any]:
    """Return the plan as a version of the layout has it. Raises NotFoundError."""
    is_there = select(LAYOUT.c.version).where(LAYOUT.c.lot == lot, LAYOUT.c.version == version)
    if connection.execute(is_there).scalar() is None:
        raise NotFoundError(f"layout: there is no version {version}; read the lot again")
    stalls = stalls_in(connection, lot, version)
    asked = select(FORMER).where(FORMER.c.lot == lot, FORMER.c.ends > version).order_by(FORMER.c.ends.desc())
    former = {row["stall"]: row for row in connection.execute(asked).mappings()}  # that of the smallest `ends` is last
    shown = [stall_json(each, former.get(each.key)) for each in stalls]
    return {"lot": lot, "layout": version, "stalls": shown, **all_zones_json(connection, lot, version)}


def touched_json(connection: Connection, keys: Sequence[int | str]) -> dict[str, Any]:
    """Return stalls of some keys: ``stalls`` of the plan as they are, and the ids of those that are ``gone``."""
    rows = connection.execute(_TOUCHED, {"among": json.dumps(keys)}).all()
    stalls = [stall_json(PlanStall(*row[:-1])) for row in rows if row.ends is None]
    return {"stalls": stalls, "gone": [row.id for row in rows if row.ends is not None]}


def stall_json(stall: PlanStall, former: RowMapping | None = None) -> dict[str, Any]:
    """Return a stall, with what a row of the table of former stalls says otherwise."""
    if former is None:
        return {"id": stall.id} | {name: getattr(stall, name) for name in LASTING}
    return {"id": stall.id} | {name: former[name] for name in LASTING}


def all_zones_json(connection: Connection, lot: str, version: int | None = None) -> dict[str, Any]:
    """Return ``zones``, the areas without stalls, and ``named_zones``, of the plan or of a version of the layout."""
    named = named_zones(connection, lot, version)
    return {"zones": zones_json(zones_of(connection, lot, version)), "named_zones": zones_json(named)}


def zones_json(zones: Sequence[Zone]) -> list[dict[str, Any]]:
    """Return areas without stalls, or zones with a name."""
    return [
        {"id": zone.id, "name": zone.name, "kind": zone.kind, "outline": [list(corner) for corner in zone.outline]}
        for zone in zones
    ]


def edit_json(connection: Connection, lot: str) -> dict[str, Any] | None:
    """Return who edits the plan, since when and until when last, with the version that it makes; None for nobody.

    Its id is not shown: who has it may write.
    """
    edit = edit_of(connection, lot)
    if edit is None:
        return None
    return {"who": edit.who, "since": utc(edit.began), "last": utc(edit.touched), "layout": edit.version}


def layout_of(row: Row[Any]) -> Layout:
    """Return a version of a layout: when, by whom and why it began."""
    return Layout(version=row.version, valid_from=moment(row.valid_from), who=row.who, why=row.why)

"""Plans of lots as answers: all of a plan, its changes since a revision, and the plan of an earlier layout."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any, Final

from sqlalchemy import Connection, Row, select

from hawk.lots.answers import Edit, Layout
from hawk.lots.change_log import Group, rows_touched, unpacked
from hawk.lots.plan import versions
from hawk.lots.plan.answers import Plan, PlanChanges
from hawk.lots.plan.queries import COLUMNS, all_stalls, named_zones, sections_of, stalls_in, zones_of
from hawk.lots.plan.values import LayoutStall, PlanStall
from hawk.lots.plan.versions import edit_of
from hawk.lots.registration.survey_place import datum_of
from hawk.lots.storage.rows import is_among
from hawk.lots.storage.schema import CHANGE, LAYOUT, STALL
from hawk.lots.values import NotFoundError, moment

_TOUCHED: Final = (
    select(*(STALL.c[name] for name in COLUMNS), STALL.c.ends).where(is_among(STALL.c.key)).order_by(STALL.c.key)
)


def plan(connection: Connection, lot: str, since: int | None = None) -> Plan:
    """Return the plan: all of it, or the stalls that changed after a revision; ``whole`` says which."""
    revision = versions.revision_of(connection, lot)
    is_whole = since is None or since < versions.whole_since(connection, lot) or since > revision
    if is_whole:
        changes = _changes(connection, lot, all_stalls(connection, lot))
    else:
        steps = select(CHANGE.c.body).where(CHANGE.c.lot == lot, CHANGE.c.revision > since)
        bodies = connection.execute(steps).scalars()
        changes = changes_of(connection, lot, [group for body in bodies for group in unpacked(body)])
    return Plan(
        **dict(changes), lot=lot, datum=list(datum_of(connection, lot)), layout=None, revision=revision,
        edit=shown_edit(connection, lot), whole=is_whole,
    )  # fmt: skip


def plan_of(connection: Connection, lot: str, version: int) -> Plan:
    """Return the plan as a version of the layout has it. Raises NotFoundError."""
    is_there = select(LAYOUT.c.version).where(LAYOUT.c.lot == lot, LAYOUT.c.version == version)
    if connection.execute(is_there).scalar() is None:
        raise NotFoundError(f"layout: there is no version {version}; read the lot again")
    changes = _changes(connection, lot, stalls_in(connection, lot, version), version=version)
    return Plan(
        **dict(changes), lot=lot, datum=list(datum_of(connection, lot)),
        layout=version, revision=None, edit=None, whole=True,
    )  # fmt: skip


def changes_of(connection: Connection, lot: str, groups: Sequence[Group]) -> PlanChanges:
    """Return the stalls of a plan that some changes touched, as they are."""
    among = json.dumps(rows_touched(groups, STALL.name))
    rows = connection.execute(_TOUCHED, {"among": among}).all()
    stalls = [LayoutStall(*row[:-1]) for row in rows if row.ends is None]
    return _changes(connection, lot, stalls, [row.id for row in rows if row.ends is not None])


def _changes(
    connection: Connection, lot: str, stalls: Sequence[PlanStall], gone: Sequence[str] = (), version: int | None = None
) -> PlanChanges:
    """Return stalls of a plan, or of a version of the layout, with all its zones and sections."""
    zones, named = zones_of(connection, lot, version), named_zones(connection, lot, version)
    return PlanChanges(
        zones=zones, named_zones=named, sections=list(sections_of(connection, lot, version)), stalls=list(stalls),
        gone=list(gone),
    )  # fmt: skip


def shown_edit(connection: Connection, lot: str) -> Edit | None:
    """Return who edits the plan, since when and until when last, with the version that it makes; None for nobody.

    Its id is not shown: who has it may write.
    """
    edit = edit_of(connection, lot)
    if edit is None:
        return None
    return Edit(who=edit.who, since=moment(edit.began), last=moment(edit.touched), layout=edit.version)


def layout_of(row: Row[Any]) -> Layout:
    """Return a version of a layout: when, by whom and why it began."""
    return Layout(version=row.version, valid_from=moment(row.valid_from), who=row.who, why=row.why)

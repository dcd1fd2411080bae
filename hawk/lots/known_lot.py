"""The lot about a place as the store knows it, for the map of a flight."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Collection, Iterator, Sequence
from typing import Final

import numpy as np
import shapely
from shapely import Polygon
from shapely.geometry.base import BaseGeometry
from sqlalchemy import Connection, func, select

from hawk.lots.names import schedule_names
from hawk.lots.plan.edits import KIND as OF_AN_EDIT
from hawk.lots.plan.queries import all_stalls, in_plan, private_zones, sections_of
from hawk.lots.plan.sections import axis_of
from hawk.lots.plan.values import LayoutSection
from hawk.lots.plan.versions import newest_layout, revision_of
from hawk.lots.registration.frames import Move, frame_of
from hawk.lots.registration.georeference import ground_about
from hawk.lots.registration.survey_place import datum_of, known_ground
from hawk.lots.storage.outlines import outline_of
from hawk.lots.storage.rows import is_among
from hawk.lots.storage.schema import CHANGE, EDIT, LOT, SECTION, STALL, SURVEY
from hawk.lots.survey.order import last_of, ordered_at
from hawk.lots.survey.private_ground import ERROR_M, rings_in
from hawk.model.known_lot import AGAIN_M, KnownLot, KnownStall, LotAhead
from hawk.model.plans import Outline
from hawk.model.poses import Ring

NEAR_M: Final = 60.0
"""A drone that stands nearer than this to a lot is about to fly over it."""

PLACE_M: Final = 5.0
"""Longest side of the places that cover a section: as large as a stall, one picture shows each whole."""

Stamp = tuple[str, int, int]
"""Id of a lot, the newest version of its layout, and the revision of its plan: another one is another plan."""
Due = Callable[[str, str, float | None], bool]
"""Returns whether a survey of a lot is due, by its id, its name and the end of its newest survey, Unix seconds."""


def lots_flown(
    connection: Connection, place: tuple[float, float], again: Sequence[str] = ()
) -> list[tuple[Stamp, str]]:
    """Return stamp and name of each of the lots with the ids ``again`` that are there; without one those of the lot at
    a place (latitude, longitude), or of the nearest one within `NEAR_M`.
    """
    rows = connection.execute(select(LOT).where(LOT.c.merged_into.is_(None)).order_by(LOT.c.made)).mappings().all()
    by_id = {str(row["id"]): row for row in rows}
    found = [by_id[each] for each in again if each in by_id]
    if not found:
        here = shapely.Point(0.0, 0.0)
        away = [(float(ground_about(place, outline_of(row["outline"])).distance(here)), row) for row in rows]
        found = [row for metres, row in sorted(away, key=lambda each: each[0])[:1] if metres <= NEAR_M]
    return [(_stamp(connection, str(row["id"])), str(row["name"])) for row in found]


def lots_of_stalls(connection: Connection, stalls: Collection[str]) -> dict[str, str]:
    """Return the lot of each stall that the store has, by their ids."""
    asked = select(STALL.c.id, STALL.c.lot).where(is_among(STALL.c.id))
    return {str(stall): str(lot) for stall, lot in connection.execute(asked, {"among": json.dumps([*stalls])})}


def _stamp(connection: Connection, lot: str) -> Stamp:
    return lot, newest_layout(connection, lot), revision_of(connection, lot)


def newest_survey(connection: Connection, lot: str) -> tuple[str, str, float | None] | None:
    """Return id and name of the lot with an id or name, and the end of its newest survey, Unix seconds; None: no such
    lot, or more than one.

    Pictures whose time is not sure count as no survey.
    """
    is_named = ((LOT.c.id == lot) | (LOT.c.name == lot)) & LOT.c.merged_into.is_(None)
    rows = connection.execute(select(LOT.c.id, LOT.c.name).where(is_named).limit(2)).all()
    if len(rows) != 1:
        return None
    (row,) = rows
    taken = select(ordered_at()).where(
        SURVEY.c.seq == select(last_of(LOT.c.id)).where(LOT.c.id == row.id).scalar_subquery()
    )
    return str(row.id), str(row.name), connection.execute(taken).scalar()


def last_author(connection: Connection, lot: str) -> str:
    """Return the name of the person whose edit of a lot's plan is the newest change of the store; "" where another
    change is: of its maker the store keeps a role.
    """
    edits = select(EDIT.c.who, EDIT.c.touched).where(EDIT.c.lot == lot).order_by(EDIT.c.touched.desc())
    newest = connection.execute(edits).first()
    is_other = CHANGE.c.edit.is_(None) & ((CHANGE.c.kind != OF_AN_EDIT) | CHANGE.c.undone.is_not(None))
    moment = func.max(func.coalesce(CHANGE.c.undone, CHANGE.c.made))
    other = connection.execute(select(moment).where(is_other)).scalar()
    return "" if newest is None or (other is not None and other > newest.touched) else str(newest.who)


def lots_ahead(
    connection: Connection,
    place: tuple[float, float] | None,
    is_due: Due = lambda *_: False,
    named: Collection[str] | None = None,
) -> tuple[LotAhead, ...]:
    """Return all lots with ground, with their distances from a place (latitude, longitude).

    Without a place each lot counts as near. ``named``: those with these ids or names alone.
    """
    wanted = select(LOT).where(LOT.c.merged_into.is_(None)).order_by(LOT.c.made)
    if named is not None:
        wanted = wanted.where(LOT.c.id.in_(named) | LOT.c.name.in_(named))
    here, found = shapely.Point(0.0, 0.0), []
    rows = connection.execute(wanted).mappings().all()
    called = schedule_names(connection, [row["name"] for row in rows])
    for row in rows:
        outline = outline_of(row["outline"])
        if not outline.polygons:
            continue
        away = 0.0 if place is None else float(ground_about(place, outline).distance(here))
        stalls, sections = (
            int(connection.execute(select(func.count()).where(in_plan(table.c, row["id"]))).scalar_one())
            for table in (STALL, SECTION)
        )
        is_near, name = away <= AGAIN_M, str(row["name"])
        newest = newest_survey(connection, row["id"]) if is_near else None
        due = newest is not None and is_due(row["id"], called[row["name"]], newest[2])
        found.append(LotAhead(str(row["id"]), name, stalls, away, outline if is_near else Outline(), due, sections))
    return tuple(found)


def known_lot(connection: Connection, lot: str, datum: tuple[float, float], survey: str = "") -> KnownLot:
    """Return the plan of a lot in the frame about a datum (latitude, longitude), as a receiver would place it.

    Stalls that nobody confirmed and that only the survey of this name (that of its journal) has found are left out: it
    is no witness of itself.
    """
    frame = frame_of(datum, datum_of(connection, lot))
    own = _found_by(connection, lot, survey)
    stalls = [stall for stall in all_stalls(connection, lot) if stall.is_confirmed or stall.key not in own]
    places = frame.of(np.array([(stall.north, stall.east) for stall in stalls]).reshape(-1, 2)).tolist()
    return KnownLot(
        lot,
        tuple(
            KnownStall(
                stall.id, north, east, (stall.angle + frame.turn) % np.pi, stall.width, stall.length,
                stall.is_confirmed, stall.label,
            )
            for stall, (north, east) in zip(stalls, places, strict=True)
        ),
        _pieces(frame.ground(known_ground(connection, lot))),
        tuple(place for section in sections_of(connection, lot) for place in _section_places(section, frame)),
    )  # fmt: skip


def _section_places(section: LayoutSection, frame: Move) -> Iterator[KnownStall]:
    """Yield places that cover a section, in the frame of a flight; ids are the section's with a number."""
    area = shapely.Polygon(section.outline) if len(section.outline) > 2 else shapely.Polygon()
    if not area.is_valid or area.is_empty:
        return  # damaged on the disk: its counts say so
    axis = np.array(axis_of(section.outline))
    along = (axis[1] - axis[0]) / np.hypot(*(axis[1] - axis[0]))
    to_axis = np.array([along, (-along[1], along[0])])
    low, high = (bound(np.array(section.outline) @ to_axis.T, axis=0) for bound in (np.min, np.max))
    count = np.maximum(np.ceil((high - low) / PLACE_M), 1).astype(int)
    length, width = ((high - low) / count).tolist()
    middles = (low + (np.indices(count).reshape(2, -1).T + 0.5) * (length, width)) @ to_axis
    corners = np.array([(a, b) for a, b in ((1, 1), (1, -1), (-1, -1), (-1, 1))]) * (length / 2, width / 2) @ to_axis
    is_part = shapely.intersects(shapely.polygons(middles[:, None] + corners), area)
    angle = (math.atan2(along[1], along[0]) + frame.turn) % np.pi
    for number, (north, east) in enumerate(frame.of(middles[is_part]).tolist(), 1):
        yield KnownStall(f"{section.id} {number}", north, east, angle, width, length)


def private_ground(connection: Connection, lot: str, datum: tuple[float, float]) -> tuple[Ring, ...]:
    """Return the rings of a lot's ground that nobody may look at, metres (north, east) about a datum (latitude,
    longitude), as a receiver would place it.
    """
    return rings_in(frame_of(datum, datum_of(connection, lot)), private_zones(connection, lot), ERROR_M)


def _found_by(connection: Connection, lot: str, survey: str) -> set[int]:
    """Return the keys of a lot's stalls that the survey of this name has found first."""
    if not survey:
        return set()
    named = select(SURVEY.c.seq).where(SURVEY.c.lot == lot, SURVEY.c.origin.startswith(f"{survey} ", autoescape=True))
    mine = select(STALL.c.key).where(STALL.c.lot == lot, STALL.c.first_survey.in_(named))
    return set(connection.execute(mine).scalars())


def _pieces(ground: BaseGeometry) -> tuple[tuple[tuple[tuple[float, float], ...], ...], ...]:
    parts = [part for part in shapely.get_parts(ground) if isinstance(part, Polygon) and not part.is_empty]
    return tuple(
        tuple(tuple((float(a), float(b)) for a, b in ring.coords[:-1]) for ring in (part.exterior, *part.interiors))
        for part in parts
    )

"""Looks of surveys at the sections of their lots, made from the vehicles or the stalls that the surveys keep.

They follow from other rows, and are made again whenever a survey is stored or placed, or a section begins or changes. A
survey, or a section, that is damaged is passed over.
"""

from __future__ import annotations

import json
import logging
from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence
from dataclasses import asdict
from typing import Any, Final

import numpy as np
import shapely
from sqlalchemy import Connection, Row, RowMapping, delete, insert, select

from hawk.lots.plan.queries import in_plan, private_zones, sections_of
from hawk.lots.plan.values import Floats, LayoutSection, shapes_of
from hawk.lots.registration.frames import Move, frame_of
from hawk.lots.registration.georeference import ground_about
from hawk.lots.registration.survey_place import datum_of
from hawk.lots.storage.digests import is_damaged
from hawk.lots.storage.outlines import outline_of, unpack_outline
from hawk.lots.storage.rows import is_among
from hawk.lots.storage.schema import DOCUMENT, SECTION, SECTION_LOOK, STALL, SURVEY
from hawk.lots.storage.tables import unpack_stalls, unpack_vehicles
from hawk.lots.survey.section_counts import SeenGround, Source, count_of
from hawk.lots.survey.vehicle_places import may_be_seen
from hawk.lots.values import PLACED, LotStoreError, Placed
from hawk.model.lot_map import StallState
from hawk.model.poses import Ring

_READ: Final = (
    "seq", "lot", "placed", "latitude", "longitude", "north", "east", "turn", "ended", "outline", "seen_ground",
    "stalls", "vehicles",
)  # fmt: skip
_ASKED: Final = select(*(SURVEY.c[name] for name in _READ)).order_by(SURVEY.c.seq)
_TOUCHED: Final = select(*(SECTION.c[name] for name in ("id", "lot", "ends", "outline", "kind", "capacity"))).where(
    is_among(SECTION.c.key)
)
_LOG = logging.getLogger(__name__)


def renew(connection: Connection, surveys: Collection[int] = (), sections: Collection[int] = ()) -> None:
    """Make the looks of surveys, by number, and the looks at sections, by key, again."""
    _renew_surveys(connection, surveys)
    if not sections:
        return
    rows = connection.execute(_TOUCHED, {"among": json.dumps([*sections])}).all()
    changed = {row.id for row in rows} - _as_before(connection, rows)
    connection.execute(delete(SECTION_LOOK).where(is_among(SECTION_LOOK.c.section)), {"among": json.dumps([*changed])})
    for lot in {touched.lot for touched in rows if touched.id in changed}:
        present = [each for each in sections_of(connection, lot) if each.id in changed]
        of_lot = connection.execute(_ASKED.where(SURVEY.c.lot == lot)).mappings().all() if present else ()
        for row in of_lot:
            _keep(connection, row, present)


def _as_before(connection: Connection, rows: Sequence[Row[Any]]) -> set[str]:
    """Return the ids of sections whose looks stay: they end and begin with all that a count follows from, as with
    another name. ``rows``: as of `_TOUCHED`.
    """
    versions: dict[str, list[Row[Any]]] = defaultdict(list)
    for row in rows:
        versions[row.id].append(row)
    alike = {
        section for section, each in versions.items()
        if len(each) > 1 and len({tuple(row[3:]) for row in each}) == 1 and None in [row.ends for row in each]
    }  # fmt: skip
    asked = select(SECTION_LOOK.c.section).where(is_among(SECTION_LOOK.c.section)).distinct()
    return {*connection.execute(asked, {"among": json.dumps([*alike])}).scalars()}


def _renew_surveys(connection: Connection, surveys: Collection[int]) -> None:
    came = select(DOCUMENT.c.survey).where(is_among(DOCUMENT.c.survey))
    documents = {*connection.execute(came, {"among": json.dumps([*surveys])}).scalars()}
    for seq in surveys:
        if seq in documents:  # its counts come with it: its vehicles do not
            continue
        connection.execute(delete(SECTION_LOOK).where(SECTION_LOOK.c.survey == seq))
        row = connection.execute(_ASKED.where(SURVEY.c.seq == seq)).mappings().first()
        if row is not None and row["lot"] is not None:
            _keep(connection, row, sections_of(connection, row["lot"]))


def _keep(connection: Connection, row: RowMapping, sections: Sequence[LayoutSection]) -> None:
    """Store what a survey saw of sections of its lot."""
    whole = [each for each in sections if each.outline and shapely.Polygon(each.outline).is_valid]
    move = move_of_survey(connection, row) if whole else None
    if move is None or is_damaged(connection, "survey", row["seq"]) or is_damaged(connection, "lot", row["lot"]):
        return
    try:
        seen = _seen(row, move, private_zones(connection, row["lot"]))
    except LotStoreError as error:
        _LOG.warning("survey %s is passed over: %s", row["seq"], error)
        return
    looks = [look for each in whole if (look := _look(row, seen, each)) is not None]
    if looks:
        connection.execute(insert(SECTION_LOOK).prefix_with("OR REPLACE"), looks)


def move_of_survey(connection: Connection, row: Mapping[str, Any] | RowMapping) -> Move | None:
    """Return the move that brings a survey onto its lot's frame; None where it is not known.

    In a lot without stalls no survey can be registered: its receiver says where it lies.
    """
    if row["placed"] in PLACED and row["north"] is not None:
        return Move.stored(row)
    stalls = select(STALL.c.key).where(in_plan(STALL.c, row["lot"])).limit(1)
    if row["placed"] != Placed.UNREGISTERED or connection.execute(stalls).first() is not None:
        return None
    return frame_of(datum_of(connection, row["lot"]), (row["latitude"], row["longitude"]))


def _seen(row: RowMapping, move: Move, private: Sequence[Ring]) -> SeenGround:
    """Return what a survey saw beside ``private`` rings. Raises LotStoreError."""
    stalls, vehicles = unpack_stalls(row["stalls"]), unpack_vehicles(row["vehicles"])
    taken = [each for each in stalls if each.state is StallState.TAKEN]
    unknown = [each for each in stalls if each.state is StallState.UNKNOWN]
    if vehicles is None:
        shapes, found = shapes_of(taken), [(each.taken_probability, each.looked_at) for each in taken]
    else:
        shapes, found = shapes_of(vehicles), [(each.probability, each.looked_at) for each in vehicles]
    outline = unpack_outline(row["seen_ground"])
    if not outline.polygons:
        outline = outline_of(row["outline"])
    ground = move.ground(ground_about((row["latitude"], row["longitude"]), outline))
    shapes, values = moved_shapes(shapes, move), np.array(found, np.float64).reshape(-1, 2)
    is_shown = may_be_seen(shapes, private)
    source: Source = "stalls" if vehicles is None else "vehicles"
    unsure = moved_shapes(shapes_of(unknown), move)
    return SeenGround(source, shapes[is_shown], values[is_shown, 0], values[is_shown, 1], unsure, ground)


def moved_shapes(shapes: Floats, move: Move) -> Floats:
    """Return shapes (N, 5) after a move."""
    found = shapes.copy()
    found[:, :2] = move.of(shapes[:, :2])
    found[:, 2] += move.turn
    return found


def _look(row: RowMapping, seen: SeenGround, section: LayoutSection) -> dict[str, Any] | None:
    """Return the row of a survey's look at a section; None where it saw next to nothing of it."""
    sight = seen.sight_of(section)
    if sight is None:
        return None
    shares = {"hidden_share": round(sight.hidden_share, 4), "seen_share": round(sight.seen_share, 4)}
    looked_at = float(row["ended"]) if sight.looked_at is None else sight.looked_at
    named = {"survey": row["seq"], "section": section.id, "looked_at": looked_at, "source": sight.source}
    return {**named, **asdict(count_of(section, sight)), **shares}

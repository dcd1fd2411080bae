"""Ground of a lot that nobody may look at, in the frame of a survey: its picture is stored and shown without it."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Final

import numpy as np
import shapely
from sqlalchemy import Connection, RowMapping, select

from hawk.lots.plan.queries import private_zones
from hawk.lots.plan.values import PRIVATE
from hawk.lots.registration.frames import Move, frame_of
from hawk.lots.registration.georeference import ring_on_earth
from hawk.lots.registration.survey_place import datum_of
from hawk.lots.storage.schema import LOT, SURVEY, ZONE
from hawk.lots.survey.section_looks import move_of_survey
from hawk.model.poses import Ring

ERROR_M: Final = 5.0
"""Error of a receiver's place without corrections, by which private ground is taken as wider."""
PLACED_M: Final = 0.5
"""The same where a survey's place among the stalls of its lot is known."""


def rings_in(move: Move, zones: Sequence[Ring], wider: float) -> tuple[Ring, ...]:
    """Return rings after a move, wider by metres; areas that touch are one."""
    grounds = [shapely.make_valid(shapely.Polygon(move.of(np.array(ring, np.float64)))) for ring in zones if ring]
    whole = shapely.union_all([ground.buffer(wider, join_style="mitre") for ground in grounds]) if grounds else None
    parts = () if whole is None else shapely.get_parts(whole)
    return tuple(tuple((float(n), float(e)) for n, e in part.exterior.coords[:-1]) for part in parts if part.area > 0)


def hidden_in(connection: Connection, survey: str) -> tuple[Ring, ...]:
    """Return the rings that no picture of a survey shows, in its frame; those of every lot that it may be of."""
    row = connection.execute(select(SURVEY).where(SURVEY.c.id == survey)).mappings().first()
    if row is None:
        return ()
    lots = json.loads(row["candidates"]) if row["lot"] is None else [row["lot"]]
    return tuple(ring for lot in lots for ring in _of_lot(connection, row, str(lot)))


def private_areas(connection: Connection) -> tuple[shapely.Polygon, ...]:
    """Return the private ground of every lot that was not merged, (longitude, latitude), as its plan has it."""
    asked = select(LOT.c.id).where(LOT.c.merged_into.is_(None)).order_by(LOT.c.id)
    has_some = select(ZONE.c.lot).where(ZONE.c.kind == PRIVATE, ZONE.c.ends.is_(None))
    lots = connection.execute(asked.where(LOT.c.id.in_(has_some))).scalars()
    return tuple(
        shapely.Polygon([(longitude, latitude) for latitude, longitude in ring_on_earth(datum, np.array(ring))])
        for lot in lots
        for datum in [datum_of(connection, lot)]
        for ring in private_zones(connection, lot)
    )


def _of_lot(connection: Connection, row: RowMapping, lot: str) -> tuple[Ring, ...]:
    zones = private_zones(connection, lot)
    if not zones:
        return ()
    placed = None if row["lot"] is None or row["north"] is None else move_of_survey(connection, row)
    if placed is not None:
        return rings_in(_inverse(placed), zones, PLACED_M)
    here = (float(row["latitude"]), float(row["longitude"]))
    return rings_in(frame_of(here, datum_of(connection, lot)), zones, ERROR_M)


def _inverse(move: Move) -> Move:
    ((north, east),) = move.back(np.zeros((1, 2))).tolist()
    return Move(north, east, -move.turn)

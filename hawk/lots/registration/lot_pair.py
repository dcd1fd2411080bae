"""Lots on the same ground: those that were made apart, and the place of one's plan on the other's."""

from __future__ import annotations

from typing import Final

from sqlalchemy import Connection, select

from hawk.lots.answers import LotPair
from hawk.lots.plan.queries import all_stalls
from hawk.lots.plan.values import LayoutStall
from hawk.lots.registration.frames import Move, frame_of
from hawk.lots.registration.georeference import ground_about, shared_area
from hawk.lots.registration.lot_match import SAME_SHARE
from hawk.lots.registration.survey_place import datum_of, known_ground, move_of
from hawk.lots.storage.outlines import outline_of
from hawk.lots.storage.schema import LOT
from hawk.lots.values import Detection, KnownGround, MappedGround, Register, Registration
from hawk.model.lot_map import StallState

_NEAR_DEG: Final = 0.1
"""Degrees of latitude, 11 km, within which lots are compared: no lot is longer."""
_LEAST_M2: Final = 1.0


def pairs_of(connection: Connection, lot: str) -> list[LotPair]:
    """Return the lots that are on the ground of a lot, by `SAME_SHARE` at least, the most alike first."""
    here = connection.execute(select(LOT).where(LOT.c.id == lot)).mappings().one()
    centre = here["latitude"], here["longitude"]
    ground = ground_about(centre, outline_of(here["outline"]))
    is_near = LOT.c.latitude.between(centre[0] - _NEAR_DEG, centre[0] + _NEAR_DEG)
    asked = select(LOT.c.id, LOT.c.name, LOT.c.outline).where(is_near, LOT.c.merged_into.is_(None), LOT.c.id != lot)
    found = []
    for row in connection.execute(asked):
        other = ground_about(centre, outline_of(row.outline))
        smaller = min(ground.area, other.area)
        if smaller >= _LEAST_M2 and (share := shared_area(ground, other) / smaller) >= SAME_SHARE:
            found.append(LotPair(lot=row.id, name=row.name, share=round(min(share, 1.0), 3)))
    return sorted(found, key=lambda each: (-each.share, each.lot))


def move_onto(connection: Connection, kept: str, other: str, register: Register) -> Move | None:
    """Return the move that brings the frame of a lot onto that of another one, by the stalls of both plans.

    None where it is not certain.
    """
    frame = frame_of(datum_of(connection, kept), datum_of(connection, other))
    known = KnownGround(tuple(all_stalls(connection, kept)), known_ground(connection, kept, other))
    ground = frame.ground(known_ground(connection, other, kept))
    stalls = [_as_found(number, stall) for number, stall in enumerate(all_stalls(connection, other))]
    if known.seen.is_empty or ground.is_empty or not stalls:
        return None
    outcome = register(known, MappedGround(frame.stalls(stalls), ground))
    return move_of(outcome).after(frame) if isinstance(outcome, Registration) else None


def _as_found(number: int, stall: LayoutStall) -> Detection:
    """Return a stall of a plan as a survey would have found it."""
    return Detection(number, *stall.shape, 0.5, StallState.UNKNOWN, 1.0, 1, 0.0)

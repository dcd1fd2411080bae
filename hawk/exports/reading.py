"""A survey of the store as an export: the layout's stalls with that survey's looks, in WGS-84."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np
from sqlalchemy import Connection, RowMapping, select

from hawk.exports.values import UNSEEN, ExportedStall, ExportedSurvey, LatLon
from hawk.lots.plan.reading import stalls_in
from hawk.lots.plan.values import NEW, PlanStall
from hawk.lots.registering import datum_accuracy, datum_of
from hawk.lots.tables import LOT, OBSERVATION, STALL, SURVEY
from hawk.lots.values import PLACED, NotFoundError, SurveyStall, outline_of, unpack_stalls, utc
from hawk.model.lot_map import StallState
from hawk.model.poses import GlobalPose
from hawk.results.survey_map import to_global

NEWEST: Final = "newest"


def survey_of(connection: Connection, lot: str, given: str = NEWEST) -> str:
    """Return the id of a lot's survey by its id, or by the beginning of it; `NEWEST`: of the last that is registered.

    Raises NotFoundError.
    """
    asked = select(SURVEY.c.id, SURVEY.c.placed, SURVEY.c.ended).where(SURVEY.c.lot == lot).order_by(SURVEY.c.seq)
    rows = connection.execute(asked).all()
    if given == NEWEST:
        placed = [row.id for row in rows if row.placed in PLACED]
        if not placed:
            raise NotFoundError(f"--survey: none of the lot's {len(rows)} surveys is registered; give the id of one")
        return str(placed[-1])
    found = [row.id for row in rows if row.id.startswith(given)]
    if len(found) != 1:
        known = ", ".join(f"{row.id} of {utc(row.ended)}" for row in rows[-5:]) or "none"
        raise NotFoundError(f"--survey: {len(found)} surveys of this lot begin with {given!r}; the last are {known}")
    return str(found[0])


def surveys_of(connection: Connection, lot: str) -> list[str]:
    """Return the ids of a lot's registered surveys, in their order. Raises NotFoundError without any."""
    asked = select(SURVEY.c.id).where(SURVEY.c.lot == lot, SURVEY.c.placed.in_(PLACED)).order_by(SURVEY.c.seq)
    found = [str(each) for each in connection.execute(asked).scalars()]
    if not found:
        raise NotFoundError("--survey: none of the lot's surveys is registered; give the id of one")
    return found


def read_survey(connection: Connection, survey: str) -> ExportedSurvey:
    """Return a survey by its id.

    A registered one has the stalls of its layout, each with the look of that survey; another one has those that it
    found, where it found them. Raises NotFoundError.
    """
    row = connection.execute(select(SURVEY).where(SURVEY.c.id == survey)).mappings().one_or_none()
    if row is None or row["lot"] is None:
        raise NotFoundError(f"survey: there is no survey {survey} of a lot")
    lot = connection.execute(select(LOT).where(LOT.c.id == row["lot"])).mappings().one()
    is_placed = row["placed"] in PLACED
    datum = datum_of(connection, lot["id"]) if is_placed else (float(row["latitude"]), float(row["longitude"]))
    return ExportedSurvey(
        lot=str(lot["name"]),
        lot_id=str(lot["id"]),
        survey=str(row["id"]),
        began=float(row["began"]),
        ended=float(row["ended"]),
        time_is_sure=bool(row["time_is_sure"]),
        layout=row["layout"] if is_placed else None,
        software=f"hawk-drone {row['program']}",
        is_simulated=bool(row["simulated"]),
        accuracy=_accuracy(connection, lot, row, is_placed=is_placed),
        is_pinned=is_placed and bool(lot["datum_is_pinned"]),
        origin=datum,
        outline=outline_of(lot["outline"]),
        stalls=_registered(connection, row, datum) if is_placed else _found(row, datum),
        doubt="" if is_placed else f"{row['placed']}: its place among the lot's stalls is not certain",
    )


def _accuracy(
    connection: Connection, lot: RowMapping, survey: Mapping[str, Any] | RowMapping, *, is_placed: bool
) -> float | None:
    if not is_placed:
        return None if survey["accuracy"] is None else float(survey["accuracy"])
    return None if lot["datum_is_pinned"] else datum_accuracy(connection, str(lot["id"]))


def _registered(connection: Connection, survey: RowMapping, datum: LatLon) -> tuple[ExportedStall, ...]:
    looks = {
        str(look["id"]): look
        for look in connection.execute(
            select(STALL.c.id, OBSERVATION).join(STALL, STALL.c.key == OBSERVATION.c.stall)
            .where(OBSERVATION.c.survey == survey["seq"])
        ).mappings()
    }  # fmt: skip
    stalls = stalls_in(connection, str(survey["lot"]), int(survey["layout"]))
    return tuple(
        _exported(stall, place, corners, looks.get(stall.id))
        for stall, (place, corners) in zip(stalls, _on_earth(datum, stalls), strict=True)
    )


def _found(survey: RowMapping, datum: LatLon) -> tuple[ExportedStall, ...]:
    """Return the stalls as the survey found them, in its own frame, with its own numbers."""
    found = [stall for stall in unpack_stalls(survey["stalls"]) if not stall.is_extra]
    stalls = [_alone(stall) for stall in found]
    looks = [
        {"state": stall.state.value, "taken": stall.taken, "looked": stall.looked, "seen": stall.seen}
        for stall in found
    ]
    return tuple(
        _exported(stall, place, corners, look)
        for stall, look, (place, corners) in zip(stalls, looks, _on_earth(datum, stalls), strict=True)
    )


def _alone(stall: SurveyStall) -> PlanStall:
    return PlanStall(NEW, str(stall.id), "", stall.north, stall.east, stall.angle, stall.width, stall.length)


def _exported(
    stall: PlanStall, place: LatLon, corners: tuple[LatLon, ...], look: Mapping[str, Any] | RowMapping | None
) -> ExportedStall:
    state = UNSEEN if look is None or look["state"] not in (StallState.FREE, StallState.TAKEN) else str(look["state"])
    return ExportedStall(
        id=stall.id,
        label=stall.label,
        kind=stall.kind,
        state=state,
        taken=None if look is None else float(look["taken"]),
        looked=None if look is None else float(look["looked"]),
        seen=0 if look is None else int(look["seen"]),
        place=place,
        corners=corners,
        width=stall.width,
        length=stall.length,
        direction=math.degrees(stall.angle) % 180.0,
        is_confirmed=stall.is_confirmed,
    )


def _on_earth(datum: LatLon, stalls: Sequence[PlanStall]) -> list[tuple[LatLon, tuple[LatLon, ...]]]:
    """Return middle and corners of stalls, counter-clockwise as seen from above."""
    if not stalls:
        return []
    middles = np.array([(stall.north, stall.east) for stall in stalls])
    angle = np.array([stall.angle for stall in stalls])
    half = np.array([(stall.length / 2, stall.width / 2) for stall in stalls])
    along = np.column_stack([np.cos(angle), np.sin(angle)]) * half[:, :1]
    right = np.column_stack([-np.sin(angle), np.cos(angle)]) * half[:, 1:]
    around = [middles + a * along + b * right for a, b in ((1, 1), (1, -1), (-1, -1), (-1, 1))]
    places = to_global(GlobalPose(*datum, 0.0), np.stack([middles, *around], axis=1).reshape(-1, 2))
    grouped = places.reshape(-1, 5, 2).tolist()
    return [((m[0], m[1]), tuple((a, b) for a, b in corners)) for m, *corners in grouped]

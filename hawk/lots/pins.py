"""Pins a lot to its place on Earth: a person says where one or two points of it really are.

One point shifts the lot. Two also turn it; its size stays, and what the points say of it is reported. The lot's frame
is always about its datum, north up: a turn changes the coordinates of all that is in it, as one version of the layout.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, Final

import numpy as np
from sqlalchemy import Connection, select

from hawk.lots import change_log
from hawk.lots.answers import Done
from hawk.lots.change_log import Change
from hawk.lots.operations import layout_row, placed
from hawk.lots.plan.versions import check_not_edited, newest_layout, read_again
from hawk.lots.registration.frames import Floats, Move, frame_of
from hawk.lots.registration.georeference import about, on_earth, ring_on_earth
from hawk.lots.registration.survey_place import Doubt, datum_of, mean_datum
from hawk.lots.storage.outlines import outline_json, outline_to_change, ring_of
from hawk.lots.storage.rows import Row, rows_where
from hawk.lots.storage.schema import DROPPED, FORMER, LOT, PIN, SECTION, STALL, SURVEY, ZONE
from hawk.lots.values import LotInputError, PossiblePlace, check_fields, checked_degrees
from hawk.model.plans import Outline

KIND: Final = "pin"
FARTHEST_M: Final = 30.0
"""A receiver that is farther off is broken, or the points are those of another lot."""
STEEPEST: Final = math.radians(10.0)
"""The same for a compass."""
LEAST_APART_M: Final = 10.0
"""Of points nearer to each other, half a metre of error is 3 degrees."""
_LOT_M: Final = 20_000.0
"""Places farther from the datum do not belong to the lot."""
_ALIKE: Final = 1e-9
"""Radians that are no turn."""


@dataclass(frozen=True, slots=True)
class PointFit:
    """``move``: of the lot about its former datum. ``residual``: metres by which the points are farther apart than the
    lot has them, 0 for one point.
    """

    move: Move
    residual: float


def pin(connection: Connection, lot: str, asked: Mapping[str, Any], who: str, now: float) -> tuple[Done, PointFit]:
    """Pin a lot by ``points``; without any, it is unpinned: its datum is the mean of its surveys again.

    Raises LotInputError, and BeingEditedError while a person edits the plan.
    """
    check_not_edited(connection, lot)
    check_fields(asked, ("points",))
    datum = datum_of(connection, lot)
    points = _points(asked.get("points"), datum)
    turned = _turn_of(connection, lot)
    if points:
        pinned = fitted(points)
        new = _place(datum, pinned.move)
        move = Move(turn=pinned.move.turn)
    else:
        new = mean_datum(connection, lot)
        pinned = PointFit(replace(frame_of(datum, new), turn=-turned), 0.0)
        move = Move(turn=-turned)
    (lot_row,) = rows_where(connection, LOT, id=lot)
    outline = _outline(lot_row, datum, pinned.move)
    place = {"latitude": new[0], "longitude": new[1], "datum_is_pinned": bool(points), "outline": outline}
    rows = [lot_row.setting(**place)]
    if abs(move.turn) > _ALIKE:
        rows += _turned(connection, lot, move, who, now)
        rows.append(Row(PIN.name, (lot,), {"lot": lot, "turn": turned + move.turn}))
    done = change_log.write(connection, Change(KIND, lot, tuple(rows)), who, now)
    read_again(connection, lot)
    return done, pinned


def fitted(points: Sequence[tuple[Floats, Floats]]) -> PointFit:
    """Return the rigid move that brings points (2,) to where they really are, both (north, east) about the datum.

    The turn and the middle of two points are met, which is the least-squares rigid fit. Raises LotInputError.
    """
    here, there = (np.array([point[k] for point in points]) for k in (0, 1))
    away = np.hypot(*(there - here).T)
    if away.max() > FARTHEST_M:
        words = f"is {away.max():.0f} m from where the lot has it, 30 m is the most: mark the same point twice"
        raise LotInputError(f"points[{int(away.argmax())}].to", words)
    turn = residual = 0.0
    if len(points) == 2:
        before, after = here[1] - here[0], there[1] - there[0]
        apart = min(float(np.hypot(*before)), float(np.hypot(*after)))
        if apart < LEAST_APART_M:
            words = f"are {apart:.1f} m apart: take points {LEAST_APART_M:.0f} m apart or more, or one point"
            raise LotInputError("points", words)
        turn = math.atan2(float(before[0] * after[1] - before[1] * after[0]), float(before @ after))
        residual = float(np.hypot(*after) - np.hypot(*before))
        if abs(turn) > STEEPEST:
            words = f"turn the lot by {math.degrees(turn):.1f}°, 10° is the most: mark the same two points on the map"
            raise LotInputError("points", words)
    north, east = (there.mean(axis=0) - Move(turn=turn).of(here.mean(axis=0)[None])[0]).tolist()
    return PointFit(Move(north, east, turn), residual)


def _points(given: object, datum: tuple[float, float]) -> list[tuple[Floats, Floats]]:
    if not isinstance(given, list) or len(given) > 2:
        raise LotInputError("points", "must be a list of one or two points, or an empty one to unpin the lot")
    found = []
    for number, point in enumerate(given):
        if not isinstance(point, dict) or point.keys() != {"from", "to"}:
            raise LotInputError(f"points[{number}]", "must be an object with from and to, [latitude, longitude] each")
        here, there = (_on_plane(point[name], f"points[{number}].{name}", datum) for name in ("from", "to"))
        found.append((here, there))
    return found


def _on_plane(given: object, field: str, datum: tuple[float, float]) -> Floats:
    place = about(datum, np.array([checked_degrees(given, field)]))[0, :2]
    if not np.isfinite(place).all() or np.hypot(*place) > _LOT_M:
        raise LotInputError(field, "must lie at this lot: it is more than 20 km away")
    return np.asarray(place, np.float64)


def _turn_of(connection: Connection, lot: str) -> float:
    return float(connection.execute(select(PIN.c.turn).where(PIN.c.lot == lot)).scalar() or 0.0)


def _place(datum: tuple[float, float], move: Move) -> tuple[float, float]:
    """Return where a move brings the datum."""
    ((latitude, longitude),) = on_earth(datum, np.array([[move.north, move.east]])).tolist()
    return latitude, longitude


def _outline(lot: Row, datum: tuple[float, float], move: Move) -> str:
    """Return a lot's outline after a move about its datum, as its column has it."""
    found = outline_to_change(lot["outline"])

    def moved(rings: Sequence[Any]) -> tuple[Any, ...]:
        return tuple(_ring(datum, move, ring) for ring in rings)

    return outline_json(Outline(moved(found.polygons), moved(found.holes)))


def _ring(datum: tuple[float, float], move: Move, ring: Sequence[Any]) -> tuple[tuple[float, float], ...]:
    return ring_on_earth(datum, move.of(np.asarray(about(datum, np.array(ring))[:, :2], np.float64)))


def _turned(connection: Connection, lot: str, move: Move, who: str, now: float) -> list[Row]:
    """Return all rows in the lot's frame after its turn, with the version of the layout that says so."""
    version = newest_layout(connection, lot) + 1
    why = f"pinned to the map, turned by {math.degrees(move.turn):.2f}°"
    rows = [layout_row(lot, version, why, who, now)]
    for table in (STALL, FORMER, DROPPED):
        there = [row for row in rows_where(connection, table, lot=lot) if row["north"] is not None]
        rows += [_stall(row, move) for row in there]
    for row in (*rows_where(connection, ZONE, lot=lot), *rows_where(connection, SECTION, lot=lot)):
        if ring := ring_of(row["outline"]):
            corners = move.of(np.array(ring, np.float64))
            rows.append(row.setting(outline=json.dumps(np.round(corners, 6).tolist())))
    for row in rows_where(connection, SURVEY, lot=lot):
        rows += _survey(row, move)
    return rows


def _stall(row: Row, move: Move) -> Row:
    ((north, east),) = move.of(np.array([[row["north"], row["east"]]])).tolist()
    return row.setting(north=north, east=east, angle=(row["angle"] + move.turn) % math.pi)


def _survey(row: Row, move: Move) -> list[Row]:
    """Return a survey with its place after the turn, or the places that it may have; nothing for one without."""
    values: dict[str, object] = {}
    if row["north"] is not None:
        values |= asdict(move.after(Move(*(row[name] for name in ("north", "east", "turn")))))
    doubt = Doubt.read(row["doubt"])
    if doubt is not None and doubt.places:
        moved = [(move.after(Move(each.north, each.east, each.turn)), each.score) for each in doubt.places]
        places = tuple(PossiblePlace(each.north, each.east, each.turn, score) for each, score in moved)
        values["doubt"] = replace(doubt, places=places).json()
    return [placed(row, **values)] if values else []

"""Pictures of a lot with its confirmed stalls as labels, in the format that `training.ground` reads.

A survey's picture is labelled with the plan as it is now, in the survey's own frame: what a person corrected later is
right for it, too. Surveys of before new paint was taken over show another plan and are left out. Ground whose stalls
nobody knows is painted grey, which readers of such pictures take as missing.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon
from shapely.geometry.base import BaseGeometry
from sqlalchemy import Connection, select

from hawk.lots.change_detection import takeover
from hawk.lots.change_detection.comparison import placed_surveys
from hawk.lots.change_log import unpacked
from hawk.lots.plan.geometry import polygons
from hawk.lots.plan.queries import all_stalls
from hawk.lots.plan.values import LayoutStall, shapes_of
from hawk.lots.registration.frames import Move
from hawk.lots.registration.georeference import ground_about
from hawk.lots.registration.survey_place import datum_of, known_ground
from hawk.lots.storage.outlines import outline_of
from hawk.lots.storage.schema import CHANGE, LAYOUT, LOT, OBSERVATION
from hawk.lots.survey.pictures import PictureFolder, Shown, drawn, extent
from hawk.lots.survey.private_ground import hidden_in
from hawk.lots.values import LotStoreError, utc
from hawk.model.lot_map import CELL_M, StallState, TileKey
from hawk.model.poses import Ring

AROUND_M: Final = 15.0
"""Ground about the stalls that a picture shows."""
SURE: Final = 0.9
"""A stall's state is a label where the survey was as sure of it."""
UNCLEAR: Final = "unclear"
_GREY: Final = 128
_QUALITY: Final = (cv2.IMWRITE_JPEG_QUALITY, 95)
_Box = tuple[float, float, float, float]
"""South, west, north, east; metres."""


@dataclass(frozen=True, slots=True)
class Taught:
    """The ``pictures`` that were written, by name, the oldest first; how many surveys have no picture (``gone``), and
    how many show the lot before new paint (``painted``).
    """

    pictures: tuple[str, ...]
    gone: int
    painted: int


@dataclass(frozen=True, slots=True)
class Flown:
    """A survey of a lot: ``move`` brings its frame onto the lot's; ``states`` of which it was sure, by stall ids.
    ``hidden``: rings that its picture must not show.
    """

    id: str
    seq: int
    ended: float
    move: Move
    states: dict[str, str] = field(repr=False)
    hidden: tuple[Ring, ...] = field(default=(), repr=False)


@dataclass(frozen=True, slots=True)
class Lesson:
    """A lot's stalls, the ground on which it has every stall, and its outline, in the lot's frame, with the surveys,
    the oldest first, and how many others show it before new paint (``painted``).
    """

    lot: str
    stalls: tuple[LayoutStall, ...] = field(repr=False)
    known: BaseGeometry = field(repr=False)
    outline: BaseGeometry = field(repr=False)
    surveys: tuple[Flown, ...]
    painted: int


def read_lesson(connection: Connection, lot: str) -> Lesson:
    """Return what the surveys of a lot can teach. Raises LotStoreError where a stall is not confirmed."""
    present = all_stalls(connection, lot)
    unconfirmed = sum(not stall.is_confirmed for stall in present)
    if unconfirmed or not present:
        raise LotStoreError(
            f"{unconfirmed} of {len(present)} stalls are not confirmed: labels must be right. Confirm those that "
            "are stalls and remove the others: on the page, under Lots in the tab Stalls"
        )
    ids, since = {stall.key: stall.id for stall in present}, _painted_at(connection, lot)
    rows = list(placed_surveys(connection, lot))
    shown = [row for row in reversed(rows) if int(row["layout"] or 0) >= since]
    surveys = tuple(
        Flown(
            row["id"],
            int(row["seq"]),
            float(row["ended"]),
            Move.stored(row),
            _states(connection, row["seq"], ids),
            hidden_in(connection, row["id"]),
        )
        for row in shown
    )
    text = connection.execute(select(LOT.c.outline).where(LOT.c.id == lot)).scalar_one()
    outline = ground_about(datum_of(connection, lot), outline_of(text))
    return Lesson(lot, tuple(present), known_ground(connection, lot), outline, surveys, len(rows) - len(shown))


def write_lesson(lesson: Lesson, pictures: PictureFolder, folder: Path) -> Taught:
    """Write ``folder/NAME.jpg`` and ``NAME.json`` for each survey with a picture.

    Raises LotStoreError where nothing would be written or a picture is broken, and OSError.
    """
    names, gone = [], 0
    for survey in lesson.surveys:
        tiles = pictures.read(survey.id, survey.hidden)
        try:
            name = _write(lesson, survey, tiles, folder) if tiles else None
        except ValueError as error:
            raise LotStoreError(f"the picture of survey {survey.id} cannot be read: {error}; remove its file") from None
        gone += name is None
        names += [] if name is None else [name]
    if not names:
        raise LotStoreError(
            f"no survey of this lot has a picture with its stalls in it ({gone} without a picture, {lesson.painted} "
            "from before the lot was painted again): fly a survey, then export again"
        )
    return Taught(tuple(names), gone, lesson.painted)


def _painted_at(connection: Connection, lot: str) -> int:
    """Return the version of the layout that took new paint over last, 0 without one."""
    is_done = (CHANGE.c.kind == takeover.KIND) & CHANGE.c.undone.is_(None)
    bodies = connection.execute(select(CHANGE.c.body).where(CHANGE.c.lot == lot, is_done)).scalars()
    begun = (group.keys for body in bodies for group in unpacked(body) if group.table == LAYOUT.name)
    return max((version for keys in begun for _, version in keys), default=0)


def _write(lesson: Lesson, survey: Flown, tiles: dict[TileKey, bytes], folder: Path) -> str | None:
    """Write one survey; return its name, None where its picture shows no stall."""
    back = survey.move.back
    corners = _corners(lesson.stalls, survey.move)
    box = _box(corners, extent(tiles))
    shown = None if box is None else drawn(tiles, box)
    labels = [] if shown is None else _labels(lesson.stalls, survey.states, corners, shown)
    if shown is None or not labels:
        return None
    is_known = shown.seen & _filled(shapely.transform(lesson.known, back), shown)
    image = np.where(is_known[..., None], shown.image, np.uint8(_GREY))
    outline = _rings(shapely.transform(lesson.outline, back))
    content = {
        "metres_per_pixel": CELL_M,
        "lot": lesson.lot,
        "survey": survey.id,
        "ended": utc(survey.ended),
        "stalls": labels,
        "lots_m": [_in_picture(np.array(ring.coords[:-1]), shown) for ring in outline],
    }
    name = f"{lesson.lot[:8]}-{survey.seq:06d}"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{name}.jpg").write_bytes(cv2.imencode(".jpg", image, _QUALITY)[1].tobytes())
    (folder / f"{name}.json").write_text(json.dumps(content, allow_nan=False))
    return name


def _corners(stalls: Sequence[LayoutStall], move: Move) -> NDArray[np.float64]:
    """Return the corners (N, 4, 2) of stalls in the frame of a survey."""
    rings = shapely.get_coordinates(polygons(shapes_of(stalls)))
    return move.back(rings).reshape(-1, 5, 2)[:, :4]


def _box(corners: NDArray[np.float64], seen: _Box) -> _Box | None:
    """Return the ground about stalls that tiles cover; None where they cover none of it."""
    south, west = np.maximum(corners.reshape(-1, 2).min(axis=0) - AROUND_M, seen[:2]).tolist()
    north, east = np.minimum(corners.reshape(-1, 2).max(axis=0) + AROUND_M, seen[2:]).tolist()
    return (south, west, north, east) if south < north and west < east else None


def _states(connection: Connection, survey: int, ids: Mapping[int, str]) -> dict[str, str]:
    """Return the states of which a survey was sure; ``ids`` of stalls by their keys."""
    asked = select(OBSERVATION.c.stall, OBSERVATION.c.state, OBSERVATION.c.taken_probability).where(
        OBSERVATION.c.survey == survey
    )
    rows = connection.execute(asked).all()
    return {
        ids[row.stall]: row.state
        for row in rows
        if row.stall in ids and max(row.taken_probability, 1 - row.taken_probability) >= SURE
    }


def _labels(
    stalls: Sequence[LayoutStall], states: Mapping[str, str], corners: NDArray[np.float64], shown: Shown
) -> list[dict[str, object]]:
    """Return the labels of the stalls whose middle the picture shows."""
    found: list[dict[str, object]] = []
    for stall, quad in zip(stalls, corners, strict=True):
        placed = _in_picture(quad, shown)
        column, row = np.rint(np.mean(placed, axis=0) / CELL_M - 0.5).astype(int).tolist()
        if not (0 <= row < shown.seen.shape[0] and 0 <= column < shown.seen.shape[1] and shown.seen[row, column]):
            continue
        state = states.get(stall.id, UNCLEAR)
        known = state if state in (StallState.FREE, StallState.TAKEN) else UNCLEAR
        found.append({"corners_m": placed, "state": str(known), "label": stall.label, "id": stall.id})
    return found


def _in_picture(places: NDArray[np.float64], shown: Shown) -> list[list[float]]:
    """Return places (N, 2) of (north, east) as metres from the picture's upper left corner, x right and y down."""
    placed = np.column_stack([places[:, 1] - shown.east, shown.north - places[:, 0]])
    return np.round(placed, 3).tolist()  # type: ignore[no-any-return]


def _filled(ground: BaseGeometry, shown: Shown) -> NDArray[np.bool_]:
    """Return the pixels (H, W) of a picture that lie on ground."""
    mask = np.zeros(shown.seen.shape, np.uint8)
    for part in shapely.get_parts(ground):
        if isinstance(part, Polygon) and not part.is_empty:
            rings = [np.array(_in_picture(np.array(r.coords), shown)) for r in (part.exterior, *part.interiors)]
            piece = np.zeros_like(mask)
            cv2.fillPoly(piece, [np.rint(ring / CELL_M - 0.5).astype(np.int32) for ring in rings], (1,))
            mask |= piece
    return np.asarray(mask > 0)


def _rings(ground: BaseGeometry) -> list[shapely.LinearRing]:
    return [part.exterior for part in shapely.get_parts(ground) if isinstance(part, Polygon) and not part.is_empty]

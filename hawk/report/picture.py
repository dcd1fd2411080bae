"""The newest survey's picture of a lot: its ground as JPEG, and stalls, rows and zones to be drawn over it."""

from __future__ import annotations

import logging
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray
from sqlalchemy import Connection

from hawk.exports.files import shown_ground
from hawk.exports.ground import Ground, corners_of, ground_of, on_paper
from hawk.exports.records import read_survey
from hawk.exports.values import ExportRecord
from hawk.lots import lists
from hawk.lots.registration.frames import Move
from hawk.lots.survey.pictures import PictureFolder
from hawk.lots.values import LotStoreError
from hawk.report.values import DrawnRow, DrawnStall, DrawnZone, LotPicture, Newest, Note, Point
from hawk.results.label_parts import numbered, reading_order
from hawk.stats.answers import SurveyUse

_LOG = logging.getLogger(__name__)
MOST_BYTES: Final = 700_000
"""Of the JPEG: it takes a third more as text, below a megabyte."""
_QUALITIES: Final = (82, 70, 55, 40, 25)
_LONGEST: Final = 1600
"""Pixels of the longer side: 220 dots an inch at the width of the paper."""
_AROUND_M: Final = 5.0
"""Ground about the stalls that is shown."""
_ASPECT: Final = 1.95
"""Width over height of a picture that fills its room on the paper."""
_MOST_ZONES: Final = 1000


def newest_of(
    connection: Connection, pictures: PictureFolder, use: SurveyUse, at: datetime, *, has_ground: bool
) -> Newest:  # fmt: skip
    """Return the newest survey of a report with its picture; what cannot be read is left out, and said.

    Its labels are those of the present plan, as the report's figures have them.
    """
    stalls = use.free + use.taken + use.unknown
    try:
        survey = read_survey(connection, use.id, has_labels_of_now=True)
    except LotStoreError as error:
        _LOG.warning("a report has no picture of survey %s: %s", use.id, error)
        return Newest(use, at, stalls, 0, None, "picture_broken")
    named = sum(each.is_named for each in survey.stalls)
    ground, note = _ground(connection, pictures, survey, has_ground=has_ground)
    if ground is None:
        return Newest(use, at, stalls, named, None, note)
    return Newest(use, at, stalls, named, _picture(connection, survey, ground), note)


def _ground(
    connection: Connection, pictures: PictureFolder, survey: ExportRecord, *, has_ground: bool
) -> tuple[Ground | None, Note | None]:  # fmt: skip
    """Return the ground of a survey, and what is missing of it."""
    note: Note | None = None if has_ground else "by_link"
    if has_ground:
        try:
            ground = shown_ground(connection, survey, pictures)
            return ground, None if ground.seen.any() else "not_kept"
        except LotStoreError as error:
            _LOG.warning("a report has no ground of survey %s: %s", survey.survey, error)
            note = "picture_broken"
    try:
        return ground_of(survey, {}, Move()), note
    except LotStoreError:
        return None, "nothing_to_draw"


def _picture(connection: Connection, survey: ExportRecord, whole: Ground) -> LotPicture:
    ground = _about_stalls(whole, corners_of(survey))
    sheet = _Sheet.of(ground)
    corners = sheet.places(corners_of(survey).reshape(-1, 2)).reshape(-1, 4, 2)
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).min(axis=1) if len(corners) else np.ones(1)
    drawn = tuple(
        DrawnStall(_points(ring), _number(stall.label), stall.state)
        for stall, ring in zip(survey.stalls, corners, strict=True)
    )
    labels = [stall.label for stall in survey.stalls]
    height, width = sheet.image.shape[:2]
    return LotPicture(
        width, height, ground.metres, sheet.is_turned, float(np.median(sides)), drawn,
        _rows(labels, corners.mean(axis=1)), _zones(connection, survey.lot_id, sheet),
        _jpeg(sheet.image) if ground.seen.any() else b"",
    )  # fmt: skip


@dataclass(frozen=True, slots=True)
class _Sheet:
    """A picture of ground on paper, (H, W, 3) BGR; a high one ``is_turned`` clockwise: its north is to the right."""

    ground: Ground
    image: NDArray[np.uint8]
    is_turned: bool

    @classmethod
    def of(cls, ground: Ground) -> _Sheet:
        """Return the picture of ground."""
        image = on_paper(ground)
        is_turned = image.shape[0] > image.shape[1]
        return cls(ground, np.asarray(np.rot90(image, -1) if is_turned else image, np.uint8), is_turned)

    def places(self, places: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return places (N, 2) of (north, east) as (column, row)."""
        at = self.ground.pixels(places)
        return np.column_stack([self.ground.seen.shape[0] - at[:, 1], at[:, 0]]) if self.is_turned else at


def _about_stalls(ground: Ground, corners: NDArray[np.float64]) -> Ground:
    """Return the ground about the stalls, no larger than is printed: unseen where the picture ends before they do, and
    as wide to its height as the paper has room for it where there is as much ground.
    """
    limit = np.array(ground.seen.shape[::-1], np.float64)
    low, high = np.zeros(2), limit
    if len(corners):
        at, around = ground.pixels(corners.reshape(-1, 2)), _AROUND_M / ground.metres
        low, high = np.floor(at.min(0) - around), np.ceil(at.max(0) + around)
        wider = np.maximum(_wider(high - low), 0.0)
        low, high = np.minimum(low, np.maximum(low - wider, 0.0)), np.maximum(high, np.minimum(high + wider, limit))
    scale = min(1.0, _LONGEST / float((high - low).max()))
    columns, rows = np.maximum(np.round((high - low) * scale), 1).astype(int).tolist()
    left, top = np.round(-low * scale).astype(int).tolist()  # of the ground on the sheet
    image, seen = (_pasted(each, scale, (left, top), (columns, rows)) for each in (ground.image, ground.seen))
    metres = ground.metres / scale
    return Ground(image, seen, ground.north + top * metres, ground.east - left * metres, metres)


def _pasted(
    picture: NDArray[np.uint8], scale: float, at: tuple[int, int], size: tuple[int, int]
) -> NDArray[np.uint8]:  # fmt: skip
    """Return a sheet of ``size`` (columns, rows), black but for a scaled picture with its corner ``at`` a place."""
    if scale < 1.0:
        small = np.maximum(np.round(np.array(picture.shape[1::-1]) * scale), 1).astype(int).tolist()
        picture = np.asarray(cv2.resize(picture, small, interpolation=cv2.INTER_AREA), np.uint8)
    sheet = np.zeros((size[1], size[0], *picture.shape[2:]), np.uint8)
    (left, top), (high, wide) = at, picture.shape[:2]
    part = sheet[max(top, 0) : top + high, max(left, 0) : left + wide]
    part[:] = picture[max(-top, 0) :, max(-left, 0) :][: part.shape[0], : part.shape[1]]
    return sheet


def _wider(size: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return by how much a box grows on each side so that its longer side is `_ASPECT` times its shorter one."""
    wider = np.zeros(2)
    shorter = int(size.argmin())
    wider[shorter] = (size.max() / _ASPECT - size[shorter]) / 2
    wider[1 - shorter] = (size.min() * _ASPECT - size[1 - shorter]) / 2
    return wider


def _jpeg(image: NDArray[np.uint8]) -> bytes:
    """Return a picture as JPEG of `MOST_BYTES` at most, at the lowest quality whatever it takes."""
    data = b""
    for quality in _QUALITIES:
        data = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, quality])[1].tobytes()
        if len(data) <= MOST_BYTES:
            return data
    half: Any = cv2.resize(image, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
    return _jpeg(np.asarray(half, np.uint8))


def _number(label: str) -> str:
    parts = numbered(label)
    return label if parts is None else parts.digits


def _rows(labels: Sequence[str], middles: NDArray[np.float64]) -> tuple[DrawnRow, ...]:
    """Return each row, whose second stall says the direction."""
    members: dict[str, list[int]] = defaultdict(list)
    for number in sorted(range(len(labels)), key=lambda each: reading_order(labels[each])):
        parts = numbered(labels[number])
        if parts is not None and parts.row:
            members[parts.row].append(number)
    found = []
    for row, stalls in members.items():
        first = middles[stalls[0]]
        step = first - middles[stalls[1 if len(stalls) > 1 else 0]]
        found.append(DrawnRow(row, _point(first), _point(step / max(float(np.linalg.norm(step)), 1e-9))))
    return tuple(found)


def _zones(connection: Connection, lot: str, sheet: _Sheet) -> tuple[DrawnZone, ...]:
    found = lists.zones(connection, lot, lists.Asked(_MOST_ZONES)).items
    return tuple(
        DrawnZone(each.name, _points(sheet.places(np.array(each.outline, np.float64))))
        for each in found
        if each.has_stalls
    )


def _points(places: NDArray[np.float64]) -> tuple[Point, ...]:
    return tuple(_point(each) for each in places)


def _point(place: NDArray[np.float64]) -> Point:
    return round(float(place[0]), 2), round(float(place[1]), 2)

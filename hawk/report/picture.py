"""The newest survey's picture of a lot: its ground as JPEG, and stalls, rows and zones to be drawn over it."""

from __future__ import annotations

import logging
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace
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
from hawk.lots.labels import numbered, reading_order
from hawk.lots.registration.frames import Move
from hawk.lots.survey.pictures import PictureFolder
from hawk.lots.values import LotStoreError
from hawk.report.values import DrawnStall, DrawnZone, LotPicture, Newest, Note, Point
from hawk.stats.answers import SurveyUse

_LOG = logging.getLogger(__name__)
MOST_BYTES: Final = 700_000
"""Of the JPEG: it takes a third more as text, below a megabyte."""
_QUALITIES: Final = (82, 70, 55, 40, 25)
_LONGEST: Final = 1600
"""Pixels of the longer side: 220 dots an inch at the width of the paper."""
_AROUND_M: Final = 8.0
"""Ground about the stalls that is shown."""
_MOST_ZONES: Final = 1000


def newest_of(
    connection: Connection, pictures: PictureFolder, use: SurveyUse, at: datetime, *, has_ground: bool
) -> Newest:  # fmt: skip
    """Return the newest survey of a report with its picture; what cannot be read is left out, and said."""
    stalls = use.free + use.taken + use.unknown
    try:
        survey = read_survey(connection, use.id)
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
    corners = ground.pixels(corners_of(survey).reshape(-1, 2)).reshape(-1, 4, 2)
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).min(axis=1) if len(corners) else np.ones(1)
    drawn = tuple(
        DrawnStall(_points(ring), _number(stall.label), stall.state)
        for stall, ring in zip(survey.stalls, corners, strict=True)
    )
    height, width = ground.seen.shape
    labels = [stall.label for stall in survey.stalls]
    return LotPicture(
        width, height, ground.metres, float(np.median(sides)), drawn,
        _rows(labels, corners.mean(axis=1)), _zones(connection, survey.lot_id, ground),
        _jpeg(on_paper(ground)) if ground.seen.any() else b"",
    )  # fmt: skip


def _about_stalls(ground: Ground, corners: NDArray[np.float64]) -> Ground:
    """Return the part of the ground about the stalls, no larger than is printed."""
    height, width = ground.seen.shape
    left, top, right, bottom = 0, 0, width, height
    if len(corners):
        at, around = ground.pixels(corners.reshape(-1, 2)), _AROUND_M / ground.metres
        left, top = np.maximum(np.floor(at.min(0) - around), 0).astype(int).tolist()
        right, bottom = np.minimum(np.ceil(at.max(0) + around), (width, height)).astype(int).tolist()
        if right - left < 1 or bottom - top < 1:
            left, top, right, bottom = 0, 0, width, height
    image, seen = ground.image[top:bottom, left:right], ground.seen[top:bottom, left:right]
    north, east = ground.north - top * ground.metres, ground.east + left * ground.metres
    scale = min(1.0, _LONGEST / max(seen.shape))
    if scale < 1.0:
        size = (max(round(seen.shape[1] * scale), 1), max(round(seen.shape[0] * scale), 1))
        image = np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), np.uint8)
        seen = np.asarray(cv2.resize(seen, size, interpolation=cv2.INTER_AREA), np.uint8)
    return replace(ground, image=image, seen=seen, north=north, east=east, metres=ground.metres / scale)


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


def _rows(labels: Sequence[str], middles: NDArray[np.float64]) -> tuple[tuple[str, Point], ...]:
    """Return the name of each row, before its first stall: as far as its second one is behind it."""
    members: dict[str, list[int]] = defaultdict(list)
    for number in sorted(range(len(labels)), key=lambda each: reading_order(labels[each])):
        parts = numbered(labels[number])
        if parts is not None and parts.row:
            members[parts.row].append(number)
    found = []
    for row, stalls in members.items():
        first = middles[stalls[0]]
        step = first - middles[stalls[1]] if len(stalls) > 1 else np.array([0.0, 0.0])
        found.append((row, _point(first + step)))
    return tuple(found)


def _zones(connection: Connection, lot: str, ground: Ground) -> tuple[DrawnZone, ...]:
    found = lists.zones(connection, lot, lists.Asked(_MOST_ZONES)).items
    return tuple(
        DrawnZone(each.name, _points(ground.pixels(np.array(each.outline, np.float64))))
        for each in found
        if each.has_stalls
    )


def _points(places: NDArray[np.float64]) -> tuple[Point, ...]:
    return tuple(_point(each) for each in places)


def _point(place: NDArray[np.float64]) -> Point:
    return round(float(place[0]), 1), round(float(place[1]), 1)

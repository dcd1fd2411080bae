"""The made-up lot of ``packaging/fake_drone.py``: its ground as a picture, and a store with its surveys."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.lots.ingest import save
from hawk.lots.storage.database import Database
from hawk.lots.store import LotStore
from hawk.lots.survey.pictures import pictures_of
from hawk.lots.values import Detection, FinishedSurvey, KnownGround, MappedGround, Registration
from hawk.model.lot_map import EncodedTile, Stall, StallState, TileKey
from hawk.model.plans import Outline
from hawk.model.poses import GlobalPose
from hawk.model.tile_picture import encode_picture
from hawk.results.survey_map import to_global

PIXELS_PER_M = 10
SIDE_M = 256.0
HALF_M = SIDE_M / 2
FIELD_M = (50.0, 28.0)
DATUM = GlobalPose(48.137, 11.575, 0.0)
FLOWN = tuple(
    datetime(2026, 5, day, hour, 5, tzinfo=UTC)
    for day, hours in ((4, (6, 8, 12)), (5, (6, 10)), (6, (8, 14)), (7, (6, 8, 10)), (8, (8, 10)))
    for hour in hours
)
"""When the surveys in a store begin, Monday to Friday."""
LASTS_S = 600.0
TAKEN_BY_HOUR = {6: 0.35, 8: 0.75, 10: 0.85, 12: 0.65, 14: 0.5}
CHANCE = {StallState.FREE: 0.03, StallState.TAKEN: 0.97}
PICTURED = 2
"""Surveys, the newest ones, that have a picture."""
Picture = NDArray[np.uint8]


@dataclass(slots=True)
class FakeStall:
    """A stall of the made-up lot."""

    stall: Stall
    shown: bool = False


def make_stalls(rng: np.random.Generator, count: int | None) -> list[FakeStall]:
    """Return rows of stalls of a lot that lies a little askew; a count makes a field of that number."""
    turn = math.radians(24)
    found: list[FakeStall] = []
    for u, v in lot_places() if count is None else field_places(count):
        east = u * math.cos(turn) + v * math.sin(turn)
        north = -u * math.sin(turn) + v * math.cos(turn)
        taken = float(rng.choice([0.03, 0.97, 0.45], p=[0.55, 0.4, 0.05]))
        state = StallState.FREE if taken < 0.2 else StallState.TAKEN if taken > 0.8 else StallState.UNKNOWN
        number = len(found) + 1
        found.append(FakeStall(Stall(number, north, east, turn, 2.5, 5.0, taken, state, 0.9, 4, 0.0, 1)))
    return found


def lot_places() -> list[tuple[float, float]]:
    """Return the middles of the stalls of a lot with aisles and a few gaps, metres along and across its rows."""
    gaps = {(2, 3), (5, 0), (0, 5)}
    cells = [(row, column) for row in range(8) for column in range(22) if (row, column // 4) not in gaps]
    return [((column - 10.5) * 2.6, (row - 3.5) * 8.4 + (2.4 if row % 2 else -0.6)) for row, column in cells]


def field_places(count: int) -> list[tuple[float, float]]:
    """Return the middles of ``count`` stalls in rows close to each other."""
    columns = math.ceil(math.sqrt(count * 5.8 / 2.6))
    rows = math.ceil(count / columns)
    cells = [(row, column) for row in range(rows) for column in range(columns)][:count]
    return [((column - (columns - 1) / 2) * 2.6, (row - (rows - 1) / 2) * 5.8) for row, column in cells]


def to_pixel(north: float, east: float) -> tuple[int, int]:
    """Return (column, row) in the ground picture."""
    return round((east + HALF_M) * PIXELS_PER_M), round((HALF_M - north) * PIXELS_PER_M)


def ring(stall: Stall, scale: float = 1.0) -> NDArray[np.int32]:
    """Return a stall's corners as pixels."""
    centre = np.array([stall.north, stall.east])
    corners = (stall.corners() - centre) * scale + centre
    return np.array([to_pixel(north, east) for north, east in corners], np.int32)


GRASS, ASPHALT = np.array([70, 105, 88], np.float32), np.array([112, 114, 116], np.float32)
"""Blue, green, red."""


def draw_ground(stalls: list[FakeStall], rng: np.random.Generator) -> tuple[Picture, NDArray[np.uint8]]:
    """Return the ground from above (BGR) and its cell classes."""
    size = round(SIDE_M * PIXELS_PER_M)
    noise = cv2.resize(rng.normal(0, 1, (size // 8, size // 8)).astype(np.float32), (size, size))
    classes = np.full((size, size), 1, np.uint8)
    places = np.array([(each.stall.east, -each.stall.north) for each in stalls], np.float32) * PIXELS_PER_M + size / 2
    (middle, (across, down), angle) = cv2.minAreaRect(places)
    outline = cv2.boxPoints((middle, (across + 110, down + 110), angle)).astype(np.int32)
    cv2.fillPoly(classes, [outline], 2)
    paved = classes == 2
    grain = np.where(paved, np.float32(5), np.float32(12)) * noise + rng.standard_normal((size, size), np.float32) * 4
    shades = [np.where(paved, hard, soft) for soft, hard in zip(GRASS, ASPHALT, strict=True)]
    picture = cv2.merge([np.clip(shade + grain, 20, 255).astype(np.uint8) for shade in shades])
    for each in stalls:
        cv2.polylines(picture, [ring(each.stall)], True, (225, 230, 232), 2, cv2.LINE_AA)
        cv2.fillPoly(classes, [ring(each.stall)], 4 if each.stall.state is StallState.TAKEN else 3)
    draw_cars(picture, (each.stall for each in stalls), rng)
    return picture, classes


def draw_cars(picture: Picture, stalls: Iterable[Stall], rng: np.random.Generator) -> None:
    """Draw a car into each stall that is not free."""
    for stall in stalls:
        if stall.state is not StallState.FREE:
            draw_car(picture, stall, rng)


def draw_car(picture: Picture, stall: Stall, rng: np.random.Generator) -> None:
    """Draw a car into a stall."""
    colour = tuple(int(v) for v in rng.integers(30, 235, 1).repeat(3) + rng.integers(-20, 20, 3))
    box = ((*to_pixel(stall.north, stall.east),), (18, 44), math.degrees(stall.angle))
    shadow = ((box[0][0] + 3, box[0][1] + 4), box[1], box[2])
    cv2.fillPoly(picture, [cv2.boxPoints(shadow).astype(np.int32)], (40, 42, 44))
    cv2.fillPoly(picture, [cv2.boxPoints(box).astype(np.int32)], colour)
    cv2.fillPoly(picture, [cv2.boxPoints((box[0], (15, 20), box[2])).astype(np.int32)], (50, 45, 40))


COLOURS = {StallState.FREE: (255, 200, 120), StallState.TAKEN: (0, 110, 255), StallState.UNKNOWN: (255, 255, 255)}


def states_of(stalls: list[FakeStall], began: datetime, rng: np.random.Generator) -> tuple[Stall, ...]:
    """Return the stalls as a survey at this time finds them: those near the middle of the lot are taken first."""
    share = TAKEN_BY_HOUR[began.hour]
    away = np.array([math.hypot(each.stall.north, each.stall.east) for each in stalls])
    order = np.argsort(np.argsort(away + rng.normal(0, 9, len(away))))
    found = []
    for each, rank in zip(stalls, order.tolist(), strict=True):
        state = StallState.TAKEN if rank < share * len(stalls) else StallState.FREE
        found.append(replace(each.stall, state=state, taken=CHANCE[state]))
    return tuple(found)


def survey_of(number: int, began: datetime, stalls: Iterable[Stall]) -> FinishedSurvey:
    """Return a survey that found these stalls."""
    found = tuple(stalls)
    at = began.timestamp()
    corners = np.concatenate([each.corners() for each in found])
    (south, west), (north, east) = corners.min(axis=0) - 10, corners.max(axis=0) + 10
    places = np.array([(south, west), (north, west), (north, east), (south, east)])
    ground = Outline((tuple((float(a), float(b)) for a, b in to_global(DATUM, places)),))
    return FinishedSurvey(
        f"{number:06d}-{began:%Y%m%dT%H%M%SZ}", DATUM, at, at + LASTS_S, time_is_sure=True, outline=ground,
        stalls=tuple(Detection.of(each, at) for each in found), program="0.4.0", seen_ground=ground,
    )  # fmt: skip


def mosaic_of(picture: Picture) -> dict[TileKey, EncodedTile]:
    """Return the ground's picture as tiles, all of it seen."""
    seen = np.full((256, 256), 255, np.uint8)
    half = picture.shape[0] // 512
    found = {}
    for row in range(-half, half):
        for column in range(-half, half):
            top, left = (row + half) * 256, (column + half) * 256
            found[row, column] = EncodedTile(1, encode_picture(picture[top : top + 256, left : left + 256], seen))
    return found


def same_numbers(known: KnownGround, found: MappedGround) -> Registration:
    """Take the stalls that a survey finds for those of the lot in the same order."""
    ids = [each.id for each in known.stalls]
    return Registration(0.0, 0.0, 0.0, {each.id: ids[each.id - 1] for each in found.stalls})


def store_with(path: Path, stalls: list[FakeStall], surveys: int = 1) -> LotStore:
    """Return the store in a file; one that is not there is made with a number of surveys, the newest of `FLOWN`."""
    if not path.exists():
        rng = np.random.default_rng(7)
        database = Database(path)
        bare, _ = draw_ground([FakeStall(replace(each.stall, state=StallState.FREE)) for each in stalls], rng)
        for number, began in enumerate(FLOWN[-surveys:], 1):
            found = tuple(each.stall for each in stalls) if surveys == 1 else states_of(stalls, began, rng)
            with database.writing() as connection:
                saved = save(connection, survey_of(number, began, found), same_numbers)
            if surveys > 1 and number > surveys - PICTURED:
                picture = bare.copy()
                draw_cars(picture, found, rng)
                pictures_of(path).write(saved.survey, mosaic_of(picture))
        database.close()
    return LotStore(path)

"""A survey by pictures in the store of lots, as one after a landing is."""

from __future__ import annotations

import asyncio
import zlib
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.daemon.lot_keeper import find_stalls
from hawk.exports.ground import Ground
from hawk.exports.values import ExportRecord
from hawk.lots.registration.georeference import about
from hawk.lots.store import LotStore, lots_file
from hawk.lots.survey.landing import LandingFacts
from hawk.lots.values import PLACED, LotStoreError, Placed, Saved, fitting_name
from hawk.model.lot_map import CELL_M, TILE_CELLS, TILE_M, Cell, EncodedTile, OccupancyMap, Stall, StallState, TileKey
from hawk.model.poses import GlobalPose
from hawk.model.tile_picture import encode_picture
from hawk.picture.values import NO_STALLS, Mapped, PictureError

_WORDS: Final = {
    Placed.FIRST: "the first survey of {lot}",
    Placed.REGISTERED: "a survey of {lot}, with {known} of its stalls",
    Placed.UNREGISTERED: "a survey of {lot}, whose place is not certain: {doubt}",
    Placed.UNDECIDED: "a survey that may be of several lots: choose one on the page, under Lots",
    Placed.NOTHING: f"a survey without a lot: {NO_STALLS}",
}


@dataclass(frozen=True, slots=True)
class Stored:
    """A survey in the store: what it is there, in ``words``, the ids of its ``lot``, None without one, and its own.

    ``doubt``: why its place among the stalls of a lot is not certain, "" where it is.
    """

    words: str
    lot: str | None
    survey: str
    doubt: str = ""

    def said_of(self, mapped: Mapped) -> Mapped:
        """Return a survey with the store's doubt, as its files say it; one that says a doubt of its own keeps that."""
        doubt = mapped.survey.doubt or self.doubt
        return replace(mapped, survey=replace(mapped.survey, doubt=doubt))


def store_survey(landed: LandingFacts, folder: Path, name: str | None = None) -> Stored:
    """Store a survey among the lots of a folder. Raises PictureError.

    ``name``: that a person gave its lot, None without one. A lot that is there keeps its own, and the words say so.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        saved = asyncio.run(_save(landed, folder))
    except (LotStoreError, OSError) as error:
        raise PictureError(f"--store: {error}") from error
    words = _WORDS[saved.placed].format(lot=saved.lot_name, known=saved.known, doubt=saved.doubt)
    kept = ""
    is_known = saved.lot is not None and saved.placed is not Placed.FIRST
    if name is not None and is_known and saved.lot_name != fitting_name(name):
        kept = (
            f". The lot keeps its name {saved.lot_name}, --name {name} is not used: rename it on the page, under Lots"
        )
    doubt = "" if saved.placed in PLACED else f"{saved.placed}: its place among the lot's stalls is not certain"
    return Stored(f"Stored in {folder} as {words}{kept}", saved.lot, saved.survey, doubt)


async def _save(landed: LandingFacts, folder: Path) -> Saved:
    store = LotStore(lots_file(folder), find_stalls)
    try:
        return await store.save(landed)
    finally:
        await store.close()


def landed_of(mapped: Mapped) -> LandingFacts:
    """Return a survey of an orthophoto as one after a landing, with its ground where that was drawn."""
    survey = mapped.survey
    tiles, mosaic = ({}, {}) if mapped.ground is None else _tiles(mapped.ground, survey)
    stalls = _stalls(survey, mapped.scores)
    return LandingFacts(
        name=f"orthophoto {survey.survey}",
        datum=GlobalPose(*survey.origin, 0.0),
        current=OccupancyMap(tiles=tiles, mosaic=mosaic, stalls=stalls, version=1, map_id=survey.survey),
        outline=survey.outline if survey.outline.polygons else None,
        seconds=0.0,
        utc=survey.ended,
        time_is_sure=survey.time_is_sure,
        program=survey.software.removeprefix("hawk-drone "),
        accuracy=survey.accuracy,
        pictures=survey.pictures,
        title=survey.lot,
    )


def _stalls(survey: ExportRecord, scores: tuple[float, ...]) -> dict[int, Stall]:
    if not survey.stalls:
        return {}
    places = np.array([stall.place for stall in survey.stalls])
    metres = about(survey.origin, places)
    known = scores if len(scores) == len(survey.stalls) else (1.0,) * len(survey.stalls)
    return {
        number: Stall(
            id=number,
            north=float(north),
            east=float(east),
            angle=float(np.radians(stall.direction)),
            width=stall.width,
            length=stall.length,
            taken=0.5 if stall.taken is None else stall.taken,
            state=StallState(stall.state),
            score=float(score),
            seen=max(1, stall.seen),
            last_seen=0.0,
            version=1,
        )
        for number, (stall, score, (north, east, *_)) in enumerate(
            zip(survey.stalls, known, metres.tolist(), strict=True), 1
        )
    }


def _tiles(ground: Ground, survey: ExportRecord) -> tuple[dict[TileKey, EncodedTile], dict[TileKey, EncodedTile]]:
    """Return cells and pictures of the tiles that a ground covers."""
    high, wide = (round(side * ground.metres / CELL_M) for side in ground.seen.shape)
    first_row, first_column = (int(np.floor(at / TILE_M)) for at in (-ground.north, ground.east))
    top, left = (
        round((at - first * TILE_M) / CELL_M) for at, first in ((-ground.north, first_row), (ground.east, first_column))
    )
    rows, columns = (-(-(first + side) // TILE_CELLS) for first, side in ((top, high), (left, wide)))
    image = np.zeros((rows * TILE_CELLS, columns * TILE_CELLS, 3), np.uint8)
    seen = np.zeros(image.shape[:2], np.uint8)
    part = slice(top, top + high), slice(left, left + wide)
    image[part] = cv2.resize(ground.image, (wide, high), interpolation=cv2.INTER_AREA)
    seen[part] = cv2.resize(ground.seen, (wide, high), interpolation=cv2.INTER_NEAREST)
    cells = _cells(seen, survey, first_row, first_column)
    tiles, mosaic = {}, {}
    for row in range(rows):
        for column in range(columns):
            at = (
                slice(row * TILE_CELLS, (row + 1) * TILE_CELLS),
                slice(column * TILE_CELLS, (column + 1) * TILE_CELLS),
            )
            if seen[at].any():
                key = first_row + row, first_column + column
                tiles[key] = EncodedTile(1, zlib.compress(cells[at].tobytes()))
                mosaic[key] = EncodedTile(1, encode_picture(image[at], seen[at]))
    return tiles, mosaic


def _cells(seen: NDArray[np.uint8], survey: ExportRecord, row: int, column: int) -> NDArray[np.uint8]:
    """Return the cells of the ground that was seen: those of the lot inside its outline, the others beside it."""
    cells = np.where(seen > 0, Cell.NON_LOT, Cell.UNKNOWN).astype(np.uint8)
    inside = np.zeros(seen.shape, np.uint8)
    for ring in survey.outline.polygons:
        metres = about(survey.origin, np.array(ring))[:, :2]
        pixels = np.column_stack([metres[:, 1] - column * TILE_M, -metres[:, 0] - row * TILE_M]) / CELL_M
        cv2.fillPoly(inside, [np.rint(pixels).astype(np.int32)], (1,))
    cells[(inside > 0) & (seen > 0)] = Cell.LOT
    return cells

"""A lot of 60 stalls in three rows that was surveyed twelve times in a week, for the tests of its report."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np

from hawk.lots import commands
from hawk.lots.survey.pictures import PictureFolder, pictures_of
from hawk.lots.values import FinishedSurvey
from hawk.model.lot_map import TILE_CELLS, EncodedTile, StallState, TileKey
from hawk.model.tile_picture import encode_picture
from tests.unit.lots.repaints import Archive
from tests.unit.lots.surveys import survey

NAME = "=Étoile <b>& Söhne</b>"
"""A name that is a formula to a spreadsheet, HTML to a browser, and no ASCII."""
ZONE = "-Visitors </style>"
MONDAY = datetime(2026, 5, 4, tzinfo=UTC)
FLOWN = ((0, 7), (0, 13), (1, 8), (1, 14), (2, 7), (2, 13), (2, 15), (3, 8), (4, 7), (4, 13), (5, 8), (7, 7))
"""Days after the Monday, and hours, UTC: nobody flew on the Sunday."""
NOW = (MONDAY + timedelta(days=7, hours=10)).timestamp()
_SHARES = {0: 0.35, 1: 0.85, 2: 0.2}


def flown(number: int, day: int, hour: int) -> FinishedSurvey:
    """Return a survey of the week: row B is nearly full, C mostly empty, the first stall of A always taken."""
    rng = np.random.default_rng(number)
    ended = (MONDAY + timedelta(days=day, hours=hour)).timestamp()
    whole = survey(stalls=60, seed=number)
    stalls = []
    for each in whole.stalls:
        is_taken = each.id == 1 or rng.random() < _SHARES[(each.id - 1) // 20]
        state, chance = (StallState.TAKEN, 0.98) if is_taken else (StallState.FREE, 0.02)
        stalls.append(replace(each, state=state, taken_probability=chance, looked_at=ended - 60, score=0.9))
    stalls[47] = replace(stalls[47], state=StallState.UNKNOWN, taken_probability=0.5)
    return replace(whole, name=f"{number:06d}-X", began=ended - 600, ended=ended, stalls=tuple(stalls))


def mosaic() -> dict[TileKey, EncodedTile]:
    """Return a picture of grey ground from 26 m north of the datum to as far south, 26 m west to 77 m east."""
    rng = np.random.default_rng(1)
    seen = np.full((TILE_CELLS, TILE_CELLS), 255, np.uint8)
    tile = EncodedTile(1, encode_picture(rng.integers(80, 90, (TILE_CELLS, TILE_CELLS, 3)).astype(np.uint8), seen))
    return {(row, column): tile for row in (-1, 0) for column in (-1, 0, 1, 2)}


class Week(Archive):
    """The lot; its newest survey has a picture, its fourth one was deleted where that is asked for."""

    def __init__(self, folder: Path, surveys: int = len(FLOWN)) -> None:
        super().__init__(folder / "lots.db")
        self.path = folder / "lots.db"
        self.pictures: PictureFolder = pictures_of(self.path)
        self.surveys = [self.add(flown(number, *FLOWN[number])).survey for number in range(surveys)]
        if not self.surveys:
            return
        self.pictures.write(self.surveys[-1], mosaic())
        self.edit({"do": "set_kind", "row": "B", "kind": "disabled"}, {"do": "draw_zone", "name": ZONE, "kind": "",
                  "outline": [[-20.0, -3.0], [-12.0, -3.0], [-12.0, 20.0], [-20.0, 20.0]]})  # fmt: skip
        with self.store.writing() as connection:
            commands.rename(connection, self.lot, NAME, "operator", NOW)

    def delete(self, number: int) -> None:
        with self.store.writing() as connection:
            commands.delete(connection, self.surveys[number], "operator", NOW)

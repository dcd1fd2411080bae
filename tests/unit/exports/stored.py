"""A stored lot of 60 stalls in three rows, its middle row with kinds, and the picture of its first survey."""

from __future__ import annotations

import copy
import shutil
from pathlib import Path
from typing import Self

import numpy as np

from hawk.exports.records import read_survey
from hawk.exports.values import ExportRecord
from hawk.lots.storage.database import Database
from hawk.lots.survey.pictures import PictureFolder
from hawk.lots.values import Saved
from hawk.model.lot_map import TILE_CELLS, EncodedTile, TileKey
from hawk.model.tile_picture import encode_picture
from tests.unit.lots.plan.plans import FAST
from tests.unit.lots.repaints import Archive, flown

NAME = "=Étoile <b>& Söhne</b>"
"""A name that is a formula to a spreadsheet, HTML to a browser, and no ASCII."""


FILE, PICTURES = "lots.db", "lots-pictures"


class Stored(Archive):
    """The lot with its first survey; `add` flies on."""

    def __init__(self, folder: Path) -> None:
        super().__init__(folder / FILE)
        self.pictures = PictureFolder(folder / PICTURES)
        self.first: Saved = self.add(flown(1))
        self.pictures.write(self.first.survey, mosaic())
        self.edit({"do": "set_kind", "row": "B", "kind": "disabled"})

    def copied(self, folder: Path) -> Self:
        """Return a copy of this store, which is closed, in another folder."""
        found = copy.copy(self)
        here = self.store.path.parent
        shutil.copyfile(here / FILE, folder / FILE)
        shutil.copytree(here / PICTURES, folder / PICTURES)
        found.store = Database(folder / FILE, FAST)
        found.pictures = PictureFolder(folder / PICTURES)
        return found

    def read(self, survey: str = "") -> ExportRecord:  # type: ignore[override]
        with self.store.reading() as connection:
            return read_survey(connection, survey or self.first.survey)


def mosaic() -> dict[TileKey, EncodedTile]:
    """Return a picture of noise from 26 m north of the datum to as far south, 26 m west to 77 m east."""
    rng = np.random.default_rng(1)
    seen = np.full((TILE_CELLS, TILE_CELLS), 255, np.uint8)
    pixels = rng.integers(60, 100, (TILE_CELLS, TILE_CELLS, 3)).astype(np.uint8)
    tile = EncodedTile(1, encode_picture(pixels, seen))
    return {(row, column): tile for row in (-1, 0) for column in (-1, 0, 1, 2)}

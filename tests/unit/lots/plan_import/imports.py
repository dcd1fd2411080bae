"""Imports of drawn plans into drawn lots, for the tests."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import shapely

from hawk.daemon.lots.keeper import find_stalls
from hawk.lots.plan import geometry
from hawk.lots.plan_files.child import packed, unpacked
from hawk.lots.plan_files.formats import read_plan
from hawk.lots.plan_import import transfer
from hawk.lots.plan_import.choices import asked_of
from hawk.lots.plan_import.previews import Preview, preview, shown_preview
from hawk.lots.values import Register
from hawk.results.survey_map import to_global
from tests.unit.lots.plan.plans import APART_M, DEEP_M, NOW, PITCH_M, Person
from tests.unit.lots.plan_files.files import DATUM, feature, geojson

Json = dict[str, Any]


def drawn(
    stalls: int = 30, a_row: int = 10, north: float = 0.0, east: float = 0.0, pitch: float = PITCH_M, first: int = 1
) -> list[Json]:
    """Return the features of rows as those of `drawn_lot`, moved by metres, with the labels 1, 2 and so on."""
    across, along = np.divmod(np.arange(stalls), a_row)
    sizes = np.tile([0.0, pitch, DEEP_M], (stalls, 1))
    shapes = np.column_stack([north - across * APART_M, east + along * pitch, sizes])
    rings = shapely.get_coordinates(geometry.polygons(shapes))
    places = to_global(DATUM, rings)[:, ::-1].reshape(stalls, 5, 2).tolist()
    return [feature([ring], ref=str(number)) for number, ring in enumerate(places, first)]


class Importer(Person):
    """A person who imports plans into a lot of three rows of ten."""

    register: Register | None = staticmethod(find_stalls)

    def preview(self, data: bytes, *pins: str, is_new: bool = False, **asked: str) -> Preview:
        chosen = asked_of({"name": "plan.geojson", **asked}, pins)
        plan = unpacked(packed(read_plan(data, chosen.file)))  # as the box hands it over
        with self.store.reading() as connection:
            return preview(connection, None if is_new else self.lot, plan, chosen, self.register)

    def shown(self, data: bytes, *pins: str, **asked: Any) -> Json:  # type: ignore[override]
        found: Json = shown_preview(self.preview(data, *pins, **asked), "token").model_dump()
        return found

    def take(self, data: bytes, *pins: str, **asked: Any) -> Json:
        uncertain = asked.pop("uncertain", False)
        return self.take_preview(self.preview(data, *pins, **asked), uncertain=uncertain)

    def take_preview(self, found: Preview, uncertain: bool = False) -> Json:
        asked = {"edit": self.edit, "uncertain": uncertain}
        with self.store.writing() as connection:
            answer: Json = transfer.take(connection, found, asked, NOW).model_dump(mode="json")
        return answer

    def begin(self, data: bytes, name: object = "North", **asked: Any) -> Json:
        found = self.preview(data, is_new=True, **asked)
        with self.store.writing() as connection:
            return transfer.begin(connection, found, {"name": name}, "Ann", NOW).model_dump()


def importer(folder: Path, stalls: int = 30) -> Importer:
    return Importer.at_work(folder / "lots.db", stalls)  # type: ignore[return-value]


__all__ = ["DEEP_M", "Importer", "drawn", "geojson", "importer"]

"""A drone with a store whose surveys are sent as documents, and the days of its life, for the tests."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from sqlalchemy import Connection, select

from hawk.daemon.lots.keeper import find_stalls
from hawk.lots import commands
from hawk.lots.documents import parts, source, survey_document
from hawk.lots.documents.collection import DocumentOutcome, collect
from hawk.lots.documents.survey_document import SurveyDocument
from hawk.lots.ingest import save
from hawk.lots.plan import edits
from hawk.lots.storage.database import Database
from hawk.lots.storage.schema import SURVEY
from hawk.lots.survey.source import Limit, PictureSource, SourceKind
from hawk.lots.values import FinishedSurvey, Saved, VehicleDetection
from hawk.model.lot_map import TileKey
from hawk.model.tile_picture import encode_picture
from hawk.model.vehicles import VehicleKind
from tests.unit.lots.plan.plans import FAST
from tests.unit.lots.surveys import box, later, survey

WHO, NOW = "operator", 1_770_100_000.0
DRONE = "Drone 1"
FAR_M = 2000.0


def tile(shade: int = 90) -> bytes:
    """Return the picture of a tile."""
    return encode_picture(np.full((256, 256, 3), shade, np.uint8), np.full((256, 256), 255, np.uint8))


def vehicle(number: int, north: float, east: float) -> VehicleDetection:
    """Return a car of a survey."""
    shape = {"north": north, "east": east, "angle": 1.5, "width": 1.9, "length": 4.5}
    return VehicleDetection(
        id=number, kind=VehicleKind.CAR, **shape, probability=0.9, looks=3, stood_s=20.0, looked_at=NOW
    )


@dataclass
class Drone:
    """Its store, and the documents that it would have sent."""

    store: Database
    sent: list[bytes] = field(default_factory=list)
    now: float = NOW

    @classmethod
    def at(cls, path: Path) -> Drone:
        return cls(Database(path, FAST))

    def copied(self, folder: Path) -> Drone:
        """Return a copy of a drone whose store is closed."""
        return replace(self, store=Database(Path(shutil.copy(self.store.path, folder)), FAST), sent=[*self.sent])

    def add(self, given: FinishedSurvey) -> Saved:
        with self.store.writing() as connection:
            return save(connection, given, find_stalls)

    def do(self, act: Callable[..., Any], *given: Any) -> Any:
        with self.store.writing() as connection:
            return act(connection, *given)

    def edit(self, lot: str, *operations: Mapping[str, Any]) -> None:
        opened = self.do(edits.open_edit, lot, {"who": "Ann"}, self.now)
        try:
            for each in operations:
                self.do(edits.do, lot, {"edit": opened.edit, "operation": each}, self.now)
        finally:
            self.do(edits.close, lot, {"edit": opened.edit}, self.now)

    def document(self, named: str, mosaic: Mapping[TileKey, bytes] | None = None) -> SurveyDocument:
        with self.store.reading() as connection:
            return source.document_of(connection, named, mosaic or {})

    def documents(self) -> list[SurveyDocument]:
        with self.store.reading() as connection:
            return [source.document_of(connection, each, {}) for each in _surveys(connection)]

    def send(self) -> None:
        """Note the documents of all surveys as they are now."""
        self.sent += [data for each in self.documents() if (data := parts.packed(each)) not in self.sent]


def _surveys(connection: Connection) -> Sequence[str]:
    return connection.execute(select(SURVEY.c.id).order_by(SURVEY.c.seq)).scalars().all()


def collected(store: Database, data: bytes, writer: str = DRONE) -> DocumentOutcome:
    """Take a document in, as it travels."""
    document = survey_document.unpacked(data)
    with store.writing() as connection:
        return collect(connection, document, writer, find_stalls)


def photographs(number: int, hours: float) -> FinishedSurvey:
    """Return a survey by photographs whose time is not sure."""
    pictures = PictureSource(SourceKind.PHOTOGRAPHS, "flight", (Limit.BY_GPS,))
    return replace(later(survey(seed=number), number, hours), pictures=pictures, time_is_sure=False)


def days(drone: Drone) -> Iterator[None]:
    """Let a drone live; stop after each thing that changes a survey or a lot."""
    first = drone.add(survey())
    assert first.lot is not None
    yield
    drone.add(survey(stalls=60))  # it went on after a battery swap, over a third row
    yield
    second = drone.add(later(survey(seed=2, stalls=60), 2))
    yield
    drone.edit(first.lot, {"do": "remove", "row": "C"}, {"do": "rename", "row": "A", "to": "X"})
    yield
    cars = (vehicle(1, -1.0, 60.0), vehicle(2, -1.0, 66.0))
    ring = [[-6.0, 52.0], [6.0, 52.0], [6.0, 80.0], [-6.0, 80.0]]
    drone.edit(first.lot, {"do": "draw_section", "name": "Kerb", "outline": ring, "kind": "parallel"})
    drone.add(replace(later(survey(seed=3), 3, 48.0), vehicles=cars))
    yield
    drone.do(commands.rename, first.lot, "North", WHO, NOW)
    drone.do(commands.choose_time_zone, first.lot, "Europe/Oslo", WHO, NOW)
    yield
    gone = drone.do(commands.delete, second.survey, WHO, NOW)
    yield
    drone.do(commands.undo, gone.seq, NOW)
    yield
    drone.add(replace(later(survey(seed=4), 4, -30.0)))  # its clock is behind
    drone.add(photographs(5, 20.0))
    yield
    part = [list(corner) for corner in box(-4, -4, 9, 26).polygons[0]]
    drone.do(commands.split, first.lot, {"name": "South", "outline": part}, WHO, NOW)
    yield
    moved = drone.add(later(survey(seed=6), 6, 72.0))
    other = drone.do(commands.move, moved.survey, {"lot": None, "name": "East"}, WHO, NOW, None)
    yield
    joined = drone.do(commands.merge, first.lot, other.lot, WHO, NOW)
    yield
    drone.do(commands.undo, joined.seq, NOW)
    yield
    drone.do(commands.merge, other.lot, first.lot, WHO, NOW)
    yield
    drone.add(later(survey(seed=7), 7, 96.0))
    yield

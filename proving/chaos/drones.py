"""Drones whose stores grow and change while all else fails, and the tables that a desk is to have of them."""

from __future__ import annotations

import contextlib
import random
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final

from sqlalchemy import Connection, select

from hawk.config.sections import StoreSettings
from hawk.daemon.lots.keeper import find_stalls
from hawk.lots import commands, outbox
from hawk.lots.documents import parts, source, survey_document
from hawk.lots.documents.collection import collect
from hawk.lots.ingest import save
from hawk.lots.storage.database import Database
from hawk.lots.storage.schema import OBSERVATION, STALL, SURVEY
from hawk.lots.store import FILE
from hawk.lots.values import FinishedSurvey, LotInputError
from hawk.model.plans import Outline
from hawk.store.recordings import Recordings
from proving.chaos.senders import TOKEN
from tests.unit.lots.documents.tables import tables
from tests.unit.lots.surveys import later, survey
from tests.unit.store.recorded import recorded

APART_DEG: Final = 0.02
"""Latitude between the lots of two drones: 2 km."""
TABLES: Final = ("lot", "layout", "zone", "section", "observation", "section_look", "order")
"""Tables of a desk that are those of its drones, but for numbers (tests/unit/lots/documents)."""
_NEW_SHARE: Final = 0.7
"""Share of changes that are a further survey."""
_STALLS: Final = 40
_SECONDS: Final = 2000
"""Of a recording, 4 MB."""


@dataclass
class ChaosDrone:
    """A drone: its ``name`` at the desk, its ``folder`` and its ``number``; ``surveys``: those stored so far."""

    name: str
    folder: Path
    number: int
    surveys: int = 0
    base: Database = field(init=False, repr=False)
    _deleted: list[int] = field(default_factory=list, repr=False)

    def __post_init__(self) -> None:
        """Make the store."""
        self.folder.mkdir(parents=True, exist_ok=True)
        self.base = Database(self.folder / FILE)

    @property
    def token_file(self) -> Path:
        """File of the token for the desk."""
        return self.folder / TOKEN

    def change(self, rng: random.Random, now: float) -> None:
        """Store a further survey, or rename the lot, delete a survey or take that back."""
        drawn = rng.random()
        with self.base.writing() as connection:
            if self.surveys == 0 or drawn < _NEW_SHARE:
                self.surveys += 1
                if self.surveys == 1:
                    recorded(self.recording, self._name(1), range(_SECONDS), rng.randbytes(1000).hex())
                save(connection, self._survey(self.surveys), find_stalls)
                return
            row = connection.execute(select(SURVEY.c.id, SURVEY.c.lot).where(SURVEY.c.lot.is_not(None))).first()
            if drawn < (1 + _NEW_SHARE) / 2 and row is not None:
                commands.rename(connection, row.lot, f"{self.name}, name {rng.randrange(1000)}", "operator", now)
            elif self._deleted:
                commands.undo(connection, self._deleted.pop(), now)
            elif row is not None:
                with contextlib.suppress(LotInputError):
                    self._deleted.append(commands.delete(connection, row.id, "operator", now).seq)

    def take_back(self, now: float) -> None:
        """Take all deletions back: nobody gives the recording of a deleted survey."""
        while self._deleted:
            with self.base.writing() as connection:
                commands.undo(connection, self._deleted.pop(), now)

    def is_sent(self, target: str, now: float) -> bool:
        """Return True when the desk has every state."""
        with self.base.reading() as connection:
            return outbox.due_state(connection, target, now) is None

    @property
    def recording(self) -> Path:
        """The recording of the first survey."""
        return Recordings(StoreSettings(directory=self.folder)).folder / f"20260501T10{self.number:02d}00Z.mcap"

    def first_survey(self) -> str:
        """Return the id of the survey that is recorded."""
        with self.base.reading() as connection:
            return str(connection.execute(select(SURVEY.c.id).order_by(SURVEY.c.seq)).scalars().first())

    def _name(self, number: int) -> str:
        return f"{self.number:02d}-{number:04d}"

    def _survey(self, number: int) -> FinishedSurvey:
        given = later(survey(stalls=_STALLS, seed=1000 * self.number + number), number, 2.0 * number)
        north = APART_DEG * self.number
        return replace(
            given,
            name=self._name(number),
            datum=replace(given.datum, latitude=given.datum.latitude + north),
            outline=_moved(given.outline, north),
            seen_ground=_moved(given.seen_ground, north),
        )


def _moved(outline: Outline, north: float) -> Outline:
    return Outline(tuple(tuple((a + north, b) for a, b in ring) for ring in outline.polygons))


def other_recordings(drones: Sequence[ChaosDrone], desk: Path) -> list[ChaosDrone]:
    """Return the drones whose recording a desk, by its folder, has not byte for byte."""
    here = Counter(path.read_bytes() for path in Recordings(StoreSettings(directory=desk)).folder.glob("*.mcap"))
    return [drone for drone in drones if here[drone.recording.read_bytes()] != 1]


def reference(drones: Sequence[ChaosDrone], path: Path) -> Database:
    """Return a desk's store that got the last state of every survey, one after the other, without a fault."""
    desk = Database(path, {"synchronous": 0})
    for drone in drones:
        with drone.base.reading() as connection:
            ids = connection.execute(select(SURVEY.c.id).order_by(SURVEY.c.seq)).scalars().all()
            documents = [parts.packed(source.document_of(connection, each, {})) for each in ids]
        for data in documents:
            with desk.writing() as connection:
                collect(connection, survey_document.unpacked(data), drone.name, find_stalls)
    return desk


@dataclass(frozen=True, slots=True)
class Difference:
    """Surveys and looks at stalls that a desk lacks or has twice, and rows of tables that it has otherwise than without
    faults. ``surveys``: those of all drones.
    """

    surveys: int
    lost: int
    doubled: int
    other_rows: Mapping[str, int]


def difference(desk: Database, wanted: Database) -> Difference:
    """Compare a desk's store with that of `reference`."""
    here, there = (_ids(each) for each in (desk, wanted))
    with desk.reading() as one, wanted.reading() as other:
        found, expected = tables(one), tables(other)
    rows = {name: _other(found[name], expected[name]) for name in TABLES}
    surveys = sum(isinstance(each, str) for each in there)
    return Difference(surveys, (there - here).total(), (here - there).total(), {k: n for k, n in rows.items() if n})


def _other(found: Sequence[str], expected: Sequence[str]) -> int:
    one, two = Counter(found), Counter(expected)
    return max((one - two).total(), (two - one).total())


def _ids(base: Database) -> Counter[Any]:
    """Return how often each survey, and each look of a survey at a stall, is in a store."""
    with base.reading() as connection:
        return Counter([*connection.execute(select(SURVEY.c.id)).scalars(), *_looks(connection)])


def _looks(connection: Connection) -> Sequence[tuple[str, str]]:
    asked = select(SURVEY.c.id, STALL.c.id).join(OBSERVATION, OBSERVATION.c.survey == SURVEY.c.seq)
    rows = connection.execute(asked.join(STALL, STALL.c.key == OBSERVATION.c.stall))
    return [(row[0], row[1]) for row in rows]

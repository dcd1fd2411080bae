"""A lot of three rows that is painted again between surveys, for the tests of proposals."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from hawk.lots import commands
from hawk.lots.answers import Done
from hawk.lots.change_detection import proposals
from hawk.lots.ingest import save
from hawk.lots.plan import edits
from hawk.lots.registration.frames import same_stalls
from hawk.lots.storage.database import Database
from hawk.lots.values import Detection, FinishedSurvey, KnownGround, MappedGround, Register, Registration, Saved
from tests.unit.lots import whole
from tests.unit.lots.surveys import A_ROW, later, survey

NOW = 1_770_900_000.0
WIDER_M, WIDER = 2.5 * 20 / 18, 18
"""Pitch and count of the middle row when it is painted again."""


def by_place(known: KnownGround, found: MappedGround) -> Registration:
    """Find the stalls of surveys whose receivers do not err."""
    return Registration(0.0, 0.0, 0.0, same_stalls(known.stalls, found.stalls))


def flown(number: int, stalls: Iterable[Detection] | None = None) -> FinishedSurvey:
    """Return survey ``number`` of the lot, with its own small errors; ``stalls`` in place of its own."""
    made = later(survey(stalls=60, seed=number), number, hours=24.0 * number)
    return made if stalls is None else replace(made, stalls=tuple(stalls))


def repainted(number: int) -> FinishedSurvey:
    """Return a survey of the lot after its middle row was painted again: 18 stalls where 20 were."""
    own = flown(number).stalls
    middle = own[A_ROW : A_ROW + WIDER]
    row = [replace(each, east=(k + 0.5) * WIDER_M - 1.25, width=WIDER_M) for k, each in enumerate(middle)]
    return flown(number, (*own[:A_ROW], *row, *own[2 * A_ROW :]))


def without(given: FinishedSurvey, *numbers: int) -> FinishedSurvey:
    """Return a survey that did not find some stalls."""
    return replace(given, stalls=tuple(stall for stall in given.stalls if stall.id not in numbers))


def extra(given: FinishedSurvey, number: int = 90) -> FinishedSurvey:
    """Return a survey that found one more stall, at the eastern end of the first row."""
    last = given.stalls[A_ROW - 1]
    return replace(given, stalls=(*given.stalls, replace(last, id=number, east=20 * 2.5 + 0.05, north=0.05)))


class Archive:
    """A store of one lot."""

    def __init__(self, path: Path) -> None:
        self.store = Database(path, {"synchronous": 0})
        self.lot = ""

    def add(self, given: FinishedSurvey, register: Register = by_place) -> Saved:
        with self.store.writing() as connection:
            saved = save(connection, given, register)
        self.lot = self.lot or saved.lot or ""
        return saved

    def changes(self) -> list[dict[str, Any]]:
        with self.store.reading() as connection:
            found: list[dict[str, Any]] = proposals.proposed(connection, self.lot).model_dump(mode="json")["surveys"]
        return found

    def newest(self) -> tuple[set[int], set[str]]:
        """Return the newest survey's proposals: numbers of stalls that begin, labels of those that end."""
        found = self.changes()
        if not found:
            return set(), set()
        return {each["id"] for each in found[0]["begin"]}, {each["label"] for each in found[0]["end"]}

    def take_over(self, survey: str, who: str = "operator", **asked: object) -> Done:
        with self.store.writing() as connection:
            return commands.take_over(connection, self.lot, {"survey": survey, **asked}, who, NOW)

    def drop(self, survey: str, **asked: object) -> Done:
        with self.store.writing() as connection:
            return commands.drop(connection, self.lot, {"survey": survey, **asked}, "operator", NOW)

    def undo(self, done: Done) -> str:
        with self.store.writing() as connection:
            return commands.undo(connection, done.seq, NOW)

    def read(self) -> dict[str, Any]:
        with self.store.reading() as connection:
            return {**whole.lot(connection, self.lot), "revision": 0}

    def stalls(self) -> dict[str, str]:
        """Return the ids of the stalls by label."""
        return {each["label"]: each["id"] for each in self.read()["stalls"]}

    def edit(self, *operations: Mapping[str, object]) -> int:
        """Do operations on the plan as one edit; return the number of the change."""
        with self.store.writing() as connection:
            edit = edits.open_edit(connection, self.lot, {"who": "Ann"}, NOW).edit
            for operation in operations:
                edits.do(connection, self.lot, {"edit": edit, "operation": operation}, NOW)
            return edits.close(connection, self.lot, {"edit": edit}, NOW).seq or 0

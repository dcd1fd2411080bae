"""An inbox whose mapping is a stub at the border of the process, and a power cut at any step."""

from __future__ import annotations

import sqlite3
import uuid
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from unittest import mock

from hawk.picture.inbox.app import Inbox, InboxNotice, Surroundings
from hawk.picture.inbox.flights import FlightReader
from hawk.picture.inbox.folder import Folder
from hawk.picture.inbox.journal import PICTURES, Flight, Journal
from hawk.picture.inbox.map_process import MapReport, MapResult
from tests.unit.picture.photographs.photos import flight as photographed

SETTLE_S = 10.0


class CutError(BaseException):
    """The power is cut: nothing after this moment is done."""


def map_report(survey: str, **changes: Any) -> MapReport:
    """Return what the command says of a survey."""
    counts = {"stalls": 3, "free": 1, "taken": 2, "unknown": 0, "free_range": (1, 2)}
    said = {"lot_name": "yard", "time_is_sure": True, "notes": (), "left_out": ()}
    stored = {"store": "Stored in store as the first survey of yard", "stored_survey": survey}
    values: dict[str, Any] = {**counts, **said, **stored}
    return MapReport.model_validate(values | changes)


@dataclass
class Store:
    """Surveys by the id of their flight: the contents of the pictures. ``says``: ends of the next mappings."""

    surveys: dict[str, frozenset[bytes]] = field(default_factory=dict)
    mapped: list[str] = field(default_factory=list)
    says: list[MapResult] = field(default_factory=list)

    def __call__(self, flight: Flight, home: Path) -> MapResult:
        """Map the pictures of a flight's folder."""
        contents = [path.read_bytes() for path in (home / PICTURES).rglob("*") if path.is_file()]
        if self.says:
            return self.says.pop(0)
        if any(b"no picture" in each for each in contents):
            return MapResult(None, f"{home / PICTURES}: no photograph can be used")
        self.surveys[flight.id] = frozenset(contents)
        self.mapped.append(flight.name)
        return MapResult(map_report(str(uuid.uuid5(uuid.NAMESPACE_URL, flight.id))))

    def has(self, survey: str) -> bool:
        """Return whether the survey of an id is stored."""
        return survey in {str(uuid.uuid5(uuid.NAMESPACE_URL, each)) for each in self.surveys}


@dataclass
class Bench:
    """A folder, a store, and the inbox between them, which can be ended and started at any time."""

    root: Path
    store: Store = field(default_factory=Store)
    said: list[InboxNotice] = field(default_factory=list)
    now: float = 0.0
    free: int = 10**12

    def __post_init__(self) -> None:
        self.inbox.mkdir()
        self.place.mkdir()

    @property
    def inbox(self) -> Path:
        """Return the folder that others fill."""
        return self.root / "inbox"

    @property
    def place(self) -> Path:
        """Return the store's folder."""
        return self.root / "store"

    @contextmanager
    def running(self) -> Iterator[Callable[[], bool]]:
        """Start the inbox; give the function that lets it look and work once."""
        around = Surroundings(self.store, self.store.has, self.said.append, lambda: 1.7e9, lambda _: self.free)
        with Journal(self.place) as journal:
            inbox = Inbox(Folder(self.inbox, SETTLE_S), self.place, journal, FlightReader(self.inbox), around)

            def step() -> bool:
                self.now += SETTLE_S
                return inbox.step(self.now)

            yield step

    def run(self, steps: int = 12) -> None:
        """Run until nothing is left to do, ``steps`` at most."""
        with self.running() as step:
            for _ in range(steps):
                step()

    def tree(self) -> set[str]:
        """Return the files in the folder, but those of surveys."""
        files = (path for path in self.inbox.rglob("*") if path.is_file())
        return {path.relative_to(self.inbox).as_posix() for path in files}

    def report(self, path: str) -> str:
        """Return the report of a folder."""
        return (self.inbox / path / "report.txt").read_text()


@contextmanager
def cut_after(steps: int) -> Iterator[None]:
    """Cut the power before the step of this number: every rename, new folder, report and transaction is one."""
    left = [steps]

    def counted(work: Callable[..., Any]) -> Callable[..., Any]:
        def step(*given: Any, **named: Any) -> Any:
            if left[0] == 0:
                raise CutError
            left[0] -= 1
            return work(*given, **named)

        return step

    with (
        mock.patch.object(Path, "rename", counted(Path.rename)),
        mock.patch.object(Path, "replace", counted(Path.replace)),
        mock.patch.object(Path, "mkdir", counted(Path.mkdir)),
        mock.patch.object(Path, "rmdir", counted(Path.rmdir)),
        mock.patch.object(Journal, "_set", counted(Journal._set)),
        mock.patch.object(Journal, "_plan", counted(Journal._plan)),
        mock.patch.object(Store, "__call__", counted(Store.__call__)),
    ):
        yield


def pictures(folder: Path, **how: Any) -> dict[str, bytes]:
    """Return the photographs of a flight by name."""
    folder.mkdir(parents=True, exist_ok=True)
    return {path.name: path.read_bytes() for path in photographed(folder, **how)}


def drop(folder: Path, files: dict[str, bytes]) -> None:
    """Put files into a folder, which is made."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, data in files.items():
        (folder / name).write_bytes(data)


def rows(bench: Bench, asked: str) -> list[Any]:
    """Return rows of the journal."""
    base = sqlite3.connect(bench.place / "inbox.db")
    try:
        return base.execute(asked).fetchall()
    finally:
        base.close()

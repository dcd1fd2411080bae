from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from hawk.lots.storage.database import Database
from hawk.lots.survey.pictures import pictures_of
from hawk.report.options import Wanted
from hawk.report.queries import read_report
from hawk.report.values import Report
from hawk.stats.use_query import asked_of
from tests.unit.report.week import NOW, Week

Read = Callable[..., Report]


@pytest.fixture(scope="session")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """The folder of a week whose fourth survey was deleted, and the id of its lot; no test changes the files."""
    folder = tmp_path_factory.mktemp("week")
    week = Week(folder)
    week.delete(3)
    week.store.close()
    return folder, week.lot


@pytest.fixture
def folder(made: tuple[Path, str], tmp_path: Path) -> Path:
    """A copy of the week that a test may change."""
    return Path(shutil.copytree(made[0], tmp_path / "week"))


@pytest.fixture
def read(folder: Path, made: tuple[Path, str]) -> Iterator[Read]:
    """Read a report of the week by options as those of the command."""
    store = Database(folder / "lots.db")

    def report(
        weekday: str | None = None, hour: str | None = None, *, has_ground: bool = True, begin: str | None = None,
        end: str | None = None, time_zone: str | None = None, **parts: tuple[str, ...],
    ) -> Report:  # fmt: skip
        asked = asked_of(weekday, hour, **parts)
        wanted = Wanted(made[1], asked, begin, end, time_zone, has_ground)
        with store.reading() as connection:
            return read_report(connection, pictures_of(folder / "lots.db"), wanted, NOW)

    yield report
    store.close()

"""Exit statuses of the commands that open the store: 2 for what the person asked wrongly, 1 for what failed."""

from __future__ import annotations

from pathlib import Path

import pytest

from hawk.cli import main
from hawk.lots.ingest import save
from hawk.lots.storage.database import Database
from hawk.lots.store import FILE
from hawk.lots.values import LotInputError, LotStoreError
from tests.unit.lots.plan_import.imports import drawn, geojson
from tests.unit.lots.surveys import survey

COMMANDS = {
    "export": ["export", "Lot 1", "--out", "DIR/lot.csv"],
    "stats": ["stats", "Lot 1"],
    "import-plan": ["import-plan", "DIR/plan.geojson", "--lot", "Lot 1"],
    "erase": ["erase", "--lot", "Lot 1", "--yes"],
    "backup": ["backup", "DIR/copy.db"],
    "verify": ["verify"],
    "restore": ["restore", "DIR/plan.geojson"],
}
"""Each command in words that a store of one lot takes, but for the backup."""


def run(folder: Path, arguments: list[str], *more: str) -> int:
    store = str(folder / "store")
    return main([*(each.replace("DIR", str(folder)) for each in arguments), *more, "--store", store])


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "store").mkdir()
    (tmp_path / "plan.geojson").write_bytes(geojson(drawn(3)))
    store = Database(tmp_path / "store" / FILE)
    with store.writing() as connection:
        save(connection, survey(stalls=6))
    store.close()
    return tmp_path


@pytest.mark.slow
@pytest.mark.parametrize("name", COMMANDS)
def test_a_store_that_cannot_be_read_is_a_failure(name: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "store" / FILE).write_bytes(b"no database" * 1000)
    assert run(folder, COMMANDS[name]) == 1
    assert capsys.readouterr().err.startswith("hawk-drone: ")


@pytest.mark.slow
@pytest.mark.parametrize("name", ["export", "stats", "import-plan", "erase"])
def test_a_lot_that_is_not_there_is_asked_for_wrongly(
    name: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(folder, [each.replace("Lot 1", "Lot 9") for each in COMMANDS[name]]) == 2
    said = capsys.readouterr().err
    assert "'Lot 9'; there are" in said
    assert "Lot 1" in said


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("name", "more", "words"),
    [
        ("export", ("--survey", "zz"), "--survey: there is no survey 'zz'"),
        ("export", ("--survey", "all"), "--out: lot.csv holds one survey"),
        ("stats", ("--from", "yesterday"), "--from: must be a date"),
        ("import-plan", ("--crs", "x"), "--crs: x is no system that is known"),
        ("import-plan", ("--pin", "1,2"), "--pin: must be x,y,latitude,longitude"),
        ("backup", ("--sim-speed",), "unrecognized arguments: --sim-speed"),
    ],
)
def test_an_option_that_cannot_be_used_is_named(
    name: str, more: tuple[str, ...], words: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(folder, COMMANDS[name], *more) == 2
    assert words in capsys.readouterr().err


@pytest.mark.parametrize("name", ["export", "stats", "backup", "verify"])
def test_what_the_store_takes_ends_well(name: str, folder: Path) -> None:
    assert run(folder, COMMANDS[name]) == 0


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (OSError(28, "No space left", "/x/lots.db"), "/x/lots.db: No space left"),
        (OSError(28, "No space left"), "copy.db: No space left"),
        (OSError("torn"), "copy.db: torn"),
        (LotInputError("file", "is none"), "copy.db: file: is none"),
        (LotInputError("config", "is odd"), "--config: is odd"),
        (LotInputError("other", "is odd"), "copy.db: other: is odd"),
        (LotStoreError("is damaged"), "is damaged"),
    ],
)
def test_an_error_names_its_file_or_its_option(
    error: Exception, words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fail(*_: object) -> None:
        raise error

    monkeypatch.setattr("hawk.lots.storage.backup.backup", fail)
    assert run(tmp_path, COMMANDS["backup"]) == (2 if isinstance(error, LotInputError) else 1)
    assert capsys.readouterr().err.replace(f"{tmp_path}/", "") == f"hawk-drone: {words}\n"


def test_an_error_of_a_command_without_a_file_names_the_store(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fail(*_: object) -> None:
        raise OSError(5, "Input/output error")

    monkeypatch.setattr("hawk.lots.storage.backup.verify", fail)
    assert run(folder, COMMANDS["verify"]) == 1
    assert capsys.readouterr().err == "hawk-drone: --store: Input/output error\n"

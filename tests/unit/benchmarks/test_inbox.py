"""The benchmark of an inbox finds what is lost and what is stored twice; every manner of dropping brings every byte."""

from __future__ import annotations

import contextlib
import random
import sqlite3
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import pytest

from benchmarks.inbox import FIRST_DAY, KINDS, Files, Folders, actions, judge

FLIGHTS: list[Files] = [
    {f"{number}-{shot}.JPG": f"{number} {shot}".encode() for shot in range(4)} for number in range(3)
]


def stored(root: Path, surveys: Sequence[int], mapped: Sequence[int], kept: Sequence[int]) -> Folders:
    """Write what a run leaves: numbers of the flights of surveys, of mapped photographs, and of files in done."""
    folders = Folders(root)
    folders.store.mkdir()
    day = FIRST_DAY.timestamp() + 37_800.0
    with contextlib.closing(sqlite3.connect(folders.store / "lots.db")) as base:
        base.execute("CREATE TABLE survey (ended REAL)")
        base.executemany("INSERT INTO survey VALUES (?)", [(day + 86_400.0 * each,) for each in surveys])
        base.commit()
    with contextlib.closing(sqlite3.connect(folders.store / "inbox.db")) as base:
        base.execute("CREATE TABLE picture (time REAL, is_mapped INTEGER)")
        base.executemany("INSERT INTO picture VALUES (?, 1)", [(day + 86_400.0 * each,) for each in mapped])
        base.commit()
    for number in kept:
        folder = folders.inbox / f"done/{number}/pictures"
        folder.mkdir(parents=True)
        for name, data in FLIGHTS[number].items():
            (folder / name).write_bytes(data)
    return folders


@pytest.mark.parametrize(
    ("surveys", "mapped", "kept", "found"),
    [
        ([0, 1, 2], [0, 1, 2] * 4, [0, 1, 2], (0, 0)),
        ([0, 2], [0, 1, 2] * 4, [0, 1, 2], (1, 0)),
        ([0, 1, 2, 2], [0, 1, 2] * 4, [0, 1, 2], (0, 1)),
        ([0, 1, 2], [0, 1, 2] * 3 + [0], [0, 1, 2], (2, 0)),
        ([0, 1, 2], [0, 1, 2] * 4, [0, 1], (1, 0)),
    ],
)
def test_what_is_lost_and_what_is_doubled_is_found(
    tmp_path: Path, surveys: list[int], mapped: list[int], kept: list[int], found: tuple[int, int]
) -> None:
    assert judge(stored(tmp_path, surveys, mapped, kept), FLIGHTS) == found


def test_each_kind_of_drop_brings_every_byte(tmp_path: Path) -> None:
    flights: list[Files] = [
        {f"{number}-{shot}.JPG": f"{number} {shot}".encode() for shot in range(4)} for number in range(40)
    ]
    steps = actions(flights, tmp_path, random.Random(1))
    assert len({len(each) for each in steps}) >= 3
    for each in steps:
        for step in each:
            step()
    found = Counter(path.read_bytes() for path in tmp_path.rglob("*") if path.is_file())
    assert set(found) == {data for files in flights for data in files.values()}
    assert set(found.values()) == {1, 2}
    assert {path.suffix for path in tmp_path.rglob("*") if path.is_file()} == {".JPG"}
    assert len(KINDS) == 6

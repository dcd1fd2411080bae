from __future__ import annotations

import os
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.config.sections import StoreSettings
from hawk.store.recording_file import RecordingFile, start_metadata
from hawk.store.recordings import DAY_S, Contents, NotThatRecordingError, Recordings, Stored, _oldest
from hawk.store.ring_buffer import Item

NOW = datetime(2026, 11, 27, 12, 0, 0, tzinfo=UTC).timestamp()
MB = 1_000_000


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "recordings").mkdir()
    return tmp_path / "recordings"


def add(folder: Path, day: int, megabytes: int = 1, *, keep: bool = False, month: int = 11, year: int = 2026) -> str:
    name = f"{year}{month:02}{day:02}T100000Z.mcap"
    with (folder / name).open("wb") as file:
        os.truncate(file.fileno(), megabytes * MB)
    if keep:
        (folder / name).with_suffix(".keep").touch()
    return name


def recordings(folder: Path, under_way: str = "", wall: float = NOW, **settings: Any) -> Recordings:
    path = folder / under_way if under_way else None
    return Recordings(StoreSettings(directory=folder.parent, **settings), lambda: path, lambda: wall)


def names(found: Recordings) -> list[str]:
    return [one.name for one in found.listed()]


def test_recordings_are_listed_the_oldest_first_with_size_and_mark(folder: Path) -> None:
    second, first = add(folder, 12, 3), add(folder, 3, keep=True)
    (folder / "notes.txt").write_text("not a recording")
    found = recordings(folder, under_way=second).listed()
    began = datetime(2026, 11, 3, 10, tzinfo=UTC).timestamp()
    assert found[0] == Stored(first, MB, began, is_kept=True)
    assert (found[1].name, found[1].bytes, found[1].is_under_way) == (second, 3 * MB, True)


def test_files_of_a_person_are_not_listed_counted_or_removed(folder: Path) -> None:
    ours = add(folder, 3, 60)
    for name in ("monday morning.mcap", "20261101T100000Z-copy.mcap"):
        (folder / add(folder, 1, 60)).rename(folder / name)
    found = recordings(folder, recordings_gb=0.1)
    assert names(found) == [ours]
    assert found.taken() == (60 * MB, 0)
    assert found.tidy() == []
    assert found.make_room(9 * MB) == [ours]
    assert sorted(path.name for path in folder.iterdir()) == ["20261101T100000Z-copy.mcap", "monday morning.mcap"]


def test_every_name_that_a_writer_gives_is_listed(folder: Path) -> None:
    given = ["20261103T100000Z.mcap", *(f"20261103T100000Z-{number}.mcap" for number in (2, 10, 999))]
    for name in given:
        (folder / name).touch()
    assert sorted(names(recordings(folder))) == sorted(given)


def test_a_folder_that_is_not_there_has_no_recordings(tmp_path: Path) -> None:
    assert recordings(tmp_path / "none").listed() == []


def test_the_oldest_go_when_all_are_too_large_but_none_that_is_kept_or_under_way(folder: Path) -> None:
    kept = add(folder, 1, 60, keep=True)
    old, young = add(folder, 2, 60), add(folder, 3, 60)
    flown = add(folder, 4, 60)
    found = recordings(folder, under_way=flown, recordings_gb=0.2)
    assert found.tidy() == [old]
    assert names(found) == [kept, young, flown]
    assert found.tidy() == []
    assert recordings(folder, under_way=flown, recordings_gb=0.1).tidy() == [young]


def test_recordings_beyond_their_days_go(folder: Path) -> None:
    old, kept, young = add(folder, 1), add(folder, 2, keep=True), add(folder, 26)
    assert recordings(folder).tidy() == []
    found = recordings(folder, recordings_days=20)
    assert found.tidy() == [old]
    assert names(found) == [kept, young]


def test_a_clock_that_was_not_set_makes_nothing_old(folder: Path) -> None:
    add(folder, 1)
    assert recordings(folder, wall=3 * DAY_S, recordings_days=20).tidy() == []
    unset = add(folder, 1, 150, month=1, year=1970)  # flown with such a clock: nobody knows when
    found = recordings(folder, recordings_days=400, recordings_gb=0.15)
    assert found.tidy() == ["20261101T100000Z.mcap"]
    assert names(found) == [unset]
    assert found.listed()[0].began is None


def test_room_is_made_from_the_oldest_and_what_is_taken_is_counted(folder: Path) -> None:
    first, second, kept = add(folder, 1, 5), add(folder, 2, 5), add(folder, 3, 7, keep=True)
    found = recordings(folder)
    assert found.taken() == (17 * MB, 7 * MB)
    assert found.make_room(1) == [first]
    assert found.make_room(100 * MB) == [second]
    assert found.make_room(100 * MB) == []
    assert names(found) == [kept]


@given(st.lists(st.tuples(st.integers(0, 9), st.booleans(), st.booleans()), max_size=12), st.integers(0, 60))
def test_no_more_is_removed_than_is_missing(given_files: list[tuple[int, bool, bool]], missing: int) -> None:
    files = [Stored(f"{n}", size, float(n), kept, flown) for n, (size, kept, flown) in enumerate(given_files)]
    chosen = _oldest(files, missing)
    assert not any(one.is_kept or one.is_under_way for one in chosen)
    free = [one for one in files if not (one.is_kept or one.is_under_way)]
    assert chosen == free[: len(chosen)]
    assert len(chosen) == len(free) or sum(one.bytes for one in chosen) >= missing
    assert not chosen or sum(one.bytes for one in chosen[:-1]) < missing


def test_a_mark_keeps_a_recording_until_it_is_taken_away(folder: Path) -> None:
    name = add(folder, 1)
    found = recordings(folder)
    found.keep(name, is_kept=True)
    assert found.listed()[0].is_kept
    with pytest.raises(NotThatRecordingError, match='is marked "keep": take the mark away first'):
        found.delete(name)
    found.keep(name, is_kept=False)
    found.keep(name, is_kept=False)
    found.delete(name)
    assert names(found) == []


def test_a_recording_under_way_is_not_deleted(folder: Path) -> None:
    name = add(folder, 1)
    with pytest.raises(NotThatRecordingError, match="is being written: delete it after the landing"):
        recordings(folder, under_way=name).delete(name)


@pytest.mark.parametrize(
    "name", ["../lots.db", "20261101T100000Z.keep", "20261101T100000Z.mcap/..", "", "20261109T100000Z.mcap"]
)
def test_other_names_are_refused(name: str, folder: Path) -> None:
    add(folder, 1)
    for ask in (recordings(folder).delete, recordings(folder).contents):
        with pytest.raises(NotThatRecordingError, match="no recording of this name"):
            ask(name)


def test_length_and_survey_are_read_from_the_file_and_unknown_where_it_is_torn(folder: Path) -> None:
    name = add(folder, 1, 0)
    path = folder / name
    head = start_metadata({"survey": "000003-x"}, datetime.fromtimestamp(NOW, UTC), 10.0)
    file = RecordingFile(path.open("wb"), head, dict)
    for seconds in (20, 50, 95):
        file.write(Item("tick", {}, "json", seconds * 1_000_000_000, 1))
    file.close()
    found = recordings(folder)
    assert found.contents(name) == Contents(75.0, "000003-x")
    path.write_bytes(path.read_bytes()[:-40])
    assert found.contents(name) == Contents(None, "000003-x")
    path.write_bytes(b"this is no recording")
    assert found.contents(name) == Contents()

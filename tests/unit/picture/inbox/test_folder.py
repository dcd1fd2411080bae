from __future__ import annotations

import os
from pathlib import Path

import pytest

from hawk.picture.inbox.folder import ABANDONED_S, HEADING, LOOSE, Folder
from hawk.store.inbox import DONE, FAILED, MAPPING
from tests.unit.jpegs import jpeg

SETTLE_S = 60.0


@pytest.fixture
def folder(tmp_path: Path) -> Folder:
    return Folder(tmp_path, SETTLE_S)


def put(folder: Folder, path: str, data: bytes = b"picture") -> Path:
    file = folder.path / path
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_bytes(data)
    return file


def settled(folder: Folder, now: float) -> dict[str, list[str]]:
    return {drop.name: [file.path for file in drop.files] for drop in folder.settled(now)}


def test_what_grows_waits_and_what_has_stopped_is_a_drop(folder: Folder) -> None:
    put(folder, "north/a.jpg")
    put(folder, "b.jpg")
    assert settled(folder, 0.0) == {}
    put(folder, "north/c.jpg")
    assert settled(folder, SETTLE_S) == {LOOSE: ["b.jpg"]}
    put(folder, "north/c.jpg", b"a longer picture")
    assert settled(folder, 2 * SETTLE_S) == {LOOSE: ["b.jpg"]}
    assert settled(folder, 3 * SETTLE_S - 1) == {LOOSE: ["b.jpg"]}
    assert settled(folder, 3 * SETTLE_S) == {LOOSE: ["b.jpg"], "north": ["north/a.jpg", "north/c.jpg"]}


def test_one_look_is_never_enough(folder: Folder) -> None:
    put(folder, "a.jpg")
    assert settled(folder, 1e9) == {}


@pytest.mark.parametrize(
    "name",
    ["b.jpg.part", "b.jpg.a1b2c3d4.partial", "b.jpg.crdownload", "b.tmp", "b.jpg.filepart", ".b.jpg.Xy12ab", "b.jpg~"],
)
def test_a_file_that_is_being_written_keeps_its_drop(folder: Folder, name: str) -> None:
    put(folder, "north/a.jpg")
    unfinished = put(folder, f"north/{name}")
    for look in range(3):
        assert settled(folder, look * SETTLE_S) == {}
    unfinished.rename(unfinished.with_name("b.jpg"))
    assert settled(folder, 3 * SETTLE_S) == {}
    assert settled(folder, 4 * SETTLE_S) == {"north": ["north/a.jpg", "north/b.jpg"]}


def test_an_upload_that_was_given_up_does_not_keep_the_others_for_ever(folder: Folder) -> None:
    put(folder, "north/a.jpg")
    put(folder, "north/b.jpg.part")
    assert settled(folder, 0.0) == {}
    assert settled(folder, ABANDONED_S - 1) == {}
    assert settled(folder, ABANDONED_S) == {"north": ["north/a.jpg"]}


def test_half_a_photograph_keeps_its_drop(folder: Folder) -> None:
    put(folder, "north/a.jpg", jpeg())
    put(folder, "north/b.jpg", jpeg()[:-2])
    assert settled(folder, 0.0) == {}
    assert settled(folder, 10 * SETTLE_S) == {}
    put(folder, "north/b.jpg", jpeg())
    assert settled(folder, 11 * SETTLE_S) == {}
    assert settled(folder, 12 * SETTLE_S) == {"north": ["north/a.jpg", "north/b.jpg"]}
    put(folder, "north/b.jpg", jpeg()[:-2])
    assert settled(folder, 13 * SETTLE_S) == {}
    assert settled(folder, 13 * SETTLE_S + ABANDONED_S - 1) == {}
    assert settled(folder, 13 * SETTLE_S + ABANDONED_S) == {"north": ["north/a.jpg", "north/b.jpg"]}


@pytest.mark.parametrize("length", [0, 1, 2, 4])
def test_a_short_file_is_no_reason_to_fail(folder: Folder, length: int) -> None:
    put(folder, "a.jpg", b"\xff\xd8\xff\xd9"[:length])
    assert settled(folder, 0.0) == {}
    assert settled(folder, ABANDONED_S) == {LOOSE: ["a.jpg"]}


def test_a_clock_that_is_set_back_changes_nothing(folder: Folder) -> None:

    file = put(folder, "a.jpg")
    os.utime(file, (4e9, 4e9))
    assert settled(folder, 0.0) == {}
    assert settled(folder, SETTLE_S) == {LOOSE: ["a.jpg"]}


def test_hidden_files_of_systems_own_folders_links_and_devices_are_no_drops(folder: Folder) -> None:

    for path in (
        ".DS_Store",
        "._a.jpg",
        "Thumbs.db",
        ".trash/a.jpg",
        *(f"{each}/x/a.jpg" for each in (MAPPING, DONE, FAILED)),
    ):
        put(folder, path)
    (folder.path / "link.jpg").symlink_to("/etc/passwd")
    (folder.path / "etc").symlink_to("/etc")
    os.mkfifo(folder.path / "pipe.jpg")
    assert settled(folder, 0.0) == {}
    assert settled(folder, SETTLE_S) == {}


def test_a_flight_that_is_moved_back_is_its_pictures_alone(folder: Folder) -> None:
    put(folder, "north/pictures/a.jpg")
    put(folder, "north/report.txt", HEADING.encode() + b"north, not mapped")
    put(folder, "north/survey/stalls.csv")
    assert settled(folder, 0.0) == {}
    assert settled(folder, SETTLE_S) == {"north": ["north/pictures/a.jpg"]}
    put(folder, "south/report.txt", b"a letter")
    put(folder, "south/survey/a.jpg")
    settled(folder, 2 * SETTLE_S)
    assert settled(folder, 3 * SETTLE_S)["south"] == ["south/report.txt", "south/survey/a.jpg"]


def test_a_folder_that_vanished_is_an_error_with_its_name(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="gone"):
        Folder(tmp_path / "gone", SETTLE_S).settled(0.0)

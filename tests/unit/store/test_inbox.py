"""The folder of an inbox: files are whole or not there, within a quota, and nothing is written outside of it."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.picture.inbox.folder import Folder
from hawk.store.inbox import (
    COUNT_S,
    DONE,
    LEAST_FREE,
    InboxFolder,
    InboxFullError,
    InboxQuota,
    NameTakenError,
    name_fault,
)

QUOTA = InboxQuota(largest=1000, most_bytes=3000, most_files=4)
JPEG = b"\xff\xd8picture\xff\xd9"


class Disk:
    def __init__(self) -> None:
        self.free = 10 * LEAST_FREE
        self.now = 0.0


@pytest.fixture
def disk() -> Disk:
    return Disk()


@pytest.fixture
def folder(tmp_path: Path, disk: Disk) -> InboxFolder:
    path = tmp_path / "inbox"
    path.mkdir()
    return InboxFolder(path, QUOTA, lambda _: disk.free, lambda: disk.now)


def write(folder: InboxFolder, name: str, data: bytes, flight: str = "") -> None:
    incoming = folder.begin(flight, name, len(data))
    incoming.write(data)
    incoming.finish()


def files(folder: InboxFolder) -> dict[str, bytes]:
    found = (path for path in sorted(folder.path.rglob("*")) if path.is_file())
    return {path.relative_to(folder.path).as_posix(): path.read_bytes() for path in found}


def test_files_lie_under_their_names_in_the_folder_and_in_flights(folder: InboxFolder) -> None:
    write(folder, "one.jpg", b"1")
    write(folder, "two.jpg", b"2", "monday")
    assert files(folder) == {"one.jpg": b"1", "monday/two.jpg": b"2"}


@pytest.mark.parametrize("other", [b"3", b"22", b""])
def test_the_same_file_may_come_again_and_another_one_takes_no_name(folder: InboxFolder, other: bytes) -> None:
    for _ in range(9):  # more than the quota has room for
        write(folder, "two.jpg", b"2", "monday")
    with pytest.raises(NameTakenError, match=r"two\.jpg"):
        write(folder, "two.jpg", other, "monday")
    write(folder, "two.jpg", other, "tuesday")
    assert files(folder) == {"monday/two.jpg": b"2", "tuesday/two.jpg": other}


def test_the_inbox_waits_for_a_file_that_is_being_written(folder: InboxFolder) -> None:
    write(folder, "one.jpg", JPEG, "monday")
    looks = Folder(folder.path, 1.0)
    incoming = folder.begin("monday", "two.jpg", len(JPEG))
    incoming.write(JPEG[:3])
    assert [drop for now in (0.0, 10.0, 20.0) for drop in looks.settled(now)] == []
    incoming.write(JPEG[3:])
    incoming.finish()
    assert looks.settled(30.0) == []
    (drop,) = looks.settled(40.0)
    assert [file.path for file in drop.files] == ["monday/one.jpg", "monday/two.jpg"]


def test_one_that_is_dropped_or_was_left_by_a_former_program_is_gone(folder: InboxFolder) -> None:
    folder.begin("", "one.jpg", 1).drop()
    write(folder, "two.jpg", b"2", "monday")
    (folder.path / "monday" / "two.jpg").rename(folder.path / "monday" / "two.jpg.0123.hawk.part")
    folder.clear()
    assert files(folder) == {}


def test_a_file_that_has_ended_is_not_dropped(folder: InboxFolder) -> None:
    incoming = folder.begin("", "one.jpg", 1)
    incoming.write(b"1")
    incoming.finish()
    incoming.drop()
    assert files(folder) == {"one.jpg": b"1"}


def test_bytes_count_with_those_that_come_and_those_that_were_mapped(folder: InboxFolder) -> None:
    (folder.path / DONE / "flight").mkdir(parents=True)
    (folder.path / DONE / "flight" / "old.jpg").write_bytes(bytes(1500))
    incoming = folder.begin("", "one.jpg", 1000)
    with pytest.raises(InboxFullError, match=r"most_gb\): empty the folder done, or raise the limit"):
        folder.begin("", "two.jpg", 501)
    incoming.drop()
    write(folder, "two.jpg", bytes(1000))
    with pytest.raises(InboxFullError, match="most_gb"):
        folder.begin("", "three.jpg", 501)
    folder.begin("", "three.jpg", 500).drop()


def test_files_count_and_what_others_did_is_seen_after_a_minute(folder: InboxFolder, disk: Disk) -> None:
    for number in range(QUOTA.most_files):
        write(folder, f"{number}.jpg", b"1")
    with pytest.raises(InboxFullError, match=r"holds 4 files, its limit is 4 \(inbox.most_files\)"):
        folder.begin("", "more.jpg", 1)
    (folder.path / "0.jpg").unlink()
    disk.now += COUNT_S + 1.0
    write(folder, "more.jpg", b"1")


def test_a_full_disk_takes_nothing(folder: InboxFolder, disk: Disk) -> None:
    disk.free = LEAST_FREE + 500
    waiting = folder.begin("", "one.jpg", 400)
    with pytest.raises(InboxFullError, match="The disk of the inbox is full"):
        folder.begin("", "two.jpg", 400)
    waiting.drop()
    folder.begin("", "two.jpg", 400).drop()


def test_a_link_leads_nowhere(folder: InboxFolder, tmp_path: Path) -> None:
    outside = tmp_path / "outside"
    outside.mkdir()
    (folder.path / "monday").symlink_to(outside)
    with pytest.raises(OSError, match="monday"):
        folder.begin("monday", "one.jpg", 1)
    (outside / "kept").write_bytes(b"kept")
    (folder.path / "one.jpg").symlink_to(outside / "kept")
    with pytest.raises(NameTakenError):
        write(folder, "one.jpg", b"new")
    assert (outside / "kept").read_bytes() == b"kept"
    assert [path.name for path in outside.iterdir()] == ["kept"]


@pytest.mark.parametrize(
    "name",
    ["", " ", "..", ".", "../a.jpg", "a/b", "a\\b", ".hidden", "a\0b", "a\nb", "\ud800", "done", "DONE", "Mapping",
     "failed", "a.part", "a.JPG.tmp", "a~", "ä" * 101],
)  # fmt: skip
def test_a_name_that_is_none(name: str) -> None:
    assert name_fault(name)


@pytest.mark.parametrize("name", ["DJI_0001.JPG", "Flug über Süd 1.mp4", "写真.jpg", "a..b.jpg"])
def test_a_name_that_may_be_used(name: str) -> None:
    assert not name_fault(name)


@given(st.text(max_size=300))
def test_no_name_that_may_be_used_leads_out_of_a_folder(name: str) -> None:
    if not name_fault(name):
        assert (Path("/inbox") / name).resolve().parent == Path("/inbox")
        assert len(name.encode()) <= 200

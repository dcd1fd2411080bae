from __future__ import annotations

import os
from pathlib import Path

import pytest

from hawk.model.moment import Moment
from hawk.model.operation import FlightSoFar
from hawk.store.run_notes import Notes, RunNotes, notes_file

NOW = Moment("boot", 5000.125, 1_800_000_000.5)
NOTES = Notes((NOW.before(3.0), NOW), FlightSoFar(30.0, 40.0, NOW))


def test_the_next_run_reads_what_was_put(tmp_path: Path) -> None:
    path = tmp_path / "starts.json"
    assert RunNotes(path).notes == Notes()
    RunNotes(path).put(NOTES)
    again = RunNotes(path)
    assert (again.notes, again.works) == (NOTES, True)
    again.put(Notes())
    assert list(tmp_path.iterdir()) == [], "notes that say nothing leave no file"
    again.put(Notes())


@pytest.mark.parametrize("text", [b"", b"{", b'{"starts_in_air": 3}', b"\xff\xfe", b'{"flight": {"seconds": "x"}}'])
def test_notes_that_cannot_be_read_are_reported_and_may_lack_a_start(
    tmp_path: Path, text: bytes, caplog: pytest.LogCaptureFixture
) -> None:
    path = tmp_path / "starts.json"
    path.write_bytes(text)
    notes = RunNotes(path)
    assert (notes.notes, notes.works) == (Notes(), False)
    assert "counted on the disk alone" in caplog.text
    notes.put(NOTES)
    assert not notes.works, "the starts of before are missing still"
    assert RunNotes(path).notes == NOTES


def test_notes_that_cannot_be_written_are_reported_once_and_kept_in_mind(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    notes = RunNotes(tmp_path / "none" / "starts.json")
    assert notes.works
    for _ in range(3):
        notes.put(NOTES)
    assert (notes.notes, notes.works) == (NOTES, False)
    assert caplog.text.count("cannot be used") == 1
    (tmp_path / "none").mkdir()
    notes.put(NOTES)
    assert notes.works


def test_a_folder_in_place_of_the_file_is_reported(tmp_path: Path) -> None:
    (tmp_path / "starts.json").mkdir()
    assert not RunNotes(tmp_path / "starts.json").works


def test_without_a_folder_in_memory_nothing_is_kept() -> None:
    notes = RunNotes(None)
    notes.put(NOTES)
    assert (notes.notes, notes.works) == (NOTES, False)


def test_the_folder_is_the_services_then_the_sessions_then_one_of_our_own(tmp_path: Path) -> None:
    store, session, shared = (tmp_path / name for name in ("store", "session", "shared"))
    session.mkdir()
    shared.mkdir()
    service = {"RUNTIME_DIRECTORY": "/run/hawk:/run/other", "XDG_RUNTIME_DIR": str(session)}
    found = notes_file(store, service, shared)
    assert found is not None
    assert found.parent == Path("/run/hawk")
    other = notes_file(store, {"XDG_RUNTIME_DIR": str(session)}, shared)
    assert other == session / "hawk-drone" / found.name
    own = notes_file(store, {"XDG_RUNTIME_DIR": "/nonexistent"}, shared)
    assert own == shared / f"hawk-drone-{os.getuid()}" / found.name
    assert own.parent.stat().st_mode & 0o777 == 0o700
    assert notes_file(store, {}, shared) == own, "it may be there already"
    assert notes_file(store, {}, tmp_path / "none") is None
    assert notes_file(tmp_path / "another store", {}, shared) != own


@pytest.mark.parametrize("kind", ["link", "file", "writable by all"])
def test_a_folder_that_another_may_have_made_is_not_used(tmp_path: Path, kind: str) -> None:
    place = tmp_path / f"hawk-drone-{os.getuid()}"
    if kind == "link":
        (tmp_path / "target").mkdir(mode=0o700)
        place.symlink_to(tmp_path / "target")
    elif kind == "file":
        place.write_text("")
    else:
        place.mkdir()
        place.chmod(0o777)
    assert notes_file(tmp_path, {}, tmp_path) is None


def test_a_folder_of_another_user_is_not_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "getuid", lambda: 4711)
    assert notes_file(tmp_path, {}, tmp_path) is None

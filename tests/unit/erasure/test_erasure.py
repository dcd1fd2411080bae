from __future__ import annotations

import hashlib
import io
import shutil
import sqlite3
import sys
from contextlib import closing
from copy import copy
from dataclasses import replace
from pathlib import Path

import pytest
from mcap.writer import Writer

from hawk.cli import main
from hawk.config.sections import StoreSettings
from hawk.erasure.erasure import erase
from hawk.lots import commands, lists, shares
from hawk.lots.documents import arrival_log
from hawk.lots.documents.arrival import Arrival, ArrivalKind, Outcome
from hawk.lots.ingest import save
from hawk.lots.storage import erasure
from hawk.lots.storage.database import Database, read_only
from hawk.lots.storage.schema import VERSION
from hawk.lots.store import FILE
from hawk.lots.survey.pictures import PictureFolder, pictures_of
from hawk.lots.values import LotStoreError, NotFoundError
from hawk.model.poses import GlobalPose
from hawk.store.recording_request import OfferedRecording, Part
from hawk.store.recording_requests import PartWriter, RecordingRequests
from hawk.store.recordings import MARK, Recordings
from hawk.store.replay import METADATA
from hawk.store.store_lock import FILE as RUNNING
from hawk.store.store_lock import held_store
from tests.unit.lots import whole
from tests.unit.lots.surveys import BEGAN, box, later, survey
from tests.unit.lots.test_training_set import mosaic
from tests.unit.store.recorded import recorded

NAME, OTHER_NAME = "Behind the cinema", "Somewhere else"
FAR = GlobalPose(52.05, 5.0, 0.0)


class Kept:
    """A store of two lots, the first with two surveys, and every file that belongs to them."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.settings = StoreSettings(directory=folder)
        one, two = survey(), later(survey(), 2)
        far = replace(
            later(survey(), 3), datum=FAR, outline=box(-20, -3, 40, 50, FAR), seen_ground=box(-20, -3, 40, 50, FAR)
        )
        store = Database(folder / FILE)
        with store.writing() as connection:
            saved = [save(connection, each) for each in (one, two, far)]
            self.lot, self.other = (each["id"] for each in whole.lots(connection))
            commands.rename(connection, self.lot, NAME, "operator", BEGAN)
            commands.rename(connection, self.other, OTHER_NAME, "operator", BEGAN)
            shares.share(connection, self.lot, {"days": 3}, BEGAN)
            for stored, lot in zip(saved, (self.lot, self.lot, self.other), strict=True):
                words = f"survey.id: must be the id of the address, {stored.survey}"
                for arrived in (
                    Arrival("Drone 1", ArrivalKind.SURVEY, stored.survey, Outcome.TAKEN, lot, 1),
                    Arrival("Drone 1", ArrivalKind.SURVEY, "a survey", Outcome.REFUSED, reason=words),
                ):
                    arrival_log.note(connection, arrived, BEGAN)
            self.stalls = [each["id"] for each in whole.stalls(connection, self.lot)]
        store.close()
        self.surveys = [each.survey for each in saved]
        self.names = [each.name for each in (one, two, far)]
        for each in self.surveys:
            pictures_of(folder / FILE).write(each, mosaic())
        for number, name in enumerate(self.names):
            self.record(f"2026050{number + 4}T103000Z.mcap", name)
            (folder / "journal" / name).mkdir(parents=True)
            (folder / "journal" / name / "000001.log").write_text(f"journal of {name}")
        (folder / f"{FILE}.version-3").write_bytes((folder / FILE).read_bytes())

    def copied(self, folder: Path) -> Kept:
        """Return a copy of everything in another folder."""
        shutil.copytree(self.folder, folder, dirs_exist_ok=True)
        other = copy(self)
        other.folder, other.settings = folder, StoreSettings(directory=folder)
        return other

    def record(self, name: str, of: str) -> None:
        content = io.BytesIO()
        writer = Writer(content)
        writer.start()
        writer.add_metadata(METADATA, {"format": "2", "survey": of})
        writer.finish()  # type: ignore[no-untyped-call]
        (self.folder / "recordings").mkdir(exist_ok=True)
        (self.folder / "recordings" / name).write_bytes(content.getvalue())
        (self.folder / "recordings" / name).with_suffix(MARK).touch()

    def delete(self, number: int) -> None:
        """Delete a survey as the page does."""
        store = Database(self.folder / FILE)
        with store.writing() as connection:
            commands.delete(connection, self.surveys[number], "operator", BEGAN)
        store.close()

    def merge(self) -> None:
        """Merge the other lot into the first one."""
        store = Database(self.folder / FILE)
        with store.writing() as connection:
            commands.merge(connection, self.lot, self.other, "operator", BEGAN)
        store.close()

    @property
    def secret(self) -> tuple[str, ...]:
        """Everything that names the first lot or its surveys."""
        return (NAME, self.lot, *self.surveys[:2], *self.names[:2], *self.stalls)

    def holds(self, *words: str) -> set[str]:
        """Return those words that a byte of a file, or a file's name, still holds."""
        found = set()
        for path in self.folder.rglob("*"):
            content = path.read_bytes() if path.is_file() else b""
            found |= {word for word in words if word.encode() in content or word in path.name}
        return found


@pytest.fixture(scope="module")
def first(tmp_path_factory: pytest.TempPathFactory) -> Kept:
    return Kept(tmp_path_factory.mktemp("kept"))


@pytest.fixture
def kept(first: Kept, tmp_path: Path) -> Kept:
    return first.copied(tmp_path)


@pytest.mark.slow
def test_a_survey_is_erased_with_everything_that_names_it(kept: Kept) -> None:
    assert kept.holds(kept.surveys[1], kept.names[1]) == {kept.surveys[1], kept.names[1]}
    report = erase(kept.settings, lot=None, survey=kept.surveys[1])
    assert (report.surveys, report.pictures, report.recordings, report.journals, report.copies) == (1, 1, 1, 1, 1)
    assert kept.holds(kept.surveys[1], kept.names[1]) == set()
    assert kept.holds(NAME, kept.surveys[0], kept.surveys[2], *kept.names[::2]) == {
        NAME, kept.surveys[0], kept.surveys[2], *kept.names[::2],
    }  # fmt: skip


@pytest.mark.slow
def test_of_a_lot_no_byte_is_left(kept: Kept) -> None:
    assert kept.holds(*kept.secret) == set(kept.secret)
    report = erase(kept.settings, lot=NAME, survey=None)
    assert (report.surveys, report.pictures, report.recordings, report.journals) == (2, 2, 2, 2)
    assert kept.holds(*kept.secret) == set()
    opened = Database(kept.folder / FILE)
    with opened.writing() as connection:
        assert [lot["name"] for lot in whole.lots(connection)] == [OTHER_NAME]
        assert {each.lot for each in arrival_log.listed(connection, whole.ALL).items} == {kept.other, None}
        assert len(whole.stalls(connection, kept.other)) == 40
        save(connection, later(survey(), 9))
    opened.close()


@pytest.mark.slow
def test_a_lot_that_was_merged_into_it_goes_too(kept: Kept) -> None:
    kept.delete(2)
    kept.merge()
    erase(kept.settings, lot=kept.lot, survey=None)
    assert kept.holds(NAME, OTHER_NAME, kept.lot, kept.other, *kept.surveys, *kept.names) == set()


@pytest.mark.slow
def test_a_lot_that_was_merged_into_another_is_refused_by_the_name_of_that_one(kept: Kept) -> None:
    kept.merge()
    words = f"--lot: '{OTHER_NAME}' was merged into '{NAME}', which has its surveys: give that one .{kept.lot}."
    with pytest.raises(LotStoreError, match=words):
        erase(kept.settings, lot=OTHER_NAME, survey=None)
    assert kept.holds(*kept.surveys, OTHER_NAME) == {*kept.surveys, OTHER_NAME}
    with pytest.raises(NotFoundError, match=f"there are: {NAME}$"):
        erase(kept.settings, lot="x", survey=None)


@pytest.mark.slow
def test_a_name_is_that_of_the_lot_that_is_shown(kept: Kept) -> None:
    opened = Database(kept.folder / FILE)
    with opened.writing() as connection:
        commands.rename(connection, kept.other, NAME, "operator", BEGAN)
    opened.close()
    kept.merge()
    assert erase(kept.settings, lot=NAME, survey=None).surveys == 3


@pytest.mark.slow
def test_surveys_that_were_deleted_go_with_their_lot(kept: Kept) -> None:
    kept.delete(1)
    kept.delete(2)
    report = erase(kept.settings, lot=NAME, survey=None)
    assert (report.surveys, report.pictures, report.recordings, report.journals) == (2, 2, 2, 2)
    assert kept.holds(*kept.secret) == set()
    assert kept.holds(kept.surveys[2], kept.names[2]) == {kept.surveys[2], kept.names[2]}


@pytest.mark.slow
def test_a_deleted_survey_is_of_the_lot_that_had_it_last(kept: Kept) -> None:
    opened = Database(kept.folder / FILE)
    with opened.writing() as connection:
        commands.undo(connection, commands.delete(connection, kept.surveys[1], "operator", BEGAN).seq, BEGAN)
        commands.move(connection, kept.surveys[1], {"lot": kept.other}, "operator", BEGAN, None)
        commands.delete(connection, kept.surveys[1], "operator", BEGAN)
    opened.close()
    assert erase(kept.settings, lot=NAME, survey=None).surveys == 1
    assert kept.holds(kept.names[1]) == {kept.names[1]}


@pytest.mark.slow
def test_a_deleted_survey_that_nobody_can_bring_back_goes_with_each_lot(kept: Kept) -> None:
    kept.delete(1)
    with closing(sqlite3.connect(kept.folder / FILE)) as opened, opened:
        opened.execute("DELETE FROM change WHERE kind = 'delete'")
    assert erase(kept.settings, lot=OTHER_NAME, survey=None).surveys == 2
    assert kept.holds(kept.surveys[1], kept.names[1]) == set()


@pytest.mark.slow
def test_everything_is_erased_but_the_settings_and_the_tokens(kept: Kept) -> None:
    for name in ("params.json", "web-tokens.json", "camera.yaml"):
        (kept.folder / name).write_text("kept")
    report = erase(kept.settings, lot=None, survey=None)
    assert (report.surveys, report.pictures, report.recordings, report.journals, report.copies) == (3, 3, 3, 3, 1)
    left = sorted(path.name for path in kept.folder.rglob("*"))
    assert left == ["camera.yaml", FILE, "params.json", "web-tokens.json"]
    assert kept.holds(*kept.secret, OTHER_NAME) == set()  # the store is a new one, which knows hashes of what is gone
    opened = Database(kept.folder / FILE)
    with opened.reading() as connection:
        assert (whole.lots(connection), whole.surveys(connection)) == ([], [])
        assert lists.changes(connection, whole.ALL).items == []
    opened.close()


@pytest.mark.slow
def test_a_recording_that_names_no_survey_may_hold_one(kept: Kept) -> None:
    kept.record("20260601T103000Z.mcap", "")
    (kept.folder / "recordings" / "20260602T103000Z.mcap").write_bytes(b"\x89MCAP0\r\n" + b"cut")
    assert erase(kept.settings, lot=None, survey=kept.surveys[1]).recordings == 3


@pytest.mark.slow
def test_recordings_are_looked_at_whatever_their_names(kept: Kept) -> None:
    kept.record("monday morning.mcap", kept.names[1])
    kept.record("tuesday.mcap", kept.names[2])
    assert erase(kept.settings, lot=None, survey=kept.surveys[1]).recordings == 2
    assert kept.holds(kept.surveys[1], kept.names[1], "monday") == set()
    assert kept.holds("tuesday.mcap") == {"tuesday.mcap"}


@pytest.mark.slow
def test_files_that_are_half_written_go_too(kept: Kept) -> None:
    (picture,) = (kept.folder / "lots-pictures").glob(f"{kept.surveys[1]}.zip")
    shutil.copy(picture, picture.with_suffix(".part"))
    for name in (".lots.db.version-3.new", ".lots.db.restored", "..lots.db.restored.new"):
        shutil.copy(kept.folder / FILE, kept.folder / name)
    report = erase(kept.settings, lot=None, survey=kept.surveys[1])
    assert (report.pictures, report.copies) == (1, 1)
    assert kept.holds(kept.surveys[1], kept.names[1]) == set()


_FAILS = {"pictures": (PictureFolder, "remove"), "files": (Path, "unlink"), "journals": (shutil, "rmtree")}


@pytest.mark.slow
@pytest.mark.parametrize("error", [PermissionError(13, "Permission denied"), KeyboardInterrupt()])
@pytest.mark.parametrize(
    ("at", "lot"), [("pictures", NAME), ("files", NAME), ("journals", NAME), ("files", None), ("journals", None)]
)
def test_after_an_error_the_same_command_erases_the_rest(
    at: str, error: BaseException, lot: str | None, kept: Kept, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails(of: object, *_: object, **__: object) -> bool:
        if isinstance(of, Path) and of.name == RUNNING:
            return False
        raise error

    with monkeypatch.context() as patched:
        patched.setattr(*_FAILS[at], fails)
        wanted = LotStoreError if isinstance(error, OSError) else KeyboardInterrupt
        with pytest.raises(wanted) as raised:
            erase(kept.settings, lot=lot, survey=None)
    if isinstance(error, OSError):
        assert "Permission denied. It stays, with every row of the store." in str(raised.value)
        assert str(raised.value).startswith(str(kept.folder))
    with closing(sqlite3.connect(kept.folder / FILE)) as opened:
        assert opened.execute("SELECT count(*) FROM survey").fetchone() == (3,)
    erase(kept.settings, lot=lot, survey=None)
    assert kept.holds(*kept.secret) == set()


@pytest.mark.slow
@pytest.mark.parametrize("lot", [NAME, None])
def test_nothing_is_erased_while_another_program_has_the_store_open(
    lot: str | None, kept: Kept, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(erasure, "BUSY_S", 0.0)
    with closing(read_only(kept.folder / FILE)) as reader:
        reader.execute("SELECT count(*) FROM survey").fetchone()
        with pytest.raises(LotStoreError, match=f"{FILE} is used by another program: end it, and erase again"):
            erase(kept.settings, lot=lot, survey=None)
    assert kept.holds(*kept.secret) == set(kept.secret)
    erase(kept.settings, lot=lot, survey=None)
    assert kept.holds(*kept.secret) == set()


@pytest.mark.slow
def test_a_damaged_store_is_no_hindrance_to_erase_everything(kept: Kept) -> None:
    (kept.folder / FILE).write_bytes(b"no store")
    assert erase(kept.settings, lot=None, survey=None).surveys == 0
    assert not (kept.folder / FILE).exists()


@pytest.mark.slow
def test_nothing_is_erased_while_a_daemon_uses_the_store(kept: Kept) -> None:
    with held_store(kept.folder, {"page": "http://x"}), pytest.raises(LotStoreError, match="stop it first"):
        erase(kept.settings, lot=NAME, survey=None)
    assert kept.holds(NAME) == {NAME}


@pytest.mark.slow
def test_what_is_not_there_is_named_with_what_is(kept: Kept) -> None:
    with pytest.raises(NotFoundError, match=f"--lot: there is no lot 'x'; there are: {NAME}, {OTHER_NAME}"):
        erase(kept.settings, lot="x", survey=None)
    with pytest.raises(NotFoundError, match="--survey: there is no survey 'x'; there are ") as raised:
        erase(kept.settings, lot=None, survey="x")
    assert all(f"{each[:8]} of 20" in str(raised.value) for each in kept.surveys)


@pytest.mark.slow
@pytest.mark.parametrize("lot", [None, "x"])
def test_a_folder_that_is_no_store_is_refused_and_not_made(kept: Kept, lot: str | None) -> None:
    folder = kept.folder / "none"
    with pytest.raises(LotStoreError, match=f"--store: {folder} is no store; name the folder that holds {FILE}"):
        erase(StoreSettings(directory=folder), lot=lot, survey=None)
    assert not folder.exists()
    with pytest.raises(LotStoreError, match=f"store.lots: {folder} is no store; name the file that holds the lots"):
        erase(StoreSettings(directory=kept.folder, lots=folder), lot="x", survey=None)
    assert kept.holds(NAME) == {NAME}


def test_recordings_without_a_lot_are_a_store_too(tmp_path: Path) -> None:
    (tmp_path / "recordings").mkdir()
    (tmp_path / "recordings" / "20260602T103000Z.mcap").touch()
    assert erase(StoreSettings(directory=tmp_path), lot=None, survey=None).recordings == 1


@pytest.mark.slow
def test_a_survey_is_named_by_the_beginning_of_its_id(kept: Kept) -> None:
    assert erase(kept.settings, lot=None, survey=kept.surveys[1][:8]).surveys == 1
    assert kept.holds(*kept.surveys) == {kept.surveys[0], kept.surveys[2]}


@pytest.mark.slow
def test_two_lots_of_one_name_need_an_id(kept: Kept) -> None:
    opened = Database(kept.folder / FILE)
    with opened.writing() as connection:
        commands.rename(connection, kept.other, NAME, "operator", BEGAN)
    opened.close()
    with pytest.raises(LotStoreError, match="2 lots are called"):
        erase(kept.settings, lot=NAME, survey=None)


@pytest.mark.slow
def test_a_store_of_another_version_is_left_alone(kept: Kept) -> None:
    with closing(sqlite3.connect(kept.folder / FILE)) as newer:
        newer.execute(f"PRAGMA user_version = {VERSION + 1}")
    with pytest.raises(LotStoreError, match="is of another version: start this hawk-drone once"):
        erase(kept.settings, lot=NAME, survey=None)


@pytest.mark.slow
def test_the_command_asks_first(
    kept: Kept, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["erase", "--store", str(kept.folder), "--lot", NAME]
    for answer in ("no\n", ""):
        monkeypatch.setattr(sys, "stdin", io.StringIO(answer))
        assert main(command) == 1
    with monkeypatch.context() as patched:
        patched.setattr("builtins.input", _interrupted)
        assert main(command) == 1
    with monkeypatch.context() as patched:
        patched.setattr(PictureFolder, "remove", _interrupted)
        assert main([*command, "--yes"]) == 130
    assert "stopped; a part may be erased: run it again for the rest" in capsys.readouterr().err
    assert kept.holds(NAME) == {NAME}
    monkeypatch.setattr(sys, "stdin", io.StringIO("yes\n"))
    assert main(command) == 0
    assert f"erased lot {NAME}: surveys 2, pictures 2, recordings 2, journals 2" in capsys.readouterr().out


@pytest.mark.slow
def test_the_command_erases_nothing_that_is_not_named(kept: Kept, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["erase", "--store", str(kept.folder), "--yes"]) == 2
    assert "--lot, --survey or --everything is missing" in capsys.readouterr().err
    assert kept.holds(NAME) == {NAME}


@pytest.mark.slow
def test_the_command_names_what_it_cannot_do(kept: Kept, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["erase", "--store", str(kept.folder), "--survey", "x", "--yes"]) == 2
    assert "hawk-drone: --survey: there is no survey 'x'" in capsys.readouterr().err


def _interrupted(*_: object) -> bool:
    raise KeyboardInterrupt


def test_of_a_survey_that_a_drone_sent_the_recordings_that_were_asked_for_go_too(kept: Kept) -> None:
    folder, drone, name = Recordings(kept.settings), "Drone 1", "20260510T103000Z.mcap"
    requests = RecordingRequests(folder, kept.settings)
    data = recorded(kept.folder / "r", "000009-of-the-drone", words="seen by the camera")
    for number, offered in enumerate((name, name.replace("T10", "T11"))):
        requests.ask(kept.surveys[number], drone, "000009-of-the-drone", 1.0)
        requests.offer(kept.surveys[number], drone, "", [OfferedRecording(offered, len(data))])
        part = Part(0, len(data) - number, len(data), hashlib.sha256(data).hexdigest())
        writer = requests.begin(kept.surveys[number], drone, offered, part)
        assert isinstance(writer, PartWriter)
        writer.write(data[: part.end])
        writer.close()
        requests.finish(kept.surveys[number], writer.coming)
    (kept.folder / "r").unlink()
    for survey_id in kept.surveys[:2]:
        assert b"seen by the camera" in b"".join(each.read_bytes() for each in files_below(folder.folder))
        erase(kept.settings, lot=None, survey=survey_id)
    assert b"seen by the camera" not in b"".join(each.read_bytes() for each in files_below(folder.folder))


@pytest.mark.slow
def test_a_recording_that_came_goes_with_its_own_survey_alone(kept: Kept) -> None:
    """Two drones name journals alike, and a name of a recording is given again once its file was deleted."""
    folder, journal, name = Recordings(kept.settings), kept.names[1], "20260510T103000Z.mcap"
    requests = RecordingRequests(folder, kept.settings)
    for number in (1, 2):
        if number == 2:
            folder.delete(name)
        data = recorded(kept.folder / "r", journal, words=f"seen by {number}")
        requests.ask(kept.surveys[number], f"Drone {number}", journal, 1.0)
        requests.offer(kept.surveys[number], f"Drone {number}", "", [OfferedRecording(name, len(data))])
        part = Part(0, len(data), len(data), hashlib.sha256(data).hexdigest())
        writer = requests.begin(kept.surveys[number], f"Drone {number}", name, part)
        assert isinstance(writer, PartWriter)
        writer.write(data)
        writer.close()
        assert requests.finish(kept.surveys[number], writer.coming)
    assert erase(kept.settings, lot=None, survey=kept.surveys[1]).recordings == 1, "the desk's own of that journal"
    assert (folder.folder / name).read_bytes() == data
    erase(kept.settings, lot=None, survey=kept.surveys[2])
    assert not (folder.folder / name).exists()


@pytest.mark.slow
@pytest.mark.parametrize("erased", [0, 2])
def test_the_recording_of_a_round_that_came_goes_with_each_of_its_surveys(kept: Kept, erased: int) -> None:
    folder, drone, name = Recordings(kept.settings), "Drone 1", "20260510T103000Z.mcap"
    requests, data = RecordingRequests(folder, kept.settings), recorded(kept.folder / "r", "000009-round")
    for number in (0, 2):
        requests.ask(kept.surveys[number], drone, "000009-round", 1.0)
        here = requests.offer(kept.surveys[number], drone, "", [OfferedRecording(name, len(data))])
        if here[name] < len(data):
            part = Part(0, len(data), len(data), hashlib.sha256(data).hexdigest())
            writer = requests.begin(kept.surveys[number], drone, name, part)
            assert isinstance(writer, PartWriter)
            writer.write(data)
            writer.close()
            assert requests.finish(kept.surveys[number], writer.coming)
    assert len(requests.origins()[name]) == 2
    assert (folder.folder / name).exists()
    erase(kept.settings, lot=None, survey=kept.surveys[erased])
    assert not (folder.folder / name).exists()


def files_below(folder: Path) -> list[Path]:
    return [path for path in sorted(folder.rglob("*")) if path.is_file()]

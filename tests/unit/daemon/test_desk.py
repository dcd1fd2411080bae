"""The desk: which picture lies under a plan, and what is refused."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from pathlib import Path

import pytest
from sqlalchemy import event

from hawk.cli import main
from hawk.comm.protocol.commands import Ack, Arm
from hawk.comm.protocol.heartbeat import ClientId
from hawk.config.sections import Config, ConfigError, InboxSettings
from hawk.daemon import desk
from hawk.daemon.desk import Under, ground_under, inbox_folder, refuse
from hawk.daemon.lots.schedule import Timetable
from hawk.lots.ingest import make_lot
from hawk.lots.store import FILE, LotStore
from hawk.lots.survey.pictures import PictureFolder, pictures_of
from hawk.lots.values import NotFoundError
from hawk.store.inbox import InboxQuota
from hawk.store.store_lock import held_store
from tests.unit.lots.repaints import Archive, flown
from tests.unit.lots.survey.test_pictures import MOSAIC
from tests.unit.lots.surveys import DATUM


@pytest.fixture
def archive(tmp_path: Path) -> Iterator[Archive]:
    made = Archive(tmp_path / FILE)
    yield made
    made.store.close()


def under(archive: Archive, pictures: PictureFolder, lot: str | None = None) -> Under | None:
    with archive.store.reading() as connection:
        return ground_under(connection, pictures, lot)


@pytest.mark.slow
def test_the_newest_survey_with_a_picture_lies_under_the_plan(archive: Archive) -> None:
    surveys = [archive.add(flown(number)).survey for number in (1, 2, 3)]
    pictures = pictures_of(archive.store.path)
    assert under(archive, pictures) is None
    for survey in surveys[:2]:
        pictures.write(survey, MOSAIC)
    found = under(archive, pictures)
    assert found is not None
    assert found.mosaic.map_id == surveys[1]
    assert found.datum == (DATUM.latitude, DATUM.longitude)
    assert set(found.mosaic.mosaic) == set(MOSAIC)


@pytest.mark.slow
def test_the_picture_is_found_by_as_many_statements_among_many_lots_as_in_one(archive: Archive) -> None:
    pictures = pictures_of(archive.store.path)
    pictures.write(archive.add(flown(1)).survey, MOSAIC)

    def statements() -> int:
        seen: list[object] = []
        with archive.store.reading() as connection:
            event.listen(connection, "before_cursor_execute", lambda *_: seen.append(0))
            assert ground_under(connection, pictures, None) is not None
        return len(seen)

    few = statements()
    with archive.store.writing() as connection:
        for _ in range(10):
            make_lot(connection, flown(1), 0)
    assert statements() == few


@pytest.mark.slow
def test_a_lot_is_chosen_by_name_and_one_that_is_not_there_is_named(archive: Archive) -> None:
    pictures = pictures_of(archive.store.path)
    pictures.write(archive.add(flown(1)).survey, MOSAIC)
    assert under(archive, pictures, "Lot 1") is not None
    with pytest.raises(NotFoundError, match="no lot is called 'Mall'"):
        under(archive, pictures, "Mall")


def test_a_broken_picture_is_logged_with_its_remedy_and_the_one_before_is_shown(
    archive: Archive, caplog: pytest.LogCaptureFixture
) -> None:
    pictures = pictures_of(archive.store.path)
    older, newer = (archive.add(flown(number)).survey for number in (1, 2))
    for survey in (older, newer):
        pictures.write(survey, MOSAIC)
    broken = {each: next(archive.store.path.parent.glob(f"*/{each}.zip")) for each in (older, newer)}
    broken[newer].write_bytes(b"PK")
    found = under(archive, pictures)
    assert found is not None
    assert found.mosaic.map_id == older
    assert "remove it: only the picture of that survey is lost" in caplog.text
    broken[older].write_bytes(b"PK")
    assert under(archive, pictures) is None


def test_a_command_to_a_drone_is_refused_in_words() -> None:
    answer = refuse(ClientId("one"), Arm(id=7))
    assert isinstance(answer, Ack)
    assert not answer.accepted
    assert "no drone here" in answer.reason


def test_half_files_of_a_former_run_are_removed_from_the_inbox(tmp_path: Path) -> None:
    (tmp_path / "monday").mkdir()
    for name in ("one.jpg", "two.jpg.0123abcd.hawk.part"):
        (tmp_path / "monday" / name).write_bytes(b"1")
    folder = inbox_folder(InboxSettings(folder=tmp_path, largest_gb=0.5, most_gb=2.0, most_files=3))
    assert folder is not None
    assert folder.quota == InboxQuota(500_000_000, 2_000_000_000, 3)
    assert [path.name for path in (tmp_path / "monday").iterdir()] == ["one.jpg"]
    assert inbox_folder(InboxSettings()) is None


def test_an_inbox_that_is_not_there_is_named_with_the_remedy(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"inbox\.folder: .*gone: No such file.*name the folder of hawk-drone map"):
        inbox_folder(InboxSettings(folder=tmp_path / "gone"))


def test_a_store_that_is_not_there_is_named_and_none_is_made(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["desk", "--port", "0", "--store", str(tmp_path / "other")]) == 2
    assert "lots.db is not there. Name the folder" in capsys.readouterr().err
    assert not (tmp_path / "other").exists()


@pytest.mark.slow
def test_a_lot_that_is_not_there_is_named_by_its_option(archive: Archive, capsys: pytest.CaptureFixture[str]) -> None:
    archive.add(flown(1))
    folder = archive.store.path.parent
    assert main(["desk", "--port", "0", "--store", str(folder), "--lot", "Mall"]) == 2
    assert "--lot: no lot is called 'Mall'; there are 'Lot 1'" in capsys.readouterr().err


def test_a_store_that_a_daemon_serves_is_left_to_it(archive: Archive, capsys: pytest.CaptureFixture[str]) -> None:
    folder = archive.store.path.parent
    with held_store(folder, {"version": "1", "port": "8080"}):
        assert main(["desk", "--port", "0", "--store", str(folder)]) == 2
    assert "It serves these lots already: open its page" in capsys.readouterr().err


async def test_a_desk_says_which_lots_of_its_schedule_are_not_known(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    said: asyncio.Queue[tuple[str, ...]] = asyncio.Queue()
    monkeypatch.setattr(desk, "_log_message", lambda *words: said.put_nowait(words))
    config = Config.model_validate({"schedule": [{"lot": "North", "at": "10:30"}]})
    store = LotStore(tmp_path / FILE)
    async with asyncio.timeout(30), desk._sending(config, store, Timetable(config.schedule)):
        level, text, details = await said.get()
    await store.close()
    assert (level, text) == ("warning", "The schedule names a lot that is not known: North.")
    assert details.startswith("schedule: no lot has the name or id North")

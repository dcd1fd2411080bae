"""Folders of results appear whole or not at all."""

from __future__ import annotations

import errno
import json
from pathlib import Path

import pytest

from hawk.replay.flight import RecordedFlight, ReplayError
from hawk.replay.process import process
from hawk.replay.results import SPARE_BYTES, new_folder, write_map
from tests.unit.replay.recordings import fake, flight, frame, recorded_frame, write


def names(folder: Path) -> list[str]:
    return sorted(each.name for each in folder.iterdir())


def test_a_folder_appears_at_the_end(tmp_path: Path) -> None:
    with new_folder(tmp_path / "out") as new:
        (new / "a.txt").write_text("a")
        assert not (tmp_path / "out").exists()
    assert names(tmp_path) == ["out"]
    assert names(tmp_path / "out") == ["a.txt"]


def test_an_empty_folder_is_filled_and_one_that_is_not_empty_is_refused(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    with new_folder(tmp_path / "out") as new:
        (new / "a.txt").write_text("a")
    with pytest.raises(ReplayError, match="is there and not empty: name a new folder"), new_folder(tmp_path / "out"):
        pytest.fail("it was written")
    assert names(tmp_path / "out") == ["a.txt"]


@pytest.mark.parametrize(
    ("number", "remedy"), [(errno.ENOSPC, "delete old files"), (errno.EACCES, "name a folder that you may write")]
)
def test_of_what_cannot_be_written_nothing_is_left(number: int, remedy: str, tmp_path: Path) -> None:
    def write_half() -> None:
        with new_folder(tmp_path / "out") as new:
            (new / "a.txt").write_text("a")
            raise OSError(number, "wrong")

    with pytest.raises(ReplayError, match=remedy):
        write_half()
    assert names(tmp_path) == []


def test_a_disk_without_room_is_noticed_before_anything_is_written(tmp_path: Path) -> None:
    with (
        pytest.raises(ReplayError, match="1 MB are free, 53 are needed: delete old files"),
        new_folder(tmp_path / "out", 3_000_000, lambda _: 1_500_000),
    ):
        pytest.fail("it was written")
    assert names(tmp_path) == []
    with new_folder(tmp_path / "out", 10, lambda _: SPARE_BYTES + 10):
        pass


def test_the_map_is_written_as_that_of_a_survey(tmp_path: Path) -> None:
    done = process(RecordedFlight(write(tmp_path / "a.mcap", flight(4, 3))), fake()[0])
    write_map(tmp_path / "out", done, "000007-x")
    assert names(tmp_path / "out") == ["map.png", "stalls.csv", "stalls.geojson"]
    found = json.loads((tmp_path / "out" / "stalls.geojson").read_text())
    assert found["hawk"]["survey_id"] == "000007-x"
    assert len(found["features"]) == 3


def test_a_map_without_a_place_on_earth_is_refused(tmp_path: Path) -> None:
    path = write(tmp_path / "a.mcap", [recorded_frame(frame(1), 11.0)])
    with pytest.raises(ReplayError, match=r"no place of the map's origin.*leave it out"):
        write_map(tmp_path / "out", process(RecordedFlight(path), fake()[0]), "")

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pyproj
import pytest

from hawk.picture.files import IN_SYSTEM, write_files
from hawk.picture.values import PictureError
from hawk.picture.work_folder import REPORT
from tests.unit.picture.surveys import mapped

NAMES = {"stalls.csv", "stalls.geojson", "survey.gpkg", "survey.kmz", "lot.png", REPORT}


def test_the_files_of_a_survey_are_there(tmp_path: Path) -> None:
    written = write_files(mapped(), tmp_path / "out", "hawk-drone 1.0")
    assert {path.name for path in written} == NAMES == {path.name for path in (tmp_path / "out").iterdir()}
    assert json.loads((tmp_path / "out" / REPORT).read_text())["free"] == 5
    assert len((tmp_path / "out" / "stalls.csv").read_text().splitlines()) == 9


@pytest.mark.slow
def test_stalls_are_in_the_system_of_the_source_too(tmp_path: Path) -> None:
    write_files(mapped(crs="EPSG:28992"), tmp_path, "hawk-drone 1.0")
    found = json.loads((tmp_path / IN_SYSTEM).read_text())
    assert found["crs"]["properties"]["name"] == "urn:ogc:def:crs:EPSG::28992"
    first = found["features"][0]["geometry"]["coordinates"][0]
    back = pyproj.Transformer.from_crs("EPSG:28992", "EPSG:4326", always_xy=True)
    longitude, latitude = back.transform(*first[0])
    survey = mapped().survey
    assert (latitude, longitude) == pytest.approx(survey.stalls[0].corners[0], abs=1e-7)
    assert first[0] == first[-1]


def test_a_second_run_replaces_files_as_a_whole(tmp_path: Path) -> None:
    (tmp_path / "stalls.csv").write_text("old")
    write_files(mapped(), tmp_path, "hawk-drone 1.0")
    assert "old" not in (tmp_path / "stalls.csv").read_text()
    assert not list(tmp_path.glob(".*"))


def test_a_second_run_leaves_no_file_of_the_first_one(tmp_path: Path) -> None:
    first = write_files(mapped(crs="EPSG:28992"), tmp_path, "hawk-drone 1.0")
    (tmp_path / "mine.txt").write_text("stays")
    second = write_files(replace(mapped(), ground=None), tmp_path, "hawk-drone 1.0")
    assert {path.name for path in first} - {path.name for path in second} == {IN_SYSTEM, "lot.png"}
    assert {path.name for path in tmp_path.iterdir()} == {path.name for path in second} | {"mine.txt"}


def test_a_folder_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(PictureError, match=r"--out: .*file.*cannot be written"):
        write_files(mapped(), tmp_path / "file", "hawk-drone 1.0")

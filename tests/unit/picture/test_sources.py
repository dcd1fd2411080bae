from __future__ import annotations

import os
import shlex
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import ExifTags, Image

from hawk.picture import sources
from hawk.picture.film.app import read_film
from hawk.picture.sources import MapRequest, survey_of_source
from hawk.picture.values import PictureError, PictureSurvey
from tests.unit.picture.film.films import Flight, captions, straight, write_film
from tests.unit.picture.orthophoto.drawn import blank, write

SHORT = Flight(straight, 2.0)
VIEW_DEG = 63.22
"""Of the drawn films' lens."""


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = write_film(tmp_path_factory.mktemp("film") / "DJI_0007.MP4", SHORT)
    path.with_suffix(".SRT").write_text(captions(SHORT), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Results of each step: what is found in the film's pictures is found once."""
    return tmp_path_factory.mktemp("out")


@pytest.fixture(scope="module")
def plain(film: Path, out: Path) -> PictureSurvey:
    """The survey of the film, of which a person says nothing."""
    return survey_of_source(MapRequest(film, out, hfov_deg=VIEW_DEG), _nothing)


@pytest.mark.slow
def test_a_film_is_mapped_as_photographs_are(film: Path, tmp_path: Path) -> None:
    steps: list[str] = []
    asked = MapRequest(film, tmp_path / "out", hfov_deg=VIEW_DEG)
    mapped = survey_of_source(asked, lambda step, *_: steps.append(step))
    survey = mapped.survey
    assert (survey.lot, survey.stalls, mapped.left_out) == ("DJI_0007", (), ())
    assert mapped.area_m2 > 500.0
    assert {"choose frames", "map"} <= set(steps)
    assert survey.ended == pytest.approx(1_777_890_601.5, abs=1.5)


@pytest.mark.slow
def test_a_name_is_the_lot_s_and_the_survey_stays_the_same(film: Path, out: Path, plain: PictureSurvey) -> None:
    named = survey_of_source(MapRequest(film, out, hfov_deg=VIEW_DEG, name=" North  Street "), _nothing)
    assert (named.survey.lot, named.landed.title) == ("North Street", "North Street")
    assert (named.landed.name, named.survey.survey) == (plain.landed.name, plain.survey.survey)
    assert named.survey.lot_id == plain.survey.lot_id
    pictures = named.landed.pictures
    assert pictures is not None
    assert pictures.words == "film DJI_0007.MP4"


@pytest.mark.slow
def test_the_time_that_a_person_says_is_that_of_the_last_picture_and_sure(
    film: Path, out: Path, plain: PictureSurvey
) -> None:
    timed = survey_of_source(MapRequest(film, out, hfov_deg=VIEW_DEG, taken=1_767_225_600.0), _nothing)
    survey, before = timed.survey, plain.survey
    assert (survey.ended, survey.time_is_sure, before.time_is_sure) == (1_767_225_600.0, True, False)
    assert survey.ended - survey.began == pytest.approx(before.ended - before.began)
    assert (timed.landed.utc, timed.landed.time_is_sure) == (1_767_225_600.0, True)


@pytest.mark.slow
def test_a_name_and_a_time_are_those_of_an_orthophoto_in_its_files_and_in_the_store(tmp_path: Path) -> None:
    path = blank(tmp_path, 400, 600)
    plain, said = (
        survey_of_source(MapRequest(path, tmp_path / "out", name=name, taken=taken), _nothing)
        for name, taken in ((None, None), ("North", 1_767_225_600.0))
    )
    assert (plain.survey.lot, plain.survey.time_is_sure, plain.landed.title) == ("blank", False, "blank")
    assert (said.survey.lot, said.survey.ended, said.survey.time_is_sure) == ("North", 1_767_225_600.0, True)
    assert (said.landed.title, said.landed.utc, said.landed.time_is_sure) == ("North", 1_767_225_600.0, True)
    assert said.survey.survey == plain.survey.survey


def test_a_time_is_refused_before_the_work_where_the_files_say_it_themselves(
    film: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sources, "read_film", lambda *of, **by: replace(read_film(*of, **by), time_is_sure=True))
    monkeypatch.setattr(sources, "survey_shots", lambda *_, **__: pytest.fail("it was mapped"))
    words = _refused(MapRequest(film, tmp_path / "out", hfov_deg=VIEW_DEG, taken=1_767_225_600.0))
    assert "--taken: the files say themselves" in words


@pytest.mark.slow
@pytest.mark.parametrize("is_sure", [True, False])
def test_a_moment_that_has_not_been_is_refused_before_the_work_with_the_remedy(
    film: Path, out: Path, monkeypatch: pytest.MonkeyPatch, *, is_sure: bool
) -> None:
    early = MapRequest(film, out, hfov_deg=VIEW_DEG, now=1_777_800_000.0)  # 25 h before the film
    monkeypatch.setattr(sources, "read_film", lambda *of, **by: replace(read_film(*of, **by), time_is_sure=is_sure))
    monkeypatch.setattr(sources, "survey_shots", lambda *_, **__: pytest.fail("it was mapped"))
    words = _refused(early)
    assert "which is later than now" in words
    assert "--taken" in words
    monkeypatch.undo()
    timed = survey_of_source(replace(early, taken=1_767_225_600.0), _nothing).survey
    assert (timed.ended, timed.time_is_sure) == (1_767_225_600.0, True)


def test_an_orthophoto_of_2062_is_refused_before_the_work_with_the_remedy(tmp_path: Path) -> None:
    path = blank(tmp_path, 400, 600)
    os.utime(path, (2_916_000_000.0, 2_916_000_000.0))
    words = _refused(MapRequest(path, tmp_path / "out"))
    assert "2062-" in words
    assert "its file's time of change" in words
    assert "--taken" in words


def test_a_name_that_a_lot_cannot_have_is_refused(film: Path, tmp_path: Path) -> None:
    assert "--name: has 81 characters" in _refused(MapRequest(film, tmp_path / "out", hfov_deg=VIEW_DEG, name="n" * 81))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"crs": "EPSG:4326"}, "--crs: has no use for a film"),
        ({"workers": 2}, "--workers: has no use for a film"),
        ({"group": 2}, "--group: has no use for a film"),
        ({"hfov_deg": None}, "nothing says how its lens draws"),
        ({"log": Path("flight.csv")}, "must be DJI's captions"),
    ],
)
def test_options_that_do_not_fit_a_film_are_refused(
    film: Path, tmp_path: Path, changes: dict[str, Any], words: str
) -> None:
    asked = replace(MapRequest(film, tmp_path / "out", hfov_deg=VIEW_DEG), **changes)
    with pytest.raises(PictureError, match=words):
        survey_of_source(asked, lambda *_: None)


@pytest.mark.parametrize(
    ("changes", "option"),
    [
        ({"log_offset_s": 3.0}, "--log-offset"),
        ({"hfov_deg": 60.0}, "--hfov"),
        ({"focal35_mm": 24.0}, "--focal35"),
        ({"log": Path("a.bin")}, "--log"),
    ],
)
def test_options_of_films_are_refused_for_others(tmp_path: Path, changes: dict[str, Any], option: str) -> None:
    for source, kind in (
        (tmp_path, "a folder of photographs"), (Path("a.tif"), "an orthophoto"), (Path("a.mcap"), "a recording"),
    ):  # fmt: skip
        asked = replace(MapRequest(source, tmp_path / "out"), **changes)
        with pytest.raises(PictureError, match=f"{option}: has no use for {kind}; leave it out"):
            survey_of_source(asked, lambda *_: None)


def test_a_project_of_webodm_without_an_orthophoto_is_read_for_its_photographs(tmp_path: Path) -> None:
    (tmp_path / "odm_report").mkdir()
    (tmp_path / "odm_report" / "shots.geojson").write_text('{"features": []}', encoding="utf-8")
    with pytest.raises(PictureError, match=r"images cannot be read|none of its photographs"):
        survey_of_source(MapRequest(tmp_path, tmp_path / "out"), lambda *_: None)
    with pytest.raises(PictureError, match="--group: has no use for a WebODM project"):
        survey_of_source(MapRequest(tmp_path, tmp_path / "out", group=1), lambda *_: None)


def test_the_orthophoto_of_a_project_is_taken(tmp_path: Path) -> None:
    (tmp_path / "odm_orthophoto").mkdir()
    (tmp_path / "odm_orthophoto" / "odm_orthophoto.tif").write_bytes(b"no picture")
    with pytest.raises(PictureError, match=r"odm_orthophoto\.tif"):
        survey_of_source(MapRequest(tmp_path, tmp_path / "out"), lambda *_: None)
    with pytest.raises(PictureError, match="--height: has no use for an orthophoto"):
        survey_of_source(MapRequest(tmp_path, tmp_path / "out", height_m=50.0), lambda *_: None)


def _nothing(*_: object) -> None:
    """Show nothing."""


def _refused(asked: MapRequest) -> str:
    with pytest.raises(PictureError) as refused:
        survey_of_source(asked, _nothing)
    return str(refused.value)


def test_an_unknown_kind_is_refused_with_those_that_are_known(tmp_path: Path) -> None:
    (tmp_path / "a.docx").write_text("")
    assert ".tif" in _refused(MapRequest(tmp_path / "a.docx", tmp_path / "out"))


@pytest.mark.parametrize(
    ("name", "values", "option"),
    [("a.tif", {"height_m": 60.0}, "--height"), ("a.tif", {"group": 1}, "--group")],
)
def test_an_option_of_another_kind_is_refused(tmp_path: Path, name: str, values: dict[str, float], option: str) -> None:
    (tmp_path / name).write_text("")
    assert _refused(MapRequest(tmp_path / name, tmp_path / "out", **values)).startswith(option)  # type: ignore[arg-type]


def test_an_outline_is_refused_for_photographs(tmp_path: Path) -> None:
    assert _refused(MapRequest(tmp_path, tmp_path / "out", outline=tmp_path / "lots.gpkg")).startswith("--outline")


def test_a_calibration_that_is_none_is_named(tmp_path: Path) -> None:
    lens = tmp_path / "lens.yaml"
    lens.write_text("[]")
    assert _refused(MapRequest(tmp_path, tmp_path / "out", calibration=lens)).startswith("--calibration")


def test_an_empty_folder_is_refused(tmp_path: Path) -> None:
    assert "no JPEG photograph" in _refused(MapRequest(tmp_path, tmp_path / "out"))


def test_a_folder_of_tiles_is_refused_with_the_command_that_joins_them(tmp_path: Path) -> None:
    write(tmp_path / "a.tif", np.full((3, 64, 64), 90, np.uint8))
    assert f"gdalbuildvrt {tmp_path.name}.vrt {tmp_path}/*.tif" in _refused(MapRequest(tmp_path, tmp_path / "out"))


@pytest.mark.slow
def test_a_folder_of_tiff_photographs_is_refused_with_a_command_that_keeps_their_tags(tmp_path: Path) -> None:
    folder = tmp_path / "flight"
    folder.mkdir()
    Image.new("RGB", (64, 48), (90, 90, 90)).save(folder / "DJI_0001.tif")
    words = _refused(MapRequest(folder, tmp_path / "out"))
    assert "holds photographs as TIFF (DJI_0001.tif); save them as JPEGs beside" in words
    command = shlex.split(words[words.index("exiftool") :])
    if shutil.which(command[0]) is None:
        pytest.skip("exiftool is not installed")
    placed = ("-Make=DJI", "-GPSLatitude=52.09", "-GPSLatitudeRef=N", "-overwrite_original")
    subprocess.run([command[0], *placed, str(folder / "DJI_0001.tif")], check=True, capture_output=True)
    with Image.open(folder / "DJI_0001.tif") as opened:
        opened.save(folder / "DJI_0001.jpg", exif=b"")
    subprocess.run(command, check=True, capture_output=True)
    with Image.open(folder / "DJI_0001.jpg") as opened:
        kept = opened.getexif()
    assert kept[271] == "DJI"
    assert [float(each) for each in kept.get_ifd(ExifTags.IFD.GPSInfo)[2]] == pytest.approx([52, 5, 24])


@pytest.mark.parametrize(
    ("name", "data", "words"),
    [
        ("a.heic", b"\0\0\0\x18ftypheic", "a.heic is a photograph as HEIC: save it as JPEG"),
        ("all.zip", b"PK\x03\x04", "all.zip is a ZIP archive that is cut or damaged: copy it again"),
    ],
)
def test_a_folder_without_jpegs_says_what_lies_in_it(tmp_path: Path, name: str, data: bytes, words: str) -> None:
    (tmp_path / name).write_bytes(data)
    assert words in _refused(MapRequest(tmp_path, tmp_path / "out"))

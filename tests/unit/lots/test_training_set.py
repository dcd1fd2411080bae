"""Pictures with confirmed stalls as labels: what is written, and what is refused or left out."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from benchmarks.perception.places import missing_ground, read_lots
from hawk.cli import main
from hawk.lots.names import lot_named
from hawk.lots.survey.pictures import PictureFolder, pictures_of
from hawk.lots.training_set import Lesson, read_lesson, write_lesson
from hawk.lots.values import LotStoreError, NotFoundError
from hawk.model.lot_map import TILE_CELLS, EncodedTile, TileKey
from hawk.model.tile_picture import encode_picture
from tests.unit.lots.repaints import Archive, flown, repainted


@pytest.fixture
def archive(tmp_path: Path) -> Iterator[Archive]:
    made = Archive(tmp_path / "lots.db")
    yield made
    made.store.close()


def mosaic() -> dict[TileKey, EncodedTile]:
    """Return a picture of noise over the lot: 26 m about the datum, and 51 m farther to its east."""
    rng = np.random.default_rng(1)
    seen = np.full((TILE_CELLS, TILE_CELLS), 255, np.uint8)
    pixels = rng.integers(60, 100, (TILE_CELLS, TILE_CELLS, 3)).astype(np.uint8)
    tile = EncodedTile(1, encode_picture(pixels, seen))
    return {(row, column): tile for row in (-1, 0) for column in (-1, 0, 1, 2)}


def confirmed(archive: Archive, *numbers: int) -> list[str]:
    """Fly the lot, confirm its stalls, and return the surveys' ids."""
    saved = [archive.add(flown(number)).survey for number in numbers]
    archive.edit({"do": "confirm", "all": True})
    return saved


def lesson(archive: Archive) -> Lesson:
    with archive.store.reading() as connection:
        return read_lesson(connection, archive.lot)


@pytest.mark.nightly
def test_each_survey_with_a_picture_is_one_picture_with_the_confirmed_stalls(archive: Archive, tmp_path: Path) -> None:
    first, second = confirmed(archive, 1, 2)
    pictures = PictureFolder(tmp_path / "pictures")
    pictures.write(first, mosaic())
    taught = write_lesson(lesson(archive), pictures, tmp_path / "out")
    assert (len(taught.pictures), taught.gone, taught.painted) == (1, 1, 0)
    pictures.write(second, mosaic())
    taught = write_lesson(lesson(archive), pictures, tmp_path / "both")
    assert (len(taught.pictures), taught.gone) == (2, 0)
    assert [place.name for place in read_lots(tmp_path / "both")] == list(taught.pictures)


@pytest.mark.slow
def test_labels_lie_where_the_stalls_are_in_the_picture(archive: Archive, tmp_path: Path) -> None:
    (survey,) = confirmed(archive, 1)
    pictures = PictureFolder(tmp_path / "pictures")
    pictures.write(survey, mosaic())
    write_lesson(lesson(archive), pictures, tmp_path / "out")
    (place,) = read_lots(tmp_path / "out")
    assert len(place.truth.stalls) == 60
    height, width = place.image.shape[:2]
    assert place.truth.stalls.min() >= 0
    assert (place.truth.stalls.reshape(-1, 2).max(axis=0) <= np.array((width, height)) * 0.1 + 1e-6).all()
    steps = np.diff(place.truth.stalls[:20].mean(axis=1), axis=0)
    assert steps[:, 0] == pytest.approx(2.5, abs=0.6)  # eastward is to the right
    down = place.truth.stalls[20:40].mean(axis=(0, 1)) - place.truth.stalls[:20].mean(axis=(0, 1))
    assert down[1] == pytest.approx(9.0, abs=0.3)  # southward is down
    assert len(place.truth.lots) == 1


@pytest.mark.slow
def test_a_state_is_a_label_only_where_the_survey_was_sure(archive: Archive, tmp_path: Path) -> None:
    given = flown(1)
    sure = [replace(stall, taken_probability=0.97 if k % 2 else 0.6) for k, stall in enumerate(given.stalls)]
    saved = archive.add(replace(given, stalls=tuple(sure)))
    archive.edit({"do": "confirm", "all": True})
    pictures = PictureFolder(tmp_path / "pictures")
    pictures.write(saved.survey, mosaic())
    (name,) = write_lesson(lesson(archive), pictures, tmp_path / "out").pictures
    labels = json.loads((tmp_path / "out" / f"{name}.json").read_text())["stalls"]
    unclear = [label["state"] == "unclear" for label in labels]
    assert unclear == [k % 2 == 0 for k in range(60)]


@pytest.mark.slow
def test_ground_whose_stalls_nobody_knows_is_missing_in_the_picture(archive: Archive, tmp_path: Path) -> None:
    given = flown(1)
    saved = archive.add(given)
    archive.edit({"do": "confirm", "all": True})
    pictures = PictureFolder(tmp_path / "pictures")
    pictures.write(saved.survey, {key: each for key, each in mosaic().items() if key[1] < 1})
    (name,) = write_lesson(lesson(archive), pictures, tmp_path / "out").pictures
    image = cv2.imread(str(tmp_path / "out" / f"{name}.jpg"))
    assert image is not None
    assert image.shape[1] < 2 * TILE_CELLS
    labels = json.loads((tmp_path / "out" / f"{name}.json").read_text())["stalls"]
    assert 0 < len(labels) < 60
    known = lesson(archive)
    small = replace(known, known=known.known.intersection(known.known.centroid.buffer(12.0)))
    write_lesson(small, pictures, tmp_path / "small")
    missing = missing_ground(np.asarray(cv2.imread(str(tmp_path / "small" / f"{name}.jpg")), np.uint8))
    assert missing is not None
    assert 0.2 < missing.mean() < 1.0


@pytest.mark.slow
def test_stalls_that_nobody_confirmed_teach_nothing(archive: Archive) -> None:
    archive.add(flown(1))
    archive.edit({"do": "confirm", "row": "B"})
    with pytest.raises(LotStoreError, match=r"40 of 60 stalls are not confirmed.*Confirm.* in the tab Stalls"):
        lesson(archive)


@pytest.mark.slow
def test_surveys_from_before_new_paint_are_left_out(archive: Archive, tmp_path: Path) -> None:
    pictures = PictureFolder(tmp_path / "pictures")
    for number in (1, 2):
        pictures.write(archive.add(flown(number)).survey, mosaic())
    newest = archive.add(repainted(3)).survey
    archive.take_over(newest, begin="all", end="all")
    archive.edit({"do": "confirm", "all": True})
    with pytest.raises(LotStoreError, match=r"3 from before the lot was painted again.*fly a survey"):
        write_lesson(lesson(archive), pictures, tmp_path / "out")
    pictures.write(archive.add(repainted(4)).survey, mosaic())
    taught = write_lesson(lesson(archive), pictures, tmp_path / "out")
    assert (len(taught.pictures), taught.painted) == (1, 3)


@pytest.mark.slow
def test_a_broken_picture_is_named(archive: Archive, tmp_path: Path) -> None:
    (survey,) = confirmed(archive, 1)
    pictures = PictureFolder(tmp_path / "pictures")
    pictures.write(survey, {(0, 0): EncodedTile(1, b"no picture")})
    with pytest.raises(LotStoreError, match=r"picture of survey .* cannot be read"):
        write_lesson(lesson(archive), pictures, tmp_path / "out")


@pytest.mark.slow
def test_a_lot_is_named_by_id_or_by_a_name_that_is_its_own(archive: Archive) -> None:
    archive.add(flown(1))
    with archive.store.reading() as connection:
        assert lot_named(connection, archive.lot) == lot_named(connection, "Lot 1") == archive.lot
        with pytest.raises(NotFoundError, match=r"no lot is called 'Mall'; there are 'Lot 1'"):
            lot_named(connection, "Mall")


@pytest.mark.slow
def test_the_command_writes_the_folder_and_says_how_to_go_on(
    archive: Archive, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (survey,) = confirmed(archive, 1)
    pictures_of(tmp_path / "lots.db").write(survey, mosaic())
    out = tmp_path / "out"
    command = ["export", "Lot 1", "--store", str(tmp_path), "--training", str(out)]
    assert main(command) == 0
    assert "pictures with labels: 1" in capsys.readouterr().out
    assert main(command) == 2
    assert "is there and not empty: name a new folder" in capsys.readouterr().err


def test_the_command_names_what_is_missing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["export", "Lot 1", "--store", str(tmp_path), "--training", str(tmp_path / "out")]) == 1
    assert "there is no store of lots" in capsys.readouterr().err
    assert not (tmp_path / "lots.db").exists()

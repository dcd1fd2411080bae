"""Pictures of surveys: written whole or not at all, the newest kept, and drawn on ground."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from hawk.lots.ingest import save
from hawk.lots.storage.database import Database
from hawk.lots.survey.pictures import KEPT, PictureFolder, drawn, extent, pictures_of, worth_keeping
from hawk.lots.values import LotStoreError
from hawk.model.lot_map import TILE_CELLS, TILE_M, EncodedTile, TileKey
from hawk.model.plans import Outline
from hawk.model.tile_picture import encode_picture
from tests.unit.lots.surveys import later, survey


def tile(level: int, *, seen_columns: int = TILE_CELLS) -> EncodedTile:
    seen = np.zeros((TILE_CELLS, TILE_CELLS), np.uint8)
    seen[:, :seen_columns] = 255
    return EncodedTile(1, encode_picture(np.full((TILE_CELLS, TILE_CELLS, 3), level, np.uint8), seen))


def image_of(data: bytes | None) -> NDArray[np.uint8]:
    assert data is not None
    return np.asarray(cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED), np.uint8)


MOSAIC: dict[TileKey, EncodedTile] = {(0, 0): tile(40), (-1, 0): tile(200), (0, -1): tile(90, seen_columns=100)}


def test_tiles_come_back_as_they_were(tmp_path: Path) -> None:
    pictures = PictureFolder(tmp_path / "pictures")
    assert pictures.read("a") == {}
    pictures.write("a", MOSAIC)
    assert pictures.read("a") == {key: each.data for key, each in MOSAIC.items()}
    assert pictures.surveys() == {"a"}


def test_one_picture_shows_all_tiles_and_nothing_where_nothing_was_seen(tmp_path: Path) -> None:
    pictures = PictureFolder(tmp_path)
    assert pictures.whole("a") is None
    pictures.write("a", MOSAIC)
    image = image_of(pictures.whole("a"))
    assert image.shape == (2 * TILE_CELLS, 2 * TILE_CELLS, 4)
    middle, end = TILE_CELLS // 2, TILE_CELLS + TILE_CELLS // 2
    assert image[middle, end] == pytest.approx([200, 200, 200, 255], abs=3)
    assert image[end, end] == pytest.approx([40, 40, 40, 255], abs=3)
    assert image[end, 50] == pytest.approx([90, 90, 90, 255], abs=3)
    assert (image[end, middle, 3], image[middle, middle, 3]) == (0, 0), "not seen, and no tile"
    assert sorted(pictures.read("a")) == pictures.keys("a") == sorted(MOSAIC)


def test_the_picture_of_a_large_lot_is_coarser_and_fits_a_screen(tmp_path: Path) -> None:
    pictures = PictureFolder(tmp_path)
    pictures.write("a", {(0, 0): MOSAIC[0, 0], (1, 6): MOSAIC[0, 0]})
    image = image_of(pictures.whole("a"))
    assert image.shape == (TILE_CELLS, 7 * TILE_CELLS // 2, 4)


def test_a_tile_that_is_no_picture_costs_the_picture_of_the_whole_alone(tmp_path: Path) -> None:
    pictures = PictureFolder(tmp_path)
    pictures.write("a", {**MOSAIC, (5, 5): EncodedTile(1, b"none")})
    assert (pictures.whole("a"), len(pictures.keys("a"))) == (None, 4)


def test_a_survey_without_a_picture_makes_no_file(tmp_path: Path) -> None:
    PictureFolder(tmp_path / "pictures").write("a", {})
    assert not (tmp_path / "pictures").exists()


def test_a_picture_that_cannot_be_written_leaves_the_former_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pictures = PictureFolder(tmp_path)
    pictures.write("a", {(0, 0): MOSAIC[0, 0]})

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full)
    with pytest.raises(OSError, match="No space"):
        pictures.write("a", MOSAIC)
    assert list(pictures.read("a")) == [(0, 0)]


def test_a_damaged_file_is_named_with_its_remedy(tmp_path: Path) -> None:
    pictures = PictureFolder(tmp_path)
    pictures.write("a", MOSAIC)
    whole = (tmp_path / "a.zip").read_bytes()
    (tmp_path / "a.zip").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(LotStoreError, match=r"a\.zip.*remove it"):
        pictures.read("a")


def test_files_of_other_names_and_sizes_in_it_are_left_alone(tmp_path: Path) -> None:
    import zipfile

    with zipfile.ZipFile(tmp_path / "a.zip", "w", zipfile.ZIP_DEFLATED) as file:
        file.writestr("../outside.jpg", b"x")
        file.writestr("0_0.jpg", b"\0" * (2 << 20))
        file.writestr("1_1.jpg", b"small")
    assert PictureFolder(tmp_path).read("a") == {(1, 1): b"small"}


def test_only_named_surveys_are_kept(tmp_path: Path) -> None:
    pictures = PictureFolder(tmp_path)
    for name in "abc":
        pictures.write(name, MOSAIC)
    pictures.keep({"b", "z"})
    assert pictures.surveys() == {"b"}


def test_a_half_written_picture_goes_with_its_survey(tmp_path: Path) -> None:
    pictures = PictureFolder(tmp_path)
    pictures.write("a", MOSAIC)
    for name in ("a.part", "b.part"):
        (tmp_path / name).touch()
    assert (pictures.remove("a"), pictures.remove("b")) == (True, False)
    assert [*tmp_path.iterdir()] == []


@pytest.mark.slow
def test_the_newest_surveys_of_each_lot_are_worth_keeping(tmp_path: Path) -> None:
    store = Database(tmp_path / "lots.db", {"synchronous": 0})
    with store.writing() as connection:
        saved = [save(connection, later(survey(), n, hours=n)).survey for n in range(KEPT + 3)]
        none = [save(connection, replace(later(survey(stalls=0), 90 + n, n), outline=Outline())).survey for n in (1, 2)]
    with store.reading() as connection:
        assert worth_keeping(connection, {*saved, *none, "gone"}, saved[-1]) == {*saved[3:], *none}
        assert worth_keeping(connection, {*saved, *none}, none[0]) == {*saved[3:], *none}
        few = {*saved[2:5], none[0]}
        assert worth_keeping(connection, few, saved[-1]) == few - {saved[2]}
        assert worth_keeping(connection, few, none[0]) == few
    store.close()


def test_a_picture_shows_north_up_what_was_seen() -> None:
    tiles = {key: each.data for key, each in MOSAIC.items()}
    assert extent(tiles) == (-TILE_M, -TILE_M, TILE_M, TILE_M)
    shown = drawn(tiles, extent(tiles))
    assert shown is not None
    assert (shown.north, shown.east) == (TILE_M, -TILE_M)
    assert shown.image.shape == (2 * TILE_CELLS, 2 * TILE_CELLS, 3)
    north_east, south_east = shown.image[100, TILE_CELLS + 50], shown.image[TILE_CELLS + 100, TILE_CELLS + 50]
    assert north_east.tolist() == [200] * 3
    assert south_east.tolist() == [40] * 3
    assert not shown.seen[:TILE_CELLS, :TILE_CELLS].any()
    assert shown.seen[TILE_CELLS:, :100].all()
    assert not shown.seen[TILE_CELLS:, 101:TILE_CELLS].any()


def test_a_box_is_cut_out_of_its_tiles() -> None:
    tiles = {key: each.data for key, each in MOSAIC.items()}
    shown = drawn(tiles, (-1.0, 2.0, 1.0, 5.0))
    assert shown is not None
    assert (shown.image.shape, shown.north, shown.east) == ((20, 30, 3), 1.0, 2.0)
    assert np.unique(shown.image[:10]).tolist() == [200]
    assert drawn(tiles, (500.0, 500.0, 510.0, 510.0)) is None


def test_pictures_lie_beside_their_store(tmp_path: Path) -> None:
    pictures_of(tmp_path / "other.db").write("a", MOSAIC)
    assert (tmp_path / "other-pictures" / "a.zip").exists()

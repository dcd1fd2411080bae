"""The files of a survey by the ends of their names, and what is left of one that cannot be written."""

from __future__ import annotations

import errno
import io
import json
import zipfile
from pathlib import Path

import numpy as np
import pyogrio
import pytest
import shapely

from hawk.exports.feeds import feed_text
from hawk.exports.files import TABLES, export, made, tiles_of
from hawk.exports.formats import WRITTEN, Wanted
from hawk.lots.answers import SurveyPlace
from hawk.lots.registration.frames import same_stalls
from hawk.lots.registration.georeference import about
from hawk.lots.values import Doubtful, KnownGround, LotStoreError, MappedGround, Registration
from hawk.results.stall_files import CSV_COLUMNS
from tests.unit.exports.stored import Stored
from tests.unit.lots.repaints import flown

BEGINNINGS = {
    ".csv": b"stall_id,", ".geojson": b'{"type": "FeatureCollection"', ".gpkg": b"SQLite format 3\x00",
    ".kmz": b"PK\x03\x04", ".png": b"\x89PNG", ".tif": b"II",
    ".sections.csv": b"section_id,", ".sections.geojson": b'{"type": "FeatureCollection"',
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("suffix", WRITTEN)
def test_the_end_of_the_name_says_what_is_written(stored: Stored, tmp_path: Path, suffix: str) -> None:
    with stored.store.reading() as connection:
        written = export(connection, stored.first.survey, stored.pictures, tmp_path / f"lot{suffix.upper()}")
    assert written[0].read_bytes().startswith(BEGINNINGS[suffix])
    assert len(written) == (3 if suffix == ".tif" else 1)
    assert not list(tmp_path.glob("*.part"))
    assert not list(tmp_path.glob(".hawk-export*"))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("suffix", "layer", "key"), [(".gpkg", "stalls", "stall_id"), (".geojson", None, "id"), (".kmz", None, "stall_id")]
)
def test_gdal_opens_each_file_with_its_system_and_places_to_a_centimetre(
    stored: Stored, tmp_path: Path, suffix: str, layer: str | None, key: str
) -> None:
    file, survey = tmp_path / f"lot{suffix}", stored.read()
    with stored.store.reading() as connection:
        export(connection, survey.survey, stored.pictures, file)
    meta, _, shapes, values = pyogrio.raw.read(file, layer=layer)
    assert meta["crs"] == "EPSG:4326"
    ids = dict(zip(meta["fields"].tolist(), values, strict=True))[key].tolist()
    middles = {each: shapely.from_wkb(shape).centroid for each, shape in zip(ids, shapes, strict=True)}
    for stall in survey.stalls:
        place = np.array([(middles[stall.id].y, middles[stall.id].x)])
        assert np.abs(about(stall.place, place)[0, :2]).max() < 0.01
    assert len(shapes) == len(survey.stalls) + (suffix == ".geojson"), "GeoJSON has the lot, too"


@pytest.mark.slow
def test_gdal_opens_the_table(stored: Stored, tmp_path: Path) -> None:
    with stored.store.reading() as connection:
        export(connection, stored.first.survey, stored.pictures, tmp_path / "lot.csv")
    meta, _, _, values = pyogrio.raw.read(tmp_path / "lot.csv")
    assert tuple(meta["fields"]) == CSV_COLUMNS
    assert len(values[0]) == 60


@pytest.mark.slow
def test_a_picture_lies_where_its_survey_is_registered_and_one_in_doubt_in_its_own_frame(stored: Stored) -> None:
    def turned(known: KnownGround, found: MappedGround) -> Registration:
        return Registration(0.5, -0.25, 0.01, same_stalls(known.stalls, found.stalls))

    moved, doubtful = stored.add(flown(2), turned), stored.add(flown(3), lambda *_: Doubtful("it may lie beside"))
    with stored.store.reading() as connection:
        tiles = {each.survey: tiles_of(connection, each.survey, stored.pictures) for each in (moved, doubtful)}
        first = tiles_of(connection, stored.first.survey, stored.pictures)
    place = tiles[moved.survey].place
    assert (place.north, place.east, place.turn) == pytest.approx((0.5, -0.25, 0.01), abs=0.2)
    assert place.turn == pytest.approx(0.01, abs=1e-3)
    assert tiles[doubtful.survey].place == first.place == SurveyPlace(north=0.0, east=0.0, turn=0.0)
    assert sorted(first.tiles) == [[row, column] for row in (-1, 0) for column in (-1, 0, 1, 2)]
    assert (tiles[moved.survey].tiles, first.cells, first.cell_m) == ([], 256, 0.1)


@pytest.mark.nightly
@pytest.mark.parametrize(("age_s", "is_known"), [(3600.0, True), (3601.0, False)])
def test_a_feed_gives_a_state_for_an_hour_where_no_other_time_is_named(
    stored: Stored, age_s: float, is_known: bool
) -> None:
    looked_at = max(each.looked_at or 0.0 for each in stored.read().stalls)
    with stored.store.reading() as connection:
        text = feed_text(connection, "cds", Wanted(stored.lot), looked_at + age_s)
    assert any("available" in each for each in json.loads(text)["data"]["spaces"]) is is_known


@pytest.mark.slow
def test_rasters_come_in_one_archive(stored: Stored) -> None:
    with stored.store.reading() as connection:
        content_type, data = made(connection, stored.first.survey, stored.pictures, ".zip")
        with pytest.raises(LotStoreError, match=r"kind: \.exe must be one of \.csv, \.geojson, \.gpkg"):
            made(connection, stored.first.survey, stored.pictures, ".exe")
    assert content_type == "application/zip"
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        stem = f"survey-{stored.first.survey[:8]}"
        assert archive.namelist() == [f"{stem}.tif", f"{stem}-occupancy.tif", f"{stem}.json"]


@pytest.mark.slow
@pytest.mark.parametrize("suffix", [*TABLES, ".png"])
def test_a_full_disk_leaves_the_file_of_before(
    stored: Stored, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, suffix: str
) -> None:
    target = tmp_path / f"lot{suffix}"
    target.write_bytes(b"before")

    def full(self: Path, data: bytes) -> int:
        with self.open("wb") as file:
            file.write(data[:5])
        raise OSError(errno.ENOSPC, "No space left on device", str(self))

    monkeypatch.setattr(Path, "write_bytes", full)
    with stored.store.reading() as connection, pytest.raises(LotStoreError, match=f"--out: {target}: no room"):
        export(connection, stored.first.survey, stored.pictures, target)
    assert target.read_bytes() == b"before"
    assert not list(tmp_path.glob("*.part"))

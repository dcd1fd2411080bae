"""The first bytes of a file say what it is, whatever its name says, and a refusal has the remedy of that kind."""

from __future__ import annotations

import io
import sqlite3
import struct
import zipfile
from pathlib import Path

import pytest

from hawk.formats.kind import kind_of, kind_of_file
from hawk.picture.sources import MapRequest, survey_of_source
from hawk.picture.values import PictureError


def archive(*names: str) -> bytes:
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w") as packed:
        for name in names:
            packed.writestr(name, b"x")
    return made.getvalue()


def tiles(with_id: bool, folder: Path) -> bytes:
    path = folder / "t.db"
    opened = sqlite3.connect(path)
    opened.execute("CREATE TABLE tiles (zoom_level INTEGER, tile_column INTEGER, tile_row INTEGER, tile_data BLOB)")
    if with_id:
        opened.execute(f"PRAGMA application_id = {0x4D504258}")
    opened.commit()
    opened.close()
    return path.read_bytes()


DNG = struct.pack("<2sHIHHHIIHHII", b"II", 42, 8, 2, 256, 4, 1, 4000, 50706, 1, 4, 0x0401) + bytes(40)
WMS = b'<?xml version="1.0"?>\n<!-- a -->\n<GDAL_WMS><Service name="TMS"/></GDAL_WMS>'


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", "is empty[:;]"),
        (archive("all/odm_orthophoto/odm_orthophoto.tif"), "all that WebODM made, as an archive; unpack it, and name"),
        (archive("DJI_0001.JPG"), "is an archive of photographs; unpack it, and name the folder"),
        (archive("a.txt"), "is a ZIP archive; unpack it"),
        (archive("a.txt")[:60], "cut or damaged; copy it again"),
        (b"\x00\x00\x00\x18ftypheic" + bytes(20), "is a photograph as HEIC; save it as JPEG with its EXIF"),
        (DNG, r"is a raw photograph \(DNG\); name the folder of the JPEGs beside it"),
        (b"1\n00:00:00,000 --> 00:00:01,000\nx\n", r"captions \(SRT\); name the film"),
        (b"#EXTM3U\nhttp://example.org/a.ts\n", "list of films on a server; copy the film itself"),
        (b"PMTiles\x03" + bytes(40), r"map tiles \(PMTiles\); export the orthophoto itself"),
        (b"LASF" + bytes(40), r"cloud of points \(LAS\); name the orthophoto"),
        (WMS, "XML by which GDAL asks a server; save the picture itself"),
        (b"\xef\xbb\xbf" + WMS, "XML by which GDAL asks a server"),
        (b"\x89HDF\r\n\x1a\n", "is an HDF5 file; export the picture as GeoTIFF"),
        (b"no picture at all", "is of no kind that is known[:;] (name one that ends in .tif|export it|copy it)"),
    ],
    ids=lambda each: each if isinstance(each, str) else "file",
)  # fmt: skip
@pytest.mark.parametrize("name", ["photo.tif", "photo.mp4", "photo"])
def test_a_source_that_is_something_else_is_named_with_its_remedy(
    tmp_path: Path, name: str, data: bytes, words: str
) -> None:
    path = tmp_path / name
    path.write_bytes(data)
    with pytest.raises(PictureError, match=words):
        survey_of_source(MapRequest(path, tmp_path / "out"), lambda *_: None)


@pytest.mark.parametrize("with_id", [True, False])
def test_map_tiles_are_known_with_and_without_their_id(tmp_path: Path, with_id: bool) -> None:
    path = tmp_path / "a.tif"
    path.write_bytes(tiles(with_id, tmp_path))
    assert kind_of_file(path).name == "MBTiles"


def test_what_we_read_is_known_by_its_bytes() -> None:
    for data, name in (
        (b"II*\0", "TIFF"), (b"MM\0*", "TIFF"), (b"II+\0", "TIFF"), (b"\xff\xd8\xff\xe0", "JPEG"),
        (b"  <VRTDataset a='1'>", "VRT"), (b"<osm version='0.6'>", "OSM"), (b"<kml:kml>", "KML"),
        (" {".encode("utf-16"), "JSON"), (b"  0\r\nSECTION\r\n", "DXF"), (b"\x1e{}", "JSON"),
        (b"\0\0\0\x20ftypisom", "MP4"), (b"RIFF\0\0\0\0AVI ", "AVI"), (b"\x89MCAP0\r\n", "MCAP"),
    ):  # fmt: skip
        assert kind_of(data).name == name, data

"""Kinds of files by their first bytes, whatever their names say: a refusal says it, with the remedy of its kind."""

from __future__ import annotations

import re
import struct
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Final

HEAD_BYTES: Final = 4096
_FTYP: Final = b"ftyp"
_HEIF: Final = (b"heic", b"heix", b"hevc", b"heim", b"heis", b"mif1", b"msf1", b"avif")
_DNG_VERSION: Final = 50706
"""Tag that every DNG has in its first directory (DNG 1.7, chapter 4)."""
_APPLICATION: Final = slice(68, 72)
"""SQLite's application id (sqlite.org/fileformat.html, 1.3)."""
_GPKG: Final = (b"GPKG", b"GP10", b"GP11")


@dataclass(frozen=True, slots=True)
class Kind:
    """``name``: for a program; ``words``: behind "the file", "is a GeoTIFF"; ``remedy``: where nothing reads it."""

    name: str
    words: str
    remedy: str = ""

    def __str__(self) -> str:
        return f"{self.words}: {self.remedy}" if self.remedy else self.words


UNKNOWN: Final = Kind("", "is of no kind that is known")
_EMPTY: Final = Kind("empty", "is empty")
_JPEG: Final = Kind("JPEG", "is a JPEG picture")
_TIFF: Final = Kind("TIFF", "is a TIFF picture")
_ZIP: Final = Kind("zip", "is a ZIP archive", "unpack it, and name what is in it")
_DATABASE: Final = Kind("SQLite", "is an SQLite file, but no GeoPackage", "export the layer as GeoPackage")
_VRT: Final = Kind("VRT", "is a VRT of GDAL")
_GDAL_XML: Final = Kind(
    "service",
    "is XML by which GDAL asks a server",
    "save the picture itself as GeoTIFF",
)
_MP4: Final = Kind("MP4", "is a film")

_BEGINNINGS: Final = (
    (b"\xff\xd8\xff", _JPEG),
    (b"\x89PNG\r\n", Kind("PNG", "is a PNG picture")),
    (b"\x00\x00\x00\x0cjP  \r\n\x87\n", Kind("JPEG 2000", "is a JPEG 2000 picture")),
    (b"\xff\x4f\xff\x51", Kind("JPEG 2000", "is a JPEG 2000 picture")),
    (b"GIF8", Kind("GIF", "is a GIF picture", "save it as JPEG or GeoTIFF")),
    (b"BM", Kind("BMP", "is a BMP picture", "save it as JPEG or GeoTIFF")),
    (b"\x89MCAP0\r\n", Kind("MCAP", "is a recording (MCAP)")),
    (b"\x1aE\xdf\xa3", Kind("Matroska", "is a film")),
    (b"PK\x05\x06", Kind("zip", "is an empty ZIP archive", "pack it again")),
    (b"AC10", Kind("DWG", "is a DWG", "save it as DXF")),
    (b"%PDF", Kind("PDF", "is a PDF", "export the drawing as DXF, or the layer as GeoJSON")),
    (b"\x00\x00\x27\x0a", Kind("shapefile", "is a shapefile", "save the layer as GeoPackage or GeoJSON")),
    (b"\x1f\x8b", Kind("gzip", "is packed by gzip", "unpack it first")),
    (b"BZh", Kind("bzip2", "is packed by bzip2", "unpack it first")),
    (b"\xfd7zXZ\x00", Kind("xz", "is packed by xz", "unpack it first")),
    (b"Rar!", Kind("RAR", "is packed as RAR", "unpack it first")),
    (b"7z\xbc\xaf", Kind("7z", "is packed as 7z", "unpack it first")),
    (b"\x89HDF\r\n\x1a\n", Kind("HDF5", "is an HDF5 file", "export the picture as GeoTIFF")),
    (b"LASF", Kind("LAS", "is a cloud of points (LAS)", "name the orthophoto that was made of it")),
    (b"PMTiles", Kind("PMTiles", "is a set of map tiles (PMTiles)", "export the orthophoto itself as GeoTIFF")),
    (b"ply\n", Kind("PLY", "is a model of points", "name the orthophoto that was made of it")),
    (b"AutoCAD Binary DXF", Kind("DXF", "is a DXF")),
    (b"#EXTM3U", Kind("playlist", "is a list of films on a server", "copy the film itself from the camera's card")),
)  # fmt: skip
"""Beginnings of files -> their kinds."""
_LINE: Final = re.compile(r"\s*\n\s*")


def kind_of(head: bytes) -> Kind:
    """Return what the first bytes of a file say; some thousand are enough (`HEAD_BYTES`)."""
    if not head.strip():
        return _EMPTY
    for begin, kind in _BEGINNINGS:
        if head.startswith(begin):
            return kind
    for look in (_of_tiff, _of_box, _of_database, _of_archive, _of_text):
        found = look(head)
        if found is not None:
            return found
    return UNKNOWN


def kind_of_file(path: Path) -> Kind:
    """Return what a file is by its first bytes. Raises OSError."""
    with path.open("rb") as file:
        kind = kind_of(file.read(HEAD_BYTES))
    if kind is _ZIP:
        return _of_names(path)
    return _tiles(path) if kind is _DATABASE else kind


def _of_tiff(head: bytes) -> Kind | None:
    if head[:4] not in (b"II*\x00", b"MM\x00*", b"II+\x00", b"MM\x00+"):
        return None
    if _DNG_VERSION in _tags(head):
        return Kind("DNG", "is a raw photograph (DNG)", "name the folder of the JPEGs beside it, or make JPEGs of it")
    return _TIFF


def _tags(head: bytes) -> set[int]:
    """Return the tags of a TIFF's first directory, as far as it lies in the first bytes (TIFF 6.0, section 2)."""
    order = "<" if head.startswith(b"II") else ">"
    try:
        (at,) = struct.unpack_from(f"{order}I", head, 4)
        (count,) = struct.unpack_from(f"{order}H", head, at)
        return {struct.unpack_from(f"{order}H", head, at + 2 + 12 * number)[0] for number in range(count)}
    except struct.error:
        return set()


def _of_box(head: bytes) -> Kind | None:
    """Return the kind of a file of ISO's boxes (ISO 14496-12, 4.3): a film, or photographs as HEIC."""
    name = head[4:8]
    if name == _FTYP:
        if head[8:12] in _HEIF:
            return Kind("HEIC", "is a photograph as HEIC", "save it as JPEG with its EXIF: heif-convert FILE photo.jpg")
        return _MP4
    if name in (b"moov", b"mdat", b"wide", b"free", b"skip", b"pnot"):
        return _MP4
    return Kind("AVI", "is a film") if head[:4] == b"RIFF" and head[8:12] == b"AVI " else None


def _of_database(head: bytes) -> Kind | None:
    if not head.startswith(b"SQLite format 3\0"):
        return None
    if head[_APPLICATION] in _GPKG or b"gpkg_contents" in head:
        return Kind("GeoPackage", "is a GeoPackage")
    if head[_APPLICATION] == b"MPBX":
        return _MBTILES
    return _DATABASE


_MBTILES: Final = Kind(
    "MBTiles", "is a set of map tiles (MBTiles)", "export the orthophoto itself as GeoTIFF: gdal_translate FILE out.tif"
)


def _tiles(path: Path) -> Kind:
    """Distinguish MBTiles without their id from other SQLite files by the names of their tables."""
    with path.open("rb") as file:
        return _MBTILES if b"tile_column" in file.read(1 << 16) else _DATABASE


def _of_archive(head: bytes) -> Kind | None:
    return _ZIP if head.startswith(b"PK\x03\x04") else None


def _of_names(path: Path) -> Kind:
    """Return what an archive holds."""
    try:
        with zipfile.ZipFile(path) as archive:
            names = [name.lower() for name in archive.namelist()]
    except (zipfile.BadZipFile, OSError, ValueError, NotImplementedError, RuntimeError):
        return Kind("zip", "is a ZIP archive that is cut or damaged", "copy it again, and unpack it")
    if any("odm_orthophoto" in name or "odm_report" in name for name in names):
        return Kind("zip", "is all that WebODM made, as an archive", "unpack it, and name the folder that holds it")
    if any(name.endswith((".jpg", ".jpeg")) for name in names):
        return Kind("zip", "is an archive of photographs", "unpack it, and name the folder")
    return _ZIP


def _of_text(head: bytes) -> Kind | None:
    encoding = "utf-16" if head.startswith((b"\xff\xfe", b"\xfe\xff")) else "utf-8-sig"
    try:
        text = head.decode(encoding, "ignore" if len(head) >= HEAD_BYTES else "strict").lstrip("\ufeff\x1e").strip()
    except UnicodeDecodeError:
        text = head.decode(encoding, "ignore").strip() if encoding == "utf-8-sig" else ""
    for matches, kind in _TEXTS:
        if matches(text):
            return kind
    return None


def _begins(*names: str) -> Callable[[str], bool]:
    """Match XML whose first element, behind declaration and comments, has one of these names."""
    found = re.compile(rf"(?:<\?[^>]*\?>\s*|<!--.*?-->\s*|<!DOCTYPE[^>]*>\s*)*<(?:\w+:)?(?:{'|'.join(names)})\b", re.S)
    return lambda text: found.match(text) is not None


_TEXTS: Final[tuple[tuple[Callable[[str], bool], Kind], ...]] = (
    (_begins("VRTDataset"), _VRT),
    (_begins("GDAL_WMS", "GDAL_WMTS", "GDAL_WCS", "WCS_GDAL", "WMS_Tile_Service", "WMT_MS_Capabilities", "Capabilities",
             "MRF_META", "GDALTileIndexDataset", "OGRWFSDataSource", "WMS_Capabilities"), _GDAL_XML),
    (_begins("kml"), Kind("KML", "is a KML")),
    (_begins("osm"), Kind("OSM", "is OpenStreetMap's XML")),
    (_begins("gpx"), Kind("GPX", "is a GPX", "draw areas, and save them as GeoJSON")),
    (_begins("html", "HTML"), Kind("HTML", "is a page of the web", "download the file itself")),
    (lambda text: text.startswith("<"), Kind("XML", "is XML of another kind", "save it as GeoJSON")),
    (lambda text: text.startswith(("{", "[")), Kind("JSON", "is JSON")),
    (lambda text: _LINE.sub("\n", text).startswith(("0\nSECTION", "999\n")), Kind("DXF", "is a DXF")),
    (lambda text: re.match(r"\d+\s*\n\s*\d\d:\d\d:\d\d", text) is not None,
     Kind("captions", "is a film's captions (SRT)", "name the film, with its captions beside it under its name")),
)  # fmt: skip
"""Beginnings of texts -> their kinds, the first one that fits."""

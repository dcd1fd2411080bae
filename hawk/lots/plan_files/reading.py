"""Reads a file with a plan, of whichever kind: by its first bytes, never by its name."""

from __future__ import annotations

import io
import zipfile
from typing import Final

from hawk.lots.plan_files.shapes import plan_of
from hawk.lots.plan_files.values import LARGEST_BYTES, LARGEST_UNPACKED_BYTES, Asked, Drawing, Notes, PlanFile
from hawk.lots.values import LotInputError

_ENDS: Final = (".geojson", ".json", ".gpkg", ".dxf", ".osm", ".xml")
"""Ends of the names within an archive that may be a plan."""
_OTHERS: Final = (
    (b"AC10", "is a DWG: save it as DXF"),
    (b"%PDF", "is a PDF: export the drawing as DXF, or the layer as GeoJSON"),
    (b"\x00\x00\x27\x0a", "is a shapefile: save the layer as GeoPackage or GeoJSON"),
    (b"\x1f\x8b", "is packed by gzip: unpack it first"),
    (b"Rar!", "is packed as RAR: unpack it first"),
    (b"7z\xbc\xaf", "is packed as 7z: unpack it first"),
    (b"\x89PNG", "is a picture: export the drawing as DXF, or the layer as GeoJSON"),
    (b"\xff\xd8\xff", "is a picture: export the drawing as DXF, or the layer as GeoJSON"),
)
"""Beginnings of files that people have instead -> words behind "the file"."""
_KNOWN: Final = "GeoJSON, GeoPackage, DXF and OpenStreetMap's XML are read"


def read_plan(data: bytes, asked: Asked) -> PlanFile:
    """Return the stalls of a file. Loads the packages that its kind needs. Raises LotInputError."""
    notes = Notes()
    check_size(len(data))
    return plan_of(_drawing(_unpacked(data), asked, notes), asked, notes)


def check_size(count: int) -> None:
    """Refuse a file that is too large. Raises LotInputError."""
    if count > LARGEST_BYTES:
        most = LARGEST_BYTES // 1_000_000
        raise LotInputError("file", f"is too large: {most} MB are read at most; leave other layers out")


def _drawing(data: bytes, asked: Asked, notes: Notes) -> Drawing:
    for begin, words in _OTHERS:
        if data.startswith(begin):
            raise LotInputError("file", words)
    if data.startswith(b"SQLite format 3\0"):
        from hawk.lots.plan_files import geopackage

        return geopackage.read(data, asked, notes)
    head = _head(data)
    if head.startswith(("{", "[")):
        from hawk.lots.plan_files import geojson

        return geojson.read(data, asked, notes)
    if head.startswith("<"):
        from hawk.lots.plan_files import osm

        return osm.read(data, asked, notes)
    if head.startswith(("0\nSECTION", "999\n", "AutoCAD Binary DXF")):
        from hawk.lots.plan_files import dxf

        return dxf.read(data, asked, notes)
    raise LotInputError("file", f"is empty: {_KNOWN}" if not data.strip() else f"is of no kind that is known: {_KNOWN}")


def _head(data: bytes) -> str:
    """Return how the text of a file begins, each line without spaces about it."""
    encoding = "utf-16" if data.startswith((b"\xff\xfe", b"\xfe\xff")) else "utf-8-sig"
    text = data[:400].decode(encoding, "ignore")
    return "\n".join(line.strip() for line in text.strip().splitlines())


def _unpacked(data: bytes) -> bytes:
    """Return the one plan in an archive; other data as it is. Raises LotInputError."""
    if not data.startswith(b"PK\x03\x04"):
        return data
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            plans = [each for each in archive.infolist() if each.filename.lower().endswith(_ENDS)]
            if len(plans) != 1:
                words = "no plan" if not plans else f"{len(plans)} plans"
                raise LotInputError("file", f"is an archive with {words} in it: send the one file. {_KNOWN}")
            if plans[0].file_size > LARGEST_UNPACKED_BYTES:
                raise LotInputError("file", _BOMB)
            with archive.open(plans[0]) as file:
                content = file.read(LARGEST_UNPACKED_BYTES + 1)
    except (zipfile.BadZipFile, OSError, RuntimeError, NotImplementedError, EOFError, ValueError) as error:
        raise LotInputError("file", f"cannot be unpacked ({error}): send the file itself") from None
    if len(content) > LARGEST_UNPACKED_BYTES:  # the archive's list of sizes lies
        raise LotInputError("file", _BOMB)
    return content


_BOMB: Final = (
    f"is too large unpacked: {LARGEST_UNPACKED_BYTES // 1_000_000} MB are read at most; leave other layers out"
)

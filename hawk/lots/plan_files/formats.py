"""Reads a file with a plan, of whichever kind: by its first bytes, never by its name."""

from __future__ import annotations

import io
import zipfile
import zlib
from typing import TYPE_CHECKING, Final

from hawk.formats.kind import HEAD_BYTES, kind_of
from hawk.lots.plan_files.shapes import plan_of
from hawk.lots.plan_files.values import LARGEST_BYTES, LARGEST_UNPACKED_BYTES, Asked, Drawing, Notes, PlanFile
from hawk.lots.values import LotInputError
from hawk.runtime.late import late

if TYPE_CHECKING:  # each format has its own library
    from hawk.lots.plan_files import dxf, geojson, layers, osm
else:
    dxf = late("hawk.lots.plan_files.dxf")
    geojson = late("hawk.lots.plan_files.geojson")
    layers = late("hawk.lots.plan_files.layers")
    osm = late("hawk.lots.plan_files.osm")

ENDS: Final = (".geojson", ".geojsonl", ".geojsons", ".ndjson", ".json", ".gpkg", ".dxf", ".osm", ".xml", ".kml")
"""Ends of the names within an archive that may be a plan."""
_PICTURE: Final = "export the drawing as DXF, or the layer as GeoJSON"
_PICTURES: Final = dict.fromkeys(("JPEG", "PNG", "TIFF", "JPEG 2000", "VRT", "MP4"), _PICTURE)
_KNOWN: Final = "GeoJSON, GeoPackage, KML, DXF and OpenStreetMap's XML are read"


def read_plan(data: bytes, asked: Asked, log: bytes = b"") -> PlanFile:
    """Return the stalls of a file. Loads the packages that its kind needs. Raises LotInputError.

    ``log``: as of `hawk.lots.plan_files.layers.read`.
    """
    notes = Notes()
    check_size(len(data))
    return plan_of(_drawing(unpacked(data, ENDS), asked, notes, log), asked, notes)


def check_size(count: int) -> None:
    """Refuse a file that is too large. Raises LotInputError."""
    if count > LARGEST_BYTES:
        most = LARGEST_BYTES // 1_000_000
        raise LotInputError("file", f"is too large: {most} MB are read at most; leave other layers out")


def _drawing(data: bytes, asked: Asked, notes: Notes, log: bytes) -> Drawing:
    kind = kind_of(data[:HEAD_BYTES])
    match kind.name:
        case "GeoPackage" | "KML":
            return layers.read(data, asked, notes, log)
        case "JSON":
            return geojson.read(data, asked, notes)
        case "OSM" | "XML":
            return osm.read(data, asked, notes)
        case "DXF":
            return dxf.read(data, asked, notes)
    remedy = kind.remedy or _PICTURES.get(kind.name, _KNOWN)
    raise LotInputError("file", f"{kind.words}: {remedy}")


def unpacked(data: bytes, ends: tuple[str, ...]) -> bytes:
    """Return the one file in an archive whose name ends so; other data as it is. Raises LotInputError."""
    if not data.startswith(b"PK\x03\x04"):
        return data
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            plans = [each for each in archive.infolist() if each.filename.lower().endswith(ends)]
            if len(plans) != 1:
                words = "no plan" if not plans else f"{len(plans)} plans"
                raise LotInputError("file", f"is an archive with {words} in it: send the one file. {_KNOWN}")
            if plans[0].file_size > LARGEST_UNPACKED_BYTES:
                raise LotInputError("file", _BOMB)
            with archive.open(plans[0]) as file:
                content = file.read(LARGEST_UNPACKED_BYTES + 1)
    except (zipfile.BadZipFile, OSError, RuntimeError, NotImplementedError, EOFError, ValueError, zlib.error) as error:
        raise LotInputError("file", f"cannot be unpacked ({error}): send the file itself") from None
    if len(content) > LARGEST_UNPACKED_BYTES:  # the archive's list of sizes lies
        raise LotInputError("file", _BOMB)
    return content


_BOMB: Final = (
    f"is too large unpacked: {LARGEST_UNPACKED_BYTES // 1_000_000} MB are read at most; leave other layers out"
)

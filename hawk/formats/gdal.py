"""GDAL for strangers' pictures: few drivers, no network, and no VRT that reads what is no picture.

rasterio's wheel brings some 150 drivers, of which several ask servers. Here a picture is opened by the one driver of
its first bytes, a VRT is read by us before GDAL does, and GDAL's own doors to the network are closed.
"""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final
from xml.etree.ElementTree import Element, ParseError

from defusedxml import DefusedXmlException
from defusedxml.ElementTree import fromstring

from hawk.formats.kind import kind_of_file
from hawk.formats.remote_raster import Door, Hosts, RemoteError, RemoteRaster, check_part, without_secrets
from hawk.runtime.late import load

DRIVERS: Final = {
    "TIFF": "GTiff",
    "VRT": "VRT",
    "JPEG": "JPEG",
    "PNG": "PNG",
    "JPEG 2000": "JP2OpenJPEG",
}
"""Kinds of `hawk.formats.kind` -> the driver of GDAL that opens them; no other one is let."""
OPTIONS: Final = {
    "GDAL_CONFIG_FILE": os.devnull,
    "GDAL_HTTP_PROXY": "http://127.0.0.1:9",
    "GDAL_HTTPS_PROXY": "http://127.0.0.1:9",
    "GDAL_HTTP_MAX_RETRY": "0",
    "GDAL_VRT_ENABLE_PYTHON": "NO",
    "GDAL_VRT_ENABLE_RAWRASTERBAND": "NO",
    "GDAL_VRT_RAWRASTERBAND_ALLOWED_SOURCE": "SIBLING_OR_CHILD_OF_VRT_PATH",
    "GDAL_NUM_THREADS": "1",
}
"""GDAL's settings (https://gdal.org/en/stable/user/configoptions.html): every file beyond this computer is refused."""
_SKIP: Final = (
    "AmigoCloud Carto CSW DAAS EEDA EEDAI Elasticsearch ESRIC GDALG GTI HTTP KMLSUPEROVERLAY MRF NGW OAPIF OGCAPI "
    "PDF PLMOSAIC PLScenes STACIT STACTA WCS WFS WMS WMTS Zarr"
)
"""Drivers that ask servers, or that read files which name others; GDAL reads their names as it begins."""
_UNUSED: Final = (
    *("NO_PROXY", "no_proxy"),
    *(
        f"GDAL_HTTP_{name}"
        for name in ("AUTH", "BEARER", "COOKIE", "HEADERS", "HEADER_FILE", "PROXYUSERPWD", "USERPWD")
    ),
)
"""Variables of the environment by which curl would go past the proxy, or send one server's keys to all."""
_SOURCES: Final = ("SourceFilename", "SourceDataset", "GCPProjectionFile", "OverviewFile")
"""Elements of a VRT that name a file, each in place of which a whole VRT may stand."""
_REFUSED: Final = {
    "VRTRawRasterBand": "reads bytes of any file as pixels",
    "VRTDerivedRasterBand": "computes its pixels by a program",
    "VRTProcessedDataset": "computes its pixels by a program",
    "GDALTileIndexDataset": "asks for other files",
}
_COMPUTED: Final = ("PixelFunctionType", "PixelFunctionCode", "ProcessingSteps", "AlgorithmOptions")
_DEEPEST: Final = 8
_MOST_BYTES: Final = 64_000_000
"""Of a VRT: a city's of 30,000 tiles has 40 MB."""


class UnsafeError(ValueError):
    """A picture is not opened; the text says why behind the name of the file, with the remedy."""


def prepare() -> None:
    """Close GDAL's doors in this process, before rasterio or pyogrio are loaded for the first time."""
    os.environ.setdefault("GDAL_SKIP", _SKIP.replace(" ", ","))
    os.environ.setdefault("PROJ_NETWORK", "OFF")
    for name in _UNUSED:
        os.environ.pop(name, None)
    os.environ.setdefault("CPL_VSIL_CURL_ALLOWED_EXTENSIONS", f".{secrets.token_hex(16)}")  # no name ends so
    for name, value in OPTIONS.items():
        os.environ.setdefault(name, value)


def driver_of(path: Path) -> str:
    """Return the driver that opens a picture. Raises UnsafeError for a file of another kind, OSError."""
    kind = kind_of_file(path)
    driver = DRIVERS.get(kind.name)
    if driver is None:
        remedy = "" if kind.remedy else ": export it as GeoTIFF"
        raise UnsafeError(f"{kind}{remedy}")
    return driver


def check_vrt(path: Path, hosts: Hosts = ()) -> None:
    """Refuse a VRT that would read what is no picture on this computer or an allowed host, at any depth.

    Raises UnsafeError, OSError.
    """
    seen: set[Path] = set()
    waiting = [(path, 0)]
    while waiting:
        each, depth = waiting.pop()
        if each in seen:
            continue
        seen.add(each)
        if depth > _DEEPEST:
            raise UnsafeError(f"has VRTs within VRTs, more than {_DEEPEST} deep: build one of the pictures themselves")
        waiting += [(source, depth + 1) for source in _checked_sources(each, hosts)]


def sources_of(path: Path) -> list[tuple[str, Path | None]]:
    """Return the names that a VRT's elements have, with the files that they mean; None for what is no local file.

    Empty for a file that is no VRT, or none that can be read. Raises OSError.
    """
    tree = _tree(path)
    return [] if tree is None else list(_sources(tree, path))


def _tree(path: Path) -> Element | None:
    if kind_of_file(path).name != "VRT" or path.stat().st_size > _MOST_BYTES:
        return None
    try:
        found: Element = fromstring(path.read_bytes(), forbid_dtd=True)
    except (ParseError, DefusedXmlException, ValueError, RecursionError):
        return None
    return found


def _sources(tree: Element, path: Path) -> Iterator[tuple[str, Path | None]]:
    folder = path.resolve().parent  # GDAL takes that of the file itself, not of a link to it
    for source in tree.iter():
        if source.tag not in _SOURCES:
            continue
        name = (source.text or "").strip()
        is_beside = next((value for key, value in source.items() if key.lower() == "relativetovrt"), "0") == "1"
        is_file = bool(name) and not name.startswith(("/vsi", "<")) and "://" not in name
        if name:
            yield name, ((folder / name) if is_beside else Path(name)) if is_file else None


def _checked_sources(path: Path, hosts: Hosts) -> Iterator[Path]:
    """Yield the VRTs that a VRT is made of, after a check of all that it names."""
    tree = _tree(path)
    if tree is None:
        raise UnsafeError("is no whole VRT: build it again: gdalbuildvrt city.vrt FOLDER/*.tif")
    for element in tree.iter():
        kind = element.get("subClass", "")
        said = _REFUSED.get(kind) or (_REFUSED["VRTDerivedRasterBand"] if element.tag in _COMPUTED else "")
        if said:
            raise UnsafeError(f"{said} ({kind or element.tag}), which is not read: gdal_translate it to a GeoTIFF")
    for name, source in dict.fromkeys(_sources(tree, path)):
        if source is None:
            _check_remote(name, hosts)
            continue
        if not source.is_file():
            continue  # its opener says which are missing
        try:
            driver = driver_of(source)
        except UnsafeError as error:
            raise UnsafeError(f"names {source.name}, which {error}") from None
        if driver == "VRT":
            yield source


def _check_remote(name: str, hosts: Hosts) -> None:
    """Raise UnsafeError for a name in a VRT that is of no allowed host."""
    said = without_secrets(name)[:80]
    try:
        part = check_part(name, hosts) if hosts else None
    except RemoteError as error:
        raise UnsafeError(f"names {said}: {error}") from None
    if part is None:
        raise UnsafeError(f"names {said}, no file of this computer: copy it here, build the VRT again")


def rasterio() -> Any:
    """Return rasterio with all parts of it that are used here, GDAL prepared. Raises ImportError without it."""
    prepare()
    return load("rasterio", "_err", "enums", "errors", "transform", "vrt", "warp", "windows")


def remote_options(path: Path | RemoteRaster, opened: Door) -> dict[str, str]:
    """Return GDAL's settings to read a picture through an open door, with this computer's own ones for the rest."""
    return OPTIONS | opened.options(path if isinstance(path, RemoteRaster) else None)


def open_picture(path: Path | RemoteRaster, *, is_checked: bool = False, hosts: Hosts = ()) -> Any:
    """Open a picture by rasterio, by its own driver; one of a server within `remote_options`.

    Args:
        path: The picture.
        is_checked: `check_vrt` has passed it: that of a city takes a second.
        hosts: Those that a VRT may name.

    Raises UnsafeError, OSError, ImportError, and rasterio's errors.
    """
    opened = rasterio().open
    if isinstance(path, RemoteRaster):
        return opened(path.gdal_name, driver="JP2OpenJPEG" if path.name.endswith(".jp2") else "GTiff")
    driver = driver_of(path)
    if driver == "VRT" and not is_checked:
        check_vrt(path, hosts)
    return opened(path, driver=driver)

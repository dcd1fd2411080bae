"""Files of which a VRT of GDAL is made."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Final
from xml.etree.ElementTree import ParseError

from defusedxml import DefusedXmlException
from defusedxml.ElementTree import fromstring

_SOURCES: Final = ("SourceFilename", "SourceDataset")
"""Elements that name a file: of a mosaic, and of what gdalwarp writes, where a whole VRT may stand in place of one."""


def parts_of(path: Path) -> list[Path]:
    """Return the files that a VRT names, sorted, with those of the VRTs among them; none for a file of another kind.

    What lies in an archive or on another computer is left out.
    """
    found: set[Path] = set()
    waiting = [path]
    while waiting:
        named = _named_by(waiting.pop()) - found
        found |= named
        waiting += named
    return sorted(found)


def missing_parts(parts: Iterable[Path]) -> list[str]:
    """Return those of `parts_of` that are not there, in their order."""
    return [str(part) for part in parts if not part.exists()]


def _named_by(path: Path) -> set[Path]:
    if path.suffix.lower() != ".vrt":
        return set()
    try:
        tree = fromstring(path.read_bytes())
    except (OSError, ParseError, DefusedXmlException):
        return set()
    parts = set()
    folder = path.resolve().parent  # GDAL takes that of the file itself, not of a link to it
    for source in (each for kind in _SOURCES for each in tree.iter(kind)):
        name = (source.text or "").strip()
        is_beside = source.get("relativeToVRT") == "1"
        if name and not name.startswith(("/vsi", "<")) and "://" not in name:
            parts.add(folder / name if is_beside else Path(name))
    return parts

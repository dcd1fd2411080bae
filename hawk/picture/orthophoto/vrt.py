"""Files of which a VRT of GDAL is made."""

from __future__ import annotations

from pathlib import Path
from xml.etree.ElementTree import ParseError

from defusedxml import DefusedXmlException
from defusedxml.ElementTree import fromstring


def missing_parts(path: Path) -> list[str]:
    """Return the files that a VRT names and that are not there, sorted; none for a file of another kind."""
    if path.suffix.lower() != ".vrt":
        return []
    try:
        tree = fromstring(path.read_bytes())
    except (OSError, ParseError, DefusedXmlException):
        return []
    parts = set()
    for source in tree.iter("SourceFilename"):
        name = (source.text or "").strip()
        is_beside = source.get("relativeToVRT") == "1"
        if name and not name.startswith("/vsi") and "://" not in name:
            parts.add(path.parent / name if is_beside else Path(name))
    return sorted(str(part) for part in parts if not part.exists())

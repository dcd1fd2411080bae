"""Files of which a VRT of GDAL is made."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from hawk.formats.gdal import sources_of


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
    try:
        return {source for _, source in sources_of(path) if source is not None}
    except OSError:
        return set()

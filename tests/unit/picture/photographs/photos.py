"""Photographs of drones, written as their makers write them."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

NAMESPACES = {
    "drone-dji": "http://www.dji.com/drone-dji/1.0/",
    "drone": "http://www.autelrobotics.com/drone/1.0/",
    "Camera": "http://pix4d.com/camera/1.0/",
    "drone-parrot": "http://www.parrot.com/drone-parrot/1.0/",
    "drone-skydio": "https://www.skydio.com/drone-skydio/1.0/",
}
DJI = {
    "drone-dji:RelativeAltitude": "+60.00",
    "drone-dji:AbsoluteAltitude": "+160.00",
    "drone-dji:GimbalRollDegree": "+0.00",
    "drone-dji:GimbalPitchDegree": "-90.00",
    "drone-dji:GimbalYawDegree": "+30.00",
}
SIZE = (80, 60)


def exif(
    place: tuple[float, float] | None = (46.84, -91.99),
    altitude: float = 160.0,
    model: str = "FC330",
    make: str = "DJI",
    taken: str = "2024:05:01 10:00:00",
    base: dict[int, Any] | None = None,
    photo: dict[int, Any] | None = None,
    gps: dict[int, Any] | None = None,
) -> Image.Exif:
    """Return EXIF; None in ``base``, ``photo`` or ``gps`` takes a tag away."""
    found = Image.Exif()
    found[271], found[272] = make, model
    inner = {0x9003: taken, 0x920A: 8.8}
    where: dict[int, Any] = {}
    if place is not None:
        for reference, value, signs in ((1, place[0], "NS"), (3, place[1], "EW")):
            where[reference] = signs[value < 0]
            where[reference + 1] = _degrees(abs(value))
        where[5], where[6] = bytes([altitude < 0]), abs(altitude)
    for directory, changes in ((found, base), (inner, photo), (where, gps)):
        for tag, value in (changes or {}).items():
            if value is None:
                del directory[tag]
            else:
                directory[tag] = value
    found._ifds[0x8769], found._ifds[0x8825] = inner, where
    return found


def _degrees(value: float) -> tuple[float, float, float]:
    minutes = (value - int(value)) * 60
    return float(int(value)), float(int(minutes)), round((minutes - int(minutes)) * 60, 6)


def xmp(tags: dict[str, str], inner: str = "") -> bytes:
    """Return a packet with these tags as attributes, and ``inner`` as elements of the description."""
    spaces = " ".join(f'xmlns:{prefix}="{space}"' for prefix, space in NAMESPACES.items())
    attributes = " ".join(f'{name}="{value}"' for name, value in tags.items())
    return (
        '<?xpacket begin="\ufeff" id="W5M0MpCehiHzreSzNTczkc9d"?>\n<x:xmpmeta xmlns:x="adobe:ns:meta/">'
        '<rdf:RDF xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#">'
        f'<rdf:Description rdf:about="" {spaces} {attributes}>{inner}</rdf:Description>'
        '</rdf:RDF></x:xmpmeta>   <?xpacket end="w"?>'
    ).encode()


def photo(path: Path, found: Image.Exif | None, packet: bytes = b"", size: tuple[int, int] = SIZE) -> Path:
    """Write a JPEG with these tags."""
    pixels = np.random.default_rng(1).integers(0, 255, (size[1], size[0], 3), np.uint8)
    options: dict[str, Any] = {} if found is None else {"exif": found}
    Image.fromarray(pixels).save(path, "JPEG", quality=90, **options, **({"xmp": packet} if packet else {}))
    return path


def flight(folder: Path, count: int = 4, first: int = 0, minute: int = 0, **changes: Any) -> list[Path]:
    """Write photographs of a DJI, seven seconds and some ten metres one after the other."""
    packet = xmp(DJI | changes.pop("tags", {}))
    start = datetime(2024, 5, 1, 10, tzinfo=UTC) + timedelta(minutes=minute)
    size = changes.pop("size", SIZE)
    north = changes.pop("north", 0.0)
    return [
        photo(
            folder / f"DJI_{first + k:04d}.JPG",
            exif(
                (46.84 + 1e-4 * k + north, -91.99),
                taken=f"{start + timedelta(seconds=7 * k):%Y:%m:%d %H:%M:%S}",
                **changes,
            ),
            packet,
            size,
        )
        for k in range(count)
    ]

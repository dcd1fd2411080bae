"""EXIF of a photograph: place, time, camera and focal length (EXIF 2.32), read by Pillow."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Any, Final

from hawk.picture.values import PictureError
from hawk.runtime.late import load
from hawk.runtime.programs import remedy

_MAKE, _MODEL, _ORIENTATION, _SOFTWARE, _CHANGED = 271, 272, 274, 305, 306
_EXIF_IFD, _GPS_IFD = 0x8769, 0x8825
_TAKEN, _OFFSET, _SUBSECONDS = 0x9003, 0x9011, 0x9291
_SERIAL: Final = 0xA431
_FOCAL, _FOCAL_35, _ZOOM = 0x920A, 0xA405, 0xA404
_PLANE_RESOLUTION, _PLANE_UNIT, _PIXELS = 0xA20E, 0xA210, (0xA002, 0xA003)
_MM_PER_UNIT: Final = {2: 25.4, 3: 10.0, 4: 1.0, 5: 0.001}
"""By EXIF's FocalPlaneResolutionUnit; 4 and 5 are no standard, but cameras write them."""
_SENSOR_MM: Final = (2.0, 70.0)
"""Widths of sensors between which EXIF is believed."""
_HEMISPHERES: Final = ((1, ("N", "S")), (3, ("E", "W")))
"""Tags of the references of latitude and longitude, with what they may say."""
_SAVING_S: Final = 60.0
"""Between a photograph and the moment its file was changed: the camera itself takes less."""


@dataclass(frozen=True, slots=True)
class Exif:
    """Facts of a photograph's EXIF; None or "" where it does not say.

    ``latitude``, ``longitude``: degrees; ``altitude``: metres above sea or ellipsoid; ``error_m``: GNSS's horizontal
    one. ``clock``: by the camera's clock, ``gnss``: by GNSS, Unix seconds; a clock without an offset counts as UTC.
    ``zone_h``: that offset, hours. ``has_hemisphere``: the letters of the place are there. ``focal_mm``, and
    ``focal_35_mm`` on 35 mm film; ``zoom``: digital, 1.0 without. ``sensor_mm``: longer side of the sensor by the
    resolution of the focal plane. ``orientation``: 1 to 8. ``saved_by``: program that saved the file later than the
    camera did. ``serial``: number of the camera's body.
    """

    make: str = ""
    model: str = ""
    orientation: int = 1
    latitude: float | None = None
    longitude: float | None = None
    altitude: float | None = None
    error_m: float | None = None
    clock: float | None = None
    gnss: float | None = None
    focal_mm: float | None = None
    focal_35_mm: float | None = None
    zoom: float = 1.0
    sensor_mm: float | None = None
    saved_by: str = ""
    zone_h: float | None = None
    has_hemisphere: bool = True
    serial: str = ""


def read_exif(data: bytes, longer: int) -> Exif:
    """Return the facts of EXIF's bytes for a picture whose longer side has ``longer`` pixels.

    Raises ValueError when the bytes are no EXIF, PictureError without Pillow.
    """
    if not data:
        return Exif()
    base, photo, gps = _directories(data)
    return Exif(
        make=_text(base.get(_MAKE)),
        model=_text(base.get(_MODEL)),
        orientation=int(_number(base.get(_ORIENTATION)) or 1),
        latitude=_angle(gps, 1, 90.0),
        longitude=_angle(gps, 3, 180.0),
        altitude=_altitude(gps),
        error_m=_positive(gps.get(31)),
        clock=_clock(photo),
        saved_by=_saved_by(base, photo),
        gnss=_gnss(gps),
        focal_mm=_positive(photo.get(_FOCAL)),
        focal_35_mm=_positive(photo.get(_FOCAL_35)),
        zoom=max(1.0, _number(photo.get(_ZOOM)) or 1.0),
        sensor_mm=_plane_mm(photo, longer),
        zone_h=None if (zone := _zone(photo)) is None else zone.total_seconds() / 3600.0,
        has_hemisphere=all(_text(gps.get(tag)).upper()[:1] in letters for tag, letters in _HEMISPHERES),
        serial=_text(photo.get(_SERIAL)),
    )


def _directories(data: bytes) -> tuple[Mapping[int, Any], Mapping[int, Any], Mapping[int, Any]]:
    try:
        pil = load("PIL", "Image")  # only desks that map pictures have it
    except ImportError as error:
        raise PictureError(f"Pillow is not installed, which reads EXIF: {remedy('pictures')}") from error
    try:
        exif = pil.Image.Exif()
        exif.load(b"Exif\x00\x00" + data)
        return dict(exif), dict(exif.get_ifd(_EXIF_IFD)), dict(exif.get_ifd(_GPS_IFD))
    except Exception as error:  # Pillow raises SyntaxError, struct.error, KeyError and others for torn bytes
        raise ValueError(f"its EXIF cannot be read ({error})") from error


def _text(value: object) -> str:
    text = value.decode("ascii", "replace") if isinstance(value, bytes) else str(value or "")
    return text.split("\x00", 1)[0].strip()


def _number(value: Any) -> float | None:
    """Return a finite number, None for anything else: a rational may be 0/0."""
    try:
        found = float(value)
    except (TypeError, ValueError, ZeroDivisionError):
        return None
    return found if math.isfinite(found) else None


def _positive(value: Any) -> float | None:
    found = _number(value)
    return found if found is not None and found > 0 else None


def _angle(gps: Mapping[int, Any], reference: int, largest: float) -> float | None:
    """Return latitude or longitude: tag ``reference`` is the hemisphere, the next one degrees, minutes, seconds."""
    if _text(gps.get(9)).upper() == "V":  # GPSStatus: no fix, the numbers are of no use
        return None
    parts = gps.get(reference + 1)
    if not isinstance(parts, tuple) or not 1 <= len(parts) <= 3:
        return None
    values = [_number(part) for part in parts]
    angle = sum(value / 60.0**k for k, value in enumerate(values) if value is not None)
    if None in values or not abs(angle) <= largest:
        return None
    return -angle if _text(gps.get(reference)).upper()[:1] in ("S", "W") else angle


def _altitude(gps: Mapping[int, Any]) -> float | None:
    value = _number(gps.get(6))
    is_below = gps.get(5) in (1, b"\x01")
    return None if value is None else (-value if is_below else value)


def _moment(value: object) -> datetime | None:
    try:
        return datetime.strptime(f"{_text(value)} +0000", "%Y:%m:%d %H:%M:%S %z")
    except ValueError:
        return None


def _saved_by(base: Mapping[int, Any], photo: Mapping[int, Any]) -> str:
    changed, taken = _moment(base.get(_CHANGED)), _moment(photo.get(_TAKEN))
    if changed is None or taken is None or abs((changed - taken).total_seconds()) <= _SAVING_S:
        return ""
    return _text(base.get(_SOFTWARE)) or "another program"


def _clock(photo: Mapping[int, Any]) -> float | None:
    moment = _moment(photo.get(_TAKEN))
    if moment is None:
        return None
    moment -= _zone(photo) or timedelta()
    digits = _text(photo.get(_SUBSECONDS))
    return moment.timestamp() + (float(f"0.{digits}") if digits.isascii() and digits.isdigit() else 0.0)


def _zone(photo: Mapping[int, Any]) -> timedelta | None:
    """Return the clock's offset from UTC; None without one, or where it cannot be read."""
    with contextlib.suppress(ValueError):
        return datetime.strptime(_text(photo.get(_OFFSET)), "%z").utcoffset()
    return None


def _gnss(gps: Mapping[int, Any]) -> float | None:
    parts = gps.get(7)
    values = [_number(part) for part in parts] if isinstance(parts, tuple) and len(parts) == 3 else [None]
    if None in values:
        return None
    hours, minutes, seconds = (value or 0.0 for value in values)
    try:
        day = datetime.strptime(_text(gps.get(29)), "%Y:%m:%d").replace(tzinfo=UTC)
    except ValueError:
        return None
    return day.timestamp() + hours * 3600 + minutes * 60 + seconds


def _plane_mm(photo: Mapping[int, Any], longer: int) -> float | None:
    """Return the sensor's longer side by the focal plane's resolution, for the pixels that the camera wrote."""
    resolution, unit = _positive(photo.get(_PLANE_RESOLUTION)), _MM_PER_UNIT.get(photo.get(_PLANE_UNIT, 2))
    if resolution is None or unit is None:
        return None
    written = max(_positive(photo.get(tag)) or 0.0 for tag in _PIXELS)
    sensor = (written or longer) / resolution * unit
    return sensor if _SENSOR_MM[0] <= sensor <= _SENSOR_MM[1] else None

"""Place, height and attitude in the XMP tags of each maker.

Two conventions of angles exist. *Forward*: at zero the camera looks ahead to the horizon, and -90 degrees of pitch is
straight down; a rotation Rz(yaw) Ry(pitch) Rx(roll) in NED. *Down*: at zero it looks straight down with the picture's
top to the north, +90 degrees of pitch is ahead.

- DJI, forward: its guides give NED and the order ZYX (Mavic 3M Image Processing Guide 1.0, part I); gimbal angles are
  those of the camera, not relative to the drone. Past straight down some write a roll of 180 degrees and a yaw that is
  turned with it (orthority's issue 36): the rotation covers that.
- Autel, forward, under ``drone:`` with DJI's names; older firmware writes Pix4D's tags, pitch 0 straight down
  (OpenAthena, `parseImage.py`).
- Parrot, forward, in NED (developer.parrot.com/docs/pdraw/photo-metadata.html), beside Pix4D's tags.
- Skydio, forward, `CameraOrientationNED`; its `CameraOrientationFLU` has no north and is not read
  (support.skydio.com, article 4417425974683).
- Pix4D's ``Camera:``, down (support.pix4d.com, articles 202558969 and 360016450032). Cameras of the make senseFly give
  roll with the other sign (OpenDroneMap, `opendm/photo.py`); Parrot's Sequoia on a senseFly does not.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final

from hawk.model.pictures import angles, rotation
from hawk.picture.photographs.xmp import number

Tags = Mapping[str, str]
Attitude = tuple[float, float, float]

_SKYDIO: Final = "drone-skydio:"
_FORWARD: Final = (
    "drone-dji:Gimbal{}Degree",
    "drone:Gimbal{}Degree",
    "drone-parrot:Camera{}Degree",
    f"{_SKYDIO}CameraOrientationNED/{_SKYDIO}{{}}",
)
_DOWN: Final = "Camera:{}"
_HEIGHTS: Final = (
    "drone-dji:RelativeAltitude",
    "drone:RelativeAltitude",
    f"{_SKYDIO}RelativeAltitude",
    "Camera:AboveGroundAltitude",
)
_ALTITUDES: Final = ("drone-dji:AbsoluteAltitude", "drone:AbsoluteAltitude", f"{_SKYDIO}AbsoluteAltitude")
_LATITUDES: Final = ("drone-dji:GpsLatitude", "drone-dji:Latitude", "drone:GpsLatitude", f"{_SKYDIO}Latitude")
_LONGITUDES: Final = (
    "drone-dji:GpsLongitude",
    "drone-dji:GpsLongtitude",  # DJI's spelling in older files, and Autel's
    "drone-dji:Longitude",
    "drone:GpsLongitude",
    "drone:GpsLongtitude",
    f"{_SKYDIO}Longitude",
)
_SERIALS: Final = ("drone-dji:DroneSerialNumber", "drone-dji:CameraSerialNumber")
_FINEST_M: Final = 0.01
"""Least standard deviation that is believed: GNSS with corrections gives no better."""


def attitude(tags: Tags, make: str) -> Attitude | None:
    """Return roll, pitch and yaw (radians) of a camera as `MapPose` has them; None where the tags do not say."""
    for names in _FORWARD:
        found = _angles(tags, names)
        if found is not None:
            return looking_down(*found)
    found = _angles(tags, _DOWN)
    if found is None:
        return None
    roll, pitch, yaw = found
    return (-roll if make.casefold() == "sensefly" else roll), pitch, yaw


def looking_down(roll: float, pitch: float, yaw: float) -> Attitude:
    """Return the attitude of a camera whose forward angles are these: (0, -pi / 2, yaw) is (0, 0, yaw)."""
    return angles(rotation(roll, pitch, yaw) @ rotation(0.0, math.pi / 2, 0.0))


def _angles(tags: Tags, names: str) -> Attitude | None:
    roll, pitch, yaw = (number(tags, names.format(name)) for name in ("Roll", "Pitch", "Yaw"))
    if pitch is None or yaw is None:
        return None
    return math.radians(roll or 0.0), math.radians(pitch), math.remainder(math.radians(yaw), math.tau)


def tilt_alone(tags: Tags, make: str) -> Attitude | None:
    """Return the attitude of a camera whose tags give a pitch and no yaw: its yaw is 0, which nobody said."""
    with_yaw = {name.format("Yaw"): "0" for name in (*_FORWARD, _DOWN) if name.format("Yaw") not in tags}
    return attitude({**with_yaw, **tags}, make)


def has_gimbal(tags: Tags) -> bool:
    """Return True where the angles are those of a camera that a gimbal holds."""
    return any(_angles(tags, names) is not None for names in _FORWARD)


def velocity(tags: Tags) -> tuple[float, float]:
    """Return metres a second north and east; zero where the tags do not say. Parrot gives east first."""
    values = [_float(part) for part in tags.get("Camera:IMULinearVelocity", "").split(",")]
    if len(values) < 2 or values[0] is None or values[1] is None:
        return 0.0, 0.0
    return values[1], values[0]


def line_s(tags: Tags) -> float:
    """Return seconds between two lines of the picture that are read out, 0 where the tags do not say (nanoseconds)."""
    return max(0.0, number(tags, "Camera:LineReadoutTime") or 0.0) * 1e-9


def _float(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def height(tags: Tags) -> float | None:
    """Return metres above the take-off place, or above the ground where the maker gives that."""
    return number(tags, *_HEIGHTS)


def altitude(tags: Tags) -> float | None:
    """Return metres above sea or ellipsoid."""
    return number(tags, *_ALTITUDES)


def place(tags: Tags) -> tuple[float, float] | None:
    """Return latitude and longitude (degrees)."""
    latitude, longitude = number(tags, *_LATITUDES), number(tags, *_LONGITUDES)
    return None if latitude is None or longitude is None else (latitude, longitude)


def sigma(tags: Tags) -> tuple[float | None, float | None]:
    """Return the place's standard deviation, horizontally and in height, metres, by RTK or as Pix4D and Skydio do."""
    sides = [number(tags, f"drone-dji:RtkStd{side}") for side in ("Lon", "Lat")]
    known = [side for side in sides if side is not None and side > 0]
    across = max(known) if known else number(tags, "Camera:GPSXYAccuracy", f"{_SKYDIO}GpsHorizontalAccuracy")
    up = number(tags, "drone-dji:RtkStdHgt") if known else None
    up = up or number(tags, "Camera:GPSZAccuracy", f"{_SKYDIO}GpsVerticalAccuracy")
    return _believed(across), _believed(up)


def serial(tags: Tags) -> str:
    """Return the serial number of the aircraft, else of its camera, "" where the tags do not say."""
    return next((tags[name].strip() for name in _SERIALS if tags.get(name, "").strip()), "")


def _believed(metres: float | None) -> float | None:
    return None if metres is None or metres <= 0 else max(_FINEST_M, metres)

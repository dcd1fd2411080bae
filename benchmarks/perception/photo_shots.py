"""Photographs of a flight as the camera wrote them: lens, attitude and place from XMP and EXIF.

The lens and the attitude are Pix4D's tags (`Camera:` in XMP), the place is EXIF's. A photograph does not say how high
above the ground it was taken: a label file says it of one photograph, and EXIF's altitudes of the others differ from
that one's.
"""

from __future__ import annotations

import math
import re
import struct
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import cv2
import numpy as np
from defusedxml import ElementTree
from numpy.typing import NDArray

from hawk.algo.vision.rectify import camera_to_ned, intrinsics
from hawk.model.pictures import CameraModel
from hawk.model.poses import MapPose
from hawk.survey.scoring import FloatArray

SENSOR_WIDTHS_MM: Final[Mapping[str, float]] = {"Sequoia": 6.17472}
"""Width of the sensor by `Camera:RigName`: Pix4D's lengths are millimetres. Sequoia's colour camera has pixels of
1.34 micrometres (Parrot, Sequoia's specifications).
"""
_CAMERA: Final = "{http://pix4d.com/camera/1.0/}"
_ZERO: Final = np.zeros(3)
_GPS_POINTER, _LATITUDE, _LONGITUDE, _ALTITUDE = 0x8825, 2, 4, 6
_BYTES: Final = {1: 1, 2: 1, 3: 2, 4: 4, 5: 8, 10: 8}
_NEWTON_STEPS: Final = 5
_SUFFIXES: Final = (".jpg", ".jpeg")


@dataclass(frozen=True, slots=True)
class Shot:
    """A photograph. ``latitude``, ``longitude`` (degrees) and ``altitude`` (metres) are EXIF's, ``attitude`` is roll,
    pitch and yaw (radians) at the middle line, ``turning`` radians a second about the camera's x (right), y (down) and
    z (ahead), ``velocity`` metres a second to north and east, ``line_s`` the time between two lines of the picture that
    are read out, 0.0 where it is not given.
    """

    name: str
    image: NDArray[np.uint8] = field(repr=False)
    camera: CameraModel
    attitude: tuple[float, float, float]
    latitude: float
    longitude: float
    altitude: float
    velocity: tuple[float, float] = (0.0, 0.0)
    turning: tuple[float, float, float] = (0.0, 0.0, 0.0)
    line_s: float = 0.0

    def pixels(self, points: FloatArray, height_m: float) -> FloatArray:
        """Return the picture coordinates (N, 2) of points (N, 2) of the ground: metres north and east of the point
        below the camera, which was ``height_m`` above it at the middle line. Lines are read one after the other while
        the camera moves on and turns.
        """
        seconds = np.zeros((len(points), 1))
        for _ in range(3 if self.line_s else 1):
            offset = np.column_stack([points - seconds * np.array(self.velocity), np.full(len(points), height_m)])
            rays = offset @ camera_to_ned(self.camera, MapPose(0.0, 0.0, height_m, *self.attitude))
            rays = rays - np.cross(seconds * np.array(self.turning), rays)
            seen = cv2.projectPoints(rays, _ZERO, _ZERO, intrinsics(self.camera), np.array(self.camera.distortion))[0]
            pixels = np.asarray(seen, float).reshape(-1, 2)
            seconds = (pixels[:, 1:] - self.camera.height / 2) * self.line_s
        return pixels

    def ground(self, pixels: FloatArray, height_m: float) -> FloatArray:
        """Return the points of the ground that picture coordinates (N, 2) show, the inverse of `pixels`."""
        points = np.zeros_like(pixels, float)
        for _ in range(_NEWTON_STEPS):
            base = self.pixels(points, height_m)
            slopes = [self.pixels(points + metre, height_m) - base for metre in np.eye(2)]
            points = points + np.linalg.solve(np.stack(slopes, axis=-1), (pixels - base)[..., None])[..., 0]
        return points

    def axis(self) -> FloatArray:
        """Return the camera's optical axis as a unit vector (3,) of north, east and down."""
        return np.asarray(camera_to_ned(self.camera, MapPose(0.0, 0.0, 1.0, *self.attitude))[:, 2])


def photographs(folder: Path) -> list[Path]:
    """Return the photographs of a folder, by name."""
    return sorted(path for path in folder.iterdir() if path.suffix.lower() in _SUFFIXES)


def read_shot(path: Path) -> Shot:
    """Return a photograph. Raises ValueError, which names the file and what it lacks."""
    image, kinds, parts = cv2.imreadWithMetadata(str(path), cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION)
    if image is None:
        raise ValueError(f"{path} cannot be read as a picture; leave it out of the folder")
    found = {int(kind): np.asarray(part).tobytes() for kind, part in zip(np.ravel(kinds), parts, strict=True)}
    try:
        latitude, longitude, altitude = _place(found[cv2.IMAGE_METADATA_EXIF])
        tags = _tags(found[cv2.IMAGE_METADATA_XMP])
        camera = _camera(tags, image.shape[1], image.shape[0])
        roll, pitch, yaw = (math.radians(float(tags[key])) for key in ("Roll", "Pitch", "Yaw"))
        east, north, *_ = (float(v) for v in tags.get("IMULinearVelocity", "0,0").split(","))
        line_s = float(tags.get("LineReadoutTime", "0")) * 1e-9
    except (KeyError, ValueError, struct.error, ElementTree.ParseError) as error:
        raise ValueError(
            f"{path} lacks {error}: it needs EXIF's place and Pix4D's camera tags in XMP; use the camera's own file"
        ) from error
    at = (latitude, longitude, altitude)
    return Shot(path.name, np.asarray(image, np.uint8), camera, (roll, pitch, yaw), *at, (north, east), line_s=line_s)


def _tags(xmp: bytes) -> dict[str, str]:
    """Return the attributes of `Camera:` in an XMP packet."""
    start, end = xmp.index(b"<x:xmpmeta"), xmp.rindex(b">", 0, xmp.index(b"</x:xmpmeta") + 20) + 1
    root: Any = ElementTree.fromstring(xmp[start:end])
    return {
        name.removeprefix(_CAMERA): value
        for element in root.iter()
        for name, value in element.attrib.items()
        if name.startswith(_CAMERA)
    }


def _camera(tags: Mapping[str, str], width: int, height: int) -> CameraModel:
    """Return the lens. Pix4D's distortion is R1, R2, R3 (radial), T1, T2 (tangential), its principal point is measured
    from the corner of the first pixel.
    """
    pixels_per_mm = width / SENSOR_WIDTHS_MM[tags["RigName"]]
    focal = float(tags["PerspectiveFocalLength"]) * pixels_per_mm
    cx, cy = (float(v) * pixels_per_mm - 0.5 for v in tags["PrincipalPoint"].split(","))
    r1, r2, r3, t1, t2 = (float(v) for v in re.split(r"[,\s]+", tags["PerspectiveDistortion"].strip()))
    return CameraModel(width, height, focal, focal, cx, cy, (r1, r2, t1, t2, r3))


def _place(exif: bytes) -> tuple[float, float, float]:
    """Return latitude and longitude (degrees) and altitude (metres) from EXIF (EXIF 2.32, 4.6.6)."""
    order = {b"II": "<", b"MM": ">"}[exif[:2]]
    first = _entries(exif, order, struct.unpack_from(f"{order}I", exif, 4)[0])
    gps = _entries(exif, order, struct.unpack(f"{order}I", first[_GPS_POINTER])[0])
    signs = [-1.0 if gps[tag - 1][:1] in minus else 1.0 for tag, minus in _SIGNS.items()]
    values = []
    for tag in _SIGNS:
        numbers = struct.unpack(f"{order}{len(gps[tag]) // 4}I", gps[tag])
        ratios = [above / below for above, below in zip(numbers[::2], numbers[1::2], strict=True)]
        values.append(sum(ratio / 60**k for k, ratio in enumerate(ratios)))
    latitude, longitude, altitude = (sign * value for sign, value in zip(signs, values, strict=True))
    return latitude, longitude, altitude


_SIGNS: Final = {_LATITUDE: (b"S",), _LONGITUDE: (b"W",), _ALTITUDE: (b"\x01",)}
"""By tag: what the tag before it says where the value is negative."""


def _entries(exif: bytes, order: str, at: int) -> dict[int, bytes]:
    """Return the bytes of every entry of the directory at ``at``, by its tag."""
    values = {}
    for number in range(struct.unpack_from(f"{order}H", exif, at)[0]):
        entry = at + 2 + 12 * number
        tag, kind, count = struct.unpack_from(f"{order}HHI", exif, entry)
        size = _BYTES.get(kind, 1) * count
        start = entry + 8 if size <= 4 else struct.unpack_from(f"{order}I", exif, entry + 8)[0]
        values[tag] = exif[start : start + size]
    return values

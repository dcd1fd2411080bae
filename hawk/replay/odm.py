"""A recording's pictures for OpenDroneMap: ``images/``, ``geo.txt`` and ``cameras.json``.

``geo.txt`` (https://docs.opendronemap.org/geo): the projection, then a line a picture: name, longitude, latitude,
altitude, yaw, pitch, roll, degrees; yaw 0: the picture's top points north, pitch 0: the camera looks straight down.
``cameras.json`` (https://docs.opendronemap.org/arguments/cameras) holds OpenSfM's camera "brown": lengths by the longer
side of the picture, from its middle (https://opensfm.org/docs/geometry.html). ODM looks it up by make, model, size and
focal length in each picture's EXIF, so these are written into the pictures; their pixels are those of the recording.
"""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from hawk.formats.image import NoImage, decode
from hawk.model.frames import place_at
from hawk.model.operation import GROUND_STATES
from hawk.model.pictures import CameraModel, angles, rotation
from hawk.model.poses import GlobalPose, MapPose
from hawk.replay.flight import Origin, RecordedFlight, ReplayError
from hawk.replay.results import free_of, new_folder
from hawk.store.frame_codec import FRAME_INPUT, FrameFormatError, picture_of, values_of
from hawk.store.replay import Recorded

MAKE: Final = "hawk"
MODEL: Final = "drone"
FILM_MM: Final = 36.0
"""Width of 35 mm film, by which EXIF gives a focal length without a sensor's size."""
_PROJECTION: Final = "EPSG:4326"
_APP1, _SCAN, _START = 0xE1, 0xDA, b"\xff\xd8"
_EXIF_NAME: Final = b"Exif\x00\x00"
_LEAST_HEIGHT_M: Final = 6.0
_FIT_POINTS: Final = 200


@dataclass(frozen=True, slots=True)
class Written:
    """Pictures that were written, those of the ground or without a place, and those that could not be read.

    ``lens_error``: largest difference between lens and "brown" in the picture, pixels.
    """

    pictures: int
    left_out: int
    unreadable: int
    lens_error: float


def write_odm(flight: RecordedFlight, folder: Path, free_bytes: Callable[[Path], int] = free_of) -> Written:
    """Write the pictures that were taken in the air with a pose into a new folder, up to the recording's damage.

    Raises ReplayError: no such picture, a folder that cannot be written, a full disk.
    """
    size = flight.path.stat().st_size
    with new_folder(folder, size, free_bytes) as new:
        (new / "images").mkdir()
        shots = _Shots(new / "images")
        flight.follow(shots.take)
        camera = shots.camera
        if camera is None:
            cut = f" ({flight.damage})" if flight.damage else ""
            words = f"{flight.path}: holds no pictures from {_LEAST_HEIGHT_M:g} m above the ground with a place{cut}"
            raise ReplayError(f"{words}; name the recording of a flight that mapped")
        model, error = brown(camera)
        (new / "geo.txt").write_text("\n".join(shots.lines) + "\n", encoding="utf-8")
        (new / "cameras.json").write_text(json.dumps({camera_id(camera): model}, indent=1), encoding="utf-8")
    return Written(len(shots.lines) - 1, shots.left_out, shots.unreadable, error)


class _Shots:
    """Writes pictures, and keeps their lines of ``geo.txt``."""

    def __init__(self, images: Path) -> None:
        self.lines = [_PROJECTION]
        self.camera: CameraModel | None = None
        self.left_out = self.unreadable = 0
        self._images, self._origin = images, Origin()

    def take(self, message: Recorded) -> bool:
        """Take a message; return True for a picture. Raises ReplayError, RecordingError, OSError."""
        self._origin.look(message)
        if message.topic != FRAME_INPUT:
            return False
        try:
            frame, jpeg = values_of(message.data), picture_of(message.data)
            pose, camera = pose_of(frame), camera_of(frame)
        except (FrameFormatError, LookupError, TypeError, ValueError) as error:
            raise ReplayError(f"the picture at {message.time:.2f} s cannot be read: {error!r}") from error
        optics = replace(camera, mount_roll=0.0, mount_pitch=0.0, mount_yaw=0.0)
        is_other = self.camera is not None and self.camera != optics
        if pose is None or self._origin.datum is None or is_other:
            self.left_out += 1
        elif not _is_whole(jpeg, camera):
            self.unreadable += 1
        else:
            self.camera = optics
            self._write(jpeg, pose, camera, self._origin.datum)
        return True

    def _write(self, jpeg: bytes, pose: MapPose, camera: CameraModel, datum: GlobalPose) -> None:
        name = f"{len(self.lines):05d}.jpg"
        (self._images / name).write_bytes(with_exif(jpeg, camera))
        place = place_at(pose.north, pose.east, datum)
        turn = rotation(pose.roll, pose.pitch, pose.yaw)
        roll, pitch, yaw = angles(turn @ rotation(camera.mount_roll, camera.mount_pitch, camera.mount_yaw))
        degrees = (math.degrees(angle) for angle in (yaw % math.tau, pitch, roll))
        where = f"{place.longitude:.8f} {place.latitude:.8f} {self._origin.arm_altitude + pose.height:.3f}"
        self.lines.append(" ".join([name, where, *(f"{angle:.3f}" for angle in degrees)]))


def _is_whole(jpeg: bytes, camera: CameraModel) -> bool:
    """Return True for a picture that is whole and has the camera's size."""
    try:
        return decode(jpeg).shape[:2] == (camera.height, camera.width)
    except NoImage:
        return False


def pose_of(frame: dict[str, Any]) -> MapPose | None:
    """Return the pose of a frame that shows the ground from above, else None.

    Raises LookupError, TypeError, ValueError.
    """
    if frame["pose"] is None or frame.get("map_problem") or frame["state"] in GROUND_STATES:
        return None
    pose = MapPose(**{name: float(value) for name, value in frame["pose"].items()})
    height = pose.height - float(frame.get("ground") or 0.0)
    return pose if pose.is_finite() and height >= _LEAST_HEIGHT_M else None


def camera_of(frame: dict[str, Any]) -> CameraModel:
    """Return the camera of a frame. Raises LookupError, TypeError, ValueError."""
    values = dict(frame["camera"])
    distortion = tuple(float(each) for each in values.pop("distortion", ()))
    return CameraModel(**values, distortion=distortion)


def camera_id(camera: CameraModel) -> str:
    """Return the name by which ODM looks the camera up: that of `with_exif`."""
    ratio = str(_film_focal(camera) / FILM_MM)[:6]
    return f"v2 {MAKE} {MODEL} {camera.width} {camera.height} brown {ratio}"


def _film_focal(camera: CameraModel) -> int:
    """Return the focal length on 35 mm film, whole millimetres as EXIF has it."""
    return max(1, round(FILM_MM * camera.fx / max(camera.width, camera.height)))


def brown(camera: CameraModel) -> tuple[dict[str, Any], float]:
    """Return OpenSfM's camera, and its largest difference from the lens in the picture, pixels.

    A lens of eight coefficients (OpenCV's rational model) is fitted by three radial ones, as far as the corners.
    """
    side = max(camera.width, camera.height)
    k1, k2, p1, p2, k3, k4, k5, k6 = (*camera.distortion, *([0.0] * 8))[:8]
    error = 0.0
    if any((k4, k5, k6)):
        reach = math.hypot(max(camera.cx, camera.width - camera.cx), max(camera.cy, camera.height - camera.cy))
        radius = np.linspace(0.0, reach / min(camera.fx, camera.fy), _FIT_POINTS)
        square = radius**2
        powers = np.column_stack((square, square**2, square**3))
        real = (1 + powers @ (k1, k2, k3)) / (1 + powers @ (k4, k5, k6))
        fitted, *_ = np.linalg.lstsq(powers * radius[:, None], (real - 1) * radius, rcond=None)
        k1, k2, k3 = fitted.tolist()
        error = float(np.abs((1 + powers @ fitted - real) * radius).max() * max(camera.fx, camera.fy))
    model = {
        "projection_type": "brown",
        "width": camera.width,
        "height": camera.height,
        "focal_x": camera.fx / side,
        "focal_y": camera.fy / side,
        "c_x": (camera.cx - (camera.width - 1) / 2) / side,
        "c_y": (camera.cy - (camera.height - 1) / 2) / side,
        "k1": k1,
        "k2": k2,
        "p1": p1,
        "p2": p2,
        "k3": k3,
    }
    return model, error


def with_exif(jpeg: bytes, camera: CameraModel) -> bytes:
    """Return a JPEG with make, model and focal length in its EXIF, in place of what it had; the pixels stay.

    https://www.cipa.jp/std/documents/e/DC-008-Translation-2019-E.pdf: a TIFF header, IFD0 with make and model, and the
    EXIF IFD with the focal length on 35 mm film.
    """
    make, model = MAKE.encode() + b"\x00", MODEL.encode() + b"\x00"
    texts = 8 + 2 + 3 * 12 + 4
    exif = texts + len(make) + len(model)
    exif += exif % 2
    ifd0 = struct.pack(">H", 3)
    ifd0 += struct.pack(">HHII", 0x010F, 2, len(make), texts)
    ifd0 += struct.pack(">HHII", 0x0110, 2, len(model), texts + len(make))
    ifd0 += struct.pack(">HHII", 0x8769, 4, 1, exif) + struct.pack(">I", 0)
    parts = (b"MM\x00\x2a" + struct.pack(">I", 8) + ifd0 + make + model).ljust(exif, b"\x00")
    parts += struct.pack(">HHHIHHI", 1, 0xA405, 3, 1, _film_focal(camera), 0, 0)
    segment = _EXIF_NAME + parts
    return b"".join((_START, struct.pack(">BBH", 0xFF, _APP1, len(segment) + 2), segment, _without_exif(jpeg)))


def _without_exif(jpeg: bytes) -> bytes:
    """Return a JPEG behind its start, without EXIF."""
    kept, place = [], len(_START)
    while place + 4 <= len(jpeg) and jpeg[place] == 0xFF and jpeg[place + 1] != _SCAN:
        end = place + 2 + int.from_bytes(jpeg[place + 2 : place + 4], "big")
        if not (jpeg[place + 1] == _APP1 and jpeg[place + 4 : place + 10] == _EXIF_NAME):
            kept.append(jpeg[place:end])
        place = end
    return b"".join((*kept, jpeg[place:]))

"""Photographs of a flight as the camera wrote them, read as the product reads them: lens, attitude and place.

A photograph does not say how high above the ground it was taken: a label file says it of one photograph, and EXIF's
altitudes of the others differ from that one's.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hawk.algo.vision.rectify import camera_to_ned
from hawk.formats.image import NoImage, decode
from hawk.model.pictures import CameraModel
from hawk.picture.photographs.folder import SUFFIXES
from hawk.picture.photographs.lenses import Lenses
from hawk.picture.photographs.photograph import UnusableError, read_photograph
from hawk.picture.reconstruction.camera_pose import CameraPose
from hawk.survey.accuracy import FloatArray


@dataclass(frozen=True, slots=True)
class Shot:
    """A photograph. ``latitude``, ``longitude`` (degrees) and ``altitude`` (metres) are its place, ``attitude`` is
    roll, pitch and yaw (radians) at the middle line, ``turning`` radians a second about the camera's x (right), y
    (down) and z (ahead), ``velocity`` metres a second to north and east, ``line_s`` the time between two lines of the
    picture that are read out, 0.0 where it is not given.
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

    def posed(self, height_m: float) -> CameraPose:
        """Return the pose about the point below the camera, which was ``height_m`` above it at the middle line."""
        return CameraPose(
            self.camera, 0.0, 0.0, height_m, self.attitude, turning=self.turning, velocity=self.velocity,
            line_s=self.line_s,
        )  # fmt: skip

    def pixels(self, points: FloatArray, height_m: float) -> FloatArray:
        """Return the picture coordinates (N, 2) of points (N, 2), metres north and east of the point below."""
        return self.posed(height_m).pixels(points)

    def ground(self, pixels: FloatArray, height_m: float) -> FloatArray:
        """Return the points of the ground that picture coordinates (N, 2) show, the inverse of `pixels`."""
        return self.posed(height_m).ground(pixels)

    def axis(self) -> FloatArray:
        """Return the camera's optical axis as a unit vector (3,) of north, east and down."""
        return np.asarray(camera_to_ned(self.camera, self.posed(1.0).pose)[:, 2])


def photographs(folder: Path) -> list[Path]:
    """Return the photographs of a folder, by name."""
    return sorted(path for path in folder.iterdir() if path.suffix.lower() in SUFFIXES)


def read_shot(path: Path) -> Shot:
    """Return a photograph. Raises ValueError, which names the file and what it lacks."""
    try:
        read = read_photograph(path, Lenses()).shot
        image = decode(path.read_bytes())
    except (UnusableError, NoImage) as error:
        raise ValueError(f"{path} {error}") from error
    if read.attitude is None or read.altitude is None:
        raise ValueError(f"{path} lacks its attitude or its altitude; use the camera's own file")
    return Shot(
        path.name, image, read.camera, read.attitude, read.latitude, read.longitude, read.altitude, read.velocity,
        line_s=read.line_s,
    )  # fmt: skip

"""Pictures of the printed board by a camera that is known."""

from __future__ import annotations

import re

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from hawk.calibrate.board import PAPERS, board_pdf
from hawk.model.pictures import CameraModel

Picture = NDArray[np.uint8]
Pose = tuple[float, float, float, float, float, float]
"""Turns about the camera's x, y, z (degrees), then the board's middle: x, y, z in squares."""

TRUE = CameraModel(960, 540, 702.0, 698.0, 492.0, 262.0, (-0.21, 0.07, 0.0008, -0.0006, 0.0))
_PIXELS = 6  # of the sheet, by millimetre
_FINER = 2  # drawn so much finer than the picture: an edge is no step


def sheet(paper: str = "A4") -> Picture:
    """The printed page, from the PDF's own rectangles; 6 pixels a millimetre."""
    size = PAPERS[paper]
    page = np.full((round(size.height * _PIXELS), round(size.width * _PIXELS)), 255, np.uint8)
    scale = 25.4 / 72 * _PIXELS
    for found in re.finditer(rb"([\d.]+) ([\d.]+) ([\d.]+) ([\d.]+) re f", board_pdf(size)):
        left, bottom, width, height = (float(value) * scale for value in found.groups())
        top = page.shape[0] - bottom - height
        page[round(top) : round(top + height), round(left) : round(left + width)] = 0
    return page


class Studio:
    """Takes pictures of a sheet with one camera."""

    def __init__(self, page: Picture, camera: CameraModel = TRUE) -> None:
        self.page, self.camera = page, camera
        self._shape = (camera.height * _FINER, camera.width * _FINER)
        rows, columns = np.mgrid[0 : self._shape[0], 0 : self._shape[1]].astype(np.float32)
        # whole numbers are pixel centres
        x, y = ((at + 0.5) / _FINER - 0.5 for at in (columns, rows))
        matrix = np.array([[camera.fx, 0, camera.cx], [0, camera.fy, camera.cy], [0, 0, 1.0]])
        rays = cv2.undistortPoints(np.stack([x, y], -1).reshape(-1, 1, 2), matrix, np.array(camera.distortion))
        self._rays = np.asarray(rays, np.float32)

    def view(self, pose: Pose, *, noise: float = 2.0, seed: int = 0) -> Picture:
        """The page as the camera shows it, BGR."""
        turn = Rotation.from_euler("xyz", pose[:3], degrees=True).as_matrix()
        # a ray meets the board at place + turn (x, y, 0)
        plane = np.column_stack([turn[:, 0], turn[:, 1], np.array(pose[3:])])
        scale = PAPERS["A4"].square * _PIXELS
        across, down = (np.array(self.page.shape[::-1]) - 1) / 2
        to_page = np.array([[scale, 0, across], [0, scale, down], [0, 0, 1.0]]) @ np.linalg.inv(plane)
        at = cv2.perspectiveTransform(self._rays, to_page).reshape(*self._shape, 2)
        x, y = np.ascontiguousarray(at[..., 0]), np.ascontiguousarray(at[..., 1])
        wall = cv2.remap(self.page, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=(120,))
        size = (self.camera.width, self.camera.height)
        picture = cv2.GaussianBlur(cv2.resize(wall, size, interpolation=cv2.INTER_AREA), (0, 0), 0.6).astype(np.float32)
        picture += noise * np.random.default_rng(seed).standard_normal(picture.shape, np.float32)
        grey = np.clip(picture * 0.8 + 20, 0, 255).astype(np.uint8)
        return np.asarray(cv2.cvtColor(grey, cv2.COLOR_GRAY2BGR), np.uint8)


def poses() -> list[Pose]:
    """Views as a person shows them: parts of the picture, tilts, near and far."""
    found: list[Pose] = []
    for k, (x, y) in enumerate([(-1, -1), (0, -1), (1, -1), (-1, 0), (0, 0), (1, 0), (-1, 1), (0, 1), (1, 1)]):
        tilt = ((28, 0), (-28, 0), (0, 28), (0, -28))[k % 4]
        depth = 14.0 + k % 3
        found.append((tilt[0], tilt[1], 90.0, x * 0.42 * depth, y * 0.20 * depth, depth))
    found += [(25, 25, 5, 0, 0, 16), (-25, 25, -8, 2, 0, 18), (25, -25, 80, -2, 1, 15), (-25, -25, 100, 1, -1, 14)]
    found += [(0, 0, 90, 0, 0, 9), (10, -8, 90, 0, 0, 38), (15, 30, 90, -3, 0, 24), (-30, 10, 95, 4, 1, 20)]
    found += [(5, -32, 88, 5.5, -2.5, 13), (-20, 20, 92, -5.5, 2.5, 13)]
    return found

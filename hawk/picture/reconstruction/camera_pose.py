"""A photograph in the air: its camera, place and attitude, and what moves while its lines are read."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.vision.rectify import camera_to_ned, intrinsics
from hawk.model.pictures import CameraModel
from hawk.model.poses import MapPose

FloatArray = NDArray[np.float64]
_ZERO: Final = np.zeros(3)
_STEPS: Final = 4
_FLAT: Final = 1e-3
_UNTIL: Final = (cv2.TERM_CRITERIA_COUNT, 20, 0.0)


@dataclass(frozen=True, slots=True)
class CameraPose:
    """A photograph's pose: metres ``north`` and ``east`` of the survey's origin, ``height`` above its ground, and
    ``attitude``: roll, pitch, yaw as `hawk.picture.values.Shot` has them, at the middle line.

    ``turning``: radians a second about the camera's x (right), y (down), z (ahead); ``velocity``: metres a second
    north and east; ``line_s``: seconds between two lines, 0 where all are taken at once or it is not known.
    ``level``: height of the ground below, metres above the survey's mean ground; ``slope``: metres by which the ground
    rises a metre north and a metre east.
    """

    camera: CameraModel = field(repr=False)
    north: float
    east: float
    height: float
    attitude: tuple[float, float, float]
    turning: tuple[float, float, float] = (0.0, 0.0, 0.0)
    velocity: tuple[float, float] = (0.0, 0.0)
    line_s: float = 0.0
    level: float = 0.0
    slope: tuple[float, float] = (0.0, 0.0)

    @property
    def pose(self) -> MapPose:
        """The pose above the ground below."""
        return MapPose(self.north, self.east, self.height - self.level, *self.attitude)

    def reach(self) -> float:
        """Return the distance from the point below the camera to the farthest corner of the picture, metres."""
        half = math.hypot(self.camera.width, self.camera.height) / 2
        return self.height * half / self.camera.fx

    def rays(self, pixels: FloatArray) -> FloatArray:
        """Return the directions (N, 3) north, east and down of picture coordinates (N, 2) as the camera sees."""
        lens, matrix = np.array(self.camera.distortion), intrinsics(self.camera)
        seen = cv2.undistortPoints(pixels.reshape(-1, 1, 2), matrix, lens, criteria=_UNTIL)
        flat = np.asarray(seen, np.float64).reshape(-1, 2)
        rays = np.column_stack([flat, np.ones(len(flat))])
        if self.line_s:
            rays = rays + np.cross(self._seconds(pixels) * np.array(self.turning), rays)
        return np.asarray(rays @ camera_to_ned(self.camera, self.pose).T)

    def ground(self, pixels: FloatArray) -> FloatArray:
        """Return the ground (N, 2) north and east that pixels (N, 2) show; those above the horizon lie far away."""
        rays, slope = self.rays(pixels), np.array(self.slope)[:, None]
        moved = self._seconds(pixels) * np.array(self.velocity) if self.line_s else np.zeros((1, 2))
        above = self.height - self.level - moved @ slope
        scale = above / np.maximum(rays[:, 2:] + rays[:, :2] @ slope, _FLAT)
        return np.asarray(rays[:, :2] * scale + (self.north, self.east) + moved)

    def ground_height(self, places: FloatArray) -> FloatArray:
        """Return how high (N, 1) the ground is at places (N, 2), metres above the survey's mean ground."""
        return np.asarray(self.level + (places - (self.north, self.east)) @ np.array(self.slope)[:, None])

    def pixels(self, ground: FloatArray) -> FloatArray:
        """Return the pixels (N, 2) of places (N, 2) of the ground, or (N, 3) with their height above mean ground."""
        up = ground[:, 2:] if ground.shape[1] > 2 else self.ground_height(ground)
        seconds = np.zeros((len(ground), 1))
        turn, matrix = camera_to_ned(self.camera, self.pose), intrinsics(self.camera)
        lens = np.array(self.camera.distortion)
        for _ in range(_STEPS if self.line_s else 1):
            at = ground[:, :2] - (self.north, self.east) - seconds * np.array(self.velocity)
            rays = np.column_stack([at, self.height - up]) @ turn
            rays = rays - np.cross(seconds * np.array(self.turning), rays)
            shown = cv2.projectPoints(rays, _ZERO, _ZERO, matrix, lens)[0].reshape(-1, 2)
            seconds = self._seconds(np.asarray(shown, np.float64))
        return np.asarray(shown, np.float64)

    def _seconds(self, pixels: FloatArray) -> FloatArray:
        """Return the time (N, 1) of the lines of pixels after the middle one."""
        return np.asarray((pixels[:, 1:] - self.camera.height / 2) * self.line_s)

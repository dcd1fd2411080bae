"""The camera's motion over the ground in a film: how far the picture moves between two frames."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.model.pictures import CAMERA_TO_BODY, CameraModel, rotations
from hawk.picture.film.course import Course, FloatArray
from hawk.picture.film.video import Video

BETWEEN_S: Final = 0.3
"""Seconds between two frames: short, so that they show the same ground. Each begins where the one before ends, so that
a start or stop within it shows by how far the picture moved.
"""
_LEAST_DOWN: Final = 0.2
"""Of the camera's axis, a unit vector: a flatter one shows the horizon."""
_WIDTH: Final = 256
_LEAST_RESPONSE: Final = 0.05
"""Of a phase correlation: below it the two pictures have no shift in common."""
_MOST: Final = 4000
"""Measurements of a film: twenty minutes; a longer film is measured in its first part."""


@dataclass(frozen=True, slots=True)
class Motion:
    """Shifts (N, 2) of the ground in the picture, right and down, in focal lengths, from the frames at ``time`` (N,),
    seconds of the film, to those ``between`` seconds later.
    """

    time: FloatArray
    shift: FloatArray
    between: float


def measure(video: Video, camera: CameraModel, step: Callable[[int, int], None] = lambda *_: None) -> Motion:
    """Measure a film's motion by phase correlation; pairs without a clear shift are left out."""
    gap = max(1, round(BETWEEN_S * video.fps))
    numbers = range(0, video.frames, gap)[: _MOST + 1]
    window = cv2.createHanningWindow(_small_size(video.size), cv2.CV_32F)
    before: tuple[int, NDArray[np.float32]] | None = None
    times, shifts = [], []
    for number, picture in video.frames_of(numbers):
        small = _small(picture)
        if before is not None and number == before[0] + gap:
            (right, down), response = cv2.phaseCorrelate(before[1], small, window)
            if response >= _LEAST_RESPONSE:
                times.append(before[0] / video.fps)
                shifts.append((right, down))
                step(len(times), len(numbers) - 1)
        before = (number, small)
    scale = video.size[0] / _small_size(video.size)[0] / camera.fx
    return Motion(np.array(times), np.array(shifts, np.float64).reshape(-1, 2) * scale, gap / video.fps)


def expected(course: Course, times: FloatArray, between: float) -> FloatArray:
    """Return the shifts (N, 2) that a course gives at its ``times`` (N,), as `Motion` has them.

    What the picture's middle shows at the first moment is looked for in the second one's picture; turns of the camera
    move it as flight does.
    """
    first, second = course.at(times), course.at(times + between)
    origin = (float(course.latitude[0]), float(course.longitude[0]))
    moved = second.metres(origin) - first.metres(origin)
    before, after = _cameras(first.attitude), _cameras(second.attitude)
    ahead = before[:, :, 2]
    with np.errstate(divide="ignore", invalid="ignore"):
        ground = ahead / ahead[:, 2:] * first.height[:, None]
        off = ground - np.column_stack([moved, first.height - second.height])
        seen = np.einsum("nij,ni->nj", after, off)
        shifts = seen[:, :2] / seen[:, 2:]
    shifts[~((first.height > 0) & (ahead[:, 2] > _LEAST_DOWN) & (seen[:, 2] > 0))] = np.nan
    return np.asarray(shifts)


def _cameras(attitude: FloatArray) -> FloatArray:
    """Return the turns (N, 3, 3) from a camera's right, down, ahead to north, east, down."""
    return np.asarray(rotations(attitude) @ CAMERA_TO_BODY)


def _small_size(size: tuple[int, int]) -> tuple[int, int]:
    width = min(_WIDTH, size[0])
    return width, max(1, round(size[1] * width / size[0]))


def _small(picture: NDArray[np.uint8]) -> NDArray[np.float32]:
    grey = cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)
    size = _small_size((grey.shape[1], grey.shape[0]))
    return np.asarray(cv2.resize(grey, size, interpolation=cv2.INTER_AREA), np.float32)

"""Frames of a film at the pace of the ground: one each quarter of what the picture shows, the sharpest of its few."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.model.pictures import CameraModel
from hawk.picture.film.course import Course
from hawk.picture.photographs.photograph import MOST_TILT_DEG

STEP: Final = 0.25
"""Share of the picture's shorter side on the ground between two frames: they overlap by three quarters."""
LEAST_HEIGHT_M: Final = 3.0
_WITHIN: Final = 0.2
"""Share of a step by which a sharper frame may lie beside the one that is due."""
_CANDIDATES: Final = 5
_TURNING: Final = math.radians(35.0)
"""A second: a rolling shutter bends the ground, and its pixels blur."""
_SHARP_SIDE: Final = 640


@dataclass(frozen=True, slots=True)
class Due:
    """A frame that is due, with those beside it that may stand for it, in order."""

    candidates: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Plan:
    """Frames that are due, and how many frames are out of the question: by reason."""

    due: tuple[Due, ...]
    left_out: dict[str, int]


def plan(course: Course, is_covered: NDArray[np.bool_], camera: CameraModel) -> Plan:
    """Return which frames of a film are due.

    Args:
        course: The drone at each frame (N,).
        is_covered: (N,) frames at which its place is known.
        camera: The lens.
    """
    is_tilted = course.tilt() > math.radians(MOST_TILT_DEG)
    is_low = ~(course.height >= LEAST_HEIGHT_M)
    reasons = {
        "the log or the captions do not cover them; name those of the whole flight by --log": ~is_covered,
        f"were taken below {LEAST_HEIGHT_M:g} m, on the ground; else give the height by --height": is_covered & is_low,
        f"look more than {MOST_TILT_DEG:.0f} degrees off straight down; turn the camera down, to -90": is_covered
        & ~is_low
        & is_tilted,
    }
    usable = is_covered & ~is_low & ~is_tilted & (course.turning() <= _TURNING)
    counts = {reason: int(mask.sum()) for reason, mask in reasons.items() if mask.any()}
    return Plan(tuple(_due(course, usable, camera)), counts)


def _due(course: Course, usable: NDArray[np.bool_], camera: CameraModel) -> Iterator[Due]:
    """Give the frames that are due: the first one, then each that lies a step from the one before.

    Distance is from place to place, so that a drone that stands, and GNSS that wanders, add none.
    """
    numbers = np.flatnonzero(usable)
    if not len(numbers):
        return
    places = course.metres()[numbers]
    steps = STEP * course.height[numbers] * min(camera.width, camera.height) / camera.fx
    at = 0
    yield Due(_spread(numbers[:1]))
    while True:
        far = np.hypot(*(places[at + 1 :] - places[at]).T) / steps[at + 1 :]
        reached = np.flatnonzero(far >= 1.0)
        if not len(reached):
            break
        due = int(reached[0])
        begin = due
        while begin > 0 and far[begin - 1] >= 1.0 - _WITHIN:
            begin -= 1
        end = due
        while end + 1 < len(far) and 1.0 <= far[end + 1] <= 1.0 + _WITHIN:
            end += 1
        yield Due(_spread(numbers[at + 1 + begin : at + 2 + end]))
        at += 1 + due
    left = np.hypot(*(places[-1] - places[at]))
    if left > _WITHIN * steps[-1]:
        yield Due((int(numbers[-1]),))


def _spread(numbers: NDArray[np.intp]) -> tuple[int, ...]:
    """Return a few of these numbers, evenly."""
    chosen = np.unique(np.linspace(0, len(numbers) - 1, _CANDIDATES).round().astype(int))
    return tuple(int(numbers[k]) for k in chosen)


def sharpest(
    due: Sequence[Due],
    frames_of: Callable[[Sequence[int]], Iterable[tuple[int, NDArray[np.uint8]]]],
    step: Callable[[int, int], None] = lambda *_: None,
) -> tuple[list[int], int]:
    """Return the sharpest frame of each that is due, and how many of these have none that can be read; in one pass.

    One picture is held at a time. ``frames_of`` gives the frames of rising numbers.
    """
    wanted = sorted({number for each in due for number in each.candidates})
    found: dict[int, float] = {}
    for number, picture in frames_of(wanted):
        found[number] = sharpness(picture)
        step(len(found), len(wanted))
    best = [
        max((number for number in each.candidates if number in found), key=lambda n: found[n], default=None)
        for each in due
    ]
    return sorted({number for number in best if number is not None}), best.count(None)


def sharpness(picture: NDArray[np.uint8]) -> float:
    """Return the variance of a picture's Laplacian at `_SHARP_SIDE` pixels across, its middle half."""
    height, width = picture.shape[:2]
    middle = picture[height // 4 : height - height // 4, width // 4 : width - width // 4]
    grey = cv2.cvtColor(middle, cv2.COLOR_BGR2GRAY)
    shrink = max(1, round(grey.shape[1] / _SHARP_SIDE))
    small = cv2.resize(grey, None, fx=1 / shrink, fy=1 / shrink, interpolation=cv2.INTER_AREA) if shrink > 1 else grey
    return float(cv2.Laplacian(small, cv2.CV_32F).var())

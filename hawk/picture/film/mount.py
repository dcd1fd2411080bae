"""A camera of which the log says nothing: fixed to the drone or held level, its picture's top to any of four sides."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from hawk.model.pictures import angles, rotation
from hawk.picture.film.clock import ClockFit, SeveralError
from hawk.picture.film.course import Course
from hawk.picture.values import PictureError

_SIDES: Final = ("nose", "right", "tail", "left")
"""By quarter turns clockwise as seen from above."""


@dataclass(frozen=True, slots=True)
class Mount:
    """A fit, the course with the camera's attitudes, and a sentence. ``is_steadied``: the camera is held level."""

    fitted: ClockFit
    course: Course = field(repr=False)
    is_steadied: bool
    note: str


def find_mount(course: Course, fit: Callable[[Course], ClockFit]) -> Mount:
    """Return how a camera is mounted: the one of eight that the film's motion agrees with best.

    The picture's top to the nose counts first; the other sides are tried where nothing fits so. ``course``: that of a
    camera that is fixed to the drone. Raises PictureError where none fits.
    """
    refusal: PictureError | None = None
    found: list[Mount] = []
    for quarter, side in enumerate(_SIDES):
        for is_steadied in (False, True):
            turned = _turned(course.levelled() if is_steadied else course, quarter)
            try:
                found.append(Mount(fit(turned), turned, is_steadied, _note(side, is_steadied)))
            except SeveralError:
                raise
            except PictureError as error:
                refusal = refusal or error
        if quarter == 0 and found:
            break
    if refusal is not None and not found:
        raise refusal
    return min(found, key=lambda one: one.fitted.off)


def _turned(course: Course, quarter: int) -> Course:
    """Return the course with the camera turned on its mount by quarter turns."""
    if not quarter:
        return course
    mount = rotation(0.0, 0.0, quarter * math.pi / 2)
    return replace(course, attitude=np.array([angles(rotation(*row) @ mount) for row in course.attitude]))


def _note(side: str, is_steadied: bool) -> str:
    if is_steadied:
        words = "the camera does not sway with the drone: it is taken as held straight down"
    else:
        words = "the camera is taken as fixed to the drone, straight down"
    return f"The log has no gimbal: {words}, its picture's top to the {side}"

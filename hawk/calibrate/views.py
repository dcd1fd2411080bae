"""Finding the board in a picture, and keeping the views that are still and different."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.calibrate.board import SQUARES, make_board
from hawk.calibrate.coverage import View

Floats = NDArray[np.float64]

LEAST_CORNERS: Final = 12
"""Corners that a view needs; the board has 54."""
MOST_VIEWS: Final = 60
"""More views cost time and add nothing."""
STILL: Final = 1 / 500
"""Movement of the corners between two pictures, share of the picture's width, up to which the board is held still:
motion blur and the shutter's rolling stay below a pixel then."""
_USUAL_FOV: Final = math.radians(70)


class BoardFinder:
    """Finds the board in pictures of one size (pixels)."""

    def __init__(self, width: int, height: int) -> None:
        self._size = (width, height)
        board = make_board()
        self._corners = np.asarray(board.getChessboardCorners(), float)
        self._detector = cv2.aruco.CharucoDetector(board)
        focal = width / 2 / math.tan(_USUAL_FOV / 2)  # a guess is enough for the tilt
        self._guess = np.array([[focal, 0, (width - 1) / 2], [0, focal, (height - 1) / 2], [0, 0, 1]])

    def find(self, image: NDArray[np.uint8]) -> View | None:
        """Return the view of a picture, BGR (H, W, 3); None where too little of the board is seen."""
        grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
        found: Any = self._detector.detectBoard(grey)
        if found[0] is None or found[1] is None or len(found[1]) < LEAST_CORNERS:
            return None
        corners = np.asarray(found[0], float).reshape(-1, 2)
        ids = np.asarray(found[1], np.int32).ravel()
        if np.linalg.matrix_rank(self._corners[ids, :2] - self._corners[ids[0], :2], tol=0.5) < 2:
            return None  # one row of corners shows no plane
        done, turn, _ = cv2.solvePnP(self._corners[ids], corners, self._guess, np.zeros(5))
        if not done:
            return None
        normal = np.asarray(cv2.Rodrigues(turn)[0], float)[:, 2]
        lean = (-math.atan2(normal[0], normal[2]), -math.atan2(normal[1], normal[2]))
        middle = corners.mean(0) / self._size
        return View(corners, ids, (float(middle[0]), float(middle[1])), self._span(corners, ids), lean)

    def points(self, view: View) -> Floats:
        """Return the board's corners (N, 3) that a view shows, in squares."""
        return np.asarray(self._corners[view.ids])

    def _span(self, corners: Floats, ids: NDArray[np.int32]) -> float:
        """Return the share of the picture that the whole board would span, from the corners that are seen."""
        found: Any = cv2.findHomography(self._corners[ids, :2], corners)
        plane = found[0]
        if plane is None:
            return 0.0
        across, down = SQUARES
        outline = np.array([[[0, 0], [across, 0], [across, down], [0, down]]], float)
        ends = cv2.perspectiveTransform(outline, np.asarray(plane, float))[0]
        return float((np.ptp(ends, axis=0) / self._size).max())


@dataclass(slots=True)
class Collector:
    """Keeps the views that are of use. ``must_be_still``: False for single pictures."""

    width: int
    views: list[View]
    must_be_still: bool = True
    _last: View | None = None

    def take(self, view: View | None) -> str:
        """Take the next picture's view; return why it is not kept, in words; empty when it is kept."""
        last, self._last = self._last, view
        if view is None:
            return "the board is not seen"
        if self.must_be_still and (last is None or not _is_still(last, view, self.width)):
            return "hold the board still"
        if not all(view.differs(other) for other in self.views):
            return "this view is there already"
        if len(self.views) >= MOST_VIEWS:
            return "there are enough views"
        self.views.append(view)
        return ""


def _is_still(before: View, now: View, width: int) -> bool:
    _, here, there = np.intersect1d(before.ids, now.ids, return_indices=True)
    if len(here) < LEAST_CORNERS // 2:
        return False
    moved = np.hypot(*(now.corners[there] - before.corners[here]).T)
    return float(np.median(moved)) <= STILL * width

"""The lens from views of the board: OpenCV's calibration (Zhang, 2000), its spread; which views are missing."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.calibrate.board import SQUARES, make_board

CELLS: Final = (4, 3)
"""Parts of the picture across and down."""
CELL_CORNERS: Final = 8
"""Corners, of all views, that a part of the picture needs."""
LEAST_VIEWS: Final = 15
TILTED: Final = math.radians(20)
"""A board that leans by so much counts as tilted."""
NEAR: Final = 0.6
FAR: Final = 0.4
"""Share of the picture's width or height, the larger one, that the board spans: near from the one on, far up to the
other."""
_DIFFERENT = 0.2  # of the sum of differences of place, size and tilt (radians), as ROS's calibrator has it

_ROWS = ("upper", "middle", "lower")
_COLUMNS = ("left", "left of the middle", "right of the middle", "right")
_LEANS = ("left", "right", "top", "bottom")


@dataclass(frozen=True, slots=True)
class View:
    """A view of the board.

    ``corners`` (N, 2): pixels of those of its corners that are seen, ``ids`` (N,) their numbers. ``place``: middle of
    the corners, shares of the picture's width and height. ``size``: `NEAR`'s share. ``lean``: radians by which the
    board's right edge is farther away than its left, and its lower edge than its upper.
    """

    corners: Floats = field(repr=False)
    ids: NDArray[np.int32] = field(repr=False)
    place: tuple[float, float]
    size: float
    lean: tuple[float, float]

    def differs(self, other: View) -> bool:
        """Return True when this view adds something to the other."""
        mine, its = (np.array([*view.place, view.size, *view.lean]) for view in (self, other))
        return float(np.abs(mine - its).sum()) >= _DIFFERENT


@dataclass(frozen=True, slots=True)
class Coverage:
    """Parts, tilts and distances that the views show. ``cells`` (rows, columns): corners by part of the picture."""

    cells: NDArray[np.int64] = field(repr=False)
    leans: tuple[bool, bool, bool, bool]
    """True where a view leans so: its left, right, top, bottom edge is the near one."""
    is_near: bool
    is_far: bool
    views: int

    @property
    def missing(self) -> str:
        """Next view to show, in words; empty when everything is there."""
        if not self.views:
            return "hold the board into the picture, still and in even light"
        rows, columns = np.nonzero(self.cells < CELL_CORNERS)
        if len(rows):
            least = int(np.argmin(self.cells[rows, columns]))
            return f"move the board to the {_part(int(rows[least]), int(columns[least]))} of the picture"
        for there, edge in zip(self.leans, _LEANS, strict=True):
            if not there:
                return f"tilt the board: its {edge} edge nearer to the camera, by 30 degrees or more"
        if not self.is_near:
            return "move the board nearer, until it is more than 60 % as high or as wide as the picture"
        if not self.is_far:
            return "move the board away, until it is less than 40 % as high and as wide as the picture"
        if self.views < LEAST_VIEWS:
            return f"show {LEAST_VIEWS - self.views} more views, each at another place and tilt"
        return ""

    @property
    def share(self) -> float:
        """Share of what is needed that is there, 0 to 1."""
        parts = [min(1.0, float(cell) / CELL_CORNERS) for cell in self.cells.flat]
        parts += [float(each) for each in (*self.leans, self.is_near, self.is_far)]
        return (sum(parts) + min(1.0, self.views / LEAST_VIEWS)) / (len(parts) + 1)


def coverage(views: Sequence[View], width: int, height: int) -> Coverage:
    """Return what views of a picture of that size (pixels) show."""
    cells = np.zeros((CELLS[1], CELLS[0]), np.int64)
    for view in views:
        columns = np.clip(view.corners[:, 0] / width * CELLS[0], 0, CELLS[0] - 1).astype(int)
        rows = np.clip(view.corners[:, 1] / height * CELLS[1], 0, CELLS[1] - 1).astype(int)
        np.add.at(cells, (rows, columns), 1)
    leans = [view.lean for view in views]
    return Coverage(
        cells,
        (
            any(across >= TILTED for across, _ in leans),
            any(across <= -TILTED for across, _ in leans),
            any(down >= TILTED for _, down in leans),
            any(down <= -TILTED for _, down in leans),
        ),
        any(view.size >= NEAR for view in views),
        any(view.size <= FAR for view in views),
        len(views),
    )


def _part(row: int, column: int) -> str:
    """Return a part of the picture in words."""
    if row == 1:
        return _COLUMNS[column]
    return f"{_ROWS[row]} {_COLUMNS[column]}" if column in (0, CELLS[0] - 1) else f"{_ROWS[row]} middle"


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


Floats = NDArray[np.float64]

MOST_RMS: Final = 0.5
"""Pixels between the corners as they are seen and as the lens shows them, root of the mean square."""
MOST_FOCAL_SPREAD: Final = 0.002
"""Share of the focal length, one standard deviation: a stall of 2.5 m is off by 5 mm."""
MOST_CENTRE_SPREAD: Final = 0.002
"""Share of the picture's width, one standard deviation."""
NAMES: Final = ("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3")
"""Parameters in OpenCV's order; pixels, and numbers without a unit."""
_LEAST_VIEWS: Final = 6
_OUTLIER: Final = 2.5  # times the median of the views' errors
_OUTLIER_PX: Final = 0.3
_MOST_LEFT_OUT: Final = 0.25
_SURE: Final = 2.0  # spreads from zero


class LensError(Exception):
    """The views give no lens; the text says why, and the remedy."""


@dataclass(frozen=True, slots=True)
class Lens:
    """A calibrated lens.

    ``values`` and ``spreads`` (9,) by `NAMES`; a spread is one standard deviation, 0 for k3 where it is left out.
    ``rms`` in pixels. ``left_out`` counts the views that do not fit the others.
    """

    width: int
    height: int
    values: tuple[float, ...]
    spreads: tuple[float, ...]
    rms: float
    views: int
    left_out: int = 0

    @property
    def problems(self) -> list[str]:
        """Why it is not accepted, in sentences with their remedies; empty when it is."""
        found = []
        if not self.rms < MOST_RMS:
            found.append(
                f"the error is {self.rms:.2f} px, it must be below {MOST_RMS:g}: is the board flat, and the focus "
                "fixed? Hold it still, in more light"
            )
        focal = max(s / v for s, v in zip(self.spreads[:2], self.values[:2], strict=True))
        if not focal <= MOST_FOCAL_SPREAD:
            found.append(
                f"the focal length is uncertain by {focal:.2%}, at most {MOST_FOCAL_SPREAD:.1%} is allowed: show more "
                "tilted boards"
            )
        centre = max(self.spreads[2:4]) / self.width
        if not centre <= MOST_CENTRE_SPREAD:
            found.append(
                f"the centre is uncertain by {centre:.2%} of the width, at most {MOST_CENTRE_SPREAD:.1%} is allowed: "
                "show more boards tilted and near"
            )
        return found


@dataclass(frozen=True, slots=True)
class _Fit:
    rms: float
    values: Floats = field(repr=False)
    spreads: Floats = field(repr=False)
    errors: Floats = field(repr=False)


def calibrate(views: Sequence[View], width: int, height: int) -> Lens:
    """Return the lens of views of one camera. Raises LensError.

    The spreads count only where boards are tilted (`hawk.calibrate.lens`): boards that are all parallel to the
    picture leave the focal length open, and OpenCV's spread does not show it.

    Views that do not fit the others are left out, a quarter of them at most. k3 is left out where it is within two
    spreads of zero: it bends the corners of the picture.
    """
    finder = BoardFinder(width, height)
    kept = list(views)
    fit = _fit(finder, kept, width, height, 0)
    while True:
        worst = int(np.argmax(fit.errors))
        limit = max(_OUTLIER_PX, _OUTLIER * float(np.median(fit.errors)))
        if fit.errors[worst] <= limit or len(kept) <= max(_LEAST_VIEWS, (1 - _MOST_LEFT_OUT) * len(views)):
            break
        del kept[worst]
        fit = _fit(finder, kept, width, height, 0)
    if abs(fit.values[8]) < _SURE * fit.spreads[8]:
        fit = _fit(finder, kept, width, height, cv2.CALIB_FIX_K3)
    return Lens(
        width,
        height,
        tuple(float(value) for value in fit.values),
        tuple(float(value) for value in fit.spreads),
        fit.rms,
        len(kept),
        len(views) - len(kept),
    )


def _fit(finder: BoardFinder, views: Sequence[View], width: int, height: int, flags: int) -> _Fit:
    if len(views) < _LEAST_VIEWS:
        raise LensError(f"{len(views)} views of the board, at least {_LEAST_VIEWS} are needed: show more of them")
    boards = [finder.points(view).astype(np.float32) for view in views]
    seen = [view.corners.astype(np.float32) for view in views]
    guess, none = np.eye(3), np.zeros(5)
    try:
        found: Any = cv2.calibrateCameraExtended(boards, seen, (width, height), guess, none, flags=flags)
    except cv2.error as error:
        raise LensError(
            f"the views give no lens ({error.err or error}): show the board tilted, in several parts"
        ) from error
    rms, matrix, distortion, _, _, spreads, _, errors = found
    values = np.concatenate([np.asarray(matrix)[[0, 1, 0, 1], [0, 1, 2, 2]], np.ravel(distortion)[:5]])
    if not (np.isfinite(values).all() and (values[:2] > 0).all()):
        raise LensError("the views give no lens: show the board tilted, in several parts of the picture")
    return _Fit(float(rms), values, np.ravel(spreads)[:9], np.ravel(errors))

"""The camera in flight: ground that pictures show along straight legs, while the drone turns, and while it leans.

A level picture is a rectangle about the drone, wide across the heading. Between two legs the drone turns it: about a
waypoint it shows what a disc would, and more than the two rectangles together. Turned half round on the spot, its
corners sweep a disc that is wider still. The camera leans with the drone: as it speeds up the picture looks behind, as
it brakes ahead, and at a corner outwards.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hawk.algo.ground import Bools, Floats
from hawk.algo.path_plan.settings import PathPlanSettings
from hawk.model.pictures import CameraModel
from hawk.model.plans import HeightParameters
from hawk.model.poses import MapPose

LOOKS: Final = 3  # pictures that a place is in while the drone flies past, at least
SMEAR_M: Final = 0.1  # ground that may pass while the shutter is open: a pixel of the network
SLOWEST_M_S: Final = 0.5  # a slower drone would be taken for stuck
_TIMES: Final = 8
_MOVES_M_S: Final = 2.0
_ENOUGH: Final = 30  # frames from a moving drone: it has sped up and slowed down or turned by then


@dataclass(frozen=True, slots=True)
class Swath:
    """Ground in the good part of a picture, metres: ``width`` across the heading, ``depth`` along it, from a height."""

    width: float
    depth: float
    height: float

    @property
    def reach(self) -> float:
        """Distance from the middle of the picture to a corner, metres."""
        return math.hypot(self.width, self.depth) / 2

    @classmethod
    def of(cls, camera: CameraModel, height: float, good_share: float) -> Swath:
        """Return the swath of a level camera at a height (metres); ``good_share`` as in the settings."""
        scale = height * good_share
        return cls(scale * camera.width / camera.fx, scale * camera.height / camera.fy, height)


def exploring_height(heights: HeightParameters, camera: CameraModel, cm_per_pixel: float | None) -> float:
    """Return the height to explore from, metres within Min and Max: for this size of a pixel, or the desired one."""
    return heights.bounded(heights.desired if cm_per_pixel is None else cm_per_pixel / 100 * camera.fx)


class ReadableSpeed:
    """Follows how often pictures are worked on; frames that a busy computer drops are left out."""

    def __init__(self, exposure_s: float) -> None:
        """``exposure_s`` is the longest time that the shutter is open, seconds."""
        self._smearless = SMEAR_M / exposure_s
        self._times: deque[float] = deque(maxlen=_TIMES)

    def take(self, captured: float) -> None:
        """Record a picture that is being worked on; ``captured`` in seconds."""
        if self._times and captured <= self._times[-1]:
            self._times.clear()
        self._times.append(captured)

    def limit(self, depth: float) -> float:
        """Return the highest readable speed, m/s, for pictures that show ``depth`` metres along the path."""
        fastest = self._smearless
        if len(self._times) > 1:
            fastest = min(fastest, depth / (LOOKS * float(np.median(np.diff(self._times)))))
        return max(fastest, SLOWEST_M_S)


@dataclass(frozen=True, slots=True)
class Lean:
    """Distances by which the picture moves when the drone leans, metres.

    ``corner`` is outwards at a corner for each unit by which the direction changes, ``start`` behind the drone as it
    speeds up, ``stop`` ahead as it brakes at the end. ``radius`` is the radius about its middle within which a picture
    that leans at a corner shows the ground.
    """

    corner: float
    start: float
    stop: float
    radius: float

    @classmethod
    def of(cls, swath: Swath, settings: PathPlanSettings, leans: float = 1.0) -> Lean:
        """Return it for a camera that looks straight down, ``leans`` (0..1) being the share of the settings' lean."""
        side = math.atan2(swath.depth / 2, swath.height)

        def beyond(lean_deg: float) -> float:
            return swath.height * math.tan(side + math.radians(lean_deg * leans)) - swath.depth / 2

        corner = swath.height * math.tan(math.radians(settings.lean_deg * leans))
        radius = swath.width / 2 * settings.lean_share
        return cls(corner, beyond(settings.lean_deg), beyond(settings.stop_lean_deg), radius)


class LeanObserver:
    """Finds out in flight by how much the drone leans."""

    def __init__(self, settings: PathPlanSettings) -> None:
        self._expected = settings.lean_deg
        self._most = 0.0
        self._moving = 0

    def take(self, pose: MapPose, speed: float) -> None:
        """Record the pose of one frame and the speed over ground, m/s."""
        self._moving += speed > _MOVES_M_S
        self._most = max(self._most, math.degrees(math.hypot(pose.roll, pose.pitch)))

    @property
    def share(self) -> float:
        """Largest lean against the expected one, 0..1; 1 until enough was flown to know."""
        if self._moving < _ENOUGH or self._expected <= 0:
            return 1.0
        return min(1.0, self._most / self._expected)


Singles = NDArray[np.float32]

_LEAN_LEG_M: Final = 3.0
"""On a shorter leg the drone does not gather the speed that it would have to lean for: at ArduCopter's 2.5 m/s² and
5 m/s³ it leans fully after half a second, and half a second later no more."""

LEVEL: Final = Lean(0.0, 0.0, 0.0, 0.0)
"""The lean of a camera that is kept level."""


@dataclass(frozen=True, slots=True)
class Corners:
    """Begins and ends of K legs.

    ``before`` (K, 2) is the direction (north, east) in which the drone flies as each begins, its length the share of
    full lean that it flies fast enough for, (0, 0) where it stands. ``turned`` (K,) is the radius about the begin that
    is shown by turning there, metres. ``last`` (K,) is True for legs that end the tour.
    """

    before: Floats
    turned: Floats
    last: Bools


@dataclass(frozen=True, slots=True)
class Footprint:
    """Ground that a picture shows: ``width`` across and ``depth`` along its heading, metres.

    ``turned`` is the radius about a waypoint that the picture shows by turning to the next leg, ``spun`` the radius
    about a place where it turns half round; 0: turns are left out. ``lean`` says by how much the picture moves while
    the drone leans.
    """

    width: float
    depth: float
    turned: float = 0.0
    spun: float = 0.0
    lean: Lean = LEVEL

    @classmethod
    def of(cls, swath: Swath, settings: PathPlanSettings, leans: float = 1.0) -> Footprint:
        """Return the footprint of a camera that turns with the drone, and leans by a share of the settings' lean."""
        turned, spun = settings.turned_share * swath.width / 2, settings.spun_share * swath.reach
        return cls(swath.width, swath.depth, turned, spun, Lean.of(swath, settings, leans))

    def shown(self, cells: Singles, begins: Floats, ends: Floats, corners: Corners | None = None) -> Bools:
        """Return (K, N), True where one of K straight legs, with the corner where it begins, shows one of N cells.

        All are (north, east), metres. Without ``corners`` the picture stays level and turns nowhere. Cells (N, 6) are
        boxes, shown only as wholes: (north, east) of the middle, of the half length and of the half width.
        """
        along, across, half, unit = legs_about(cells[:, :2], begins, ends)
        long, wide, around = _extents(cells, unit)
        reach = half + (self.depth / 2 - long)
        shown = np.asarray(np.abs(across) <= self.width / 2 - wide)
        if corners is None:
            return np.asarray(shown & (np.abs(along) <= reach))
        lean = self.lean
        share = _lean_shares(2 * half)
        stands = np.asarray(~corners.before.any(1))
        shown &= along <= reach + _where(corners.last, lean.stop) * share
        shown &= along >= -reach - _where(stands, lean.start) * share
        aside = across * across
        for sign, radii in ((1, corners.turned), (-1, np.where(corners.last, self.spun, 0.0))):
            if radii.any():
                near = along + sign * half
                shown |= near * near + aside < np.maximum(_column(radii) - around, 0) ** 2
        if lean.corner > 0:
            shown |= _outwards(along + half, across, unit, share[:, 0], corners.before, lean, around)
        return np.asarray(shown)

    def swept(self, cells: Singles, place: Floats, heading: float, headings: Floats) -> Bools:
        """Return (K, N), True where the picture shows one of N cells while it turns on the spot.

        It turns from ``heading`` to each of K ``headings`` (radians) in the shorter direction.
        """
        if cells.shape[1] > 2:
            inner = 2 * float(np.sqrt((cells[:, 2:] ** 2).sum(1)).max(initial=0.0))
            within = replace(self, width=self.width - inner, depth=self.depth - inner, spun=self.spun - inner / 2)
            return within.swept(cells[:, :2], place, heading, headings)
        off = cells - place.astype(np.float32)
        away = np.hypot(off[:, 0], off[:, 1])
        result = np.zeros((len(headings), len(cells)), np.bool_)
        near = np.flatnonzero(away <= self.spun)
        if len(near) == 0:
            return result
        turns = np.array([math.remainder(value - heading, math.tau) for value in headings.tolist()])
        left, right = self.turns_until_shown(off[near], heading)
        result[:, near] = np.where(turns[:, None] >= 0, right <= turns[:, None], left <= -turns[:, None])
        return result

    def turns_until_shown(self, off: Singles, heading: float) -> tuple[Floats, Floats]:
        """Return the turns to the left and to the right after which a picture shows cells, radians; 0 when it does now.

        ``off`` (N, 2) are the cells' places against the drone's, no farther than the picture's corners. ``heading`` is
        the picture's, radians.
        """
        away = np.maximum(np.hypot(off[:, 0], off[:, 1]), 1e-6)
        # a cell is shown while its bearing lies between these angles to the picture's wide axis, on either side of it
        least = np.arccos(np.minimum(self.width / 2 / away, 1.0))
        most = np.maximum(np.arcsin(np.minimum(self.depth / 2 / away, 1.0)), least)
        aside = (np.arctan2(off[:, 1], off[:, 0]) - heading - math.pi / 2) % math.pi
        from_axis = np.minimum(aside, math.pi - aside)
        is_shown = (from_axis >= least) & (from_axis <= most)
        right = np.minimum((aside - most) % math.pi, (aside + least) % math.pi)
        left = np.minimum((least - aside) % math.pi, (-most - aside) % math.pi)
        return np.where(is_shown, 0.0, left), np.where(is_shown, 0.0, right)


def _outwards(
    along: Singles,
    across: Singles,
    unit: Floats,
    share: NDArray[np.floating],
    before: Floats,
    lean: Lean,
    around: Singles | float,
) -> Bools:
    """Return (K, N), True where the picture shows a cell as the drone leans into the corner where each leg begins.

    ``along`` and ``across`` are about the leg's begin, ``unit`` (K, 2) is its direction, ``share`` (K,) that of full
    lean on it, ``before`` (K, 2) as in `Corners`, and ``around`` (N,) the cells' radius, metres.
    """
    far = lean.corner * np.minimum(share, np.hypot(before[:, 0], before[:, 1]))
    other = directions(before)
    ahead = _column(far * ((unit * other).sum(1) - 1.0))
    aside = _column(far * (unit[:, 0] * other[:, 1] - unit[:, 1] * other[:, 0]))
    on_path = (along * ahead + across * aside) / np.maximum(ahead * ahead + aside * aside, np.float32(1e-6))
    on_path = np.clip(on_path, 0, 1)
    off, beside = along - on_path * ahead, across - on_path * aside
    flies = np.asarray(before.any(1))[:, None]
    return np.asarray((off * off + beside * beside <= np.maximum(lean.radius - around, 0) ** 2) & flies)


def _extents(cells: Singles, unit: Floats) -> tuple[Singles | float, Singles | float, Singles | float]:
    """Return half the extents of boxes (N, 6) along and across K legs (K, N), and their radius (N,), metres; cells
    (N, 2) have none.
    """
    if cells.shape[1] == 2:
        return 0.0, 0.0, 0.0
    length, width, ahead = cells[:, 2:4].T, cells[:, 4:6].T, unit.astype(np.float32)
    aside = np.column_stack([-ahead[:, 1], ahead[:, 0]])
    long, wide = (np.abs(turned @ length) + np.abs(turned @ width) for turned in (ahead, aside))
    return long, wide, np.sqrt((cells[:, 2:] ** 2).sum(1))


def directions(legs: Floats) -> Floats:
    """Return legs (..., 2) as vectors of length 1, (1, 0) for legs without length."""
    lengths = np.hypot(legs[..., 0], legs[..., 1])[..., None]
    return np.where(lengths < 1e-9, (1.0, 0.0), legs / np.maximum(lengths, 1e-9))


def momenta(legs: Floats) -> Floats:
    """Return the directions of legs (..., 2), each as long as its share of full lean."""
    lengths = np.hypot(legs[..., 0], legs[..., 1])[..., None]
    return np.asarray(directions(legs) * _lean_shares(lengths))


def _lean_shares(lengths: NDArray[np.floating]) -> NDArray[np.floating]:
    """Return the shares (0..1) of full lean that legs (lengths in metres) are flown fast enough for."""
    return np.asarray(np.minimum(lengths / _LEAN_LEG_M, 1.0))


def _column(values: Floats) -> Singles:
    return values.astype(np.float32)[:, None]


def _where(there: Bools, metres: float) -> Singles:
    return np.where(there, metres, 0.0).astype(np.float32)[:, None]


def legs_about(cells: Singles, begins: Floats, ends: Floats) -> tuple[Singles, Singles, Singles, Floats]:
    """Return the cells along each leg from its middle and across it (K, N), half its length (K, 1), its direction."""
    leg = ends - begins
    length = np.hypot(leg[:, 0], leg[:, 1])
    unit = directions(leg)
    # one product of matrices gives both coordinates of every cell about every leg
    turn = np.concatenate([unit, np.column_stack([-unit[:, 1], unit[:, 0]])])
    middle = (begins + ends) / 2
    origin = np.concatenate([(middle * unit).sum(1), middle[:, 1] * unit[:, 0] - middle[:, 0] * unit[:, 1]])
    turned = turn.astype(np.float32) @ cells.T - origin[:, None].astype(np.float32)
    half = (length / 2).astype(np.float32)[:, None]
    return turned[: len(leg)], turned[len(leg) :], half, unit

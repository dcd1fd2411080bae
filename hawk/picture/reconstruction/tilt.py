"""Tilt of photographs whose files do not say it, by the ground that neighbours show, and by the horizon.

Level ground in two pictures makes a homography, which says how the ground's normal lies in the camera (Faugeras and
Lustman 1988). It has up to two solutions with that ground in front of the camera, of which one is false: where a drone
flies ahead both look alike, so that the one that is less tilted counts, and a horizon that shows says the rest.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from statistics import median
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from hawk.algo.vision.rectify import intrinsics
from hawk.formats.image import NoImage
from hawk.model.pictures import CameraModel
from hawk.picture.reconstruction.camera_pose import CameraPose, FloatArray
from hawk.picture.reconstruction.features import RATIO, Features, alike
from hawk.picture.reconstruction.headings import MOST
from hawk.picture.values import Shot

NEIGHBOURS: Final = 4
LEAST: Final = 30
"""Features that must lie on one plane."""
_COMMON: Final = 0.1
"""Least share of a picture that the common ground spans: a narrow strip says little of its normal."""
_PLANE: Final = 0.006
"""Distance from a homography, by the focal length."""
_LEAST_BASE: Final = 0.08
"""Distance of two cameras by their height: from nearer ones nothing shows the ground's normal."""
_IN_FRONT: Final = 0.98
_SMALL: Final = 160
_LEAST_SKY: Final = 0.06
_STRAIGHT: Final = 0.03
_SMOOTH: Final = 4.0
_BRIGHTER: Final = 25.0
MOST_DEG: Final = 30.0
"""Off straight down, the median of a flight whose files say no angles, above which its photographs look ahead.

One photograph errs far more, by a rolling shutter, trees, or little common ground: those of a flight straight down had
a median of 23 degrees (docs/results/pictures.md).
"""
LEAST_DEG: Final = 20.0
"""Off straight down, from which a photograph of such a flight is left out."""
_REMEDY: Final = "turn the camera down, to -90"


def tilts(posed: Sequence[CameraPose], asked: Sequence[int], found: Callable[[int], Features]) -> dict[int, float]:
    """Return the tilts, radians off straight down, of the photographs ``asked`` for, as far as neighbours show them."""
    feet = np.array([(one.north, one.east) for one in posed])
    tree = cKDTree(feet)
    result = {}
    for number in asked:
        near = np.atleast_1d(tree.query(feet[number], min(NEIGHBOURS + 1, len(feet)))[1]).tolist()
        pairs = [
            _normals(posed[number].camera, posed[other].camera, found(number), found(other))
            for other in near
            if other != number
        ]
        tilt = _agreed([pair for pair in pairs if len(pair)])
        if tilt is not None:
            result[number] = tilt
    return result


def _normals(camera: CameraModel, other: CameraModel, here: Features, there: Features) -> FloatArray:
    """Return the normals (N, 3) of the ground in a camera, up to two, that a neighbour allows."""
    here, there = here.strongest(MOST), there.strongest(MOST)
    nothing = np.zeros((0, 3))
    if min(len(here.pixels), len(there.pixels)) < LEAST:
        return nothing
    one, two = alike(here, there, RATIO)
    if len(one) < LEAST:
        return nothing
    a, b = _flat(camera, here.pixels[one]), _flat(other, there.pixels[two])
    plane, inlier = cv2.findHomography(a, b, cv2.USAC_MAGSAC, _PLANE, maxIters=5000, confidence=0.9999)
    if plane is None or int(inlier.sum()) < LEAST:
        return nothing
    common = a[np.ravel(inlier) > 0]
    whole = camera.width * camera.height / (camera.fx * camera.fy)
    if cv2.contourArea(cv2.convexHull(common.astype(np.float32))) < _COMMON * whole:
        return nothing
    rays = np.column_stack([common, np.ones(len(common))])
    _, _, moves, normals = cv2.decomposeHomographyMat(plane, np.eye(3))
    fits = [
        np.ravel(normal)
        for move, normal in zip(moves, normals, strict=True)
        if float(np.linalg.norm(move)) > _LEAST_BASE and (rays @ normal > 0).mean() >= _IN_FRONT
    ]
    return np.asarray(fits, np.float64).reshape(-1, 3)


def _flat(camera: CameraModel, pixels: FloatArray) -> FloatArray:
    """Return pixels (N, 2) as (x, y) at a distance of one ahead of the camera, without the lens's distortion."""
    seen = cv2.undistortPoints(pixels.reshape(-1, 1, 2), intrinsics(camera), np.array(camera.distortion))
    return np.asarray(seen, np.float64).reshape(-1, 2)


def _agreed(pairs: Sequence[FloatArray]) -> float | None:
    """Return the median tilt of pairs, each by the solution that is less tilted; None without any."""
    if not pairs:
        return None
    return float(np.median([np.arccos(np.abs(pair[:, 2]).clip(0.0, 1.0)).min() for pair in pairs]))


def has_horizon(image: NDArray[np.uint8]) -> bool:
    """Return whether a picture (H, W, 3), BGR, shows sky above a straight horizon, at its upper or lower edge.

    Sky: smooth, brighter than the ground and no redder, along the whole edge down to one straight line.
    """
    height = max(1, round(_SMALL * image.shape[0] / image.shape[1]))
    small = cv2.resize(image, (_SMALL, height), interpolation=cv2.INTER_AREA).astype(np.float32)
    return any(_is_sky_above(each) for each in (small, small[::-1]))


def _is_sky_above(small: NDArray[Any]) -> bool:
    grey, rows = small.mean(axis=2), len(small)
    rough = np.abs(np.diff(grey, axis=0))
    line = np.where((rough > _SMOOTH).any(axis=0), (rough > _SMOOTH).argmax(axis=0), rows)
    depth = float(np.median(line)) / rows
    if not _LEAST_SKY < depth < 0.9:
        return False
    across = np.arange(len(line))
    slope, begin = np.polyfit(across, line, 1)
    if float(np.percentile(np.abs(line - slope * across - begin), 90)) > _STRAIGHT * rows:
        return False
    sky = np.arange(rows)[:, None] < line[None] - 1
    ground = ~sky
    is_bright = float(grey[sky].mean() - np.median(grey[ground])) > _BRIGHTER
    blue, red = float(small[..., 0][sky].mean()), float(small[..., 2][sky].mean())
    return is_bright and blue >= red - 2.0


def oblique_shots(
    shots: Sequence[Shot],
    poses: Sequence[CameraPose],
    found: Callable[[int], Features],
    picture: Callable[[Shot], NDArray[np.uint8]],
) -> dict[str, str]:
    """Return the names of shots that look too far off straight down, of those whose files say no angles; and why.

    Args:
        shots: All shots.
        poses: Their poses by their files.
        found: Gives the features of a shot by its number.
        picture: Gives a shot's picture. Raises NoImage.
    """
    asked = [number for number, shot in enumerate(shots) if shot.attitude is None]
    if not asked:
        return {}
    seen = tilts(poses, asked, found)
    middle = math.degrees(median(seen.values())) if seen else 0.0
    reasons = {}
    for number in asked:
        shot = shots[number]
        if middle > MOST_DEG and math.degrees(seen.get(number, 0.0)) > LEAST_DEG:
            reasons[shot.name] = (
                f"looks about {middle:.0f} degrees or more off straight down, by the ground that its neighbours show, "
                f"and its file says no angles; {_REMEDY}"
            )
        elif _shows_sky(picture, shot):
            reasons[shot.name] = f"shows sky above the horizon, and its file says no angles; {_REMEDY}"
    return reasons


def _shows_sky(picture: Callable[[Shot], NDArray[np.uint8]], shot: Shot) -> bool:
    try:
        return has_horizon(picture(shot))
    except NoImage:  # the map says so
        return False

"""Ground by a picture's colours: lit ground, shade, deep shade, crowns of leaves.

The sun is yellow and the sky is blue: ground in shade is darker than lit ground, bluer, and less red. Dark asphalt is
dark but not that blue; dark cars reflect the sky and can be.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.perception.places import Place

GROUND_M = 0.10
"""Metres per pixel of everything here."""
SHADE_GREEN, SHADE_BLUE, SHADE_RED = 0.70, 1.10, 0.93
"""Shade: green at most, blue by green at least, red by green at most these shares of lit ground's."""
DEEP_M = 3.4
"""Deep shade holds a disc of this diameter, of even ground: a car's shadow is narrower, a dark car not even."""
TREE_SHADE_M, TREE_REACH_M = 2.6, 5.0
"""Shade within the second distance of a crown holds a disc of the first: leaves make it narrower and less even."""
LEAF_BLUE, LEAF_ROUGH, LEAF_RED, GREEN_RED = 0.84, 0.10, 1.25, 0.93
"""Leaves: blue by green at most, standard deviation by mean of green at least, red by green at most; colours are shares
of lit ground's. The last is for leaves of any blue below that of the ground.
"""
AUTUMN_BLUE, AUTUMN_ROUGH = 0.72, 0.06
"""Thin yellow crowns have less blue and are less rough."""
CROWN_M, CROWN_M2 = 1.0, 2.5
"""A crown holds a disc of this diameter and has at least this area, square metres."""

_NEAR_M = 6.0
_SMOOTH_M, _SMOOTH, _PLAIN = 0.7, 5.0, 9.0
_SPECK_M, _RIM_M, _PAINT = 0.7, 2.0, 1.2
_LIT_BLUE, _LIT_RED = (0.80, 1.10), (0.93, 1.20)
_LIT_LEVELS = (70.0, 215.0)
_BRIGHTER, _DARKER = 1.35, 0.72
_AROUND_M = 30.0
_LEAST_SHARE = 0.02
_ROUGH_M = 0.9

Mask = NDArray[np.bool_]
Colours = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class GroundLight:
    """Masks (H, W) at `GROUND_M`, and the colour (3,) of lit ground, BGR; NaN where the picture shows no lit ground.

    ``ground``: smooth grey ground about the stalls, lit or in shade. ``lit`` (H, W): green of the lit ground nearby.
    """

    image: NDArray[np.uint8]
    ground: Mask
    lit: Colours
    lit_colour: Colours
    shade: Mask
    deep: Mask
    crown: Mask


def ground_light(place: Place, stalls: NDArray[np.float64]) -> GroundLight:
    """Distinguish lit ground from shade and crowns; ``stalls`` (N, 4, 2) in metres say where ground for cars is."""
    factor = place.metres_per_pixel / GROUND_M
    method = cv2.INTER_AREA if factor < 1 else cv2.INTER_LINEAR
    image = np.asarray(cv2.resize(place.image, None, fx=factor, fy=factor, interpolation=method), np.uint8)
    soft = np.asarray(cv2.GaussianBlur(image, (0, 0), 1.5), np.float32)
    green = np.maximum(soft[..., 1], 1.0)
    blue, red = soft[..., 0] / green, soft[..., 2] / green
    smooth = _near(image.shape[:2], stalls) & (_deviation(image[..., 1], _SMOOTH_M) < _SMOOTH) & ~_missing(place, image)
    coloured = _within(blue, _LIT_BLUE) & _within(red, _LIT_RED) & _within(green, _LIT_LEVELS)
    is_lit = smooth & coloured
    if is_lit.mean() < _LEAST_SHARE * smooth.mean() or not is_lit.any():
        none = np.zeros(image.shape[:2], np.bool_)
        nothing = np.full(3, np.nan, np.float32)
        return GroundLight(image, none, np.full(none.shape, np.nan, np.float32), nothing, none, none, none)
    middle = float(np.median(green[is_lit]))
    is_lit &= _within(green, (_DARKER * middle, _BRIGHTER * middle))
    colour = np.median(soft[is_lit], axis=0)
    lit = _mean_around(green, is_lit, middle)
    shade = (green < SHADE_GREEN * lit) & (blue > SHADE_BLUE * colour[0] / colour[1])
    shade &= red < SHADE_RED * colour[2] / colour[1]
    shade &= ~_missing(place, image)
    crown = _crowns(image, green, blue * colour[1] / colour[0], red * colour[1] / colour[2])
    plain = _closed(shade & (_deviation(_unpainted(image, green, shade), _SMOOTH_M) < _PLAIN), _SPECK_M)
    near_crown = _within_reach(crown, TREE_REACH_M)
    core = _opened(plain, DEEP_M) | _opened(_closed(shade, _SPECK_M), TREE_SHADE_M) & near_crown
    deep = core & ~crown | shade & _within_reach(core, _RIM_M)
    return GroundLight(image, smooth & (is_lit | shade), lit, np.asarray(colour, np.float32), shade, deep, crown)


def _crowns(image: NDArray[np.uint8], green: Colours, blue: Colours, red: Colours) -> Mask:
    """Return crowns: leaves are rough and hold little blue, green ones and those of autumn; lawns are smooth."""
    rough = _deviation(image[..., 1], _ROUGH_M) / green
    leaves = ((blue < LEAF_BLUE) & (red < LEAF_RED) | (blue < 1.0) & (red < GREEN_RED)) & (rough > LEAF_ROUGH)
    leaves |= (blue < AUTUMN_BLUE) & (red < LEAF_RED) & (rough > AUTUMN_ROUGH)
    opened = _opened(_closed(leaves, _SPECK_M), CROWN_M)
    _, label, stats, _ = cv2.connectedComponentsWithStats(opened.astype(np.uint8), connectivity=8)
    large = stats[:, cv2.CC_STAT_AREA] * GROUND_M**2 >= CROWN_M2
    large[0] = False
    return np.asarray(large[label])


def _near(shape: tuple[int, ...], stalls: NDArray[np.float64]) -> Mask:
    drawn = np.zeros(shape, np.uint8)
    cv2.fillPoly(drawn, [np.rint(stall / GROUND_M - 0.5).astype(np.int32) for stall in stalls], (1,))
    return _within_reach(drawn > 0, _NEAR_M)


def _within_reach(mask: Mask, reach_m: float) -> Mask:
    if not mask.any():
        return mask
    away = cv2.distanceTransform((~mask).astype(np.uint8), cv2.DIST_L2, 3)
    return np.asarray(away * GROUND_M < reach_m)


def _missing(place: Place, image: NDArray[np.uint8]) -> Mask:
    if place.missing is None:
        return np.zeros(image.shape[:2], np.bool_)
    return np.asarray(cv2.resize(place.missing.astype(np.uint8), image.shape[1::-1]) > 0)


def _unpainted(image: NDArray[np.uint8], green: Colours, shade: Mask) -> Colours:
    """Return green without what is brighter than the shade nearby: lines do not make its ground uneven."""
    level = _mean_around(green, shade, float(green[shade].mean()) if shade.any() else 0.0)
    return np.asarray(np.minimum(image[..., 1].astype(np.float32), _PAINT * level), np.float32)


def _deviation(values: NDArray[np.uint8] | Colours, side_m: float) -> Colours:
    """Return the standard deviation in a square about each pixel, grey levels."""
    green = values.astype(np.float32)
    size = (odd(side_m),) * 2
    spread = cv2.blur(green * green, size) - cv2.blur(green, size) ** 2
    return np.asarray(np.sqrt(np.maximum(spread, 0)), np.float32)


def _mean_around(values: Colours, mask: Mask, default: float) -> Colours:
    """Return the mean of values under a mask in a square about each pixel, ``default`` where there are few."""
    size = (odd(_AROUND_M),) * 2
    weight = cv2.blur(mask.astype(np.float32), size)
    total = cv2.blur(np.where(mask, values, 0).astype(np.float32), size)
    return np.where(weight > _LEAST_SHARE, total / np.maximum(weight, 1e-6), default).astype(np.float32)


def _opened(mask: Mask, diameter_m: float) -> Mask:
    """Return what of a mask holds a disc."""
    radius = diameter_m / 2
    return _within_reach(mask & ~_within_reach(~mask, radius), radius)


def _closed(mask: Mask, diameter_m: float) -> Mask:
    """Return a mask with its gaps closed that hold no disc."""
    return ~_opened(~mask, diameter_m)


def _within(values: NDArray[np.floating], limits: tuple[float, float]) -> Mask:
    return np.asarray((values > limits[0]) & (values < limits[1]))


def odd(metres: float) -> int:
    """Return a length as an odd number of pixels."""
    return 2 * round(metres / GROUND_M / 2 - 0.5) + 1

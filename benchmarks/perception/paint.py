"""Painted lines along the long sides of stalls, as a picture shows them."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.perception.ground_light import GROUND_M
from benchmarks.perception.stall_rows import Boxes

Floats = NDArray[np.float64]
LINE = 0.07
"""Least contrast of a line: brighter than the ground on both sides by this share of the ground."""
SHOWN = 0.5
"""Least share of a side along which the line shows, between cars and crowns."""
REACH_M, ASIDE_M = 0.35, 0.3
"""Greatest distance of a line from the labelled side, and distance of its ground from the line, metres."""

_STEP_M, _WINDOW_M, _PLACES, _MIDDLE = 0.05, 0.5, 16, 0.8
_SLANT = 2


@dataclass(frozen=True, slots=True)
class SideLine:
    """The best line along a side: share of the side along which it shows, its contrast there (share of the ground), and
    its width at half of its height, metres; contrast and width are NaN where nothing shows.
    """

    shown: float
    contrast: float
    width: float


def brightness(image: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Return the brighter one of red and green (H, W), in which white and yellow paint are both bright."""
    return np.asarray(image[..., 1:].max(axis=2), np.float32)


def side_lines(bright: NDArray[np.float32], boxes: Boxes, number: int) -> tuple[SideLine, SideLine]:
    """Return the lines along both long sides of a stall."""
    return _side_line(bright, boxes, number, -1), _side_line(bright, boxes, number, 1)


def is_marked(bright: NDArray[np.float32], boxes: Boxes, number: int) -> bool:
    """Return True where a line shows along at least one long side."""
    return any(line.shown >= SHOWN for line in side_lines(bright, boxes, number))


def _side_line(bright: NDArray[np.float32], boxes: Boxes, number: int, side: int) -> SideLine:
    profile, offsets = _profiles(bright, boxes, number, side)
    aside = round(ASIDE_M / _STEP_M)
    middle = profile[:, aside:-aside]
    ground = np.maximum(profile[:, : -2 * aside], profile[:, 2 * aside :])
    ridge = (middle - ground) / np.maximum(ground, 1.0)
    near = np.stack([np.roll(ridge, k, axis=1) for k in range(-_SLANT, _SLANT + 1)]).max(axis=0)
    shown = (near >= LINE).mean(axis=0)
    inside = np.abs(offsets[aside:-aside]) <= REACH_M + 1e-9
    best = int(np.argmax(np.where(inside, shown + 1e-3 * ridge.mean(axis=0), -1)))
    if shown[best] == 0:
        return SideLine(0.0, np.nan, np.nan)
    there = near[:, best] >= LINE
    mean = _straightened(profile[there], ridge[there], best, aside)
    return SideLine(float(shown[best]), float(np.median(near[there, best])), _width(mean))


def _profiles(bright: NDArray[np.float32], boxes: Boxes, number: int, side: int) -> tuple[Floats, Floats]:
    """Return the brightness (places along the side, offsets across it), each a mean over a window, and the offsets."""
    reach = REACH_M + 2 * ASIDE_M
    offsets = np.arange(-round(reach / _STEP_M), round(reach / _STEP_M) + 1) * _STEP_M
    half = boxes.length[number] / 2 * _MIDDLE
    places = np.linspace(-half, half, _PLACES)[:, None] + np.linspace(-_WINDOW_M / 2, _WINDOW_M / 2, 5)
    across = boxes.width[number] / 2 * side + offsets
    points = (
        boxes.centre[number]
        + across[None, None, :, None] * boxes.across[number]
        + places[:, :, None, None] * boxes.along[number]
    ) / GROUND_M - 0.5
    flat = points.reshape(len(places) * 5, -1, 2).astype(np.float32)
    sampled = cv2.remap(bright, flat[..., 0], flat[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    profile = np.asarray(sampled.reshape(len(places), 5, -1).mean(axis=1), np.float64)
    return profile, np.asarray(offsets, np.float64)


def _straightened(profile: Floats, ridge: Floats, best: int, aside: int) -> Floats:
    """Return the mean profile about the line, each place shifted so that its ridge lies in the middle."""
    low, high = max(best - _SLANT, 0), min(best + _SLANT + 1, ridge.shape[1])
    peak = low + ridge[:, low:high].argmax(axis=1) + aside
    reach = np.arange(-aside, aside + 1)
    index = np.clip(peak[:, None] + reach, 0, profile.shape[1] - 1)
    return np.asarray(np.take_along_axis(profile, index, axis=1).mean(axis=0))


def _width(profile: Floats) -> float:
    """Return the width at half height, metres; NaN where the profile does not fall to half within its reach."""
    middle = len(profile) // 2
    base = max(profile[0], profile[-1])
    half = base + (profile[middle] - base) / 2
    if profile[middle] <= base:
        return float("nan")
    total = 0.0
    for part in (profile[middle:], profile[middle::-1]):
        below = np.flatnonzero(part < half)
        if not len(below):
            return float("nan")
        k = int(below[0])
        total += k - 1 + (part[k - 1] - half) / (part[k - 1] - part[k])
    return float(total * _STEP_M)

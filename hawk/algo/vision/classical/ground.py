"""The ground around rows: how unlike bare asphalt each cell looks, where cars stand, where the lot goes on."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.vision import decode
from hawk.algo.vision.classical.strokes import Map
from hawk.algo.vision.decode import Stalls
from hawk.algo.vision.network import CELL_PIXELS
from hawk.algo.vision.seen import FloatArray

_EDGE_CAP, _STEP_CAP, _CHROMA_CAP = 60.0, 60.0, 30.0
_EDGE_LIMIT = 16.0
_DARK = 30.0
_PLANTS_A, _PLANTS_B = 121, 134
"""Highest a and least b (OpenCV's 8-bit Lab, 128 is grey) of leaves and grass."""
_SPREAD_M = 0.9
_CAR_M = 1.7
_LIKE_M = 0.9
_LIKE, _LOT = (0.15, 0.5, 0.85), (0.2, 0.6, 0.93)
_NEAR_M = (9.0, 18.0)
_TAKEN: FloatArray = np.array([-2.64, 0.81, 0.97, 2.5, 0.77, 2.05, 0.9, 0.67, 1.77])
"""Logistic regression of taken on the `stall_features`, bias first, fitted to drawn lots (`training.fit_classical`)."""
_INNER = (0.55, 0.74)
"""Shares of a stall's width and length in which cars are looked for; neighbours and their shade reach in from aside."""


@dataclass(frozen=True, slots=True)
class Ground:
    """Cells of `CELL_PIXELS` pixels: ``features`` (H, W, F) float32, each a small number that is near 0 on bare ground;
    ``like`` (H, W), 0..1, how much a cell looks like the rows' asphalt, in light or in shade;
    ``green`` (H, W), 0..1, how much of what is around it is plants.
    """

    features: NDArray[np.float32] = field(repr=False)
    like: Map = field(repr=False)
    green: Map = field(repr=False)


def survey_ground(image: NDArray[np.uint8], valid: NDArray[np.bool_], stalls: Stalls, side: float) -> Ground:
    """Look at the ground of a picture; the asphalt is what most of the ground in and before the stalls (pixels) is."""
    lab = cv2.cvtColor(image, cv2.COLOR_BGR2LAB)
    size = valid[::CELL_PIXELS, ::CELL_PIXELS].shape[::-1]
    cells = np.asarray(cv2.resize(lab, size, interpolation=cv2.INTER_AREA), np.float32)
    asphalt = _asphalt(cells, valid[::CELL_PIXELS, ::CELL_PIXELS], stalls)
    lightness = np.ascontiguousarray(lab[..., 0], np.uint8)
    edge = _halved(_edges(lightness), cells.shape)
    step = cells[..., 0] - asphalt[0]
    chroma = np.hypot(cells[..., 1] - asphalt[1], cells[..., 2] - asphalt[2])
    spread = 2 * round(_SPREAD_M / side / CELL_PIXELS / 2) + 1
    mean, square = cv2.blur(cells[..., 0], (spread,) * 2), cv2.blur(cells[..., 0] ** 2, (spread,) * 2)
    # shade takes lightness and leaves most of the colour
    like = np.exp(-((chroma / 9) ** 2) - np.where(step > 0, (step / 30) ** 2, (step / 70) ** 2))
    features = np.stack(
        [
            np.minimum(edge, _EDGE_CAP) / _EDGE_CAP,
            (edge > _EDGE_LIMIT).astype(np.float32),
            np.sqrt(np.maximum(square - mean**2, 0)) / _STEP_CAP,
            np.minimum(np.maximum(step, 0), _STEP_CAP) / _STEP_CAP,
            np.minimum(np.maximum(-step, 0), _STEP_CAP) / _STEP_CAP,
            np.minimum(chroma, _CHROMA_CAP) / _CHROMA_CAP,
            (step < -_DARK).astype(np.float32),
            like < 0.4,
        ],
        axis=-1,
    ).astype(np.float32)
    plants = (cells[..., 1] < _PLANTS_A) & (cells[..., 2] > _PLANTS_B)
    green = cv2.blur(plants.astype(np.float32), (spread,) * 2)
    return Ground(features, np.asarray(like, np.float32), np.asarray(green, np.float32))


def stall_features(ground: Ground, stalls: Stalls) -> FloatArray:
    """Return the mean features (N, F) within the inner part of each stall (pixels)."""
    inner = (np.abs(decode.sample_grid()) <= np.array(_INNER) / 2).all(axis=1)
    at = np.rint(decode.sample_points(stalls)[:, inner] / CELL_PIXELS).astype(np.intp)
    rows, columns = ground.like.shape
    row, column = np.clip(at[..., 1], 0, rows - 1), np.clip(at[..., 0], 0, columns - 1)
    return np.asarray(ground.features[row, column].mean(axis=1), np.float64)


def taken(ground: Ground, stalls: Stalls) -> FloatArray:
    """Return the probability (N,) of each stall (pixels) being taken."""
    return np.asarray(logistic(_TAKEN[0] + stall_features(ground, stalls) @ _TAKEN[1:]), np.float64)


def car_map(ground: Ground, cell_m: float) -> Map:
    """Return the probability (H, W) that a car stands at each cell, by what is within a car's width around it."""
    size = 2 * round(_CAR_M / cell_m / 2) + 1
    said = cv2.blur((ground.features @ _TAKEN[1:].astype(np.float32)), (size, size)) + _TAKEN[0]
    return np.asarray(logistic(said) * (1 - ground.green), np.float32)


def lot_map(ground: Ground, stalls: Stalls, cell_m: float) -> Map:
    """Return the probability (H, W) of lot: the rows, and what goes on from them like their asphalt.

    0.5 where no row is near: asphalt alone is as well a road's or a roof's.
    """
    drawn = np.ones(ground.like.shape, np.uint8)
    cv2.fillPoly(drawn, list(np.rint(stalls.corners() / CELL_PIXELS).astype(np.int32)), (0,))
    away = cv2.distanceTransform(drawn, cv2.DIST_L2, 5) * cell_m if len(stalls) else np.full(drawn.shape, np.inf)
    size = 2 * round(_LIKE_M / cell_m / 2) + 1
    like = cv2.blur(ground.like, (size, size))
    said = np.interp(like, _LIKE, _LOT)
    near = np.interp(away, _NEAR_M, (1.0, 0.0))
    return np.where(drawn == 0, _LOT[-1], 0.5 + (said - 0.5) * near).astype(np.float32)


def logistic(values: Any) -> Any:
    """Return 1 / (1 + exp(-values)), of the values' own type."""
    return 1 / (1 + np.exp(-values))


def _edges(lightness: NDArray[np.uint8]) -> Map:
    soft = cv2.GaussianBlur(lightness, (3, 3), 0)
    gx, gy = cv2.Sobel(soft, cv2.CV_32F, 1, 0, scale=0.25), cv2.Sobel(soft, cv2.CV_32F, 0, 1, scale=0.25)
    return np.asarray(cv2.magnitude(gx, gy), np.float32)


def _halved(values: Map, shape: tuple[int, ...]) -> Map:
    return np.asarray(cv2.resize(values, (shape[1], shape[0]), interpolation=cv2.INTER_AREA), np.float32)


def _asphalt(cells: NDArray[np.float32], valid: NDArray[np.bool_], stalls: Stalls) -> FloatArray:
    """Return the usual Lab colour (3,) of the ground in and before the stalls, of the whole picture without any."""
    if not len(stalls):
        return np.asarray(np.median(cells[valid], axis=0) if valid.any() else np.zeros(3))
    longer = Stalls(stalls.column, stalls.row, stalls.angle, stalls.width, stalls.length * 2, stalls.score)
    at = np.rint(decode.sample_points(longer).reshape(-1, 2) / CELL_PIXELS).astype(np.intp)
    rows, columns = valid.shape
    inside = (at >= 0).all(axis=1) & (at[:, 0] < columns) & (at[:, 1] < rows)
    at = at[inside]
    seen = cells[at[:, 1], at[:, 0]][valid[at[:, 1], at[:, 0]]]
    if not len(seen):
        return np.zeros(3)
    return np.array([_mode(seen[:, 0], 12.0), *np.median(seen[:, 1:], axis=0)])


def _mode(values: NDArray[np.float32], width: float) -> float:
    """Return where values (0..255) are densest."""
    count = np.bincount(values.astype(np.intp), minlength=256).astype(np.float32)
    return float(cv2.GaussianBlur(count.reshape(1, -1), (0, 0), width).argmax())

"""Targets of the network, drawn from a scene's stalls and masks."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hawk.algo.vision.detection import FloatArray
from hawk.algo.vision.network import (
    CELL_PIXELS,
    CORE_SHARE,
    OFFSET_CELLS,
    USUAL_LENGTH_M,
    USUAL_VEHICLE_M,
    USUAL_WIDTH_M,
    VEHICLE_KINDS,
)

LOT, CORE, CAR, SINE, COSINE, OFFSET_COLUMN, OFFSET_ROW, WIDTH, LENGTH, TAKEN = range(10)
"""Channels of the network's answer and of the targets."""
SHADE, COVER = 10, 11
"""Further channels of the answer: ground in shadow (what is shadow is no car), and crowns and roofs, which hide it."""
VEHICLE, KINDS = 12, 19
"""First channels of the answer about vehicles: core, direction, offset and size as of stalls, and one for each kind."""
SHAPE = (CORE, SINE, COSINE, OFFSET_COLUMN, OFFSET_ROW, WIDTH, LENGTH)
VEHICLE_SHAPE = tuple(range(VEHICLE, KINDS))
ANSWER_CHANNELS = KINDS + len(VEHICLE_KINDS)
PLACE_WEIGHT, CORE_WEIGHT, CAR_WEIGHT, SHADE_WEIGHT, COVER_WEIGHT, TAKEN_WEIGHT, VEHICLE_WEIGHT = range(
    ANSWER_CHANNELS, ANSWER_CHANNELS + 7
)
"""Further target channels (0/1): where lot, core and what hangs on it, cars, shade, cover, the stalls' states, and
vehicles are known.
"""
TARGET_CHANNELS = ANSWER_CHANNELS + 7
LABELS = 4
"""Layers of labels: lot, car, shade, cover."""
UNKNOWN = 2
"""Value of a label that is not known."""
CELL_M = 0.2
"""Side of an output cell, metres."""


def shape_of(quads: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return centre (N, 2), angle [0, pi), width and length of quads (N, 4, 2); the long side is the length."""
    along = (quads[:, 2] + quads[:, 3] - quads[:, 0] - quads[:, 1]) / 2
    across = (quads[:, 1] + quads[:, 2] - quads[:, 0] - quads[:, 3]) / 2
    length, width = np.hypot(*along.T), np.hypot(*across.T)
    swap = width > length
    along[swap] = across[swap]
    angle = np.arctan2(along[:, 1], along[:, 0]) % math.pi
    return quads.mean(axis=1), angle, np.minimum(length, width), np.maximum(length, width)


_LAYERS = ((LOT, PLACE_WEIGHT), (CAR, CAR_WEIGHT), (SHADE, SHADE_WEIGHT), (COVER, COVER_WEIGHT))


@dataclass(frozen=True, slots=True)
class VehicleLabels:
    """Vehicles of a scene: ``quads`` (M, 4, 2) pixels, ``kind`` (M,) index of `VEHICLE_KINDS`, ``judged`` (M,): False
    for what may be one or none.
    """

    quads: NDArray[np.float32]
    kind: NDArray[np.intp]
    judged: NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class TrainingScene:
    """A drawn scene, or a window of a real picture, as the trainer keeps it.

    ``image`` is BGR uint8 (H, W, 3) at 0.1 m; ``labels`` uint8 (H, W, `LABELS`), each 0, 1 or `UNKNOWN`;
    ``quads`` (N, 4, 2) pixels, whole numbers are pixel centres; ``taken`` (N,) and ``judged`` (N,): False where the
    picture does not show a stall. ``unclear`` (N,): states that are not known, None without any. ``seen`` (H, W): 0
    where it is not known whether there are stalls, None without such ground. ``cast`` (2,) is the shadow of one metre
    of height, metres along columns and rows, None where the sun is not known. ``vehicles``: None where nobody labelled
    them.
    """

    image: NDArray[np.uint8]
    labels: NDArray[np.uint8]
    quads: NDArray[np.float32]
    taken: NDArray[np.bool_]
    judged: NDArray[np.bool_]
    unclear: NDArray[np.bool_] | None = None
    seen: NDArray[np.uint8] | None = None
    cast: NDArray[np.float64] | None = None
    vehicles: VehicleLabels | None = None


def draw_targets(
    labels: NDArray[np.uint8],
    known: NDArray[np.uint8],
    stalls: NDArray[np.floating[Any]],
    taken: NDArray[np.bool_],
    judged: NDArray[np.bool_],
    unclear: NDArray[np.bool_] | None = None,
    vehicles: VehicleLabels | None = None,
) -> NDArray[np.float32]:
    """Return (TARGET_CHANNELS, H/2, W/2) for a crop.

    ``labels`` (H, W, `LABELS`) and ``known`` (H, W; where it is known what stalls there are) are in pixels, as are the
    ``stalls`` (N, 4, 2) of the crop; the rest as in `TrainingScene`.
    """
    half = labels[::CELL_PIXELS, ::CELL_PIXELS]
    shown = known[::CELL_PIXELS, ::CELL_PIXELS]
    target = np.zeros((TARGET_CHANNELS, *half.shape[:2]), np.float32)
    for layer, (channel, weight) in enumerate(_LAYERS):
        target[channel] = half[..., layer] == 1
        target[weight] = (half[..., layer] != UNKNOWN) & (shown > 0)
    target[CORE_WEIGHT] = shown
    usual = USUAL_WIDTH_M, USUAL_LENGTH_M
    rows, columns, mine = _draw_objects(target, SHAPE, CORE_WEIGHT, np.asarray(stalls, np.float64), judged, usual)
    target[TAKEN, rows, columns] = taken[mine]
    target[TAKEN_WEIGHT, rows, columns] = 1 if unclear is None else ~unclear[mine]
    if vehicles is not None:
        target[VEHICLE_WEIGHT] = shown
        rows, columns, mine = _draw_objects(
            target, VEHICLE_SHAPE, VEHICLE_WEIGHT, vehicles.quads.astype(np.float64), vehicles.judged, USUAL_VEHICLE_M
        )
        target[KINDS + vehicles.kind[mine], rows, columns] = 1
    return target


def _draw_objects(
    target: NDArray[np.float32],
    shape: tuple[int, ...],
    weight: int,
    quads: NDArray[np.float64],
    judged: NDArray[np.bool_],
    usual: tuple[float, float],
) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp]]:
    """Draw the cores of objects (N, 4, 2; pixels) into the channels ``shape``, sizes over the ``usual`` ones.

    Where one is not judged, the channel ``weight`` is 0. Returns row, column and object of each core cell.
    """
    core, sine, cosine, offset_column, offset_row, across, along = shape
    size = target.shape[1:]
    owner, ignored = np.zeros(size, np.int16), np.zeros(size, np.int16)
    centre, angle, width, length = shape_of(quads.reshape(-1, 4, 2) / CELL_PIXELS)
    for k in np.flatnonzero(judged).tolist():
        _mark(owner, centre[k], angle[k], width[k] * CORE_SHARE, length[k] * CORE_SHARE, k + 1)
    for k in np.flatnonzero(~judged).tolist():
        _mark(ignored, centre[k], angle[k], width[k], length[k], 1)
    target[weight][ignored > 0] = 0
    rows, columns = np.nonzero(owner)
    mine = owner[rows, columns].astype(np.intp) - 1
    target[core, rows, columns] = 1
    target[sine, rows, columns] = np.sin(2 * angle[mine])
    target[cosine, rows, columns] = np.cos(2 * angle[mine])
    target[offset_column, rows, columns] = (centre[mine, 0] - columns) / OFFSET_CELLS
    target[offset_row, rows, columns] = (centre[mine, 1] - rows) / OFFSET_CELLS
    target[across, rows, columns] = np.log(np.maximum(width[mine], 2) * CELL_M / usual[0])
    target[along, rows, columns] = np.log(np.maximum(length[mine], 4) * CELL_M / usual[1])
    return rows, columns, mine


def _mark(
    canvas: NDArray[np.int16], centre: NDArray[np.float64], angle: float, width: float, length: float, value: int
) -> None:
    """Set the cells whose middle is in a rectangle (polygon filling would add the cells on its edge)."""
    reach = (width + length) / 2
    size = (canvas.shape[1], canvas.shape[0])
    low = np.clip(np.floor(centre - reach), 0, size).astype(int)
    high = np.clip(np.ceil(centre + reach) + 1, 0, size).astype(int)
    columns = np.arange(low[0], high[0])[None, :] - centre[0]
    rows = np.arange(low[1], high[1])[:, None] - centre[1]
    along = columns * math.cos(angle) + rows * math.sin(angle)
    across = rows * math.cos(angle) - columns * math.sin(angle)
    inside = (np.abs(along) <= length / 2) & (np.abs(across) <= width / 2)
    canvas[low[1] : high[1], low[0] : high[0]][inside] = value

"""Where the inner parts of stalls may be: what completes rows over several frames asks for it.

It does not only draw the stalls that were found: every place with paint half a pitch to both sides counts, in the
direction and at the pitch of the frame's rows, so that worn lines add up over frames.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from hawk.algo.vision.classical.lattice import Row
from hawk.algo.vision.classical.paint import Map
from hawk.algo.vision.classical.strokes import View
from hawk.algo.vision.decode import Stalls
from hawk.algo.vision.network import CELL_PIXELS, CORE_SHARE

_ALONG_M = 2.6
_SURE = 0.4
_BETWEEN = 0.3
_PAINT_ALONE = 0.6


def core_map(views: Sequence[View], rows: Sequence[Sequence[Row]], stalls: Stalls, car: Map) -> Map:
    """Return the probability (H, W), in the cells of ``car``, that a cell lies in a stall's inner part.

    ``rows`` are those of each view, ``stalls`` (pixels) the candidates with their scores.
    """
    core = _drawn(stalls, car.shape)
    for view, some in zip(views, rows, strict=True):
        if some:
            pitch = float(np.median([row.pitch for row in some]))
            core = np.maximum(core, _between_lines(view, pitch, car))
    return core


def _drawn(stalls: Stalls, shape: tuple[int, ...]) -> Map:
    """Return the inner parts of stalls, each with its score; where two meet, the surer one."""
    core = np.zeros(shape, np.float32)
    order = np.argsort(stalls.score, kind="stable")
    corners = stalls.corners()[order] / CELL_PIXELS
    middle = corners.mean(axis=1, keepdims=True)
    inner = np.rint((middle + (corners - middle) * CORE_SHARE) * 16).astype(np.int32)
    for quad, score in zip(inner, stalls.score[order].tolist(), strict=True):
        cv2.fillConvexPoly(core, quad, score, shift=4)
    return core


def _between_lines(view: View, pitch: float, car: Map) -> Map:
    """Return the dense evidence of one view at one pitch, in cells of the picture."""
    ridge = cv2.resize(view.ridge, None, fx=1 / CELL_PIXELS, fy=1 / CELL_PIXELS, interpolation=cv2.INTER_AREA)
    cell = view.side * CELL_PIXELS
    ridge = cv2.blur(np.maximum(ridge, 0), (1, 2 * round(_ALONG_M / cell / 2) + 1))
    half = round(pitch / cell / 2)
    padded = cv2.copyMakeBorder(ridge, 0, 0, half, half, cv2.BORDER_CONSTANT, value=(0,))
    left, right = padded[:, : -2 * half], padded[:, 2 * half :]
    lines = (0.7 * np.minimum(left, right) + 0.3 * np.maximum(left, right)) / _SURE
    said = np.minimum(lines, 1) * (1 - np.minimum(ridge / _BETWEEN, 1)) * np.float32(_PAINT_ALONE)
    reach = (2 * round(CORE_SHARE * pitch / cell / 2) + 1, 2 * round(_ALONG_M / cell / 4) + 1)
    said = cv2.dilate(said, np.ones(reach[::-1], np.uint8))
    to_cells = view.to_picture.copy()
    to_cells[:, 2] /= CELL_PIXELS
    size = (car.shape[1], car.shape[0])
    return np.asarray(cv2.warpAffine(said, to_cells, size, flags=cv2.INTER_LINEAR), np.float32)

"""One frame's evidence on map cells, and the layers of one tile, as arrays or as bytes.

In bytes log-odds are rounded to a sixteenth, looks to a quarter, probabilities to 1/255. Rounding a rounded value
changes nothing, so that a tile that is evicted and loaded repeatedly stays as it is.
"""

from __future__ import annotations

import io
import math
import zipfile
import zlib
from dataclasses import dataclass, field, replace
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.ground import Window
from hawk.algo.vision.detection import FrameGround, GroundImage
from hawk.model.lot_map import TILE_M, Cell
from hawk.model.poses import MapPose

EVIDENCE_M = 0.2
"""Side of an evidence cell, metres."""
TILE_SIDE = round(TILE_M / EVIDENCE_M)
"""Evidence cells along one side of a tile."""

_SHAPE = (TILE_SIDE, TILE_SIDE)
_LOT_SCALE = 16.0
_LOOKS_SCALE = 4.0
_FRAME_LIMIT = 2.5  # log-odds that one frame may claim: the network is surer of itself than it should be

Floats = NDArray[np.float64]
Grid16 = NDArray[np.float16]
Grid32 = NDArray[np.float32]
GridU8 = NDArray[np.uint8]


@dataclass(slots=True)
class EvidenceLayers:
    """Layers (128, 128) from the tile's north-west corner.

    ``lot`` log-odds, ``core`` and ``car`` mean probabilities, ``looks`` independent looks so far, ``well`` 1 where the
    cell was seen in the good part of a picture, ``shown`` the `Cell` class without the stalls.
    """

    lot: Grid32 = field(default_factory=lambda: np.zeros(_SHAPE, np.float32))
    looks: Grid32 = field(default_factory=lambda: np.zeros(_SHAPE, np.float32))
    core: Grid16 = field(default_factory=lambda: np.zeros(_SHAPE, np.float16))
    car: Grid16 = field(default_factory=lambda: np.zeros(_SHAPE, np.float16))
    well: GridU8 = field(default_factory=lambda: np.zeros(_SHAPE, np.uint8))
    shown: GridU8 = field(default_factory=lambda: np.zeros(_SHAPE, np.uint8))

    def to_bytes(self) -> bytes:
        """Return the layers as bytes."""
        buffer = io.BytesIO()
        np.savez(
            buffer,
            lot=np.round(self.lot * _LOT_SCALE).astype(np.int8),
            looks=np.round(np.minimum(self.looks * _LOOKS_SCALE, 255)).astype(np.uint8),
            core=_to_byte(self.core),
            car=_to_byte(self.car),
            well=np.packbits(self.well),
            shown=self.shown,
        )
        return zlib.compress(buffer.getvalue(), 1)

    @classmethod
    def from_bytes(cls, data: bytes) -> EvidenceLayers:
        """Read the layers. Raises ValueError when the bytes are none."""
        try:
            with np.load(io.BytesIO(zlib.decompress(data)), allow_pickle=False) as arrays:
                layers = cls()
                layers.lot[:] = arrays["lot"] / np.float32(_LOT_SCALE)
                layers.looks[:] = arrays["looks"] / np.float32(_LOOKS_SCALE)
                layers.core[:] = arrays["core"] / np.float32(255)
                layers.car[:] = arrays["car"] / np.float32(255)
                layers.well[:] = np.unpackbits(arrays["well"]).reshape(layers.well.shape)
                layers.shown[:] = np.minimum(arrays["shown"], Cell.LOT)
        except (zlib.error, zipfile.BadZipFile, KeyError, ValueError, OSError, EOFError) as error:
            raise ValueError(f"not an evidence tile: {error}") from error
        return layers


def _to_byte(layer: Grid16) -> GridU8:
    return np.round(layer.astype(np.float32) * 255).astype(np.uint8)


@dataclass(frozen=True, slots=True)
class CellEvidence:
    """One frame's evidence on a window of map cells.

    ``lot`` is the frame's log-odds (limited), ``core`` and ``car`` probabilities, ``mask`` 0 not in the picture, 1 in
    it, 2 in its good part.
    """

    window: Window
    lot: Grid32
    core: Grid32
    car: Grid32
    mask: GridU8

    def in_picture(self, places: Floats) -> NDArray[np.bool_]:
        """Return True (N,) for the places (N, 2) of (north, east) that lie in the usable picture."""
        return np.asarray(self.window.values_at(self.mask, places) > 0)


def transform_points(affine: Floats, points: Floats) -> Floats:
    """Apply a (2, 3) affine of the map plane to points (..., 2)."""
    return np.asarray(points @ affine[:, :2].T + affine[:, 2])


def moved(image: GroundImage, correction: Floats) -> GroundImage:
    """Return the picture with its place corrected by a (2, 3) map-to-map affine."""
    to_map = correction[:, :2] @ image.to_map
    to_map[:, 2] += correction[:, 2]
    view = image.view
    if view is not None:
        back = np.linalg.inv(np.vstack([correction, (0.0, 0.0, 1.0)]))
        view = replace(view, to_image=view.to_image @ back)
    return replace(image, to_map=to_map, view=view)


def outline(image: GroundImage) -> Floats:
    """Return the corners (4, 2) of the whole picture on the ground, (north, east) metres."""
    rows, columns = image.valid.shape
    corners = np.array([[0, 0], [columns - 1, 0], [columns - 1, rows - 1], [0, rows - 1]], np.float64)
    return transform_points(image.to_map, corners)


def extent(image: GroundImage) -> tuple[tuple[float, float], float]:
    """Return the middle (north, east) of the picture on the ground, and the radius about it, metres."""
    corners = outline(image)
    middle = corners.mean(0)
    return (float(middle[0]), float(middle[1])), float(np.hypot(*(corners - middle).T).max())


def quality_mask(valid: NDArray[np.bool_], pixel_m: float, edge_m: float, good_share: float) -> NDArray[np.uint8]:
    """Return 0 outside the usable picture, 1 in it, 2 in its good middle.

    ``edge_m`` of the border are not usable; good is the middle ``good_share`` of the picture along each axis.
    """
    usable = _eroded(valid.astype(np.uint8), edge_m / pixel_m, edge_m / pixel_m)
    rows = np.flatnonzero(valid.any(1))
    columns = np.flatnonzero(valid.any(0))
    if len(rows) == 0:
        return usable
    trim = (1 - good_share) / 2
    good = _eroded(valid.astype(np.uint8), trim * (rows[-1] - rows[0] + 1), trim * (columns[-1] - columns[0] + 1))
    return np.asarray(usable + (good & usable), dtype=np.uint8)


def cell_evidence(seen: FrameGround, edge_m: float, good_share: float) -> CellEvidence | None:
    """Return the frame's evidence on map cells, None when nothing of the picture is usable."""
    mask = quality_mask(seen.lot.valid, seen.lot.metres_per_pixel, edge_m, good_share)
    if not mask.any():
        return None
    window = Window.around(outline(seen.lot), EVIDENCE_M)
    return CellEvidence(
        window=window,
        lot=log_odds(warp(seen.lot, seen.lot.values, window, cv2.INTER_LINEAR)),
        core=warp(seen.core, seen.core.values, window, cv2.INTER_LINEAR),
        car=warp(seen.car, seen.car.values, window, cv2.INTER_LINEAR),
        mask=warp(seen.lot, mask, window, cv2.INTER_NEAREST),
    )


def warp(image: GroundImage, values: NDArray[Any], window: Window, interpolation: int) -> NDArray[Any]:
    """Return ``values`` (of the geometry of ``image``) on the window's cells, 0 outside the picture."""
    size = (window.columns, window.rows)
    return cv2.warpAffine(values, window.affine(image.to_map), size, flags=interpolation)


def log_odds(probability: Grid32) -> Grid32:
    """Return one frame's log-odds, limited to what one frame may claim."""
    edge = np.float32(1 / (1 + np.exp(_FRAME_LIMIT)))
    p = np.clip(probability, edge, 1 - edge)
    return np.asarray(np.log(p / (1 - p)), dtype=np.float32)


def _eroded(mask: NDArray[np.uint8], rows: float, columns: float) -> NDArray[np.uint8]:
    kernel = np.ones((2 * int(np.ceil(rows)) + 1, 2 * int(np.ceil(columns)) + 1), np.uint8)
    return np.asarray(cv2.erode(mask, kernel, borderType=cv2.BORDER_CONSTANT, borderValue=0), dtype=np.uint8)


TURN: Final = 0.6
"""Turn on the spot, radians, after which a frame is an independent look: most of the picture shows other ground."""
MOST_STILL: Final = 0.5
"""Sum of all frames from one place after the first: they average its noise, and see nothing new."""


class Novelty:
    """Shares (0..1) of an independent look, from the places of the frames.

    A place counts once: a drone that hovers, swayed by the wind, learns nothing by swaying. Distance counts as far as
    the drone has got from the last independent look, not along its path.
    """

    def __init__(self, look_m: float, still_weight: float) -> None:
        """Make it.

        Args:
            look_m: Distance after which a frame is an independent look.
            still_weight: Share of a frame from the same place, until `MOST_STILL` is reached.
        """
        self._look_m = look_m
        self._still_weight = still_weight
        self._from: MapPose | None = None
        self._reached = self._still = 0.0

    def of(self, pose: MapPose) -> float:
        """Return the share of the frame from a pose, 0 from one that has shown all it can."""
        if self._from is None:
            self._begin(pose)
            return 1.0
        share = self._apart(self._from, pose)
        gained = max(0.0, share - self._reached)
        still = min(self._still_weight, MOST_STILL - self._still)
        self._reached, self._still = max(self._reached, share), self._still + still
        if share >= 1.0:
            self._begin(pose)
        return min(1.0, gained + still)

    def _begin(self, pose: MapPose) -> None:
        self._from, self._reached, self._still = pose, 0.0, 0.0

    def _apart(self, first: MapPose, second: MapPose) -> float:
        turn = abs(math.remainder(second.yaw - first.yaw, math.tau))
        return first.distance(second) / self._look_m + turn / TURN

"""A lot of any size, drawn by formula: what an earlier flight left of it, and what the next pictures show.

Rows of stalls run east, 17.4 m from one double row to the next; the known lot is a square about the origin, and beyond
its eastern side the lot goes on, not seen yet.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.ground import tile_window
from hawk.algo.mapper import delta
from hawk.algo.mapper.evidence import EVIDENCE_M
from hawk.algo.mapper.grid import EvidenceTile
from hawk.algo.mapper.table import FREE, STALL_DTYPE, TAKEN, Rows, corners_of, to_bytes
from hawk.algo.vision.detection import Detection, FrameGround, GroundImage
from hawk.model.lot_map import TILE_CELLS, TILE_M, Cell, TileKey
from hawk.model.poses import MapPose
from hawk.model.tile_picture import encode_picture

BEYOND_M: Final = 120.0
"""Extent of the lot east of the known part, metres."""
_PITCH_M, _WIDTH_M, _LENGTH_M = 17.4, 2.6, 5.2
_BLOCK = 18  # stalls between two cross aisles
_CROSS_M = 8.0
_LAYER_M, _PICTURE_M = 0.2, 0.1
_FOCAL, _COLUMNS, _ROWS = 914.0, 1280, 720

Floats = NDArray[np.float32]


class WideLot:
    """``hectares`` of it are known."""

    def __init__(self, hectares: float) -> None:
        self.half = math.sqrt(hectares * 1e4) / 2
        self._rng = np.random.default_rng(1)
        self.stalls = self._make_stalls()
        self._noise = self._rng.normal(0, 0.6, (256, 256)).astype(np.float32)
        texture = self._rng.normal(110, 14, (TILE_CELLS * 4, TILE_CELLS * 4, 3))
        self._texture = np.clip(cv2.GaussianBlur(texture, (3, 3), 0), 0, 255).astype(np.uint8)

    def parts(self) -> dict[str, bytes]:
        """Return the known part as the flight journal keeps it."""
        known = self.stalls[self.stalls["east"] < self.half]
        parts = {f"{delta.STALL}/{int(row['id'])}": to_bytes(row) for row in known}
        meta = delta.MapMeta("wide", 1, len(self.stalls) + 1, (0.0, 0.0, 0.0))
        parts[delta.META] = meta.to_bytes()
        for key in self._known_tiles():
            parts[delta.tile_name(delta.GRID, key)] = self._tile(key).to_bytes()
            parts[delta.tile_name(delta.MOSAIC, key)] = self._picture_tile()
        return parts

    def look(self, pose: MapPose, captured: float) -> FrameGround:
        """Return what a picture from there shows; the top of the picture is north."""
        shape = tuple(round(pose.height * n / _FOCAL / _LAYER_M) for n in (_ROWS, _COLUMNS))
        affine = _affine(pose, (shape[0], shape[1]), _LAYER_M)
        valid = np.ones(shape, np.bool_)
        near = self.stalls[np.hypot(self.stalls["north"] - pose.north, self.stalls["east"] - pose.east) < 60]
        lot = GroundImage(self._lot_values(affine, shape[0], shape[1]), affine, valid)
        core = GroundImage(_drawn(lot, near, 0.74), affine, valid)
        car = GroundImage(_drawn(lot, near[near["state"] == TAKEN], 0.8), affine, valid)
        picture = self._picture(pose)
        return FrameGround(_found(lot, near), lot, car, core, car, picture, pose, captured)

    def _make_stalls(self) -> Rows:
        along = np.arange(math.ceil((2 * self.half + BEYOND_M) / _WIDTH_M))
        east = -self.half + (along + 0.5) * _WIDTH_M + along // _BLOCK * _CROSS_M
        east = east[east < self.half + BEYOND_M]
        pairs = np.arange(math.ceil(2 * self.half / _PITCH_M)) * _PITCH_M - self.half + _PITCH_M / 2
        north = np.concatenate([pairs - _LENGTH_M / 2, pairs + _LENGTH_M / 2])
        places = np.stack(np.meshgrid(north, east, indexing="ij"), -1).reshape(-1, 2)
        rows = np.zeros(len(places), STALL_DTYPE)
        rows["id"] = np.arange(len(places)) + 1
        rows["north"], rows["east"] = places.T
        rows["cos2"], rows["width"], rows["length"] = 1.0, _WIDTH_M, _LENGTH_M
        rows["solidity"], rows["exists"], rows["looks"], rows["seen"] = 8.0, 4.0, 6.0, 12
        taken = self._rng.random(len(rows)) < 0.6
        rows["taken"], rows["state"] = np.where(taken, 3.0, -3.0), np.where(taken, TAKEN, FREE)
        rows["confirmed"], rows["version"], rows["touched"] = True, 1, 1
        return rows

    def _known_tiles(self) -> Iterator[TileKey]:
        reach = math.ceil(self.half / TILE_M)
        yield from ((row, column) for row in range(-reach, reach) for column in range(-reach, reach))

    def _tile(self, key: TileKey) -> EvidenceTile:
        window, tile = tile_window(key, EVIDENCE_M), EvidenceTile()
        layers = tile.layers
        north = -(window.row + np.arange(window.rows) + 0.5) * EVIDENCE_M
        east = (window.column + np.arange(window.columns) + 0.5) * EVIDENCE_M
        is_lot = (np.abs(north) < self.half)[:, None] & (np.abs(east) < self.half)[None]
        noise = self._noise[: window.rows, : window.columns]
        layers.lot[:] = np.where(is_lot, 3.0, -3.0) + noise
        layers.looks[:] = 6.0 + noise
        top = np.array([[-window.row * EVIDENCE_M, window.column * EVIDENCE_M]])
        affine = np.column_stack([[0.0, EVIDENCE_M], [-EVIDENCE_M, 0.0], top[0] + [-EVIDENCE_M / 2, EVIDENCE_M / 2]])
        image = GroundImage(layers.lot, affine, np.ones(layers.lot.shape, np.bool_))
        near = self.stalls[
            (np.abs(self.stalls["north"] - north.mean()) < TILE_M)
            & (np.abs(self.stalls["east"] - east.mean()) < TILE_M)
        ]
        layers.core[:] = np.clip(_drawn(image, near, 0.74) + noise / 10, 0, 1)
        layers.car[:] = np.clip(_drawn(image, near[near["state"] == TAKEN], 0.8) + noise / 10, 0, 1)
        layers.well[:] = 1
        layers.shown[:] = np.where(is_lot, Cell.LOT, Cell.NON_LOT)
        return tile

    def _picture_tile(self) -> bytes:
        top, left = (int(self._rng.integers(0, TILE_CELLS * 3)) for _ in range(2))
        pixels = self._texture[top : top + TILE_CELLS, left : left + TILE_CELLS]
        return encode_picture(pixels, np.full((TILE_CELLS, TILE_CELLS), 255, np.uint8))

    def _lot_values(self, affine: NDArray[np.float64], rows: int, columns: int) -> Floats:
        north = affine[0, 1] * np.arange(rows) + affine[0, 2]
        east = affine[1, 0] * np.arange(columns) + affine[1, 2]
        inside = (np.abs(north) < self.half)[:, None] & ((east > -self.half) & (east < self.half + BEYOND_M))[None]
        return np.where(inside, 0.95, 0.05).astype(np.float32)

    def _picture(self, pose: MapPose) -> GroundImage:
        shape = (round(pose.height * _ROWS / _FOCAL / _PICTURE_M), round(pose.height * _COLUMNS / _FOCAL / _PICTURE_M))
        pixels = self._texture[: shape[0], : shape[1]]
        return GroundImage(pixels, _affine(pose, shape, _PICTURE_M), np.ones(shape, np.bool_))


def _affine(pose: MapPose, shape: tuple[int, int], pixel_m: float) -> NDArray[np.float64]:
    origin = (pose.north + pixel_m * (shape[0] - 1) / 2, pose.east - pixel_m * (shape[1] - 1) / 2)
    return np.array([[0.0, -pixel_m, origin[0]], [pixel_m, 0.0, origin[1]]])


def _drawn(image: GroundImage, stalls: Rows, share: float) -> Floats:
    values = np.zeros(image.valid.shape, np.float32)
    corners = corners_of(stalls)
    centre = corners.mean(1, keepdims=True)
    for quad in np.round(image.pixel_points(centre + (corners - centre) * share) * 16).astype(np.int32):
        cv2.fillConvexPoly(values, quad, (0.95,), shift=4)
    return values


def _found(image: GroundImage, stalls: Rows) -> tuple[Detection, ...]:
    rows, columns = image.valid.shape
    pixels = image.pixel_points(corners_of(stalls))
    visible = ((pixels >= 0) & (pixels <= (columns - 1, rows - 1))).all(2).mean(1)
    return tuple(
        Detection(
            float(stall["north"]),
            float(stall["east"]),
            0.0,
            _WIDTH_M,
            _LENGTH_M,
            0.9,
            0.95 if stall["state"] == TAKEN else 0.05,
            float(share),
        )
        for stall, share in zip(stalls, visible, strict=True)
        if share >= 0.5
    )

"""Two real places side by side with a drive between them: a lot that goes on across other ground.

Pictures and labels are joined in memory. Each picture ends where its lots end on the side of the drive, so that nothing
but the drive lies between both.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import permutations
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.worlds.world import World

DRIVE_M: Final = (6.0, 8.0)
"""Least and largest width of the drive."""
LEAST_FACING_M: Final = 15.0
"""Least length along the drive over which both places have lot beside it."""
_BESIDE_M: Final = 12.0
_LANE_M: Final = 6.0
_GRASS: Final = (62, 96, 84)  # BGR
_NOISE: Final = 7.0
_TURNS: Final = 4

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class _Side:
    """A place turned by quarter turns and cut where its lots end in the east."""

    world: World

    @classmethod
    def of(cls, world: World, turns: int) -> _Side:
        turned = _turned(world, turns)
        end = max((float(shape[:, 0].max()) for shape in _shapes(turned)), default=turned.size_m[0])
        columns = min(round(end / turned.metres_per_pixel), turned.ground.shape[1])
        return cls(replace(turned, ground=np.ascontiguousarray(turned.ground[:, :columns])))

    @property
    def rows_beside(self) -> NDArray[np.bool_]:
        """Metres from the north where lot lies beside the eastern edge."""
        width, height = self.world.size_m
        drawn = np.zeros((int(height) + 1, int(width) + 1), np.uint8)
        cv2.fillPoly(drawn, [np.round(lot).astype(np.int32) for lot in self.world.lots], (1,))
        return np.asarray(drawn[:, -int(_BESIDE_M) :].any(axis=1))


def pair_of(places: Sequence[World], seed: int) -> World:
    """Return two of the places (two at least, of one scale) as one world, drawn by a seed.

    Labels that the edge of their picture cuts at the drive count: what is left of such a stall can be seen. Raises
    ValueError when no two of them face each other.
    """
    rng = np.random.default_rng(seed)
    couples = list(permutations(range(len(places)), 2))
    for couple in rng.permutation(len(couples)).tolist():
        west, east = (places[number] for number in couples[couple])
        for turns in rng.permutation(_TURNS * _TURNS).tolist():
            left, right = _Side.of(west, turns // _TURNS), _Side.of(east, turns % _TURNS)
            facing = _facing(left, right)
            if facing.sum() >= LEAST_FACING_M:
                return _joined(left, right, float(np.median(np.flatnonzero(facing))), rng, seed)
    raise ValueError("no two places have lots that face each other across a drive")


def _facing(left: _Side, right: _Side) -> NDArray[np.bool_]:
    """Return the metres from the north where both have lot beside the drive; the right one is turned to face it."""
    one, other = left.rows_beside, right.rows_beside[::-1]
    common = min(len(one), len(other))
    return np.asarray(one[:common] & other[:common])


def _joined(left: _Side, right: _Side, middle_m: float, rng: np.random.Generator, seed: int) -> World:
    """Return both with the drive between; the lane through a grass strip crosses it at ``middle_m`` from the north."""
    west, east = left.world, _turned(right.world, 2)
    scale = west.metres_per_pixel
    drive = _drive(west, middle_m, float(rng.uniform(*DRIVE_M)), rng, is_grass=bool(rng.integers(2)))
    rows = max(west.ground.shape[0], east.ground.shape[0])
    parts = [np.pad(part, ((0, rows - len(part)), (0, 0), (0, 0))) for part in (west.ground, drive, east.ground)]
    off = np.array([(west.ground.shape[1] + drive.shape[1]) * scale, 0.0])
    moved = [replace(stall, corners=stall.corners + off) for stall in east.stalls]
    stalls = tuple(replace(stall, id=number) for number, stall in enumerate([*west.stalls, *moved]))
    lots = (*west.lots, *(lot + off for lot in east.lots))
    name = f"pair {seed}, {west.name} and {east.name}"
    return replace(west, name=name, ground=np.hstack(parts), stalls=stalls, lots=lots, start_m=None, seed=seed)


def _drive(west: World, middle_m: float, width_m: float, rng: np.random.Generator, *, is_grass: bool) -> NDArray[Any]:
    """Return the picture of the drive (H, W, 3): asphalt, or grass with a lane across it."""
    scale, rows = west.metres_per_pixel, west.ground.shape[0]
    size = (rows, round(width_m / scale))
    asphalt = np.median(west.ground[west.ground.any(axis=2)], axis=0)
    colour = np.broadcast_to(np.array(_GRASS if is_grass else asphalt, np.float64), (*size, 3)).copy()
    if is_grass:
        lane = slice(max(round((middle_m - _LANE_M / 2) / scale), 0), round((middle_m + _LANE_M / 2) / scale))
        colour[lane] = asphalt
    return np.clip(colour + rng.normal(0.0, _NOISE, (*size, 1)), 0, 255).astype(np.uint8)


def _turned(world: World, turns: int) -> World:
    """Return the world turned by quarter turns, counter-clockwise."""
    for _ in range(turns):
        width = world.size_m[0]
        world = replace(
            world,
            ground=np.ascontiguousarray(np.rot90(world.ground)),
            stalls=tuple(replace(stall, corners=_quarter(stall.corners, width)) for stall in world.stalls),
            lots=tuple(_quarter(lot, width) for lot in world.lots),
            start_m=None,
        )
    return world


def _quarter(points: Floats, width_m: float) -> Floats:
    return np.column_stack([points[:, 1], width_m - points[:, 0]])


def _shapes(world: World) -> list[Floats]:
    return [*world.lots, *(stall.corners for stall in world.stalls)]

"""A lot of three hectares to fly over, drawn and written as a picture with its truth."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import cv2
import numpy as np
import shapely

from benchmarks.frames import camera_model
from hawk.worlds.camera import WorldCamera
from hawk.worlds.generate import WorldOptions, generate_world
from hawk.worlds.world import World

SIDE_M: Final = 300.0
SCALE: Final = 0.1
"""Metres a pixel: as fine as the camera sees from 45 m."""
ALTITUDE_M: Final = 3000.0
"""From so high a car of 2 m leans by 10 cm at the edge of the picture."""
HECTARES: Final = (2.7, 3.3)
ATTEMPTS: Final = 60


@dataclass(frozen=True, slots=True)
class DrawnLot:
    """Files of a drawn lot; ``hectares`` of all its parts, ``stalls`` in it."""

    picture: Path
    truth: Path
    hectares: float
    stalls: int


def draw_lot(seed: int, folder: Path) -> DrawnLot:
    """Draw the first world from this seed on whose lots have some three hectares, as seen from far above."""
    options = WorldOptions(
        width=(SIDE_M, SIDE_M), height=(SIDE_M, SIDE_M), metres_per_pixel=SCALE, stalls=(300, 3000), difficult=0.0
    )
    for number in range(seed, seed + ATTEMPTS):
        world = generate_world(number, options)
        if HECTARES[0] <= _hectares(world) <= HECTARES[1]:
            return _write(world, folder)
    raise AssertionError(f"no lot of three hectares among {ATTEMPTS} seeds from {seed} on")


def _hectares(world: World) -> float:
    return float(shapely.union_all([shapely.Polygon(lot).buffer(0) for lot in world.lots]).area) / 1e4


def _write(world: World, folder: Path) -> DrawnLot:
    folder.mkdir(parents=True, exist_ok=True)
    side = round(SIDE_M / SCALE)
    camera = camera_model(side, side, ALTITUDE_M / SCALE)
    middle = SIDE_M / 2
    seen = WorldCamera(world, camera).render(middle, middle, ALTITUDE_M, 0.0, 0.0, 0.0, rng=np.random.default_rng(1))
    picture, truth = folder / "lot.png", folder / "lot.json"
    cv2.imwrite(str(picture), seen)
    truth.write_text(json.dumps(world.truth_json()), encoding="utf-8")
    return DrawnLot(picture, truth, _hectares(world), len(world.stalls))

"""Looks of drawn scenes with real ground, leaves and cars (`training.textures`).

Sizes and labels stay those of the drawing: ground keeps the drawn brightness, and paving the drawn colour, by which
paint counts as visible; a car or crown is opaque where the drawn one is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import cv2
import numpy as np

from hawk.worlds.plan import Vehicle
from hawk.worlds.scene.canvas import Bytes, Floats, as_bytes, as_floats
from hawk.worlds.scene.cars import Sprite, VehicleModel
from hawk.worlds.scene.facets import HeightLayer
from hawk.worlds.scene.light import Sun
from hawk.worlds.scene.materials import Material
from hawk.worlds.scene.render import AS_DRAWN, Looks
from training.ground import METRES_PER_PIXEL
from training.textures import SHEET_PIXELS, CarPicture, Sheet, Textures

_CAR_KINDS: Final = ("sedan", "hatch", "suv", "minivan")
_CAR_SHARE: Final = 0.75
"""Share of the cars of these kinds that a real one replaces: the others keep shapes that the pictures lack."""
_UNDER_ROOF: Final = (34.0, 31.0, 29.0)
"""Blue, green, red of what a roof hides: glass in the dark."""
_PAVED: Final = ("asphalt", "concrete", "pavers", "clinker", "grass grid", "gravel")
_LOW_PIXELS: Final = 16
_LEAF_LIGHT_M: Final = 0.25
_EXPOSURE: Final = (-0.3, 0.25)


@dataclass(frozen=True, slots=True)
class Dress:
    """A share (0..1) of the scenes that look as real ground does, and the textures by which they do."""

    textures: Textures
    share: float

    def looks(self, seed: int, index: int) -> Looks:
        """Return the looks of a scene. Its drawing has numbers of its own: its labels do not depend on its looks."""
        rng = np.random.default_rng((seed, index, 1))
        return RealLooks(self.textures, rng) if rng.random() < self.share else AS_DRAWN


class RealLooks(Looks):
    """The textures as they look in one scene; the same generator state gives the same looks."""

    def __init__(self, textures: Textures, rng: np.random.Generator) -> None:
        self._textures = textures
        self._rng = rng
        self._exposure = np.float32(np.exp(rng.uniform(*_EXPOSURE)))
        self._leaves = _picked(textures.leaves, rng)
        self._hue = np.float32(rng.uniform())
        bare, plants = textures.grass, (*textures.grass, *textures.wild)
        kinds = {"grass": plants, "dirt": bare, "bark": textures.wild, "rock": textures.wild}
        self._sheets = {**dict.fromkeys(_PAVED, textures.paving), **kinds}
        self._grounds: dict[Material, Sheet | None] = {}

    def ground(self, material: Material, picture: Floats, metres_per_pixel: float) -> Floats:
        """Give ground the structure of real ground, and grass a part of its hue too."""
        if material not in self._grounds:
            self._grounds[material] = _picked(self._sheets.get(material.kind, ()), self._rng)
        sheet = self._grounds[material]
        if sheet is None:
            return picture
        height, width = picture.shape[:2]
        coarse = (max(1, width // _LOW_PIXELS), max(1, height // _LOW_PIXELS))
        low = cv2.resize(cv2.resize(picture, coarse, interpolation=cv2.INTER_AREA), (width, height))
        if material.kind == "grass":
            low = low * self._tinted(sheet, np.asarray(material.colour, np.float32))
        return as_floats(low * self._part(sheet, height, width, metres_per_pixel))

    def crown(self, layers: list[HeightLayer]) -> list[HeightLayer]:
        """Give leaves the structure and a part of the hue of real ones; the light on them stays."""
        return layers if self._leaves is None else [self._leafed(layer, self._leaves) for layer in layers]

    def _leafed(self, layer: HeightLayer, leaves: Sheet) -> HeightLayer:
        rows, columns = layer.pixels.shape[:2]
        scale = float(np.linalg.norm(layer.corners[1] - layer.corners[0])) / columns
        drawn = layer.pixels[..., :3].astype(np.float32)
        light = cv2.GaussianBlur(drawn, (0, 0), _LEAF_LIGHT_M / scale) * self._tinted(leaves, drawn.mean((0, 1)))
        pixels = layer.pixels.copy()
        pixels[..., :3] = np.clip(light * self._part(leaves, rows, columns, scale), 0, 255)
        return replace(layer, pixels=pixels)

    def _tinted(self, sheet: Sheet, colour: Floats) -> Floats:
        """Return the gain (3,) that gives a colour a part of the hue of a sheet, and leaves its brightness."""
        real = sheet.colour / sheet.colour.mean() * max(float(colour.mean()), 1.0) / np.maximum(colour, 1)
        return as_floats(1 + self._hue * (real - 1))

    def vehicle(self, vehicle: Vehicle, model: VehicleModel, sun: Sun) -> VehicleModel:
        """Return a real car in place of a drawn one, of its size and outline, lit from the scene's sun."""
        if vehicle.kind not in _CAR_KINDS or not self._textures.cars or self._rng.random() > _CAR_SHARE:
            return model
        car = self._textures.cars[int(self._rng.integers(len(self._textures.cars)))]
        body, roof = model.sprites
        rows, columns = body.pixels.shape[:2]
        shown = cv2.resize(_lit_from(car, vehicle, sun), (columns, rows), interpolation=cv2.INTER_AREA)
        shown = np.clip(shown * self._exposure, 0, 255).astype(np.uint8)
        high, wide = roof.pixels.shape[:2]
        left = round((columns - wide) / 2 + roof.along * columns / model.length)
        top = (rows - high) // 2
        under = slice(max(top, 0), top + high), slice(max(left, 0), left + wide)
        top_of_car = cv2.resize(shown[under], (wide, high), interpolation=cv2.INTER_LINEAR)
        shown[under] = _UNDER_ROOF
        return replace(model, sprites=(_with_picture(body, shown), _with_picture(roof, as_bytes(top_of_car))))

    def _part(self, sheet: Sheet, height: int, width: int, metres_per_pixel: float) -> Floats:
        """Return a random part of a sheet at another scale."""
        scale = metres_per_pixel / METRES_PER_PIXEL
        rows, columns = round(height * scale) or 1, round(width * scale) or 1
        row, column = self._rng.integers(SHEET_PIXELS, size=2).tolist()
        part = sheet.variation.take(np.arange(row, row + rows), 0, mode="wrap")
        part = part.take(np.arange(column, column + columns), 1, mode="wrap")
        if (rows, columns) == (height, width):
            return as_floats(part)
        how = cv2.INTER_AREA if scale > 1 else cv2.INTER_LINEAR
        return as_floats(cv2.resize(as_floats(part), (width, height), interpolation=how))


def _picked(sheets: Sequence[Sheet], rng: np.random.Generator) -> Sheet | None:
    return sheets[int(rng.integers(len(sheets)))] if sheets else None


def _lit_from(car: CarPicture, vehicle: Vehicle, sun: Sun) -> Bytes:
    """Return a car's picture, mirrored so that its lit side is the scene's."""
    if car.light is None:
        return car.pixels
    ahead = np.array([np.cos(vehicle.heading), np.sin(vehicle.heading)])
    towards = -np.array(sun.shadow)
    light = towards @ ahead, towards @ np.array([-ahead[1], ahead[0]])
    along, across = (-1 if light[k] * car.light[k] < 0 else 1 for k in (0, 1))
    return car.pixels[::across, ::along]


def _with_picture(sprite: Sprite, picture: Bytes) -> Sprite:
    pixels = sprite.pixels.copy()
    pixels[..., :3] = picture
    return replace(sprite, pixels=pixels)

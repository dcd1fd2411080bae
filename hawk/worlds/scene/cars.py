"""Vehicles from above: pictures at the heights of body and roof."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np

from hawk.worlds.plan import Vehicle
from hawk.worlds.scene.canvas import Bytes, Floats, Points, noise
from hawk.worlds.scene.light import Sun

SPRITE_M = 0.05
"""Metres per pixel of a vehicle's picture."""

_PAINTS = (
    *((238, 238, 236),) * 6, *((215, 216, 216),) * 2, *((22, 22, 24),) * 4, *((38, 37, 36),) * 3, *((75, 74, 72),) * 3,
    *((112, 110, 107),) * 3, *((160, 160, 157),) * 3, *((190, 188, 184),) * 2, (38, 34, 120), (30, 28, 165),
    (40, 40, 200),
    (100, 62, 32), (150, 75, 35), (70, 42, 26), (130, 90, 50), (60, 72, 50), (140, 165, 178), (62, 85, 112),
    (60, 120, 200), (60, 140, 90),
)  # fmt: skip
_SHARES = {
    "stall": {
        "sedan": 0.36, "suv": 0.31, "hatch": 0.12, "pickup": 0.11, "van": 0.05, "minivan": 0.03, "motorcycle": 0.012,
        "lorry": 0.008,
    },
    "aisle": {"sedan": 0.4, "suv": 0.3, "hatch": 0.1, "pickup": 0.1, "van": 0.06, "motorcycle": 0.02, "lorry": 0.02},
    "road": {
        "sedan": 0.36, "suv": 0.27, "hatch": 0.1, "pickup": 0.1, "van": 0.07, "lorry": 0.07, "motorcycle": 0.03,
    },
    "yard": {"sedan": 0.15, "suv": 0.1, "van": 0.25, "lorry": 0.4, "pickup": 0.1},
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Shape:
    """Length, width, roof height (metres); ends of the front and rear glass (shares of the length from the tail)."""

    length: float
    width: float
    height: float
    screen: tuple[float, float]
    rear: tuple[float, float]


_SHAPES = {
    "sedan": Shape(4.65, 1.82, 1.45, (0.60, 0.72), (0.14, 0.25)),
    "hatch": Shape(4.0, 1.75, 1.5, (0.62, 0.76), (0.03, 0.10)),
    "suv": Shape(4.75, 1.92, 1.72, (0.64, 0.75), (0.04, 0.10)),
    "minivan": Shape(5.1, 1.98, 1.75, (0.70, 0.83), (0.03, 0.08)),
    "pickup": Shape(5.6, 2.0, 1.85, (0.58, 0.68), (0.41, 0.45)),
    "van": Shape(5.5, 2.05, 2.4, (0.84, 0.92), (0.0, 0.0)),
    "lorry": Shape(7.8, 2.4, 3.1, (0.90, 0.95), (0.0, 0.0)),
    "motorcycle": Shape(2.1, 0.8, 1.1, (0.0, 0.0), (0.0, 0.0)),
    "motorhome": Shape(6.9, 2.3, 2.9, (0.90, 0.95), (0.0, 0.0)),
    "coach": Shape(12.2, 2.55, 3.3, (0.965, 0.985), (0.0, 0.0)),
    "trailer": Shape(13.6, 2.55, 3.9, (0.0, 0.0), (0.0, 0.0)),
}
_CARGO = {"lorry": 0.76, "van": 0.82, "motorhome": 0.84, "coach": 0.96, "trailer": 1.0}
"""Share of the length under the high part of a box-shaped vehicle."""
LONG_KINDS = ("lorry", "motorhome", "coach", "trailer")
"""Kinds that reach beyond a stall."""


@dataclass(frozen=True, slots=True)
class Sprite:
    """A picture at one height: BGRA uint8 with its centre at ``along`` metres ahead of the vehicle's centre."""

    pixels: Bytes
    height: float
    along: float
    fine: bool = False


@dataclass(frozen=True, slots=True)
class VehicleModel:
    """A drawn vehicle: size in metres and its pictures from low to high. The pictures' x axis points ahead."""

    length: float
    width: float
    height: float
    sprites: tuple[Sprite, ...]


def sample_kind(rng: np.random.Generator, place: str) -> str:
    """Draw a kind of vehicle for a place: stall, aisle, road or yard."""
    shares = _SHARES[place]
    weights = np.array(list(shares.values()))
    return str(list(shares)[int(np.searchsorted(np.cumsum(weights / weights.sum()), rng.random()))])


def draw_vehicle(rng: np.random.Generator, kind: str) -> VehicleModel:
    """Draw one vehicle of a kind. Raises KeyError for an unknown one."""
    shape = _SHAPES[kind]
    length, width = shape.length * rng.uniform(0.93, 1.07), shape.width * rng.uniform(0.96, 1.05)
    if kind == "lorry":
        length *= rng.choice([0.85, 1.0, 1.25])
    height = shape.height * rng.uniform(0.95, 1.05)
    if kind == "motorcycle":
        return _motorcycle(rng, length, width, height)
    paint = _paint(rng, kind)
    if kind in _CARGO:
        return _box_vehicle(rng, kind, shape, length, width, height, paint)
    return _car(rng, kind, shape, length, width, height, paint)


def dimmed(rng: np.random.Generator, model: VehicleModel) -> VehicleModel:
    """Return a dark vehicle whose glass, roof and body hardly differ, as in a low sun or a poor picture."""
    colour = rng.uniform(14, 62) * np.array([1 + rng.uniform(0, 0.5), 1.0, 1 - rng.uniform(-0.1, 0.3)])
    detail = rng.uniform(0.1, 0.6)
    sprites = []
    for sprite in model.sprites:
        pixels = sprite.pixels.copy()
        shape = pixels[..., :3].mean(axis=2, keepdims=True)
        shape = (shape - np.median(shape)) * detail
        pixels[..., :3] = np.clip(colour + shape, 3, 250).astype(np.uint8)
        sprites.append(replace(sprite, pixels=pixels))
    return replace(model, sprites=tuple(sprites))


def length_m(kind: str) -> float:
    """Return the usual length (metres) of a kind of vehicle."""
    return _SHAPES[kind].length


def footprint_m(vehicle: Vehicle) -> Points:
    """Return the four ground corners (metres) of a vehicle of its kind's usual size."""
    shape = _SHAPES[vehicle.kind]
    return outline(vehicle.x, vehicle.y, vehicle.heading, shape.length, shape.width)


def outline(x: float, y: float, heading: float, length: float, width: float) -> Points:
    """Return the four ground corners (metres) of a rectangle about a centre."""
    ahead = np.array([math.cos(heading), math.sin(heading)]) * length / 2
    aside = np.array([-math.sin(heading), math.cos(heading)]) * width / 2
    corners: Points = np.array([x, y]) + np.array([ahead + aside, ahead - aside, -ahead - aside, -ahead + aside])
    return corners


def _paint(rng: np.random.Generator, kind: str) -> Floats:
    if kind in _CARGO and rng.random() < 0.65:
        base = np.array((235.0, 235.0, 235.0))
    else:
        base = np.array(_PAINTS[int(rng.integers(len(_PAINTS)))], float)
    return np.clip(base * rng.uniform(0.85, 1.1) + rng.normal(0, 5, 3), 5, 250).astype(np.float32)


def _car(
    rng: np.random.Generator, kind: str, shape: Shape, length: float, width: float, height: float, paint: Floats
) -> VehicleModel:
    rows, columns = max(8, round(width / SPRITE_M)), max(16, round(length / SPRITE_M))
    body = _blank(rows, columns, paint)
    _shade(rng, body)
    roof0 = {"sedan": 0.26, "hatch": 0.12, "suv": 0.11, "minivan": 0.09, "pickup": 0.455}[kind]
    glass = _glass(rng)
    _wedge(body, shape.screen[0], shape.screen[1], 0.37, 0.43, glass)
    _wedge(body, shape.rear[0], shape.rear[1], 0.40 if kind != "pickup" else 0.37, 0.37, glass)
    _side_glass(body, roof0, shape.screen, glass * 0.9)
    if kind == "pickup":
        _bed(rng, body, paint)
    _reflections(rng, body, shape)
    _wedge(body, roof0 + 0.01, shape.screen[0] - 0.005, 0.35, 0.35, glass * 0.7)  # what the roof hides
    _seams(rng, body, paint)
    lamps = rng.uniform(120, 235)
    for side in (-0.34, 0.34):
        _dot(body, 0.975, side, (lamps, lamps, lamps))
        _dot(body, 0.015, side, (40.0, 40.0, rng.uniform(90, 190)))
    sprites = [Sprite(_with_alpha(body, _round(rows, columns, rng.uniform(0.24, 0.38))), 0.7, 0.0)]
    sprites.append(_roof_sprite(rng, paint, roof0, shape.screen[0], length, width, height))
    return VehicleModel(length, width, height, tuple(sprites))


def _roof_sprite(
    rng: np.random.Generator, paint: Floats, start: float, end: float, length: float, width: float, height: float
) -> Sprite:
    span = (end - start) * length
    rows, columns = max(6, round(0.72 * width / SPRITE_M)), max(6, round(span / SPRITE_M))
    bright = rng.uniform(0.98, 1.18) if paint.mean() > 40 else rng.uniform(1.0, 1.6)
    top = _blank(rows, columns, np.clip(paint * bright, 6, 252).astype(np.float32))
    across = np.linspace(-1, 1, rows, dtype=np.float32)[:, None, None]
    top *= 1 - 0.12 * np.abs(across) ** 3 + 0.08 * np.float32(rng.uniform(-1, 1)) * across
    if rng.random() < 0.3:  # sunroof
        _wedge(
            top, 0.5, rng.uniform(0.75, 0.92), 0.34, 0.34, np.array([40, 36, 33], np.float32) * rng.uniform(0.5, 1.6)
        )
    if rng.random() < 0.25:  # rails
        level = rng.uniform(20, 190)
        for side in (0.06, 0.93):
            y = int(rows * side)
            cv2.line(top, (2, y), (columns - 3, y), (level, level, level), 1)
    alpha = _round(rows, columns, 0.25)
    return Sprite(_with_alpha(top, alpha), height, ((start + end) / 2 - 0.5) * length)


def _box_vehicle(
    rng: np.random.Generator, kind: str, shape: Shape, length: float, width: float, height: float, paint: Floats
) -> VehicleModel:
    rows, columns = round(width / SPRITE_M), round(length / SPRITE_M)
    body = _blank(rows, columns, paint)
    _shade(rng, body)
    _wedge(body, shape.screen[0], shape.screen[1], 0.40, 0.36, _glass(rng))
    low = Sprite(_with_alpha(body, _round(rows, columns, 0.14)), 0.9, 0.0)
    share = _CARGO[kind]
    cargo = paint if kind not in ("lorry", "trailer") or rng.random() < 0.4 else _paint(rng, "van")
    sprites = [low]
    for level, shadow in ((0.45, 0.55), (0.7, 0.6), (1.0, 1.0)):
        top = _blank(rows, round(columns * share), cargo * np.float32(shadow))
        if level == 1.0:
            top *= 1 + noise(rng, top.shape[0], top.shape[1], [20, 4], [0.03, 0.02])[..., None]
            for u in np.arange(0.08, 1, rng.uniform(0.08, 0.3)):
                x = int(u * top.shape[1])
                cv2.line(top, (x, 1), (x, rows - 2), tuple(map(float, cargo * rng.uniform(0.8, 0.97))), 1)
        place = (share / 2 - 0.5) * length
        sprites.append(
            Sprite(_with_alpha(top, _round(top.shape[0], top.shape[1], 0.06)), height * level, place, level == 0.45)
        )
    return VehicleModel(length, width, height, tuple(sprites))


def _motorcycle(rng: np.random.Generator, length: float, width: float, height: float) -> VehicleModel:
    rows, columns = round(width / SPRITE_M), round(length / SPRITE_M)
    alpha = np.zeros((rows, columns), np.uint8)
    cv2.ellipse(
        alpha, (columns // 2, rows // 2), (columns // 2 - 1, max(2, rows // 5)), 0, 0, 360, 255, -1, cv2.LINE_AA
    )
    cv2.line(alpha, (int(columns * 0.74), 1), (int(columns * 0.74), rows - 2), 255, 2)
    body = _blank(rows, columns, _paint(rng, "motorcycle") * np.float32(0.8))
    _wedge(body, 0.2, 0.5, 0.2, 0.2, np.array([30, 28, 26], np.float32))
    return VehicleModel(length, width, height, (Sprite(_with_alpha(body, alpha), 0.8, 0.0),))


def _blank(rows: int, columns: int, colour: Floats) -> Floats:
    picture = np.empty((rows, columns, 3), np.float32)
    picture[:] = colour
    return picture


def _with_alpha(picture: Floats, alpha: Bytes) -> Bytes:
    soft = cv2.blur(picture, (2, 2))
    pixels: Bytes = np.dstack([np.clip(soft, 0, 255).astype(np.uint8), alpha])
    return pixels


def _round(rows: int, columns: int, share: float) -> Bytes:
    """Return the alpha of a rectangle with rounded corners (radius as a share of the shorter side)."""
    radius = max(1, int(min(rows, columns) * share))
    alpha = np.zeros((rows, columns), np.uint8)
    cv2.rectangle(alpha, (radius, 0), (columns - radius - 1, rows - 1), 255, -1)
    cv2.rectangle(alpha, (0, radius), (columns - 1, rows - radius - 1), 255, -1)
    for x in (radius, columns - radius - 1):
        for y in (radius, rows - radius - 1):
            cv2.circle(alpha, (x, y), radius, 255, -1, cv2.LINE_AA)
    return alpha


def _shade(rng: np.random.Generator, body: Floats) -> None:
    """Round the flanks, let bonnet and boot catch the sky differently, and let the lacquer mirror it."""
    body += np.array([34, 25, 18], np.float32) * np.float32(rng.uniform(0, 1.3))
    across = np.linspace(-1, 1, body.shape[0], dtype=np.float32)[:, None, None]
    along = np.linspace(0, 1, body.shape[1], dtype=np.float32)[None, :, None]
    sun, ends = np.float32(rng.uniform(-0.18, 0.18)), np.float32(rng.uniform(-0.14, 0.14))
    body *= 1 - 0.24 * np.abs(across) ** 3 + sun * across + ends * np.sign(along - 0.5)
    for _ in range(int(rng.integers(0, 4))):  # bright streaks along the shoulders
        middle, spread = rng.choice([-0.68, 0.68, rng.uniform(-0.8, 0.8)]), rng.uniform(0.04, 0.14)
        start = rng.uniform(0.05, 0.7)
        inside = (along > start) & (along < start + rng.uniform(0.12, 0.4))
        body += (
            np.exp(-(((across - np.float32(middle)) / np.float32(spread)) ** 2))
            * inside
            * np.float32(rng.uniform(15, 90))
        )


def _glass(rng: np.random.Generator) -> Floats:
    if rng.random() < 0.1:
        return np.array([172, 165, 160], np.float32)
    return np.clip(np.array([48, 43, 40]) * rng.uniform(0.5, 1.7) + rng.normal(0, 5, 3), 8, 140).astype(np.float32)


def _wedge(picture: Floats, x0: float, x1: float, half0: float, half1: float, colour: Floats) -> None:
    """Fill a trapezium: shares of the length, half widths at both ends as shares of the width."""
    rows, columns = picture.shape[:2]
    corners = [(x0, 0.5 - half0), (x1, 0.5 - half1), (x1, 0.5 + half1), (x0, 0.5 + half0)]
    points = np.array([(round(x * columns), round(y * rows)) for x, y in corners], np.int32)
    cv2.fillConvexPoly(picture, points, tuple(map(float, np.clip(colour, 0, 255))))


def _side_glass(picture: Floats, roof0: float, screen: tuple[float, float], colour: Floats) -> None:
    rows, columns = picture.shape[:2]
    for side in (-1, 1):
        corners = [(roof0, 0.36), (screen[0], 0.36), (screen[1], 0.445), (roof0 - 0.05, 0.445)]
        points = [(round(x * columns), round((0.5 + side * y) * rows)) for x, y in corners]
        cv2.fillConvexPoly(picture, np.array(points, np.int32), tuple(map(float, colour)))


def _bed(rng: np.random.Generator, picture: Floats, paint: Floats) -> None:
    inner = paint * rng.uniform(0.3, 0.75) if rng.random() < 0.7 else np.full(3, rng.uniform(20, 60), np.float32)
    _wedge(picture, 0.04, 0.395, 0.40, 0.40, np.asarray(inner, np.float32))
    if rng.random() < 0.2:
        _wedge(
            picture,
            0.08,
            rng.uniform(0.2, 0.36),
            0.3,
            0.3,
            np.asarray(rng.uniform(30, 210) + rng.normal(0, 12, 3), np.float32),
        )


def _reflections(rng: np.random.Generator, picture: Floats, shape: Shape) -> None:
    """Let the sky shine in the screens: often lighter than a dark body."""
    if rng.random() < 0.45:
        return
    level = np.float32(rng.uniform(35, 130))
    for start, end in (shape.screen, shape.rear):
        if rng.random() < 0.2:
            continue
        x0, x1 = int(start * picture.shape[1]), int(end * picture.shape[1])
        y0, y1 = int(picture.shape[0] * rng.uniform(0.1, 0.4)), int(picture.shape[0] * rng.uniform(0.6, 0.9))
        part = picture[y0:y1, x0:x1]
        part += (np.array([level * 1.12, level, level * 0.94], np.float32) - part) * np.float32(rng.uniform(0.3, 0.9))


def _seams(rng: np.random.Generator, picture: Floats, paint: Floats) -> None:
    rows, columns = picture.shape[:2]
    for u in rng.uniform(0.76, 0.97, int(rng.integers(0, 3))):
        x = int(u * columns)
        cv2.line(picture, (x, int(rows * 0.12)), (x, int(rows * 0.88)), tuple(map(float, paint * 0.78)), 1)


def _dot(picture: Floats, u: float, side: float, colour: tuple[float, float, float]) -> None:
    x, y = int(u * picture.shape[1]), int((0.5 + side) * picture.shape[0])
    cv2.rectangle(picture, (x - 1, y - 2), (x + 1, y + 2), colour, -1)


class ShadowsAmong:
    """The vehicles of a place, as what stands between others and the sun."""

    def __init__(self, drawn: Sequence[tuple[Vehicle, VehicleModel]], sun: Sun) -> None:
        self._sun = sun
        self._blocks = [
            (vehicle, outline(vehicle.x, vehicle.y, vehicle.heading, model.length, model.width), model.height)
            for vehicle, model in (drawn if sun.is_low else ())
        ]
        self._places = np.array([(vehicle.x, vehicle.y) for vehicle, _, _ in self._blocks]).reshape(-1, 2)
        self._reaches = np.array([height * sun.reach + 8.0 for _, _, height in self._blocks])

    def gain(self, of: Vehicle, places: Points, height: float) -> Floats:
        """Return the gain (..., 3) that the other vehicles' shadows leave at places (..., 2), metres, at a height.

        It is 1 under a sun that is not low: there shadows fall on the ground between vehicles.
        """
        gain = np.ones((*places.shape[:-1], 3), np.float32)
        if not self._blocks:
            return gain
        left = np.array(self._sun.gain, np.float32)
        near = np.hypot(*(self._places - (of.x, of.y)).T) < self._reaches
        for k in np.flatnonzero(near).tolist():
            vehicle, footprint, top = self._blocks[k]
            if vehicle is not of and top > height:
                swept = np.concatenate([footprint, footprint + self._sun.cast(top - height)]).astype(np.float32)
                hull = np.asarray(cv2.convexHull(swept)[:, 0], np.float64)
                gain[_inside(hull, places)] = left
        return gain


def _inside(hull: Points, places: Points) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """Return True (...) for places (..., 2) inside a convex outline (N, 2)."""
    edges = np.roll(hull, -1, axis=0) - hull
    away = places[..., None, :] - hull
    sides = edges[:, 0] * away[..., 1] - edges[:, 1] * away[..., 0]
    return np.asarray((sides >= 0).all(-1) | (sides <= 0).all(-1))

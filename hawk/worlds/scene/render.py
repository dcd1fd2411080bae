"""Draws a plan: the ground with paint and shadows, and everything that has height."""

from __future__ import annotations

import math
import zlib
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.worlds.conditions import draw_leaves, draw_puddles, draw_snow
from hawk.worlds.plan import Gain, Post, SitePlan, Stroke, Surface, Vehicle
from hawk.worlds.scene.buildings import draw_building
from hawk.worlds.scene.canvas import Bytes, Canvas, Floats, Patch, Points, as_bytes, as_floats, noise
from hawk.worlds.scene.cars import ShadowsAmong, Sprite, VehicleModel, dimmed, draw_vehicle, length_m, outline
from hawk.worlds.scene.facets import HeightLayer, flat_layer
from hawk.worlds.scene.light import Shadows, Sun
from hawk.worlds.scene.materials import Colour, Material, texture
from hawk.worlds.scene.trees import draw_bare_tree, draw_tree, leaf_colours

_FAR_M = 20.0
"""Things this far outside a canvas may still throw a shadow into it or lean into it."""


@dataclass(frozen=True, slots=True)
class Drawn:
    """A drawn place: ``ground`` is BGR float32 (0..255) with shadows, ``layers`` are the things that stand on it.

    ``shade`` (0..1) is the depth of the shadows on the ground. ``vehicles`` are kinds with the four corners (metres)
    of their bodies on the ground, the short ends first and last.
    """

    ground: Floats
    layers: tuple[HeightLayer, ...]
    shade: Floats
    vehicles: tuple[tuple[str, Points], ...] = ()


class Looks:
    """Looks of drawn things: each method gets what was drawn and returns what is shown, of the same size and opaque in
    the same places, so that the truth stays. These change nothing.
    """

    def ground(self, material: Material, picture: Floats, metres_per_pixel: float) -> Floats:
        """Return a picture of ground, BGR float32 (H, W, 3), 0..255."""
        del material, metres_per_pixel
        return picture

    def crown(self, layers: list[HeightLayer]) -> list[HeightLayer]:
        """Return the slices of a crown with leaves, lowest first."""
        return layers

    def vehicle(self, vehicle: Vehicle, model: VehicleModel, sun: Sun) -> VehicleModel:
        """Return a vehicle as it is before anything shades it."""
        del vehicle, sun
        return model


AS_DRAWN = Looks()
"""Nothing looks otherwise than it is drawn."""


def draw_plan(
    plan: SitePlan, canvas: Canvas, sun: Sun, random: np.random.Generator | Streams, looks: Looks = AS_DRAWN
) -> Drawn:
    """Draw the part of a plan that is on the canvas (its picture is filled in place)."""
    streams = random if isinstance(random, Streams) else Streams(random)
    mpp = canvas.metres_per_pixel
    bare = texture(streams.of("ground"), plan.ground, canvas.height, canvas.width, mpp)
    canvas.image = looks.ground(plan.ground, bare, mpp)
    paint = Paint(canvas, plan.strokes)
    gains = deque(plan.gains)
    shown = _shown(canvas, plan.surfaces)
    for order, surface in enumerate([None, *plan.surfaces]):
        patch = None
        if surface is not None and shown[order - 1]:
            patch = draw_surface(canvas, surface, streams.of("surface", order), looks)
        if patch is not None:
            paint.bury(patch)
        while gains and gains[0].order <= order:
            _draw_gain(canvas, gains.popleft())
        paint.put_on(order)
    draw_puddles(canvas, plan.wet, streams.of("puddles"))
    paint.blend(plan.palette, plan.wear, streams.of("wear"))
    draw_snow(canvas, plan.snow, streams.of("snow"))
    for surface in plan.islands:
        draw_surface(canvas, surface, streams.of("island", *surface.polygon[0]), looks)
    if plan.leaves:
        fallen = streams.of("leaves")
        draw_leaves(canvas, plan, leaf_colours(fallen), fallen)
    shadows = Shadows(canvas, sun)
    for shade in plan.shades:
        shadows.add_block(shade, 0.0, tall=True)
    layers = _draw_standing(plan, canvas, shadows, sun, streams, looks)
    vehicles, sprites = _draw_vehicles(plan, canvas, shadows, sun, streams, looks)
    layers += sprites
    for block in plan.blocks:
        if canvas.touches(block.polygon, _margin(4.0, block.height, sun)):
            shadows.add_block(block.polygon, block.height)
    depth = shadows.apply(rng=streams.of("shadows"))
    _draw_blocks(plan, canvas, shadows)
    if plan.lamps is not None:
        plan.lamps.light(canvas)
        layers = plan.lamps.light_layers(layers)
    return Drawn(canvas.image, tuple(layers), depth, vehicles)


def draw_surface(canvas: Canvas, surface: Surface, rng: np.random.Generator, looks: Looks = AS_DRAWN) -> Patch | None:
    """Draw one surface; return its patch, None when it is outside the canvas."""
    patch = canvas.patch(surface.polygon, round_m=surface.round_m)
    if patch is None:
        return None
    if surface.kerb is not None:
        _draw_kerb(canvas, surface, patch)
    rows, columns = patch.mask.shape
    drawn = texture(rng, surface.material, rows, columns, canvas.metres_per_pixel)
    picture = looks.ground(surface.material, drawn, canvas.metres_per_pixel)
    if surface.material.joints > 3 * canvas.metres_per_pixel:
        _draw_joints(canvas, surface, patch, picture, rng)
    canvas.cover(patch, picture)
    return patch


def _shown(canvas: Canvas, surfaces: Sequence[Surface]) -> list[bool]:
    """Return True for each surface in sight: those that later ones bury altogether need not be drawn."""
    step = 8
    buried = np.zeros((canvas.height // step + 2, canvas.width // step + 2), np.uint8)
    cross = np.ones((3, 3), np.uint8)
    shown = []
    for surface in reversed(surfaces):
        mask = np.zeros_like(buried)
        corners = np.clip(canvas.to_px(surface.polygon) / step, -9999, 9999)
        cv2.fillPoly(mask, [np.round(corners * 16).astype(np.int32)], 1, shift=4)
        shown.append(bool((as_bytes(cv2.dilate(mask, cross)) > buried).any()))
        if surface.round_m == 0:
            buried |= as_bytes(cv2.erode(mask, cross, borderValue=1))
    return shown[::-1]


def _draw_kerb(canvas: Canvas, surface: Surface, patch: Patch) -> None:
    reach = max(1, round(0.16 / canvas.metres_per_pixel))
    grown = cv2.dilate(patch.mask, np.ones((2 * reach + 1, 2 * reach + 1), np.uint8))
    canvas.cover(Patch(patch.rows, patch.columns, np.asarray(grown, np.float32)), surface.kerb or (0, 0, 0), 0.9)


def _draw_joints(canvas: Canvas, surface: Surface, patch: Patch, picture: Floats, rng: np.random.Generator) -> None:
    """Darken the joints between slabs; they follow the surface's first edge."""
    edge = surface.polygon[1] - surface.polygon[0]
    angle = math.atan2(edge[1], edge[0])
    rows, columns = np.mgrid[0 : patch.mask.shape[0], 0 : patch.mask.shape[1]].astype(np.float32)
    step = np.float32(surface.material.joints / canvas.metres_per_pixel)
    across = (columns * np.float32(math.cos(angle)) + rows * np.float32(math.sin(angle))) % step
    along = (rows * np.float32(math.cos(angle)) - columns * np.float32(math.sin(angle))) % step
    picture *= 1 - ((across < 1) | (along < 1))[..., None] * np.float32(rng.uniform(0.06, 0.22))


def _draw_gain(canvas: Canvas, gain: Gain) -> None:
    if gain.width is None:
        patch = canvas.patch(gain.points, soften=gain.soften)
    else:
        patch = canvas.strip(gain.points, gain.width, soften=gain.soften)
    canvas.gain(patch, gain.gain)


def _draw_blocks(plan: SitePlan, canvas: Canvas, shadows: Shadows) -> None:
    for block in plan.blocks:
        # the block's own shadow does not fall on it
        shade = shadows.shade_at(block.polygon.mean(0)[None])[0]
        canvas.cover(canvas.patch(block.polygon), shade * np.array(block.colour, np.float32))


def _draw_standing(
    plan: SitePlan, canvas: Canvas, shadows: Shadows, sun: Sun, streams: Streams, looks: Looks
) -> list[HeightLayer]:
    layers: list[HeightLayer] = []
    mpp = canvas.metres_per_pixel
    for building in plan.buildings:
        if canvas.touches(building.polygon, _margin(_FAR_M, building.height, sun)):
            if canvas.touches(building.polygon, 0.75 * building.height):  # as far as it leans in any picture
                layers += draw_building(streams.of("building", *building.axes.origin), building, sun, mpp)
            shadows.add_block(building.polygon, building.height, tall=True)
    leaves = leaf_colours(streams.of("foliage"))
    for tree in plan.trees:
        if canvas.touches(np.array([[tree.x, tree.y]]), tree.radius + _margin(_FAR_M / 2, tree.height, sun)):
            rng = streams.of("tree", tree.x, tree.y)
            if plan.bare and rng.random() < plan.bare:
                crown_layers, crown = draw_bare_tree(rng, tree, mpp)
            else:
                crown_layers, crown = draw_tree(rng, tree, leaves, sun, mpp)
                crown_layers = looks.crown(crown_layers)
            layers += crown_layers
            shadows.add_crown(tree.x, tree.y, tree.radius, tree.height, crown)
    for post in plan.posts:
        layers += _draw_post(post, canvas, shadows, sun)
    return layers


def _draw_vehicles(
    plan: SitePlan, canvas: Canvas, shadows: Shadows, sun: Sun, streams: Streams, looks: Looks
) -> tuple[tuple[tuple[str, Points], ...], list[HeightLayer]]:
    """Return the vehicles in sight, as in `Drawn`, and their layers."""
    drawn: list[tuple[Vehicle, VehicleModel]] = []
    for vehicle in plan.vehicles:
        margin = max(6.0, length_m(vehicle.kind) / 2, _margin(0.0, 4.0, sun))
        if canvas.touches(np.array([[vehicle.x, vehicle.y]]), margin):
            rng = streams.of("vehicle", vehicle.x, vehicle.y, vehicle.key)
            model = looks.vehicle(vehicle, draw_vehicle(rng, vehicle.kind), sun)
            if plan.dim_cars and rng.random() < plan.dim_cars:
                model = dimmed(rng, model)
            drawn.append((vehicle, model))
            footprint = outline(vehicle.x, vehicle.y, vehicle.heading, model.length * 0.96, model.width * 0.94)
            shadows.add_block(footprint, model.height * 0.85)
            canvas.gain(canvas.patch(footprint, soften=0.12), 0.35)  # it is dark under a car
    among = ShadowsAmong(drawn, sun)
    layers = [
        _sprite_layer(vehicle, model, sprite, shadows, among) for vehicle, model in drawn for sprite in model.sprites
    ]
    bodies = [(one.kind, outline(one.x, one.y, one.heading, model.length, model.width)) for one, model in drawn]
    return tuple(bodies), layers


def _sprite_layer(
    vehicle: Vehicle, model: VehicleModel, sprite: Sprite, shadows: Shadows, among: ShadowsAmong
) -> HeightLayer:
    rows, columns = sprite.pixels.shape[:2]
    scale = model.length / max(1, model.sprites[0].pixels.shape[1])
    ahead = np.array([math.cos(vehicle.heading), math.sin(vehicle.heading)])
    centre = np.array([vehicle.x, vehicle.y]) + ahead * sprite.along
    layer = flat_layer(
        sprite.pixels, (centre[0], centre[1]), vehicle.heading, (columns * scale, rows * scale), sprite.height, "car"
    )
    places = _places_on(layer)
    gain = as_floats(shadows.shade_at(places, sprite.height) * among.gain(vehicle, places, sprite.height))
    shade = as_floats(cv2.resize(gain, (columns, rows), interpolation=cv2.INTER_LINEAR))
    shaded = sprite.pixels.copy()
    shaded[..., :3] = np.clip(shaded[..., :3] * shade, 0, 255).astype(np.uint8)
    return HeightLayer(layer.corners, shaded, "car", sprite.fine)


def _places_on(layer: HeightLayer) -> Points:
    """Return a coarse grid of places (6, 12, 2) on a flat layer, metres."""
    across, along = np.meshgrid(np.linspace(0, 1, 12), np.linspace(0, 1, 6))
    corner = layer.corners[0, :2]
    right, down = layer.corners[1, :2] - corner, layer.corners[3, :2] - corner
    return np.asarray(corner + across[..., None] * right + along[..., None] * down)


def _margin(usual: float, height: float, sun: Sun) -> float:
    """Return the distance (metres) from the canvas within which a thing of a height is drawn for its shadow's sake."""
    return max(usual, height * sun.reach) if sun.is_low else usual


def _draw_post(post: Post, canvas: Canvas, shadows: Shadows, sun: Sun) -> list[HeightLayer]:
    if not canvas.touches(np.array([[post.x, post.y]]), _margin(post.height * 2, post.height, sun)):
        return []
    shadows.add_pole(post.x, post.y, post.height, 0.2)
    canvas.cover(canvas.patch(outline(post.x, post.y, post.heading, 0.5, 0.5)), (170, 172, 172))
    reach = np.array([math.cos(post.heading), math.sin(post.heading)]) * 0.8
    head = np.full((6, 16, 4), 255, np.uint8)
    head[..., :3] = 90
    centre = (post.x + float(reach[0]), post.y + float(reach[1]))
    swept = outline(centre[0], centre[1], post.heading, 1.6, 0.35)
    shadows.add_block(swept + sun.cast(post.height), 0.2)
    return [flat_layer(head, centre, post.heading, (1.6, 0.3), post.height, "post", fine=True)]


_SHIFT = 4
_FINE_M = 0.027
"""Strokes are drawn at least this finely (metres per pixel) and averaged: OpenCV's own smoothing of edges would make
a line of one pixel more than two wide."""


@dataclass(frozen=True, slots=True)
class _Waiting:
    stroke: Stroke
    quad: Points
    low: NDArray[np.int64]
    high: NDArray[np.int64]


class Paint:
    """The strokes of a plan on a canvas: put on in order, buried by surfaces, blended into the picture at the end."""

    def __init__(self, canvas: Canvas, strokes: Sequence[Stroke]) -> None:
        self._canvas = canvas
        self._fine = max(1, math.ceil(canvas.metres_per_pixel / _FINE_M))
        self._masks: dict[int, Bytes] = {}
        self._waiting: list[_Waiting] = []
        if not strokes:
            return
        quads = canvas.to_px(np.array([stroke.polygon for stroke in strokes])) + 0.5
        low, high = np.floor(quads.min(1)).astype(int) - 1, np.ceil(quads.max(1)).astype(int) + 1
        inside = (high > 0).all(1) & (low[:, 0] < canvas.width) & (low[:, 1] < canvas.height)
        fine = _narrowed(quads * self._fine, 0.5)
        # the last stroke comes first, so that the next one is popped from the end
        self._waiting = [_Waiting(strokes[k], fine[k], low[k], high[k]) for k in np.nonzero(inside)[0][::-1].tolist()]

    def put_on(self, order: int) -> None:
        """Paint the strokes that were made after ``order`` surfaces or fewer."""
        groups: dict[int, list[_Waiting]] = {}
        while self._waiting and self._waiting[-1].stroke.order <= order:
            one = self._waiting.pop()
            groups.setdefault(one.stroke.colour, []).append(one)
        for colour, group in groups.items():
            self._put_on(colour, group)

    def _put_on(self, colour: int, group: list[_Waiting]) -> None:
        size = (self._canvas.width, self._canvas.height)
        low = np.maximum(np.min([one.low for one in group], axis=0), 0)
        high = np.minimum(np.max([one.high for one in group], axis=0), size)
        width, height = (high - low).tolist()
        sheet = np.zeros((height * self._fine, width * self._fine), np.uint8)
        for one in group:
            corners = np.round((one.quad - low * self._fine - 0.5) * (1 << _SHIFT)).astype(np.int32)
            cv2.fillConvexPoly(sheet, corners, float(255 * one.stroke.strength), cv2.LINE_8, _SHIFT)
        if colour not in self._masks:
            self._masks[colour] = np.zeros(size[::-1], np.uint8)
        target = self._masks[colour][low[1] : high[1], low[0] : high[0]]
        np.maximum(target, as_bytes(cv2.resize(sheet, (width, height), interpolation=cv2.INTER_AREA)), out=target)

    def bury(self, patch: Patch) -> None:
        """Cover the paint under a surface."""
        for mask in self._masks.values():
            part = mask[patch.rows, patch.columns]
            if part.any():
                part[:] = as_bytes(part * (1 - patch.mask))

    def blend(self, palette: Sequence[Colour], wear: float, rng: np.random.Generator) -> None:
        """Blend everything into the picture; ``wear`` (0..1) makes the paint patchy."""
        if not self._masks:
            return
        per_metre = 1 / self._canvas.metres_per_pixel
        cells = [6 * per_metre, 1.2 * per_metre, 0.3 * per_metre, 0.12 * per_metre]
        patchy = noise(rng, self._canvas.height, self._canvas.width, cells, [0.22, 0.15, 0.15, 0.12])
        patchy *= np.float32(0.2 + 1.3 * wear)
        patchy += 1
        np.clip(patchy, 0.1, 1.15, out=patchy)
        for number, mask in sorted(self._masks.items()):
            painted = mask > 0  # a few hundredths of the picture
            alpha = np.minimum(mask[painted].astype(np.float32) * (patchy[painted] / 255), 1)[:, None]
            below = self._canvas.image[painted]
            self._canvas.image[painted] = below + (np.asarray(palette[number], np.float32) - below) * alpha


def _narrowed(quads: Points, by: float) -> Points:
    """Move the sides of parallelograms (N, 4, 2) inwards: OpenCV fills every pixel that an edge touches."""
    first, second = quads[:, 1] - quads[:, 0], quads[:, 3] - quads[:, 0]
    area = np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]) + 1e-9
    shrunk = []
    for side, other in ((first, second), (second, first)):
        across = area / (np.linalg.norm(other, axis=1) + 1e-9)
        shrunk.append(side * np.clip(1 - 2 * by / across, 0.05, 1)[:, None] / 2)
    middle = quads.mean(1)
    a, b = shrunk
    return np.stack([middle - a - b, middle + a - b, middle + a + b, middle - a + b], axis=1)


class Streams:
    """One stream for everything, in the order in which things are drawn: one thing less changes all that follow."""

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng

    def of(self, thing: str, *key: float) -> np.random.Generator:
        """Return the random numbers of a thing; ``key`` states which one of its kind, in metres or whole numbers."""
        del thing, key
        return self._rng


class OwnStreams(Streams):
    """A stream for each thing, by the seed, its kind and its key: whatever is drawn beside it, it looks the same."""

    def __init__(self, seed: int) -> None:
        self._seed = seed

    def of(self, thing: str, *key: float) -> np.random.Generator:
        """Return the random numbers of a thing, the same for its key to a centimetre."""
        numbers = [round(value * 100) % 2**48 for value in key]
        return np.random.default_rng((self._seed, zlib.crc32(thing.encode()), *numbers))

"""Draws a plan: the ground with paint and shadows, and everything that has height."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from hawk.worlds.buildings import draw_building
from hawk.worlds.canvas import Canvas, Floats, Patch, as_bytes, as_floats
from hawk.worlds.cars import Model, Sprite, dimmed, draw_vehicle, outline
from hawk.worlds.clutter import draw_puddles
from hawk.worlds.conditions import draw_leaves, draw_snow
from hawk.worlds.facets import HeightLayer, flat_layer
from hawk.worlds.light import Shadows, Sun
from hawk.worlds.materials import texture
from hawk.worlds.paint import Paint
from hawk.worlds.plan import Gain, Plan, Post, Surface, Vehicle
from hawk.worlds.trees import draw_tree, leaf_colours

_FAR_M = 20.0
"""Things this far outside a canvas may still throw a shadow into it or lean into it."""


@dataclass(frozen=True, slots=True)
class Drawn:
    """A drawn place: ``ground`` is BGR float32 (0..255) with shadows, ``layers`` what stands on it."""

    ground: Floats
    layers: tuple[HeightLayer, ...]


def draw_plan(plan: Plan, canvas: Canvas, sun: Sun, rng: np.random.Generator) -> Drawn:
    """Draw the part of a plan that lies on the canvas (its picture is filled in place)."""
    canvas.image = texture(rng, plan.ground, canvas.height, canvas.width, canvas.metres_per_pixel)
    paint = Paint(canvas, plan.strokes)
    gains = deque(plan.gains)
    shown = _shown(canvas, plan.surfaces)
    for order, surface in enumerate([None, *plan.surfaces]):
        patch = draw_surface(canvas, surface, rng) if surface is not None and shown[order - 1] else None
        if patch is not None:
            paint.bury(patch)
        while gains and gains[0].order <= order:
            _draw_gain(canvas, gains.popleft())
        paint.put_on(order)
    draw_puddles(canvas, plan.wet, rng)
    paint.blend(plan.palette, plan.wear, rng)
    draw_snow(canvas, plan.snow, rng)
    for surface in plan.islands:
        draw_surface(canvas, surface, rng)
    if plan.leaves:
        draw_leaves(canvas, plan, leaf_colours(rng), rng)
    shadows = Shadows(canvas, sun)
    for shade in plan.shades:
        shadows.add_block(shade, 0.0, tall=True)
    layers = _draw_standing(plan, canvas, shadows, sun, rng)
    for block in plan.blocks:
        if canvas.touches(block.polygon, 4):
            shadows.add_block(block.polygon, block.height)
    shadows.apply(rng=rng)
    _draw_blocks(plan, canvas, shadows)
    if plan.lamps is not None:
        plan.lamps.light(canvas)
        layers = plan.lamps.light_layers(layers)
    return Drawn(canvas.image, tuple(layers))


def draw_surface(canvas: Canvas, surface: Surface, rng: np.random.Generator) -> Patch | None:
    """Lay one surface; return where, or None when it lies outside the canvas."""
    patch = canvas.patch(surface.polygon, round_m=surface.round_m)
    if patch is None:
        return None
    if surface.kerb is not None:
        _draw_kerb(canvas, surface, patch)
    rows, columns = patch.mask.shape
    picture = texture(rng, surface.material, rows, columns, canvas.metres_per_pixel)
    if surface.material.joints > 3 * canvas.metres_per_pixel:
        _draw_joints(canvas, surface, patch, picture, rng)
    canvas.cover(patch, picture)
    return patch


def _shown(canvas: Canvas, surfaces: Sequence[Surface]) -> list[bool]:
    """Tell which surfaces can be seen: those that later ones bury altogether need not be drawn."""
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
    if patch is not None:
        canvas.gain(patch, gain.gain)


def _draw_blocks(plan: Plan, canvas: Canvas, shadows: Shadows) -> None:
    for block in plan.blocks:
        patch = canvas.patch(block.polygon)
        if patch is not None:  # the block's own shadow does not fall on it
            shade = shadows.shade_at(block.polygon.mean(0)[None])[0]
            canvas.cover(patch, shade * np.array(block.colour, np.float32))


def _draw_standing(
    plan: Plan, canvas: Canvas, shadows: Shadows, sun: Sun, rng: np.random.Generator
) -> list[HeightLayer]:
    layers: list[HeightLayer] = []
    mpp = canvas.metres_per_pixel
    for building in plan.buildings:
        if canvas.touches(building.polygon, _FAR_M):
            if canvas.touches(building.polygon, 0.75 * building.height):  # as far as it leans in any picture
                layers += draw_building(rng, building, sun, mpp)
            shadows.add_block(building.polygon, building.height, tall=True)
    leaves = leaf_colours(rng)
    for tree in plan.trees:
        if canvas.touches(np.array([[tree.x, tree.y]]), tree.radius + _FAR_M / 2):
            crown_layers, crown = draw_tree(rng, tree, leaves, sun, mpp)
            layers += crown_layers
            shadows.add_crown(tree.x, tree.y, tree.radius, tree.height, crown)
    for post in plan.posts:
        layers += _draw_post(post, canvas, shadows)
    for vehicle in plan.vehicles:
        if canvas.touches(np.array([[vehicle.x, vehicle.y]]), 6):
            model = draw_vehicle(rng, vehicle.kind)
            if plan.dim_cars and rng.random() < plan.dim_cars:
                model = dimmed(rng, model)
            layers += _draw_vehicle(vehicle, model, canvas, shadows)
    return layers


def _draw_vehicle(vehicle: Vehicle, model: Model, canvas: Canvas, shadows: Shadows) -> list[HeightLayer]:
    footprint = outline(vehicle.x, vehicle.y, vehicle.heading, model.length * 0.96, model.width * 0.94)
    shadows.add_block(footprint, model.height * 0.85)
    contact = canvas.patch(footprint, soften=0.12)
    if contact is not None:  # it is dark under a car
        canvas.gain(contact, 0.35)
    return [_sprite_layer(vehicle, model, sprite, shadows) for sprite in model.sprites]


def _sprite_layer(vehicle: Vehicle, model: Model, sprite: Sprite, shadows: Shadows) -> HeightLayer:
    rows, columns = sprite.pixels.shape[:2]
    scale = model.length / max(1, model.sprites[0].pixels.shape[1])
    ahead = np.array([math.cos(vehicle.heading), math.sin(vehicle.heading)])
    centre = np.array([vehicle.x, vehicle.y]) + ahead * sprite.along
    layer = flat_layer(
        sprite.pixels, (centre[0], centre[1]), vehicle.heading, (columns * scale, rows * scale), sprite.height, "car"
    )
    shade = _shade_over(layer, shadows, rows, columns)
    shaded = sprite.pixels.copy()
    shaded[..., :3] = np.clip(shaded[..., :3] * shade, 0, 255).astype(np.uint8)
    return HeightLayer(layer.corners, shaded, "car", sprite.fine)


def _shade_over(layer: HeightLayer, shadows: Shadows, rows: int, columns: int) -> Floats:
    """Return the gain (rows, columns, 3) of shadows that fall on a flat layer, from a coarse grid of places."""
    across, along = np.meshgrid(np.linspace(0, 1, 12), np.linspace(0, 1, 6))
    corner = layer.corners[0, :2]
    right, down = layer.corners[1, :2] - corner, layer.corners[3, :2] - corner
    places = corner + across[..., None] * right + along[..., None] * down
    return as_floats(cv2.resize(shadows.shade_at(places), (columns, rows), interpolation=cv2.INTER_LINEAR))


def _draw_post(post: Post, canvas: Canvas, shadows: Shadows) -> list[HeightLayer]:
    if not canvas.touches(np.array([[post.x, post.y]]), post.height * 2):
        return []
    shadows.add_pole(post.x, post.y, post.height, 0.2)
    foot = canvas.patch(outline(post.x, post.y, post.heading, 0.5, 0.5))
    if foot is not None:
        canvas.cover(foot, (170, 172, 172))
    reach = np.array([math.cos(post.heading), math.sin(post.heading)]) * 0.8
    head = np.full((6, 16, 4), 255, np.uint8)
    head[..., :3] = 90
    centre = (post.x + float(reach[0]), post.y + float(reach[1]))
    layers = [flat_layer(head, centre, post.heading, (1.6, 0.3), post.height, "post", fine=True)]
    swept = outline(centre[0], centre[1], post.heading, 1.6, 0.35)
    shadows.add_block(swept + shadows.cast(post.height), 0.2)
    return layers

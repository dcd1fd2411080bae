"""Trees and bushes: crowns as slices at several heights."""

from __future__ import annotations

import cv2
import numpy as np

from hawk.worlds.plan import Tree
from hawk.worlds.scene.canvas import Bytes, Floats, as_bytes, noise
from hawk.worlds.scene.facets import HeightLayer, flat_layer
from hawk.worlds.scene.light import Sun

_SLICES = ((0.5, 1.0, 0.72), (0.75, 0.86, 0.95), (0.97, 0.58, 1.2))
"""Height, radius and brightness of a crown's slices, as shares of the tree's."""


def leaf_colours(rng: np.random.Generator) -> Floats:
    """Draw the leaf colours (N, 3) BGR of a neighbourhood."""
    base = rng.uniform(48, 105) * np.array([rng.uniform(0.4, 0.72), 1.0, rng.uniform(0.72, 1.06)])
    spread = np.exp(rng.normal(0, 0.06, (5, 3))) * rng.uniform(0.75, 1.3, (5, 1))
    colours: Floats = np.clip(base * spread, 8, 190).astype(np.float32)
    if rng.random() < 0.2:  # autumn
        colours[:2] = np.clip(np.array([45, 95, 150]) * rng.uniform(0.6, 1.2), 8, 210)
    return colours


def draw_tree(
    rng: np.random.Generator, tree: Tree, leaves: Floats, sun: Sun, metres_per_pixel: float
) -> tuple[list[HeightLayer], Bytes]:
    """Return a crown's slices, lowest first, and the alpha of the whole crown (a square 2 x radius wide)."""
    size = max(6, round(2 * tree.radius / metres_per_pixel))
    crown = _crown(rng, size)
    relief = noise(rng, size, size, [size / 5, 0.35 / metres_per_pixel, 0.15 / metres_per_pixel], [0.25, 0.25, 0.2])
    colour = leaves[int(rng.integers(len(leaves)))]
    layers = []
    for height, share, bright in _SLICES if tree.height > 1.6 else _SLICES[1:2]:
        alpha = crown if share == 1.0 else _shrunk(rng, crown, share)
        pixels = _leafage(alpha, relief, colour * np.float32(bright), sun, metres_per_pixel)
        size_m = (2 * tree.radius, 2 * tree.radius)
        fine = tree.height > 1.6 and share == _SLICES[1][1]
        layers.append(flat_layer(pixels, (tree.x, tree.y), 0.0, size_m, tree.height * height, "tree", fine=fine))
    return layers, crown


def draw_bare_tree(rng: np.random.Generator, tree: Tree, metres_per_pixel: float) -> tuple[list[HeightLayer], Bytes]:
    """Return the branches of a tree without leaves, lowest first, and the alpha of all of them (2 x radius wide)."""
    size = max(6, round(2 * tree.radius / metres_per_pixel))
    whole = _branches(rng, size)
    bark = np.clip(np.array([88.0, 96.0, 102.0]) * rng.uniform(0.45, 1.05) + rng.normal(0, 6, 3), 12, 220)
    layers = []
    for height, share in ((0.55, 1.0), (0.85, 0.7)):
        alpha = whole if share == 1.0 else _shrunk(rng, whole, share)
        relief = 1 + noise(rng, size, size, [max(2.0, size / 8), 1.0], [0.12, 0.12])
        picture = np.clip(relief[..., None] * bark * (0.85 if share == 1.0 else 1.1), 0, 255).astype(np.uint8)
        pixels = np.dstack([picture, np.where(alpha > 127, 255, 0).astype(np.uint8)])
        size_m = (2 * tree.radius, 2 * tree.radius)
        layers.append(flat_layer(pixels, (tree.x, tree.y), 0.0, size_m, tree.height * height, "tree"))
    return layers, whole


def _branches(rng: np.random.Generator, size: int) -> Bytes:
    """Return the alpha of branches that fork from the middle outwards, thinner at every fork."""
    alpha = np.zeros((size, size), np.uint8)
    reach = size / 2
    first = int(rng.integers(5, 9))
    spokes = np.arange(first) * 2 * np.pi / first
    waiting = [(reach, reach, angle + rng.normal(0, 0.25), reach * rng.uniform(0.3, 0.45), 0) for angle in spokes]
    while waiting:
        x, y, angle, length, forks = waiting.pop()
        end = (x + np.cos(angle) * length, y + np.sin(angle) * length)
        thick = max(1, round(size / 40) - forks)
        value = 255 if forks < 2 else int(rng.integers(60, 256))  # twigs are thinner than a pixel
        cv2.line(alpha, (round(x), round(y)), (round(end[0]), round(end[1])), value, thick)
        if forks < 4 and length > 1.5 and np.hypot(end[0] - reach, end[1] - reach) < reach:
            turns = rng.normal((-0.5, 0.5), 0.2)
            waiting += [(*end, angle + turn, length * rng.uniform(0.6, 0.85), forks + 1) for turn in turns]
    return alpha


def _crown(rng: np.random.Generator, size: int) -> Bytes:
    """Return the alpha of a crown: a ragged heap of leaf clumps."""
    alpha = np.zeros((size, size), np.uint8)
    middle, reach = size / 2, size / 2
    count = int(np.clip(size / 2, 10, 34))
    angles, away = rng.uniform(0, 2 * np.pi, count), np.sqrt(rng.uniform(0, 1, count)) * 0.72
    radii = reach * rng.uniform(0.12, 0.34, count) * (1.15 - 0.6 * away)
    away = np.minimum(away * reach, reach - radii)
    places = np.stack([middle + away * np.cos(angles), middle + away * np.sin(angles)], 1)
    for (x, y), radius in zip(places, radii, strict=True):
        cv2.circle(alpha, (int(x * 16), int(y * 16)), int(max(1.0, radius) * 16), 255, -1, cv2.LINE_AA, 4)
    cv2.circle(alpha, (int(middle), int(middle)), max(1, int(reach * 0.45)), 255, -1, cv2.LINE_AA)
    holes = noise(rng, size, size, [max(2.0, size / 12), max(1.5, size / 24)], [0.5, 0.5])
    edge = cv2.blur(alpha, (max(3, size // 8) | 1,) * 2).astype(np.float32) / 255
    ragged: Bytes = np.where((alpha > 127) & (holes < 0.6 + 2.2 * (edge - 0.45)), 255, 0).astype(np.uint8)
    return ragged


def _shrunk(rng: np.random.Generator, crown: Bytes, share: float) -> Bytes:
    size = crown.shape[0]
    shift = (1 - share) * size / 2
    jitter = rng.normal(0, 0.02 * size, 2)
    move = np.array([[share, 0, shift + jitter[0]], [0, share, shift + jitter[1]]])
    return as_bytes(cv2.warpAffine(crown, move, (size, size), flags=cv2.INTER_LINEAR))


def _leafage(alpha: Bytes, relief: Floats, colour: Floats, sun: Sun, metres_per_pixel: float) -> Bytes:
    """Colour a slice: leaves catch the light on the sun's side."""
    height = cv2.GaussianBlur(alpha.astype(np.float32) / 255, (0, 0), max(0.8, 0.5 / metres_per_pixel)) * 2 + relief
    slope_x, slope_y = cv2.Sobel(height, cv2.CV_32F, 1, 0), cv2.Sobel(height, cv2.CV_32F, 0, 1)
    norm = float(np.hypot(*sun.shadow)) + 1e-6
    facing = (slope_x * sun.shadow[0] + slope_y * sun.shadow[1]) / norm
    light = np.clip(1 + 0.45 * facing + 0.35 * relief, 0.3, 2.0)
    picture = np.clip(light[..., None] * colour, 0, 255).astype(np.uint8)
    pixels: Bytes = np.dstack([picture, alpha])
    return pixels

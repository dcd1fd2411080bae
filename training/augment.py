"""Turns drawn scenes into many different training pictures: turned, scaled, mirrored, lit and blurred at random."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.vision.network import CELL_PIXELS, sun_input
from hawk.worlds.scene.light import shade_gain
from training.targets import CAR, PLACE_WEIGHT, SHADE, TrainingScene, draw_targets

SCALE = (0.65, 1.5)
"""Range of the random scale: for stalls of unusual sizes and heights with an error."""
_SHADOWS_SHARE = 0.3
_SUN_LEFT_OUT = 0.4
"""Share of the samples whose sun the network is not given."""
_SHADE = 0.4
"""Ground in a deeper shade than this is in the shade."""


@dataclass(frozen=True, slots=True)
class Sample:
    """A training picture (3, side, side), value / 255 - 0.5, its targets, and the network's input ``sun`` (2,)."""

    picture: NDArray[np.float32]
    target: NDArray[np.float32]
    sun: NDArray[np.float32]


def sample(scene: TrainingScene, rng: np.random.Generator, side: int) -> Sample:
    """Return a random part of a scene, changed at random."""
    height, width = scene.image.shape[:2]
    scale = math.exp(rng.uniform(math.log(SCALE[0]), math.log(SCALE[1])))
    to_crop = _placement(rng, (width, height), scale, side)
    method = cv2.INTER_AREA if scale < 0.8 else cv2.INTER_LINEAR
    image = cv2.warpAffine(_softened(scene.image, scale), to_crop, (side, side), flags=method)
    labels = cv2.warpAffine(scene.labels, to_crop, (side, side), flags=cv2.INTER_NEAREST)
    seen = np.ones((height, width), np.uint8) if scene.seen is None else scene.seen
    known = np.asarray(cv2.warpAffine(seen, to_crop, (side, side), flags=cv2.INTER_NEAREST), np.uint8)
    stalls = scene.quads @ to_crop[:, :2].T + to_crop[:, 2]
    vehicles = scene.vehicles
    if vehicles is not None:
        moved = np.asarray(vehicles.quads @ to_crop[:, :2].T + to_crop[:, 2], np.float32)
        vehicles = replace(vehicles, quads=moved)
    target = draw_targets(
        np.asarray(labels, np.uint8), known, stalls, scene.taken, scene.judged, scene.unclear, vehicles
    )
    textured = retextured(np.asarray(image, np.float32), rng)
    cast, outside = shadow_depth(stalls[~scene.taken], (side, side), rng), outside_shade((side, side), rng)
    lit = light(in_shade(in_shade(textured, cast, rng), outside, rng), rng)
    _add_shade(target, np.maximum(cast, outside))
    picture = np.ascontiguousarray(lit.transpose(2, 0, 1)) / np.float32(255) - np.float32(0.5)
    return Sample(picture, target, _sun(scene, to_crop[:, :2] / scale, rng))


def _sun(scene: TrainingScene, turn: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float32]:
    """Return the network's input for the sun of a scene that is turned and mirrored, often left out."""
    if scene.cast is None or rng.random() < _SUN_LEFT_OUT:
        return np.zeros(2, np.float32)
    return sun_input(turn @ scene.cast)


def _add_shade(target: NDArray[np.float32], depth: NDArray[np.float32]) -> None:
    """Mark ground in such a shade (H, W; 0..1) in the targets; cars stay cars."""
    half = depth[::CELL_PIXELS, ::CELL_PIXELS] > _SHADE
    target[SHADE][half & (target[CAR] == 0) & (target[PLACE_WEIGHT] > 0)] = 1


def retextured(image: NDArray[np.float32], rng: np.random.Generator) -> NDArray[np.float32]:
    """Return a picture (H, W, 3) in 0..255 with other surfaces: smoothed flat, or with other grain on them.

    The grain of a drawn ground is the renderer's own; a network that leans on it is lost over real ground.
    """
    if rng.random() < 0.25:
        flat = cv2.bilateralFilter(image, 5, float(rng.uniform(6, 20)), float(rng.uniform(1.5, 4)))
        image = image + (flat - image) * np.float32(rng.uniform(0.5, 1.0))
    if rng.random() < 0.2:
        for size in rng.choice([1.0, 2.0, 5.0, 14.0, 40.0], int(rng.integers(1, 4)), replace=False).tolist():
            image = image * (1 + _grain(image.shape[:2], size, rng)[..., None] * np.float32(rng.uniform(0.01, 0.045)))
    if rng.random() < 0.12:  # other mixes of the same three channels: other films, other sensors
        mix = np.eye(3) + rng.normal(0, 0.08, (3, 3))
        image = image @ (mix / mix.sum(axis=1, keepdims=True)).astype(np.float32).T
    return np.asarray(image, np.float32)


def outside_shade(shape: tuple[int, int], rng: np.random.Generator) -> NDArray[np.float32]:
    """Return the depth (H, W; 0..1) of the shade of something outside a picture, cars included; often none.

    Half are the straight shadows of buildings, half the ragged ones of trees.
    """
    height, width = shape
    if rng.random() > 0.35:
        return np.zeros(shape, np.float32)
    if rng.random() < 0.5:
        turn, rows, columns = rng.uniform(0, 2 * math.pi), *np.indices((height, width), np.float32)
        field = (columns - rng.uniform(0.1, 0.9) * width) * math.cos(turn) + (rows - height / 2) * math.sin(turn)
    else:
        size = rng.uniform(20, 70)
        field = (_grain((height, width), size, rng) + 0.5 * _grain((height, width), size / 5, rng) - 0.6) * 8
    return np.asarray(np.clip(0.5 + field / rng.uniform(1, 4), 0, 1) * rng.uniform(0.75, 1.0), np.float32)


def shadow_depth(free: NDArray[np.floating], shape: tuple[int, int], rng: np.random.Generator) -> NDArray[np.float32]:
    """Return the depth (H, W; 0..1) of shadows as of vans and lorries over some or none of the ``free`` stalls.

    ``free`` is (N, 4, 2) pixels. A dark, even patch with straight edges is not yet a car.
    """
    depth = np.zeros(shape, np.float32)
    if len(free) == 0 or rng.random() > _SHADOWS_SHARE:
        return depth
    picked = rng.permutation(len(free))[: int(rng.integers(1, 6))]
    side = rng.random() < 0.5  # the sun stands on one side of all of them
    begin, slant = rng.uniform(-0.15, 0.2), rng.normal(0, 0.12)
    for quad in free[picked]:
        origin, across, along = quad[0], quad[1] - quad[0], quad[3] - quad[0]
        if side:
            origin, across = quad[1], -across
        reach = rng.uniform(0.3, 1.1)
        shares = np.array([(-0.05, begin), (reach, begin + slant), (reach, begin + slant + 0.9), (-0.05, begin + 0.9)])
        corners = origin + shares[:, :1] * across + shares[:, 1:] * along * rng.uniform(0.8, 1.05)
        cv2.fillConvexPoly(depth, np.round(corners * 16).astype(np.int32), 1.0, cv2.LINE_AA, 4)
    return np.asarray(cv2.GaussianBlur(depth, (0, 0), rng.uniform(0.5, 1.5)), np.float32) * np.float32(
        rng.uniform(0.75, 1.0)
    )


def in_shade(image: NDArray[np.float32], depth: NDArray[np.float32], rng: np.random.Generator) -> NDArray[np.float32]:
    """Return a picture (H, W, 3) under shade of a depth (H, W; 0..1), which keeps some of the sky's blue."""
    if not depth.any():
        return image
    gain = np.array(shade_gain(rng.uniform(0.25, 0.7), rng.uniform(0, 0.6)))
    return np.asarray(image * (1 - depth[..., None] * (1 - gain)), np.float32)


def _grain(shape: tuple[int, ...], size: float, rng: np.random.Generator) -> NDArray[np.float32]:
    """Return noise (H, W) of mean 0 and deviation 1 whose blotches are ``size`` pixels wide."""
    small = (max(2, round(shape[1] / size)), max(2, round(shape[0] / size)))
    coarse = rng.standard_normal((small[1], small[0]), np.float32)
    noise = cv2.resize(coarse, (shape[1], shape[0]), interpolation=cv2.INTER_CUBIC)
    return np.asarray(noise / max(float(noise.std()), 1e-6), np.float32)


def light(image: NDArray[Any], rng: np.random.Generator) -> NDArray[np.float32]:
    """Return a picture (H, W, 3) in 0..255 with another exposure, colour, sharpness and noise.

    Milder than the scenes' own differences: those are drawn in many lights and by many cameras already.
    """
    if rng.random() < 0.7:
        image = image * rng.uniform(0.8, 1.3) + rng.uniform(-14, 20)
        image = image * np.exp(rng.normal(0, 0.05, 3))
    if rng.random() < 0.1:
        image = cv2.GaussianBlur(image, (0, 0), rng.uniform(0.4, 0.95))
    if rng.random() < 0.25:
        image = image + (image - cv2.GaussianBlur(image, (0, 0), 1.2)) * rng.uniform(0.3, 1.2)
    if rng.random() < 0.2:
        image = image + rng.normal(0, rng.uniform(1, 5), image.shape)
    if rng.random() < 0.2:
        grey = image.mean(axis=2, keepdims=True)
        image = grey + (image - grey) * rng.uniform(0, 0.6)
    if rng.random() < 0.35:
        image = 255 * (np.clip(image, 0, 255) / 255) ** rng.uniform(0.65, 1.35)
    return np.asarray(np.clip(image, 0, 255), np.float32)


def _placement(rng: np.random.Generator, size: tuple[int, int], scale: float, side: int) -> NDArray[np.float64]:
    """Return the affine map (2, 3) from scene to crop pixels, with the crop inside the scene where it fits."""
    half = np.minimum(side / 2 / scale, np.array(size) / 2)
    centre = rng.uniform(half, np.array(size) - half)
    angle, mirror = rng.uniform(0, 2 * math.pi), rng.choice([-1.0, 1.0])
    c, s = math.cos(angle), math.sin(angle)
    linear = scale * np.array([[c * mirror, -s], [s * mirror, c]])
    return np.column_stack([linear, np.array([side / 2, side / 2]) - linear @ centre])


def _softened(image: NDArray[np.uint8], scale: float) -> NDArray[np.uint8]:
    """Blur before making smaller: a warp alone would alias."""
    if scale >= 0.9:
        return image
    return np.asarray(cv2.GaussianBlur(image, (0, 0), 0.45 * math.sqrt(1 / scale**2 - 1) + 0.1), np.uint8)

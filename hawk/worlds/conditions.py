"""Time of day and weather: what they do to a plan before it is drawn, and to a drawn place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

import cv2
import numpy as np

from hawk.worlds.canvas import Canvas, Floats, Points, as_floats, noise
from hawk.worlds.facets import HeightLayer
from hawk.worlds.light import Sun
from hawk.worlds.plan import Plan

_SODIUM, _LED = (0.45, 0.78, 1.0), (1.0, 0.96, 0.9)  # blue, green, red of lamp light
_COARSE_M = 0.5
_SNOW = (238.0, 236.0, 232.0)


class Condition(StrEnum):
    """What a world can be like; ``day`` is dry, with some sun."""

    DAY = "day"
    OVERCAST = "overcast"
    DUSK = "dusk"
    NIGHT = "night"
    WET = "wet"
    SNOW = "snow"
    LEAVES = "leaves"


SHARES = {
    Condition.DAY: 0.73,
    Condition.OVERCAST: 0.07,
    Condition.DUSK: 0.05,
    Condition.NIGHT: 0.04,
    Condition.WET: 0.05,
    Condition.SNOW: 0.03,
    Condition.LEAVES: 0.03,
}
"""How often a scene to train on is of each kind."""


@dataclass(frozen=True, slots=True)
class LampLight:
    """Light without a sun: ``ambient`` (blue, green, red; 1 is day), and lamps (N, 3): x, y, height, metres, each of
    ``colour`` and ``strength`` (what it adds on the ground below it)."""

    ambient: tuple[float, float, float]
    lamps: Points
    colour: tuple[float, float, float]
    strength: float

    def at(self, points: Points) -> Floats:
        """Return the gain (..., 3) at ground points (..., 2), metres: lamps fall off as the light of a point source
        over a plane does, (1 + d^2 / h^2)^-3/2."""
        gain = np.zeros((*points.shape[:-1], 1))
        for x, y, height in self.lamps.tolist():
            away = ((points - (x, y)) ** 2).sum(-1, keepdims=True) / height**2
            gain += (1 + away) ** -1.5
        return as_floats(np.array(self.ambient) + gain * self.strength * np.array(self.colour))

    def light(self, canvas: Canvas) -> None:
        """Light a canvas's picture."""
        x0, y0, x1, y1 = canvas.box
        columns = np.linspace(x0, x1, max(2, round((x1 - x0) / _COARSE_M)))
        rows = np.linspace(y0, y1, max(2, round((y1 - y0) / _COARSE_M)))
        coarse = self.at(np.stack(np.meshgrid(columns, rows), -1))
        canvas.image *= as_floats(cv2.resize(coarse, (canvas.width, canvas.height), interpolation=cv2.INTER_LINEAR))

    def light_layers(self, layers: Sequence[HeightLayer]) -> list[HeightLayer]:
        """Return layers as the lamps show them, each by the light at its middle."""
        return [replace(layer, pixels=self._lit(layer)) for layer in layers]

    def _lit(self, layer: HeightLayer) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
        pixels = layer.pixels.copy()
        gain = self.at(layer.corners[:, :2].mean(0))
        pixels[..., :3] = np.clip(pixels[..., :3] * gain, 0, 255).astype(np.uint8)
        return pixels


def sample_condition(rng: np.random.Generator) -> Condition:
    """Draw a condition for a scene to train on."""
    return list(SHARES)[int(rng.choice(len(SHARES), p=list(SHARES.values())))]


def set_condition(plan: Plan, condition: Condition, sun: Sun, rng: np.random.Generator) -> Sun:
    """Prepare a plan for a condition; return the sun that is left of ``sun``."""
    match condition:
        case Condition.OVERCAST:
            left = rng.uniform(0.82, 0.97)
            return Sun(sun.shadow, (left, left, left), 0.5)
        case Condition.DUSK:
            plan.lamps = _lamps(plan, rng, (0.35, 0.65), (1.12, 0.96, 0.98), rng.uniform(0.0, 0.5))
            left = rng.uniform(0.85, 1.0)
            return Sun((sun.shadow[0] * 2, sun.shadow[1] * 2), (left, left, left), 0.4)
        case Condition.NIGHT:
            plan.lamps = _lamps(plan, rng, (0.14, 0.34), (1.1, 1.0, 0.92), rng.uniform(0.5, 1.1))
            return Sun((0.0, 0.0), (1.0, 1.0, 1.0), sun.soften)
        case Condition.WET:
            plan.wet = rng.uniform(0.3, 1.0)
            return sun
        case Condition.SNOW:
            plan.snow = rng.uniform(0.2, 1.0)
            return sun
        case Condition.LEAVES:
            plan.leaves = rng.uniform(0.3, 1.0)
            return sun
        case _:
            return sun


def draw_snow(canvas: Canvas, amount: float, rng: np.random.Generator) -> None:
    """Lay patches of snow (0: none, 1: a third of the ground)."""
    if amount <= 0:
        return
    per_metre = 1 / canvas.metres_per_pixel
    field = noise(
        rng, canvas.height, canvas.width, [8 * per_metre, 1.5 * per_metre, 0.3 * per_metre], [0.7, 0.35, 0.12]
    )
    patch = np.clip((field - (1.2 - 0.8 * amount)) * 5, 0, 1)[..., None] * np.float32(rng.uniform(0.75, 0.97))
    canvas.image += (np.array(_SNOW, np.float32) - canvas.image) * patch


def draw_leaves(canvas: Canvas, plan: Plan, colours: Floats, rng: np.random.Generator) -> None:
    """Scatter fallen leaves about the trees."""
    if plan.leaves <= 0 or not plan.trees:
        return
    trees = np.array([(tree.x, tree.y, 2.5 * tree.radius) for tree in plan.trees])
    near = LampLight((0.0, 0.0, 0.0), trees, (1.0, 1.0, 1.0), 1.0)
    shade = Canvas(*canvas.box[:2], canvas.width, canvas.height, canvas.metres_per_pixel)
    shade.image += 1
    near.light(shade)
    density = np.clip(shade.image[..., 0] - np.float32(0.35), 0, 0.5) * np.float32(0.5 * plan.leaves)
    fallen = rng.random((canvas.height, canvas.width), np.float32) < density
    canvas.image[fallen] = colours[rng.integers(0, len(colours), int(fallen.sum()))] * np.float32(0.9)


def _lamps(
    plan: Plan, rng: np.random.Generator, level: tuple[float, float], tint: tuple[float, float, float], strength: float
) -> LampLight:
    """Light the plan's posts, and some beyond where it has few."""
    posts = [(post.x, post.y, post.height) for post in plan.posts]
    if len(posts) < 3 and plan.lots:
        outline = plan.lots[0]
        share = rng.random((4, 1))
        places = outline[rng.integers(0, len(outline), 4)] * share + outline.mean(0) * (1 - share)
        posts += [(x, y, float(rng.uniform(6, 10))) for x, y in places.tolist()]
    ambient = rng.uniform(*level)
    blue, green, red = (ambient * part for part in tint)
    colour = _SODIUM if rng.random() < 0.4 else _LED
    return LampLight((blue, green, red), np.array(posts).reshape(-1, 3), colour, strength)

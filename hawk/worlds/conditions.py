"""Time of day and weather: their effect on a plan before it is drawn, and on the drawn ground."""

from __future__ import annotations

import numpy as np

from hawk.worlds.moment import Condition
from hawk.worlds.plan import SitePlan
from hawk.worlds.scene.canvas import Canvas, Floats, noise
from hawk.worlds.scene.light import LampLight, Sun
from hawk.worlds.scene.materials import grey

_SODIUM, _LED = (0.45, 0.78, 1.0), (1.0, 0.96, 0.9)  # blue, green, red of lamp light
_SNOW = (238.0, 236.0, 232.0)


def set_condition(plan: SitePlan, condition: Condition, sun: Sun, rng: np.random.Generator) -> Sun:
    """Prepare a plan for a condition; return the sun under it."""
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
        case Condition.SNOW:
            plan.snow = rng.uniform(0.2, 1.0)
        case Condition.LEAVES:
            plan.leaves = rng.uniform(0.3, 1.0)
    return sun


def draw_puddles(canvas: Canvas, wet: float, rng: np.random.Generator) -> None:
    """Make the ground wet (0..1): darker, with puddles that mirror the sky."""
    if wet <= 0:
        return
    per_metre = 1 / canvas.metres_per_pixel
    field = noise(rng, canvas.height, canvas.width, [9 * per_metre, 2.5 * per_metre], [0.7, 0.35])
    damp = np.clip(0.6 + field, 0, 1)[..., None]
    canvas.image *= 1 - np.float32(0.4 * wet) * damp
    puddle = np.clip((field - (1.15 - 0.3 * wet)) * 6, 0, 1)[..., None] * np.float32(0.75)
    sky = np.array(grey(rng, 90, 215, 4), np.float32)
    canvas.image += (sky - canvas.image) * puddle


def draw_snow(canvas: Canvas, amount: float, rng: np.random.Generator) -> None:
    """Draw patches of snow (0: none, 1: a third of the ground)."""
    if amount <= 0:
        return
    per_metre = 1 / canvas.metres_per_pixel
    field = noise(
        rng, canvas.height, canvas.width, [8 * per_metre, 1.5 * per_metre, 0.3 * per_metre], [0.7, 0.35, 0.12]
    )
    patch = np.clip((field - (1.2 - 0.8 * amount)) * 5, 0, 1)[..., None] * np.float32(rng.uniform(0.75, 0.97))
    canvas.image += (np.array(_SNOW, np.float32) - canvas.image) * patch


def draw_leaves(canvas: Canvas, plan: SitePlan, colours: Floats, rng: np.random.Generator) -> None:
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
    plan: SitePlan,
    rng: np.random.Generator,
    level: tuple[float, float],
    tint: tuple[float, float, float],
    strength: float,
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

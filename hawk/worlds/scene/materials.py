"""Materials of the ground and of roofs: sampled once for a place, then textured for each surface."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hawk.worlds.scene.canvas import Floats, noise

Colour = tuple[float, float, float]
"""Blue, green, red, 0..255."""


@dataclass(frozen=True, slots=True)
class Material:
    """A colour and how it varies.

    ``grain``, ``mottle`` and ``blotch`` are relative deviations at about 0.1 m, 0.6 m and 4 m; ``hue`` that of the
    colour itself. ``joints`` is the side of its slabs or bricks in metres (0: none).
    """

    kind: str
    colour: Colour
    grain: float
    mottle: float
    blotch: float
    hue: float = 0.0
    joints: float = 0.0


def sample_material(rng: np.random.Generator, kind: str) -> Material:
    """Draw a material of a kind.

    The kinds: asphalt, concrete, pavers, clinker, grass grid, grass, dirt, bark, gravel, rock, water, court, roof.
    """
    sampler = _SAMPLERS.get(kind)
    if sampler is None:
        raise ValueError(f"material: no kind {kind!r}; known are {', '.join(sorted(_SAMPLERS))}")
    return sampler(rng)


def texture(rng: np.random.Generator, material: Material, height: int, width: int, metres_per_pixel: float) -> Floats:
    """Return a (height, width, 3) float32 picture of the material."""
    per_metre = 1 / metres_per_pixel
    cells = [4 * per_metre, 0.6 * per_metre, 0.12 * per_metre]
    # what is finer than a pixel is seen as its mean: grain fades as pixels grow
    grain = material.grain * min(1.0, 0.09 / metres_per_pixel + 0.25)
    value = noise(rng, height, width, cells, [material.blotch, material.mottle, grain])
    value += 1
    picture = np.empty((height, width, 3), np.float32)
    for channel, level in enumerate(material.colour):
        np.multiply(value, np.float32(level), out=picture[..., channel])
    if material.hue > 0.005:
        shift = noise(rng, height, width, [1.5 * per_metre, 0.5 * per_metre], [material.hue, material.hue * 0.6])
        picture[..., 2] *= 1 + shift
        picture[..., 0] *= 1 - shift * 0.3
    return picture


def grey(rng: np.random.Generator, low: float, high: float, tint: float = 3.0) -> Colour:
    """Draw a nearly grey colour; warm or cold by ``tint``."""
    level = rng.uniform(low, high)
    warm = rng.normal(0, level * tint / 100)
    jitter = rng.normal(0, 1.5, 3)
    blue, green, red = np.clip(level + np.array([-warm, 0.1 * warm, warm]) + jitter, 4, 250)
    return float(blue), float(green), float(red)


def _asphalt(rng: np.random.Generator) -> Material:
    colour = grey(rng, 50, 185, 6) if rng.random() < 0.5 else grey(rng, 100, 200, 6)
    amount = rng.uniform(0.4, 1.5)
    return Material("asphalt", colour, 0.05 * amount, 0.014 * amount, 0.045 * amount, 0.004)


def _concrete(rng: np.random.Generator) -> Material:
    joints = float(rng.choice([0.0, rng.uniform(1.5, 6.0)], p=[0.3, 0.7]))
    return Material("concrete", grey(rng, 130, 222, 5), 0.02, 0.02, 0.04, 0.004, joints)


def _pavers(rng: np.random.Generator) -> Material:
    colour = (
        (rng.uniform(70, 140), rng.uniform(85, 150), rng.uniform(120, 190))
        if rng.random() < 0.6
        else grey(rng, 100, 190)
    )
    return Material("pavers", colour, 0.08, 0.03, 0.03, 0.02, float(rng.choice([0.4, 0.8, 1.2])))


def _clinker(rng: np.random.Generator) -> Material:
    """Baked bricks, from red over brown to grey; their joints are finer than a pixel."""
    level = rng.uniform(85, 160)
    red = rng.uniform(1.0, 1.28)
    colour = (level * rng.uniform(0.82, 0.98), level, level * red)
    return Material("clinker", colour, rng.uniform(0.04, 0.1), 0.035, 0.05, rng.uniform(0.005, 0.02))


def _grass_grid(rng: np.random.Generator) -> Material:
    """Concrete grids with grass in their holes."""
    level, green = rng.uniform(90, 150), rng.uniform(1.0, 1.18)
    return Material("grass grid", (level * 0.82, level * green, level), 0.11, 0.07, 0.1, rng.uniform(0.02, 0.05))


def _grass(rng: np.random.Generator) -> Material:
    green = rng.uniform(65, 130)
    dry = rng.uniform(0.72, 1.22)
    blue = green * rng.uniform(0.42, 0.66)
    return Material("grass", (blue, green, green * dry), 0.13, 0.07, 0.08, float(rng.choice([0.015, 0.03, 0.06])))


def _dirt(rng: np.random.Generator) -> Material:
    scale = rng.uniform(0.5, 1.3)
    return Material("dirt", (92 * scale, 118 * scale, 140 * scale), 0.09, 0.06, 0.07, 0.02)


def _bark(rng: np.random.Generator) -> Material:
    scale = rng.uniform(0.5, 1.15)
    return Material("bark", (72 * scale, 104 * scale, 150 * scale), 0.16, 0.12, 0.08, 0.04)


def _water(rng: np.random.Generator) -> Material:
    base = rng.uniform(30, 110)
    return Material(
        "water", (base * rng.uniform(1, 1.5), base * rng.uniform(0.9, 1.2), base * 0.8), 0.03, 0.02, 0.06, 0.01
    )


def _court(rng: np.random.Generator) -> Material:
    colours = (
        (70.0, 120.0, 60.0),
        (150.0, 95.0, 50.0),
        (60.0, 70.0, 150.0),
        (110.0, 110.0, 108.0),
        (70.0, 130.0, 175.0),
    )
    picked = np.clip(np.array(colours[int(rng.integers(len(colours)))]) * rng.uniform(0.7, 1.3), 5, 245)
    return Material("court", (float(picked[0]), float(picked[1]), float(picked[2])), 0.02, 0.02, 0.03)


def _roof(rng: np.random.Generator) -> Material:
    low, high = ((180, 246), (40, 110), (100, 190), (150, 235))[int(rng.integers(4))]
    colour = grey(rng, low, high, 8)
    if rng.random() < 0.15:
        colour = (rng.uniform(40, 130), rng.uniform(50, 120), rng.uniform(90, 190))
    return Material("roof", colour, 0.02, 0.02, 0.035, 0.004)


_SAMPLERS: dict[str, Callable[[np.random.Generator], Material]] = {
    "asphalt": _asphalt,
    "concrete": _concrete,
    "pavers": _pavers,
    "clinker": _clinker,
    "grass grid": _grass_grid,
    "grass": _grass,
    "dirt": _dirt,
    "bark": _bark,
    "gravel": lambda rng: Material("gravel", grey(rng, 95, 200, 6), 0.1, 0.04, 0.06, 0.01),
    "rock": lambda rng: Material("rock", grey(rng, 110, 180, 5), 0.2, 0.16, 0.05, 0.02),
    "water": _water,
    "court": _court,
    "roof": _roof,
}

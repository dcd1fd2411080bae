"""Style of one lot: the choices of building and painting that all of its rows share."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from hawk.worlds.scene.materials import Material, grey, sample_material

Marks = Literal["lines", "dots", "tees", "corners", "blocks"]
_LINE_COLOURS = ((235.0, 235.0, 235.0), (60.0, 190.0, 225.0), (220.0, 180.0, 120.0))
_ISLAND_KINDS = ("grass", "concrete", "dirt", "bark", "grass", "pavers")


@dataclass(frozen=True, slots=True)
class LotStyle:
    """Measures in metres, angles in radians, shares 0..1.

    ``skew`` leans the stalls away from square to the aisle. ``occupancy`` is the share taken; ``drop`` the share of
    lines that are missing or cut short, ``worn`` the share in worn stretches. ``ends`` weighs what closes a row:
    nothing, island, hatching. ``unpainted`` lots have cars in rows and no lines. ``marks`` are what parts two stalls:
    lines, ``dots`` (stones in a row with gaps), ``tees`` where they meet the aisle and the kerb, ``corners`` (their
    ends alone), or ``blocks`` at the closed end. ``bays`` is the ground of the stalls where it is not the aisle's.
    ``shelters`` is the share of slots that a roof for shopping carts stands on. ``bare_ends`` is the share of rows'
    ends at islands where no line bounds the last stall: the kerb does.
    """

    width: float
    length: float
    skew: float
    aisle: float
    occupancy: float
    line_width: float
    drop: float
    worn: float
    hairpin: bool
    tees: bool
    front_line: float
    back_line: float
    hatch: float
    wheel_stops: bool
    island: Material
    break_share: float
    trees: float
    crown: tuple[float, float]
    medians: float
    side_rows: float
    accessible: float
    ends: tuple[float, float, float]
    tidy: float
    kerb: tuple[float, float, float] | None
    unpainted: bool
    shelters: float = 0.0
    bare_ends: float = 0.0
    marks: Marks = "lines"
    bays: Material | None = None

    @property
    def pitch(self) -> float:
        """Distance between lines along the row."""
        return self.width / math.cos(self.skew)

    @property
    def depth(self) -> float:
        """Depth of a row, square to the aisle."""
        return self.length * math.cos(self.skew) + 0.35 * self.width * math.sin(abs(self.skew))

    @property
    def shift(self) -> float:
        """Distance along the row from a line's open end to its closed end."""
        return self.depth * math.tan(self.skew)


def sample_style(rng: np.random.Generator, *, calm: bool = False) -> LotStyle:
    """Draw a style; ``calm`` ones are those of most lots (the simulator's worlds), else any style is possible."""
    skewed = rng.random() < (0.32 if calm else 0.38)
    skew = 0.0
    if skewed:
        skew = math.radians(rng.uniform(12, 45) if calm else rng.uniform(8, 50)) * (1 if rng.random() < 0.5 else -1)
    return LotStyle(
        width=rng.uniform(2.45, 2.85) if calm else rng.uniform(2.3, 3.1),
        length=rng.uniform(4.9, 5.6) if calm else rng.uniform(4.6, 6.1),
        skew=skew,
        aisle=rng.uniform(6.0, 7.6) if calm else rng.uniform(5.2, 8.5),
        occupancy=rng.uniform(0.42, 0.8) if calm else _occupancy(rng),
        line_width=rng.uniform(0.10, 0.16) if calm else rng.uniform(0.1, 0.21),
        drop=float(rng.choice([0.01, 0.03]) if calm else rng.choice([0, 0.02, 0.08, 0.2], p=[0.4, 0.3, 0.2, 0.1])),
        worn=rng.uniform(0.15, 0.3) if calm else float(rng.choice([0, 0.1, 0.3, 0.6], p=[0.4, 0.3, 0.2, 0.1])),
        hairpin=bool(rng.random() < (0.04 if calm else 0.09)),
        tees=bool(rng.random() < 0.12),
        front_line=float(rng.random() < 0.06),
        back_line=float(rng.random() < 0.5),
        hatch=float(rng.choice([0.015, 0.02, 0.05] if calm else [0.02, 0.02, 0.1])),
        wheel_stops=bool(rng.random() < 0.16),
        island=sample_material(rng, str(rng.choice(_ISLAND_KINDS))),
        break_share=float(rng.choice([0.0, 0.04, 0.08] if calm else [0.0, 0.0, 0.04, 0.12])),
        trees=float(rng.choice([0.15, 0.3, 0.5] if calm else [0, 0.15, 0.4, 0.8])),
        crown=(1.1, rng.uniform(2.6, 4.6)),
        medians=float(rng.choice([0.25, 0.6] if calm else [0.1, 0.45, 0.8])),
        side_rows=0.4,
        accessible=float(rng.choice([0.1, 0.3])),
        ends=(0.3, 0.43, 0.27),
        tidy=rng.uniform(0.5, 1.6),
        kerb=grey(rng, 140, 228) if rng.random() < 0.65 else None,
        unpainted=bool(not calm and rng.random() < 0.03),
        shelters=0.0 if calm else float(rng.choice([0.0, 0.0, 0.03])),
        bare_ends=0.0 if calm else float(rng.choice([0.0, 0.6])),
    )


def sample_palette(rng: np.random.Generator, asphalt: float, *, calm: bool = False) -> list[tuple[float, float, float]]:
    """Draw the paint: colour 0 of the stalls, 1 of hatching, 2 of accessible signs (blue ground), 3 white.

    ``asphalt`` is the brightness of the ground under the paint. Thin paint is mixed towards it, but a least contrast
    stays, because invisible lines teach nothing.
    """
    first = int(rng.choice(3, p=[0.75, 0.24, 0.01] if calm else [0.62, 0.34, 0.04]))
    other = first if rng.random() < 0.6 else int(rng.choice([0, 1]))
    opacity = rng.uniform(0.65, 1.0) if calm else rng.uniform(0.55, 1.0)
    colours = []
    for number in (first, other):
        pure = np.clip(np.array(_LINE_COLOURS[number]) * rng.uniform(0.82, 1.07), 0, 250)
        contrast = max(1.0, float(np.abs(pure - asphalt).max()))
        share = max(opacity, min(1.0, rng.uniform(*((32, 62) if calm else (60, 120))) / contrast))
        mixed = asphalt + (pure - asphalt) * share
        colours.append((float(mixed[0]), float(mixed[1]), float(mixed[2])))
    blue = np.clip(np.array([175.0, 110.0, 50.0]) * rng.uniform(0.7, 1.25), 0, 250)
    colours.append((float(blue[0]), float(blue[1]), float(blue[2])))
    colours.append(grey(rng, 205, 245, 1))
    return colours


def _occupancy(rng: np.random.Generator) -> float:
    low, high = ((0.0, 0.25), (0.2, 0.8), (0.75, 1.0))[int(rng.integers(3))]
    return float(rng.uniform(low, high))

"""Plain plans, styles and worlds for the tests of drawn places."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from hawk.worlds.plan import Axes, PlannedStall, SitePlan
from hawk.worlds.scene.light import Sun
from hawk.worlds.scene.materials import Material
from hawk.worlds.style import LotStyle

GREY = Material("asphalt", (100.0, 100.0, 100.0), 0, 0, 0)
WHITE = Material("concrete", (200.0, 200.0, 200.0), 0, 0, 0)
EAST = Axes((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))
SUN = Sun((2.0, 0.0), (0.5, 0.4, 0.3), 0.0)
"""Shadows fall east, twice as long as things are high."""


def generator(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def plain_plan(**changes: object) -> SitePlan:
    fields = {"axes": EAST, "ground": GREY, "asphalt": GREY, "palette": [(255.0, 255.0, 255.0)] * 4, "wear": 0.0}
    return SitePlan(**{**fields, **changes})  # type: ignore[arg-type]


def plain_style(**changes: object) -> LotStyle:
    """A lot of square stalls with plain lines, half of them taken."""
    plain: dict[str, object] = {
        "width": 2.5, "length": 5.0, "skew": 0.0, "aisle": 6.0, "occupancy": 0.5, "line_width": 0.12, "drop": 0.0,
        "worn": 0.0, "hairpin": False, "tees": False, "front_line": 0.0, "back_line": 0.0, "hatch": 0.0,
        "wheel_stops": False, "island": GREY, "break_share": 0.0, "trees": 0.0, "crown": (1.0, 2.0), "medians": 0.0,
        "side_rows": 0.0, "accessible": 0.0, "ends": (1.0, 0.0, 0.0), "tidy": 1.0, "kerb": None, "unpainted": False,
    }  # fmt: skip
    return LotStyle(**{**plain, **changes})  # type: ignore[arg-type]


def square(x: float, y: float, side: float) -> NDArray[np.float64]:
    return np.array([[x, y], [x + side, y], [x + side, y + side], [x, y + side]])


def areas_of(stalls: list[PlannedStall]) -> list[shapely.Polygon]:
    return [shapely.Polygon(stall.corners) for stall in stalls]


def largest_overlap(polygons: list[shapely.Polygon]) -> float:
    """The largest common area (m²) of any two of the polygons, on a grid of a micrometre."""
    if not polygons:
        return 0.0
    pairs = shapely.STRtree(polygons).query(polygons, predicate="intersects").T
    common = [shapely.intersection(polygons[a], polygons[b], grid_size=1e-6).area for a, b in pairs if a < b]
    return max(common, default=0.0)

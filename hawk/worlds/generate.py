"""Worlds drawn from a seed."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
import shapely

from hawk.worlds.canvas import Bytes, Canvas, Points
from hawk.worlds.cars import footprint_m
from hawk.worlds.conditions import Condition, set_condition
from hawk.worlds.facets import FacetSet, ground_projection
from hawk.worlds.light import sample_sun
from hawk.worlds.plan import SitePlan
from hawk.worlds.render import draw_plan
from hawk.worlds.site import SiteSize, plan_lot_site
from hawk.worlds.world import TrueStall, World, WorldError

_HIDDEN_SHARE = 0.5
_COVER_M = 0.2
_ATTEMPTS = 60
_GRID_M = 1e-6


@dataclass(frozen=True, slots=True)
class WorldOptions:
    """Requirements on a generated world. Sizes in metres, shares 0..1.

    ``difficult`` is the least share of stalls with worn lines or partly under a crown. ``condition``: time of day and
    weather; the same seed is the same lot with the same cars in all of them.
    """

    width: tuple[float, float] = (112.0, 138.0)
    height: tuple[float, float] = (92.0, 118.0)
    metres_per_pixel: float = 0.05
    stalls: tuple[int, int] = (84, 330)
    taken: tuple[float, float] = (0.32, 0.88)
    difficult: float = 0.16
    condition: Condition = Condition.DAY

    def __post_init__(self) -> None:
        if not 0.02 <= self.metres_per_pixel <= 0.5:
            raise WorldError("metres_per_pixel: must be between 0.02 and 0.5")
        for name, (low, high) in (("width", self.width), ("height", self.height)):
            if not 40 <= low <= high <= 400:
                raise WorldError(f"{name}: must be a range within 40..400 m, not {low}..{high}")


def generate_world(seed: int, options: WorldOptions | None = None) -> World:
    """Draw the world of a seed; the same seed and options give the same world.

    Raises WorldError when no plan meets the options.
    """
    options = options or WorldOptions()
    rng = np.random.default_rng(seed)
    mpp = options.metres_per_pixel
    width, height = (round(rng.uniform(*span) / mpp) for span in (options.width, options.height))
    size_m = (width * mpp, height * mpp)
    for _ in range(_ATTEMPTS):
        plan = _plan(rng, size_m)
        if _is_good(plan, size_m, options):
            canvas = Canvas(0.0, 0.0, width, height, mpp)
            return _draw(seed, plan, canvas, rng, options.condition)
    raise WorldError(f"seed {seed}: no lot out of {_ATTEMPTS} meets the options; widen stalls, taken or the size")


def _plan(rng: np.random.Generator, size_m: tuple[float, float]) -> SitePlan:
    """Plan a lot that leaves a rim of surroundings on all sides."""
    longer, shorter = max(size_m), min(size_m)
    size = SiteSize(width=(0.48 * longer, 0.74 * longer), depth=(0.38 * shorter, 0.66 * shorter), second=0.35)
    centre = (size_m[0] / 2 + rng.normal(0, 2), size_m[1] / 2 + rng.normal(0, 2))
    return plan_lot_site(rng, centre, size)


def _is_good(plan: SitePlan, size_m: tuple[float, float], options: WorldOptions) -> bool:
    """Return True when a plan meets the options; crowns are circles here."""
    count = len(plan.stalls)
    if not options.stalls[0] <= count <= options.stalls[1]:
        return False
    taken = sum(stall.taken for stall in plan.stalls) / count
    if not options.taken[0] <= taken <= options.taken[1]:
        return False
    corners = np.concatenate(plan.lots)
    middles = [building.axes.at(building.width / 2, building.depth / 2) for building in plan.buildings]
    if not any(0 < x < size_m[0] and 0 < y < size_m[1] for x, y in middles):
        return False
    if (corners < 1).any() or (corners > np.array(size_m) - 1).any():
        return False
    return _difficult_share(plan) >= options.difficult


def _difficult_share(plan: SitePlan) -> float:
    # a crown is ragged: only the inner part of its circle hides a stall
    crowns = shapely.STRtree([shapely.Point(tree.x, tree.y).buffer(0.8 * tree.radius) for tree in plan.trees])
    quads = [shapely.Polygon(stall.corners).buffer(-0.3) for stall in plan.stalls]
    under = set(crowns.query(quads, predicate="intersects")[0].tolist())
    hard = [stall.worn or k in under for k, stall in enumerate(plan.stalls)]
    return sum(hard) / max(1, len(hard))


def _draw(seed: int, plan: SitePlan, canvas: Canvas, rng: np.random.Generator, condition: Condition) -> World:
    # its own numbers: the same seed is the same lot in every condition
    sun = set_condition(plan, condition, sample_sun(rng, calm=True), np.random.default_rng((seed, 1)))
    drawn = draw_plan(plan, canvas, sun, rng)
    ground = np.clip(drawn.ground, 0, 255, out=drawn.ground).astype(np.uint8)
    cover = _cover(canvas, FacetSet([layer for layer in drawn.layers if layer.label in ("tree", "roof")]))
    vehicles = shapely.union_all([shapely.Polygon(footprint_m(vehicle)) for vehicle in plan.vehicles])
    stalls = [
        TrueStall(
            id=number,
            corners=stall.corners,
            taken=stall.taken,
            hidden=_covered(cover, stall.corners) > _HIDDEN_SHARE,
            worn=stall.worn,
            kind=stall.kind,
            covered=share_under(stall.corners, vehicles),
        )
        for number, stall in enumerate(plan.stalls)
    ]
    return World(
        name=f"seed-{seed}",
        metres_per_pixel=canvas.metres_per_pixel,
        ground=ground,
        layers=drawn.layers,
        stalls=tuple(stalls),
        lots=tuple(plan.lots),
        seed=seed,
    )


def _cover(canvas: Canvas, facets: FacetSet) -> Bytes:
    """Return a coarse 0/1 mask of the ground under crowns and roofs, from straight above."""
    width, height = (round(side * canvas.metres_per_pixel / _COVER_M) for side in (canvas.width, canvas.height))
    mask = np.zeros((height, width), np.uint8)
    for layer in facets.seen(ground_projection((0.0, 0.0), _COVER_M), width, height):
        layer.mark(mask, 1)
    return mask


def _covered(mask: Bytes, corners: Points) -> float:
    inside = np.zeros(mask.shape, np.uint8)
    cv2.fillConvexPoly(inside, np.round((corners / _COVER_M - 0.5) * 16).astype(np.int32), 1, shift=4)
    low = np.maximum(np.floor(corners.min(0) / _COVER_M).astype(int) - 1, 0)
    high = np.ceil(corners.max(0) / _COVER_M).astype(int) + 1
    part = np.s_[low[1] : high[1], low[0] : high[0]]
    return float((mask[part] & inside[part]).sum()) / max(1, int(inside[part].sum()))


def share_under(corners: Points, vehicles: shapely.Geometry) -> float:
    """Return the share (0..1) of a stall under vehicles.

    Measured on a grid: without one GEOS merges two outlines whose common edge differs by rounding.
    """
    quad = shapely.Polygon(corners)
    return float(shapely.intersection(quad, vehicles, grid_size=_GRID_M).area / quad.area)

"""Worlds drawn from a seed."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from datetime import datetime

import cv2
import numpy as np
import shapely

from hawk.model.sun import sun_position
from hawk.worlds import MOST_CHANGES
from hawk.worlds.conditions import set_condition
from hawk.worlds.daylight import light_at
from hawk.worlds.layout import asphalt_details, plan_section
from hawk.worlds.moment import HOURS, Condition, clock_of
from hawk.worlds.parked_cars import number_stalls, park, stays_of
from hawk.worlds.plan import Axes, SitePlan, Surface
from hawk.worlds.repaint import repaint
from hawk.worlds.scene.canvas import Bytes, Canvas, Points
from hawk.worlds.scene.cars import footprint_m
from hawk.worlds.scene.facets import FacetSet, ground_projection
from hawk.worlds.scene.light import Sun, sample_sun
from hawk.worlds.scene.materials import Material, sample_material
from hawk.worlds.scene.render import OwnStreams, Streams, draw_plan
from hawk.worlds.scene.surroundings import plan_clutter, plan_side
from hawk.worlds.style import LotStyle, sample_palette, sample_style
from hawk.worlds.world import TrueStall, World, WorldError

Rect = tuple[float, float, float, float]
"""u0, v0, u1, v1 of a section in the site's axes, metres."""


@dataclass(frozen=True, slots=True)
class SiteSize:
    """Range of the main section's width and depth in metres, and the probability of a second one."""

    width: tuple[float, float]
    depth: tuple[float, float]
    second: float


def plan_lot_site(rng: np.random.Generator, centre: tuple[float, float], size: SiteSize) -> SitePlan:
    """Plan a usual lot about ``centre`` (metres) with its surroundings, a road and a building among them."""
    plan = empty_plan(rng, centre, calm=True)
    sections, links = plan_sections(rng, size)
    lots = outlines(plan.axes, [*sections, *links])
    sides, kinds = sides_of(plan.axes, sections), ("road", "building", None, None)
    for k in rng.permutation(4):
        plan_side(plan, rng, *sides[k], kind=kinds[k])
    fill_lots(plan, rng, lots, sections, sample_style(rng, calm=True))
    return plan


def fill_lots(
    plan: SitePlan, rng: np.random.Generator, lots: list[Points], sections: list[Rect], style: LotStyle
) -> None:
    """Cover the outlines of the lots with asphalt, and fill their sections with rows and small things."""
    plan.settle()
    for outline in lots:
        plan.add_surface(Surface(outline, plan.asphalt))
    plan.lots.extend(lots)
    for r in sections:
        corner = plan.axes.moved(r[0], r[1])
        width, depth = r[2] - r[0], r[3] - r[1]
        asphalt_details(plan, rng, corner, width, depth)
        plan_clutter(plan, rng, corner, width, depth)
        if rng.random() < 0.25:  # rows across
            plan_section(plan, rng, plan.axes.moved(r[2], r[1]).facing((0, 1), (-1, 0)), depth, width, style)
        else:
            plan_section(plan, rng, corner, width, depth, style)


def empty_plan(rng: np.random.Generator, centre: tuple[float, float], *, calm: bool) -> SitePlan:
    """Return a plan of ground and asphalt only; ``calm`` ones are those of most lots."""
    kind = "asphalt" if calm else str(rng.choice(["asphalt", "concrete", "pavers"], p=[0.88, 0.08, 0.04]))
    asphalt = sample_material(rng, kind)
    asphalt = darkened(asphalt, 165 if calm else 182)  # white paint must show on it
    return SitePlan(
        axes=Axes.turned(centre, rng.uniform(0, 2 * math.pi)),
        ground=sample_material(rng, str(rng.choice(["grass", "dirt", "concrete", "grass"]))),
        asphalt=asphalt,
        palette=sample_palette(rng, float(np.mean(asphalt.colour)), calm=calm),
        wear=rng.uniform(0.1, 0.9) if calm else rng.uniform(0.0, 0.75),
        wet=rng.uniform(0.2, 1.0) if not calm and rng.random() < 0.06 else 0.0,
    )


def darkened(material: Material, brightest: float) -> Material:
    """Return the material no brighter than ``brightest`` (0..255)."""
    scale = min(1.0, brightest / max(material.colour))
    blue, green, red = (channel * scale for channel in material.colour)
    return replace(material, colour=(blue, green, red))


def plan_sections(rng: np.random.Generator, size: SiteSize) -> tuple[list[Rect], list[Rect]]:
    """Return the sections with stalls, and the links (aisles) between those that do not touch."""
    width, depth = rng.uniform(*size.width), rng.uniform(*size.depth)
    main = (-width / 2, -depth / 2, width / 2, depth / 2)
    if rng.random() >= size.second:
        return [main], []
    second_width, second_depth = width * rng.uniform(0.35, 0.6), depth * rng.uniform(0.4, 0.8)
    gap = 0.0 if rng.random() < 0.6 else rng.uniform(2.5, 7)
    low = -depth / 2 if rng.random() < 0.5 else depth / 2 - second_depth
    shift = second_width / 2
    main = (main[0] - shift, main[1], main[2] - shift, main[3])
    second = (main[2] + gap, low, main[2] + gap + second_width, low + second_depth)
    middle = low + second_depth * rng.uniform(0.3, 0.7)
    links = [(main[2] - 0.5, middle - 3.5, second[0] + 0.5, middle + 3.5)] if gap else []
    return [main, second], links


def outlines(axes: Axes, rects: list[Rect]) -> list[Points]:
    """Return the outlines (N, 2) of rectangles of ``axes``, those that touch as one; metres."""
    boxes = [shapely.box(*r).buffer(0.005, join_style="mitre") for r in rects]
    union = shapely.union_all(boxes).simplify(0.02)
    parts = union.geoms if hasattr(union, "geoms") else [union]
    return [axes.points(np.asarray(part.exterior.coords)[:-1]) for part in parts]


def sides_of(axes: Axes, rects: list[Rect]) -> list[tuple[Axes, float]]:
    """Return the four sides of the box about sections: axes at its middle with v outwards, and half its length."""
    u0, v0, u1, v1 = (f(r[k] for r in rects) for k, f in enumerate((min, min, max, max)))
    middle_u, middle_v = (u0 + u1) / 2, (v0 + v1) / 2
    return [
        (axes.moved(middle_u, v0).facing((1, 0), (0, -1)), (u1 - u0) / 2),
        (axes.moved(middle_u, v1).facing((1, 0), (0, 1)), (u1 - u0) / 2),
        (axes.moved(u0, middle_v).facing((0, 1), (-1, 0)), (v1 - v0) / 2),
        (axes.moved(u1, middle_v).facing((0, 1), (1, 0)), (v1 - v0) / 2),
    ]


_HIDDEN_SHARE = 0.5
_COVER_M = 0.2
_ATTEMPTS = 60
_GRID_M = 1e-6


@dataclass(frozen=True, slots=True)
class WorldOptions:
    """Requirements on a generated world. Sizes in metres, shares 0..1.

    ``difficult`` is the least share of stalls with worn lines or partly under a crown. ``condition``: time of day and
    weather; the same seed is the same lot with the same cars in all of them.

    ``at`` is an aware moment, at ``place`` (latitude, longitude): the cars
    are those that stand there then, the light is that of the hour, and ``condition`` is the weather. Without it the lot
    has the cars and the sun of its seed. ``repaint`` is the number of changes of the layout (`hawk.worlds.repaint`).
    """

    width: tuple[float, float] = (112.0, 138.0)
    height: tuple[float, float] = (92.0, 118.0)
    metres_per_pixel: float = 0.05
    stalls: tuple[int, int] = (84, 330)
    taken: tuple[float, float] = (0.32, 0.88)
    difficult: float = 0.16
    condition: Condition = Condition.DAY
    repaint: int = 0
    at: datetime | None = None
    place: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        if not 0.02 <= self.metres_per_pixel <= 0.5:
            raise WorldError("metres_per_pixel: must be between 0.02 and 0.5")
        for name, (low, high) in (("width", self.width), ("height", self.height)):
            if not 40 <= low <= high <= 400:
                raise WorldError(f"{name}: must be a range within 40..400 m, not {low}..{high}")
        if not 0 <= self.repaint <= MOST_CHANGES:
            raise WorldError(f"repaint: must be 0 to {MOST_CHANGES}, not {self.repaint}")
        if self.at is not None and self.condition in HOURS:
            raise WorldError(f"condition: {self.condition} is a time of day, which the moment (at) says; leave one out")


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
            number_stalls(plan)
            for number in range(1, options.repaint + 1):
                repaint(plan, seed, number, size_m)
            return _draw(seed, plan, canvas, rng, options)
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


def _draw(seed: int, plan: SitePlan, canvas: Canvas, rng: np.random.Generator, options: WorldOptions) -> World:
    sampled = sample_sun(rng, calm=True)
    streams, stays = OwnStreams(seed) if options.repaint else Streams(rng), None
    if options.at is not None:
        stays = stays_of(plan, seed, clock_of(options.place[1]))
        park(plan, stays.at(options.at), options.at, seed)
        streams = OwnStreams(seed)
    drawn = draw_plan(plan, canvas, _light(seed, plan, sampled, options), streams)
    ground = np.clip(drawn.ground, 0, 255, out=drawn.ground).astype(np.uint8)
    cover = _cover(canvas, FacetSet([layer for layer in drawn.layers if layer.label in ("tree", "roof")]))
    vehicles = shapely.union_all([shapely.Polygon(footprint_m(vehicle)) for vehicle in plan.vehicles])
    stalls = [
        TrueStall(
            id=number if stall.number is None else stall.number,
            corners=stall.corners,
            taken=stall.taken,
            hidden=_covered(cover, stall.corners) > _HIDDEN_SHARE,
            worn=stall.worn,
            kind=stall.kind,
            covered=share_under(stall.corners, vehicles),
            unclear=stall.closed,
            closed=stall.closed,
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
        at=options.at,
        stays=stays,
    )


def _light(seed: int, plan: SitePlan, sampled: Sun, options: WorldOptions) -> Sun:
    rng = np.random.default_rng((seed, 1))  # its own numbers: the same seed is the same lot in every condition
    if options.at is None:
        return set_condition(plan, options.condition, sampled, rng)
    return light_at(plan, options.condition, sun_position(options.at, *options.place), sampled, rng)


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

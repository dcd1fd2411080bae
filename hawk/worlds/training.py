"""Scenes to train on: small orthophotos of drawn places with everything that is known of them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np

from hawk.worlds.avenues import plant_avenue
from hawk.worlds.canvas import Bytes, Canvas, Floats, Points, as_bytes
from hawk.worlds.conditions import sample_condition, set_condition
from hawk.worlds.facets import FacetSet, ground_projection
from hawk.worlds.light import sample_sun
from hawk.worlds.photometry import photograph
from hawk.worlds.plan import Plan, PlannedStall
from hawk.worlds.render import draw_plan
from hawk.worlds.site import SiteSize, plan_bare_site, plan_lot_site, plan_plain_site

BARE_SHARE = 0.16
"""Share of the scenes that have no lot at all."""
PLAIN_SHARE = 0.08
"""Share of the scenes whose lot has next to nothing around it."""
AVENUE_SHARE = 0.25
"""Share of the scenes with a line of trees or a hedge at the heads of a row, besides the trees that all have."""
HIDDEN_SHARE = 0.7
"""A stall is hidden when more of it than this lies under crowns and roofs."""

_VISIBLE_LEVELS = 9.0  # grey levels between paint and ground
_SEEN_SHARE, _BESIDE = 0.5, 2.6
_SITES = (
    SiteSize(width=(16, 95), depth=(10, 72), second=0.12),
    SiteSize(width=(60, 150), depth=(45, 120), second=0.12),
)
"""Half of the lots reach beyond the picture on most sides, as real ones do."""


@dataclass(frozen=True, slots=True)
class SceneStall:
    """A stall in a scene.

    ``quad`` is (4, 2) pixels (pixel centres are whole numbers); quad[0]-quad[1] and quad[2]-quad[3] are the short ends.
    ``lines_visible`` tells whether at least one of its long lines can be seen; ``paint`` (0..1) how much paint the
    better one kept; ``covered`` the share (0..1) of it under crowns and roofs; ``hidden`` that it is too much;
    ``implied`` that mostly crowns hide it and that a stall within two or three widths can be seen: the row tells of it.
    """

    quad: Points
    taken: bool
    hidden: bool
    worn: bool
    lines_visible: bool
    paint: float
    covered: float
    kind: str
    implied: bool = False


@dataclass(frozen=True, slots=True)
class Scene:
    """A drawn orthophoto, north of nothing: BGR uint8 (H, W, 3), with uint8 masks (H, W) of 0 and 1.

    ``lot`` is the lot (aisles, stalls, islands and the trees on them), ``car`` what is visible of vehicles, ``cover``
    what crowns and roofs hide.
    """

    image: Bytes
    lot: Bytes
    car: Bytes
    cover: Bytes
    stalls: tuple[SceneStall, ...]
    metres_per_pixel: float


def draw_scene(
    rng: np.random.Generator, size_px: int | tuple[int, int] = 384, *, metres_per_pixel: float = 0.10
) -> Scene:
    """Draw a scene of ``size_px`` (a side, or height and width); the same generator state gives the same scene."""
    height, width = (size_px, size_px) if isinstance(size_px, int) else size_px
    if min(height, width) < 32 or metres_per_pixel <= 0:
        raise ValueError("draw_scene: size_px must be at least 32 and metres_per_pixel above 0")
    plan = _plan(rng)
    plan.dim_cars = float(rng.choice([0.0, 0.15, 0.4]))
    if rng.random() < AVENUE_SHARE:
        for _ in range(int(rng.integers(1, 4))):
            plant_avenue(plan, rng)
    x, y = _window_centre(rng, plan) - np.array([width, height]) * metres_per_pixel / 2
    canvas = Canvas(float(x), float(y), width, height, metres_per_pixel)
    sun = set_condition(plan, sample_condition(rng), sample_sun(rng), rng)
    drawn = draw_plan(plan, canvas, sun, rng)
    image, car, cover, roofs = _composite(rng, canvas, drawn.ground, FacetSet(drawn.layers))
    contrast = float(np.abs(np.array(plan.palette[0]) - plan.asphalt.colour).max())
    shown = [stall for stall in plan.stalls if canvas.touches(stall.corners, 1.0)]
    stalls = _implied([_scene_stall(canvas, stall, cover, contrast) for stall in shown], roofs)
    picture = photograph(rng, image)
    return Scene(picture, _lot_mask(canvas, plan), car, cover, stalls, metres_per_pixel)


def _plan(rng: np.random.Generator) -> Plan:
    kind = rng.random()
    if kind < BARE_SHARE:
        return plan_bare_site(rng, (0.0, 0.0))
    if kind < BARE_SHARE + PLAIN_SHARE:
        return plan_plain_site(rng, (0.0, 0.0))
    return plan_lot_site(rng, (0.0, 0.0), _SITES[int(rng.integers(len(_SITES)))])


def _window_centre(rng: np.random.Generator, plan: Plan) -> Points:
    """Pick where to look: a place in the lot or near its edge."""
    if not plan.lots:
        return rng.uniform(-12, 12, 2)
    if plan.stalls and rng.random() < 0.85:
        picked = plan.stalls[int(rng.integers(len(plan.stalls)))].corners.mean(0)
        return np.asarray(picked + rng.normal(0, 6, 2))
    outline = plan.lots[int(rng.integers(len(plan.lots)))]
    edge = int(rng.integers(len(outline)))
    share = rng.random()
    return np.asarray(outline[edge] * share + outline[(edge + 1) % len(outline)] * (1 - share) + rng.normal(0, 6, 2))


def _composite(
    rng: np.random.Generator, canvas: Canvas, ground: Floats, facets: FacetSet
) -> tuple[Floats, Bytes, Bytes, Bytes]:
    """Lay what stands over the ground, seen as by a map or by a drone nearby; return picture, cars, cover and roofs."""
    viewer = None
    if rng.random() < 0.7:
        centre = canvas.origin + np.array([canvas.width, canvas.height]) * canvas.metres_per_pixel / 2
        height = rng.uniform(18, 70)
        x, y = centre + rng.normal(0, 0.3, 2) * height
        viewer = (float(x), float(y), height)
    projection = ground_projection((canvas.origin[0], canvas.origin[1]), canvas.metres_per_pixel, viewer)
    image = as_bytes(cv2.cvtColor(as_bytes(np.clip(ground, 0, 255)), cv2.COLOR_BGR2BGRA))
    car = np.zeros(image.shape[:2], np.uint8)
    cover = np.zeros(image.shape[:2], np.uint8)
    roofs = np.zeros(image.shape[:2], np.uint8)
    for laid in facets.seen(projection, canvas.width, canvas.height):
        laid.paint(image)
        laid.mark(car, laid.label == "car")
        laid.mark(cover, laid.label in ("tree", "roof", "wall"))
        laid.mark(roofs, laid.label in ("roof", "wall"))
    smooth = cv2.GaussianBlur(cv2.cvtColor(image, cv2.COLOR_BGRA2BGR), (3, 3), 0.4)
    return smooth.astype(np.float32), car, cover, roofs


def _lot_mask(canvas: Canvas, plan: Plan) -> Bytes:
    mask = np.zeros((canvas.height, canvas.width), np.uint8)
    for outline in plan.lots:
        cv2.fillPoly(mask, [np.round(canvas.to_px(outline) * 16).astype(np.int32)], 1, shift=4)
    for building in plan.buildings:
        if building.shelter:
            continue
        cv2.fillPoly(mask, [np.round(canvas.to_px(building.polygon) * 16).astype(np.int32)], 0, shift=4)
    return mask


def _scene_stall(canvas: Canvas, stall: PlannedStall, cover: Bytes, contrast: float) -> SceneStall:
    quad = canvas.to_px(stall.corners)
    covered = _share(cover, quad)
    return SceneStall(
        quad=quad,
        taken=stall.taken,
        hidden=covered >= HIDDEN_SHARE,
        worn=stall.worn,
        lines_visible=stall.paint * contrast > _VISIBLE_LEVELS,
        paint=stall.paint,
        covered=covered,
        kind=stall.kind,
    )


def _implied(stalls: list[SceneStall], roofs: Bytes) -> tuple[SceneStall, ...]:
    """Mark the stalls that mostly crowns hide and that have another one in sight nearby."""
    seen = np.array([stall.quad.mean(0) for stall in stalls if stall.covered < _SEEN_SHARE]).reshape(-1, 2)
    marked = []
    for stall in stalls:
        if stall.hidden and len(seen):
            reach = _BESIDE * float(np.linalg.norm(stall.quad[1] - stall.quad[0]))
            is_beside = bool((np.hypot(*(seen - stall.quad.mean(0)).T) < reach).any())
            stall = replace(stall, implied=is_beside and _share(roofs, stall.quad) < _SEEN_SHARE)
        marked.append(stall)
    return tuple(marked)


def _share(mask: Bytes, quad: Points) -> float:
    """Return the mean of a 0/1 mask over a quadrilateral, 0 where nothing of it lies in the picture."""
    low = np.maximum(np.floor(quad.min(0)).astype(int), 0)
    high = np.minimum(np.ceil(quad.max(0)).astype(int) + 1, (mask.shape[1], mask.shape[0]))
    if (high <= low).any():
        return 0.0
    part = mask[low[1] : high[1], low[0] : high[0]]
    inside = np.zeros(part.shape, np.uint8)
    cv2.fillConvexPoly(inside, np.round((quad - low) * 16).astype(np.int32), 1, shift=4)
    total = int(inside.sum())
    return float((part & inside).sum()) / total if total else 0.0

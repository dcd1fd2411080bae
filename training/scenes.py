"""Scenes to train on: small orthophotos of drawn places with the truth about them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import cv2
import numpy as np

from hawk.worlds.conditions import set_condition
from hawk.worlds.generate import SiteSize
from hawk.worlds.moment import Condition
from hawk.worlds.plan import PlannedStall, SitePlan
from hawk.worlds.scene.canvas import Bytes, Canvas, Floats, Points, as_bytes, as_floats, noise
from hawk.worlds.scene.facets import FacetSet, ground_projection
from hawk.worlds.scene.light import sample_sun
from hawk.worlds.scene.render import AS_DRAWN, Looks, draw_plan
from training.avenues import plant_avenue
from training.crossings import plan_crossing_site
from training.decks import plan_deck_site
from training.long_vehicles import park_long_vehicle
from training.paved import plan_paved_site
from training.row_breaks import break_row
from training.sites import plan_any_lot_site, plan_bare_site, plan_plain_site
from training.streets import plan_street_site

Change = tuple[float, int, Callable[[SitePlan, np.random.Generator], None]]

BARE_SHARE = 0.16
"""Share of the scenes that have no lot at all."""
PLAIN_SHARE = 0.06
"""Share of the scenes with hardly anything around the lot."""
PAVED_SHARE = 0.18
"""Share of the scenes with a lot without paint."""
STREET_SHARE = 0.22
"""Share of the scenes with a street of houses."""
CROSSING_SHARE = 0.07
"""Share of the scenes with a crossing: vehicles that wait side by side, and no stall."""
DECK_SHARE = 0.06
"""Share of the scenes with the deck of a garage."""
CHANGES: tuple[Change, ...] = (
    (0.2, 3, break_row),
    (0.3, 4, park_long_vehicle),
    (0.35, 3, plant_avenue),
)
"""Changes of a planned site: share of the scenes, places at most in one of them, and who makes the change."""
HIDDEN_SHARE = 0.7
"""A stall is hidden when more of it than this is under crowns and roofs."""

_VISIBLE_LEVELS = 9.0  # grey levels between paint and ground
_SEEN_SHARE, _BESIDE = 0.6, 2.6
_BARE_TREES = 0.15
"""Share of the scenes with painted lots whose trees have no leaves."""
_FRAME_WIDTHS, _IN_ROW, _OWN = 2.5, 0.35, 0.5
"""Cars that frame a stall: widths away at most, lengths out of line at most, widths off its middle at least."""
_SHADE = 0.5
"""Ground in a deeper shadow than this is in the shade."""
SITES = (
    SiteSize(width=(16, 95), depth=(10, 72), second=0.12),
    SiteSize(width=(60, 150), depth=(45, 120), second=0.12),
)
"""Half of the lots reach beyond the picture on most sides, as real ones do."""
CONDITION_SHARES = {
    Condition.DAY: 0.73,
    Condition.OVERCAST: 0.07,
    Condition.DUSK: 0.05,
    Condition.NIGHT: 0.04,
    Condition.WET: 0.05,
    Condition.SNOW: 0.03,
    Condition.LEAVES: 0.03,
}
"""Share of each condition among the scenes."""


@dataclass(frozen=True, slots=True)
class SceneStall:
    """A stall in a scene.

    ``quad`` is (4, 2) pixels (pixel centres are whole numbers); quad[0]-quad[1] and quad[2]-quad[3] are the short ends.
    ``lines_visible``: at least one of its long lines is visible. ``paint``: share (0..1) of its paint that the better
    one kept. ``covered``: share (0..1) of the stall under crowns and roofs; ``hidden``: that share is too large.
    ``implied``: mostly crowns hide it, and the row shows it, because a stall within two or three widths is visible.
    ``framed``: cars stand on both sides of it, so that they show it where no line does.
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
    framed: bool = False


@dataclass(frozen=True, slots=True)
class SceneVehicle:
    """A vehicle in a scene: its body on the ground, ``quad`` (4, 2) pixels with the short ends first and last; its
    ``kind`` as of `hawk.worlds.scene.cars`; ``covered``: share (0..1) of it under crowns and roofs.
    """

    quad: Points
    kind: str
    covered: float


@dataclass(frozen=True, slots=True)
class Scene:
    """A drawn orthophoto, north of nothing: BGR uint8 (H, W, 3), with uint8 masks (H, W) of 0 and 1.

    ``lot`` is the lot (aisles, stalls, islands and the trees on them), ``car`` the visible part of vehicles, ``cover``
    the ground under crowns and roofs, ``shade`` the ground in shadow that nothing hides. ``cast`` (2,) is the shadow of
    one metre of height, metres to the right and down.
    """

    image: Bytes
    lot: Bytes
    car: Bytes
    cover: Bytes
    shade: Bytes
    stalls: tuple[SceneStall, ...]
    vehicles: tuple[SceneVehicle, ...]
    metres_per_pixel: float
    cast: Points


def plan_any_site(rng: np.random.Generator) -> SitePlan:
    """Plan a site of one of all kinds."""
    kind = rng.random()
    if kind > 1 - CROSSING_SHARE:
        return plan_crossing_site(rng, (0.0, 0.0))
    if kind > 1 - CROSSING_SHARE - DECK_SHARE:
        return plan_deck_site(rng, (0.0, 0.0), SITES[int(rng.integers(len(SITES)))])
    if kind < BARE_SHARE:
        return plan_bare_site(rng, (0.0, 0.0))
    if kind < BARE_SHARE + PLAIN_SHARE:
        return plan_plain_site(rng, (0.0, 0.0))
    if kind < BARE_SHARE + PLAIN_SHARE + STREET_SHARE:
        return plan_street_site(rng, (0.0, 0.0))
    if kind < BARE_SHARE + PLAIN_SHARE + STREET_SHARE + PAVED_SHARE:
        return plan_paved_site(rng, (0.0, 0.0), SITES[int(rng.integers(len(SITES)))])
    return plan_any_lot_site(rng, (0.0, 0.0), SITES[int(rng.integers(len(SITES)))])


def draw_scene(
    rng: np.random.Generator,
    size_px: int | tuple[int, int] = 384,
    *,
    metres_per_pixel: float = 0.10,
    plan_site: Callable[[np.random.Generator], SitePlan] = plan_any_site,
    looks: Looks = AS_DRAWN,
) -> Scene:
    """Draw a scene of ``size_px`` (a side, or height and width); the same generator state gives the same scene.

    ``plan_site`` plans its site; ``looks`` changes the picture and none of its labels. Raises ValueError for a size
    that is too small.
    """
    height, width = (size_px, size_px) if isinstance(size_px, int) else size_px
    if min(height, width) < 32 or metres_per_pixel <= 0:
        raise ValueError("draw_scene: size_px must be at least 32 and metres_per_pixel above 0")
    plan = plan_site(rng)
    plan.dim_cars = float(rng.choice([0.0, 0.15, 0.4]))
    plan.bare = plan.bare or float(rng.random() < _BARE_TREES)
    for share, places, change in CHANGES:
        if rng.random() < share:
            for _ in range(int(rng.integers(1, places + 1))):
                change(plan, rng)
    x, y = _window_centre(rng, plan) - np.array([width, height]) * metres_per_pixel / 2
    canvas = Canvas(float(x), float(y), width, height, metres_per_pixel)
    sun = set_condition(plan, sample_condition(rng), sample_sun(rng), rng)
    drawn = draw_plan(plan, canvas, sun, rng, looks)
    image, car, cover, roofs = _composite(rng, canvas, drawn.ground, FacetSet(drawn.layers))
    contrast = float(np.abs(np.array(plan.palette[0]) - plan.asphalt.colour).max())
    shown = [stall for stall in plan.stalls if canvas.touches(stall.corners, 1.0)]
    stalls = _framed(_implied([_scene_stall(canvas, stall, cover, contrast) for stall in shown], roofs))
    vehicles = tuple(_scene_vehicle(canvas, *one, cover) for one in drawn.vehicles if canvas.touches(one[1], 0.0))
    picture = photograph(rng, image)
    shade = as_bytes((drawn.shade > _SHADE) & (car == 0) & (cover == 0))
    return Scene(picture, _lot_mask(canvas, plan), car, cover, shade, stalls, vehicles, metres_per_pixel, sun.cast(1.0))


def sample_condition(rng: np.random.Generator) -> Condition:
    """Draw a condition for a scene."""
    return list(CONDITION_SHARES)[int(rng.choice(len(CONDITION_SHARES), p=list(CONDITION_SHARES.values())))]


def _window_centre(rng: np.random.Generator, plan: SitePlan) -> Points:
    """Pick the middle of the picture: a place in the lot or near its edge."""
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
    """Draw what stands on the ground, as in a map or from a drone nearby; return picture, cars, cover and roofs."""
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
    for layer in facets.seen(projection, canvas.width, canvas.height):
        layer.paint(image)
        layer.mark(car, layer.label == "car")
        layer.mark(cover, layer.label in ("tree", "roof", "wall"))
        layer.mark(roofs, layer.label in ("roof", "wall"))
    smooth = cv2.GaussianBlur(cv2.cvtColor(image, cv2.COLOR_BGRA2BGR), (3, 3), 0.4)
    return smooth.astype(np.float32), car, cover, roofs


def _lot_mask(canvas: Canvas, plan: SitePlan) -> Bytes:
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


def _scene_vehicle(canvas: Canvas, kind: str, corners: Points, cover: Bytes) -> SceneVehicle:
    quad = canvas.to_px(corners)
    return SceneVehicle(quad, kind, _share(cover, quad))


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


def _framed(stalls: tuple[SceneStall, ...]) -> tuple[SceneStall, ...]:
    """Mark free stalls without a visible line that stand between two cars of their row."""
    cars = np.array([stall.quad.mean(0) for stall in stalls if stall.taken and not stall.hidden]).reshape(-1, 2)
    return tuple(replace(stall, framed=_is_between(stall.quad, cars)) for stall in stalls)


def _is_between(quad: Points, places: Points) -> bool:
    """Return True when places (N, 2) are on both sides of a stall, within two and a half of its widths."""
    across, along = quad[1] - quad[0], quad[3] - quad[0]
    shares = np.linalg.solve(np.stack([across, along], axis=1), (places - quad.mean(0)).T).T
    beside = shares[(np.abs(shares[:, 1]) < _IN_ROW) & (np.abs(shares[:, 0]) < _FRAME_WIDTHS)][:, 0]
    return bool((beside > _OWN).any() and (beside < -_OWN).any())


def _share(mask: Bytes, quad: Points) -> float:
    """Return the mean of a 0/1 mask over a quadrilateral, 0 where it is outside the picture."""
    low = np.maximum(np.floor(quad.min(0)).astype(int), 0)
    high = np.minimum(np.ceil(quad.max(0)).astype(int) + 1, (mask.shape[1], mask.shape[0]))
    if (high <= low).any():
        return 0.0
    part = mask[low[1] : high[1], low[0] : high[0]]
    inside = np.zeros(part.shape, np.uint8)
    cv2.fillConvexPoly(inside, np.round((quad - low) * 16).astype(np.int32), 1, shift=4)
    total = int(inside.sum())
    return float((part & inside).sum()) / total if total else 0.0


def photograph(rng: np.random.Generator, image: Floats) -> Bytes:
    """Return a BGR float picture (0..255) as one of many cameras would show it (uint8)."""
    picture = _tone(rng, image.astype(np.float32))
    picture = _sharpness(rng, picture)
    picture += rng.standard_normal(picture.shape, np.float32) * np.float32(5 * rng.uniform(0, 1) ** 2)
    result = as_bytes(np.clip(picture, 0, 255))
    if rng.random() < 0.6:
        quality = int(rng.uniform(40, 95))
        encoded = cv2.imencode(".jpg", result, [cv2.IMWRITE_JPEG_QUALITY, quality])[1]
        result = as_bytes(np.asarray(cv2.imdecode(encoded, cv2.IMREAD_COLOR)))
    return result


def _tone(rng: np.random.Generator, picture: Floats) -> Floats:
    """Exposure, gamma, colour cast, contrast, saturation; sometimes dusk, often haze. Half change little."""
    amount = 1.0 if rng.random() < 0.5 else 0.4
    picture = picture * np.float32(np.exp(rng.uniform(-0.2, 0.45) * amount))
    if rng.random() < 0.05:  # dusk and lamps
        height, width = picture.shape[:2]
        lamps = 1 + noise(rng, height, width, [90], [0.3])
        picture *= np.array([0.66, 0.58, 0.6], np.float32) * np.clip(lamps, 0.5, 1.6)[..., None]
    np.clip(picture, 0, 255, out=picture)
    gamma = float(np.exp(rng.uniform(-0.35, 0.33) * amount))
    picture = as_floats(cv2.pow(picture * np.float32(1 / 255), gamma)) * np.float32(255)
    picture *= np.exp(rng.normal(0, 0.05, 3) * amount).astype(np.float32)
    mean = picture.mean()
    picture = (picture - mean) * np.float32(np.exp(rng.uniform(-0.25, 0.26) * amount)) + mean
    if rng.random() < 0.4:
        grey = picture.mean(2, keepdims=True)
        picture = grey + (picture - grey) * np.float32(rng.uniform(0.1, 0.9) if rng.random() < 0.7 else 1.35)
    if rng.random() < 0.4:  # haze: what is dark turns pale and somewhat blue
        veil = np.float32(rng.uniform(130, 230)) + np.array([1, 0, -1], np.float32) * np.float32(rng.uniform(-5, 30))
        picture += (veil - picture) * np.float32(rng.uniform(0.03, 0.3))
    return picture


def _sharpness(rng: np.random.Generator, picture: Floats) -> Floats:
    """Blur some pictures and sharpen more: at this scale most cameras' pictures have been made smaller."""
    if rng.random() < 0.7:  # cameras and map services take the grain out and leave the edges
        picture = np.asarray(cv2.bilateralFilter(picture, 5, rng.uniform(8, 32), rng.uniform(1.2, 3.0)), np.float32)
    if rng.random() < 0.4:
        picture = np.asarray(cv2.GaussianBlur(picture, (0, 0), rng.uniform(0.3, 1.05)), np.float32)
    if rng.random() < 0.06:  # the drone moved while the shutter was open
        length, angle = int(rng.integers(1, 4)), rng.uniform(0, np.pi)
        kernel = np.zeros((2 * length + 1, 2 * length + 1), np.float32)
        reach = (int(length * np.cos(angle)), int(length * np.sin(angle)))
        cv2.line(kernel, (length - reach[0], length - reach[1]), (length + reach[0], length + reach[1]), 1.0, 1)
        picture = np.asarray(cv2.filter2D(picture, -1, kernel / kernel.sum()), np.float32)
    if rng.random() < 0.65:
        soft = cv2.GaussianBlur(picture, (0, 0), rng.uniform(0.8, 1.6))
        picture = picture + (picture - soft) * np.float32(rng.uniform(0.3, 1.4))
    return picture

"""Plan of a place, in metres, before anything is drawn."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.worlds.scene.canvas import Canvas, Points
from hawk.worlds.scene.light import LampLight, Sun
from hawk.worlds.scene.materials import Colour, Material


@dataclass(frozen=True, slots=True)
class Axes:
    """A right-angled frame on the ground: origin and two unit vectors (metres, x east, y south)."""

    origin: tuple[float, float]
    u: tuple[float, float]
    v: tuple[float, float]

    @classmethod
    def turned(cls, origin: tuple[float, float], angle: float) -> Axes:
        """Return axes whose u is turned by ``angle`` from east towards south."""
        cosine, sine = math.cos(angle), math.sin(angle)
        return cls(origin, (cosine, sine), (-sine, cosine))

    def at(self, u: float, v: float) -> tuple[float, float]:
        """Return the ground point (x, y) of (u, v)."""
        x = self.origin[0] + self.u[0] * u + self.v[0] * v
        y = self.origin[1] + self.u[1] * u + self.v[1] * v
        return x, y

    def points(self, pairs: list[tuple[float, float]] | Points) -> Points:
        """Return (N, 2) ground points of (u, v) pairs."""
        pairs = np.asarray(pairs, np.float64)
        return np.asarray(np.asarray(self.origin) + pairs @ np.array([self.u, self.v]))

    def rect(self, u0: float, v0: float, u1: float, v1: float) -> Points:
        """Return the four corners of a rectangle."""
        return self.points([(u0, v0), (u1, v0), (u1, v1), (u0, v1)])

    def moved(self, u: float, v: float) -> Axes:
        """Return the same directions about another origin."""
        return Axes(self.at(u, v), self.u, self.v)

    def facing(self, u: tuple[float, float], v: tuple[float, float]) -> Axes:
        """Return axes about the same origin along two of our own directions, given in (u, v)."""
        zero = Axes((0.0, 0.0), self.u, self.v)
        return Axes(self.origin, zero.at(*u), zero.at(*v))

    @property
    def angle(self) -> float:
        """Direction of u, radians from east towards south."""
        return math.atan2(self.u[1], self.u[0])


@dataclass(frozen=True, slots=True)
class Surface:
    """Ground of one material. ``kerb`` is the colour of its border, ``round_m`` the rounding of its corners."""

    polygon: Points
    material: Material
    kerb: Colour | None = None
    round_m: float = 0.0


@dataclass(frozen=True, slots=True)
class Gain:
    """Ground made darker or lighter: a polygon, or a polyline when ``width`` is set. ``order`` as in Stroke."""

    points: Points
    gain: float
    soften: float = 0.0
    width: float | None = None
    order: int = 0


@dataclass(frozen=True, slots=True)
class Stroke:
    """A painted polygon: colour number in the plan's palette and strength 0..1.

    ``order`` is the number of surfaces at the time of painting: later ones cover it.
    """

    polygon: Points
    colour: int
    strength: float
    order: int = 0


@dataclass(frozen=True, slots=True)
class PlannedStall:
    """A painted stall; corner order as in TrueStall. ``paint`` (0..1) is what its better long line has kept.

    ``number`` is its id, by the order of planning where it is None. Nobody can park on a ``closed`` one.
    """

    corners: Points
    kind: str
    taken: bool
    worn: bool
    paint: float
    number: int | None = None
    closed: bool = False


@dataclass(frozen=True, slots=True)
class Vehicle:
    """A vehicle: centre, heading (radians, east towards south) and kind (see `hawk.worlds.scene.cars`).

    ``key`` distinguishes vehicles that stand at the same place at different times.
    """

    x: float
    y: float
    heading: float
    kind: str
    key: int = 0


@dataclass(frozen=True, slots=True)
class Tree:
    """A tree or bush: trunk place, radius of the crown and height, metres."""

    x: float
    y: float
    radius: float
    height: float


RoofPainter = Callable[[np.random.Generator, Canvas, "Building", Sun], None]
"""Draws on a roof's canvas, whose axes are the building's (u right, v down)."""


@dataclass(frozen=True, slots=True)
class Building:
    """A building under a flat roof: [0, width] x [0, depth] of its axes, metres.

    ``roof`` is the material of the roof, drawn at random where it is None; ``crowd`` draws more on it than the usual;
    a ``shelter`` stands in a lot and is part of it.
    """

    axes: Axes
    width: float
    depth: float
    height: float
    roof: Material | None = None
    crowd: RoofPainter | None = None
    shelter: bool = False

    @property
    def polygon(self) -> Points:
        """The four corners of its footprint."""
        return self.axes.rect(0, 0, self.width, self.depth)


@dataclass(frozen=True, slots=True)
class Post:
    """A lamp post: its arm points along ``heading``."""

    x: float
    y: float
    height: float
    heading: float


@dataclass(frozen=True, slots=True)
class Block:
    """A low thing of one colour on the ground, such as a wheel stop: polygon and height (metres)."""

    polygon: Points
    height: float
    colour: Colour


@dataclass(slots=True)
class SitePlan:
    """Everything on a site, in the order in which it is drawn.

    Filled by `hawk.worlds.generate` and its helpers; surfaces, gains and strokes only through the methods below.
    """

    axes: Axes
    ground: Material
    asphalt: Material
    palette: list[Colour]
    wear: float = 0.5
    surfaces: list[Surface] = field(default_factory=list)
    gains: list[Gain] = field(default_factory=list)
    strokes: list[Stroke] = field(default_factory=list)
    islands: list[Surface] = field(default_factory=list)
    stalls: list[PlannedStall] = field(default_factory=list)
    vehicles: list[Vehicle] = field(default_factory=list)
    trees: list[Tree] = field(default_factory=list)
    buildings: list[Building] = field(default_factory=list)
    posts: list[Post] = field(default_factory=list)
    blocks: list[Block] = field(default_factory=list)
    lots: list[Points] = field(default_factory=list)
    next_number: int = 0
    """Id of the next stall that gets one."""
    shades: list[Points] = field(default_factory=list)
    """Shadows of things far outside."""
    wet: float = 0.0
    snow: float = 0.0
    leaves: float = 0.0
    lamps: LampLight | None = None
    """Light of a place without sun."""
    bare: float = 0.0
    """Share of the trees without leaves."""
    dim_cars: float = 0.0
    """Share of the vehicles that are dark and show hardly any parts."""

    def add_surface(self, surface: Surface) -> None:
        """Add a surface; it removes everything that stood on its ground before."""
        self.surfaces.append(surface)
        area = surface.polygon.astype(np.float32)
        self.vehicles = [one for one in self.vehicles if not inside(area, one.x, one.y)]
        self.trees = [one for one in self.trees if not inside(area, one.x, one.y)]
        self.posts = [one for one in self.posts if not inside(area, one.x, one.y)]
        self.buildings = [one for one in self.buildings if not _buries(area, one)]

    def settle(self) -> None:
        """Remove vehicles and trees inside a building."""
        for building in self.buildings:
            area = building.polygon.astype(np.float32)
            self.vehicles = [one for one in self.vehicles if not inside(area, one.x, one.y)]
            self.trees = [one for one in self.trees if not inside(area, one.x, one.y)]

    def change(self, points: Points, gain: float, *, soften: float = 0.0, width: float | None = None) -> None:
        """Make ground darker or lighter (see Gain)."""
        self.gains.append(Gain(points, gain, soften, width, len(self.surfaces)))

    def paint(self, polygon: Points, colour: int, strength: float) -> None:
        """Paint a convex polygon of four corners."""
        self.strokes.append(Stroke(polygon, colour, strength, len(self.surfaces)))

    def plant(
        self, place: tuple[float, float], radius: float, slenderness: float, heights: tuple[float, float]
    ) -> None:
        """Plant a tree or bush whose height is ``slenderness`` times the radius of its crown, within limits; metres."""
        (x, y), (least, most) = place, heights
        height = min(max(radius * slenderness, least), most)
        self.trees.append(Tree(float(x), float(y), float(radius), float(height)))

    def line(
        self, start: tuple[float, float], end: tuple[float, float], width: float, colour: int, strength: float
    ) -> None:
        """Paint a straight line of ``width`` metres."""
        dx, dy = end[0] - start[0], end[1] - start[1]
        length = math.hypot(dx, dy)
        if length < 0.05 or strength <= 0.02:
            return
        nx, ny = -dy / length * width / 2, dx / length * width / 2
        corners = [
            (start[0] + nx, start[1] + ny),
            (end[0] + nx, end[1] + ny),
            (end[0] - nx, end[1] - ny),
            (start[0] - nx, start[1] - ny),
        ]
        self.paint(np.array(corners), colour, strength)


_BURIED = 0.3
"""A building goes when a surface covers more of it than this share."""


def inside(area: NDArray[np.float32], x: float, y: float) -> bool:
    """Return True for a place inside an outline (N, 2), or on it."""
    return cv2.pointPolygonTest(area, (x, y), measureDist=False) >= 0


def _buries(area: NDArray[np.float32], building: Building) -> bool:
    shares = [(u, v) for u in (0.0, 0.25, 0.5, 0.75, 1.0) for v in (0.0, 0.5, 1.0)]
    places = [building.axes.at(u * building.width, v * building.depth) for u, v in shares]
    return sum(inside(area, *place) for place in places) > _BURIED * len(places)

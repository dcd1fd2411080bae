"""Other cars on a real lot: those of its picture, moved between its labelled stalls.

A car is cut out with its shade along the lines of its stall and put on another stall of like size and direction; cars
are never turned round, because shade would fall to the wrong side. The ground that a car leaves is filled with that of
a bare stall near it. Stalls under leaves, in the shade of buildings, at the picture's edge, of unclear state or with
labels that overlap are left as they are, and so are cars beside stalls.
"""

from __future__ import annotations

from collections.abc import Container, Sequence
from dataclasses import dataclass, replace
from typing import Final

import cv2
import numpy as np
import shapely
from numpy.random import Generator

from hawk.worlds.ground_patches import Ground, Rims, Spot, Window, moved
from hawk.worlds.scene.canvas import Floats, Points, as_floats
from hawk.worlds.world import TrueStall, World, WorldError

_STREAM: Final = 51
_END_M: Final = 1.4
"""Cars reach this far beyond the ends of their stalls."""
_USUAL_END_M: Final = 0.9
"""Few reach farther than this."""
_TOUCHING_END_M: Final = 0.25
"""The same as `_END_M` where another stall begins, a kerb or a plant."""
_SIDE_M: Final = 0.9
"""Shade reaches this far beyond a stall's long sides."""
_CORE_M: Final = 0.6
"""Ground within this distance of a stall's long sides may have lines and the shade of cars beside it."""
_LINE_M: Final = 0.25
"""The same without shade."""
_FEATHER_M: Final = 0.12
_SHADE: Final = 0.86
"""Ground darker than this share of what it is without cars is in their shade."""
_DARKEST: Final = 0.35
_SHADE_BLUR: Final = 1.2
_DONORS: Final = 7
_LEAST_DONORS: Final = 3
"""Cars whose shade is the usual one: the median of all leaves out other things beside them."""
_OVERLAP: Final = 0.08
"""Share of a stall that another one's label may cover."""
_LIT: Final = 0.8
"""A lane darker than this share of the usual ground is in the shade of a building."""
_GAINS: Final = (0.85, 1.18)
"""Limits of the brightness of the ground at a car's new stall over that at its old one."""
_LEFT, _RIGHT = 2, 3
"""Long sides, as numbered by `hawk.worlds.ground_patches.Rims`."""
_TEMPLATES: Final = 3
"""Bare stalls near a stall that its ground may come from."""


@dataclass(frozen=True, slots=True, eq=False)
class Move:
    """A car that stands on ``source`` and comes to ``target``."""

    source: Spot
    target: Spot


def move_cars(world: World, seed: int) -> World:
    """Return a picture's world with its cars on other stalls, by the seed; the states of its truth follow.

    Raises WorldError when ids are used twice, or when the truth has no bare stall or no car that can be moved.
    """
    if len({stall.id for stall in world.stalls}) < len(world.stalls):
        raise WorldError(f"world {world.name}: stalls of --truth share an id: give each its own, or none")
    scale = world.metres_per_pixel
    spots = [Spot(stall, stall.corners / scale - 0.5) for stall in world.stalls]
    rows, columns = world.ground.shape[:2]
    inside = [one for one in spots if (one.corners >= 0).all() and (one.corners < (columns, rows)).all()]
    ground = Ground(as_floats(world.ground), scale, [spot for spot in inside if spot.stall.state == "free"])
    lot = _Lot(spots, ground)
    clear = [one for one in inside if not lot.is_overlapped(one) and not ground.has_plants(one, lot.rims(one))]
    bare = [spot for spot in clear if not spot.stall.taken and ground.is_bare(spot, _CORE_M)]
    targets = [spot for spot in bare if spot.stall.state == "free"]
    clean = [spot for spot in targets if ground.is_bare(spot, _LINE_M) and ground.is_sunlit(spot)] or targets
    cars = [spot for spot in clear if spot.stall.state == "taken" and _is_lit(ground, spot)]
    cars = [spot for spot in cars if any(one.fits(spot) for one in clean)]
    if not cars:
        raise WorldError(
            f"world {world.name}: no car can be moved: --truth must label taken stalls, and free ones that are bare"
        )
    rng = np.random.default_rng((seed, _STREAM))
    moves = _moves(rng, cars, targets, lot)
    mover = _Mover(ground, lot)
    stay = {spot.stall.id for spot in spots if spot.stall.taken} - {spot.stall.id for spot in cars}
    for spot in [*cars, *(one for one in bare if not lot.is_beside(one, stay))]:
        mover.empty(spot, clean, rng)
    shown = np.clip(np.round(mover.picture(moves)), 0, 255).astype(np.uint8)
    return replace(world, ground=shown, stalls=_states(world.stalls, moves))


def _is_lit(ground: Ground, spot: Spot) -> bool:
    """Return True where part of the ground beyond the ends of a stall is as bright as the usual ground."""
    window = ground.window(spot, 2.5)
    grey = window.of(ground.picture).mean(2)
    inner, outer = (end / ground.scale for end in (0.6, 1.6))
    rim = (window.mask(spot.grown((outer, outer, 0, 0))) > 0) & (window.mask(spot.grown((inner, inner, 0, 0))) == 0)
    return float(np.percentile(grey[rim], 75)) > _LIT * ground.usual


def _moves(rng: Generator, taken: Sequence[Spot], bare: Sequence[Spot], lot: _Lot) -> list[Move]:
    """Choose a stall for each car, each stall once, among those that are like its own."""
    waiting = [(spot, spot.stall.taken) for spot in [*taken, *bare]]
    moves: list[Move] = []
    while waiting:
        first = waiting[0][0]
        alike = [spot for spot, _ in waiting if lot.is_alike(first, spot)]
        cars = [spot for spot, is_taken in waiting if is_taken and lot.is_alike(first, spot)]
        targets = [alike[k] for k in rng.permutation(len(alike))[: len(cars)].tolist()]
        moves += [Move(source, target) for source, target in zip(cars, targets, strict=True)]
        waiting = [one for one in waiting if not lot.is_alike(first, one[0])]
    return moves


def _states(stalls: Sequence[TrueStall], moves: Sequence[Move]) -> tuple[TrueStall, ...]:
    """Return the stalls with the states after all moves."""
    left = {move.source.stall.id for move in moves}
    come = {move.target.stall.id: move.source.stall.covered for move in moves}
    return tuple(
        replace(one, taken=one.id in come, covered=come.get(one.id, 0.0)) if one.id in left | come.keys() else one
        for one in stalls
    )


class _Lot:
    """The labelled stalls of a picture, and the ground beside each."""

    def __init__(self, spots: Sequence[Spot], ground: Ground) -> None:
        self.spots = spots
        self._ground = ground
        self._scale = ground.scale
        self._ids = {spot.stall.id for spot in spots}
        self._tree = shapely.STRtree([shapely.Polygon(spot.corners) for spot in spots])
        self._rims = {spot.stall.id: (self._reach(spot, 0), self._reach(spot, 1), 0.0, 0.0) for spot in spots}

    def is_overlapped(self, spot: Spot) -> bool:
        """Return True where the labels of other stalls cover part of a stall: a car cut out there would be two."""
        area = shapely.Polygon(spot.corners)
        found = self._tree.query(area, predicate="intersects").tolist()
        others = (shapely.Polygon(self.spots[k].corners) for k in found if self.spots[k] is not spot)
        return any(area.intersection(other).area > _OVERLAP * area.area for other in others)

    def rims(self, spot: Spot) -> Rims:
        """Return how far beyond the ends of a stall its car may reach, pixels."""
        return self._rims[spot.stall.id]

    def common_rims(self, target: Spot, source: Spot) -> Rims:
        """Return how far a car from one stall may reach beyond the ends of another, pixels."""
        first, second = self.rims(source)[:2]
        if source.is_opposed(target):
            first, second = second, first
        own = self.rims(target)
        return min(own[0], first), min(own[1], second), 0.0, 0.0

    def is_alike(self, one: Spot, other: Spot) -> bool:
        """Return True for stalls of like size and direction with the aisle at the same end: lines close the other."""
        if not one.fits(other):
            return False
        first, second = self.rims(other)[:2]
        return self.rims(one)[:2] == ((second, first) if one.is_opposed(other) else (first, second))

    def is_beside(self, spot: Spot, among: Container[int]) -> bool:
        """Return True for a stall beside one of some, whose shade may lie on it."""
        return any(self._others_in(spot.beyond(side, _SIDE_M / self._scale), spot, among) for side in (_LEFT, _RIGHT))

    def is_open(self, spot: Spot, side: int, taken: Container[int]) -> bool:
        """Return True where the ground beside a stall belongs to labelled stalls without cars."""
        strip = spot.beyond(side, _SIDE_M / self._scale)
        return self._others_in(strip, spot, self._ids) and not self._others_in(strip, spot, taken)

    def _reach(self, spot: Spot, end: int) -> float:
        is_touched = self._others_in(spot.beyond(end, _END_M / self._scale), spot, self._ids)
        far = spot.beyond(end, _END_M / self._scale, _USUAL_END_M / self._scale)
        is_long = not is_touched and self._ground.is_plain(spot, far)
        return (_END_M if is_long else _TOUCHING_END_M) / self._scale

    def _others_in(self, strip: Points, spot: Spot, among: Container[int]) -> bool:
        area = shapely.Polygon(strip).buffer(-0.1 / self._scale)
        found = (self.spots[k] for k in self._tree.query(area, predicate="intersects").tolist())
        return any(one.stall.id in among and one.stall.id != spot.stall.id for one in found)


class _Mover:
    """Paints a picture with its cars on other stalls."""

    def __init__(self, ground: Ground, lot: _Lot) -> None:
        self._ground = ground
        self._lot = lot
        self._scale = ground.scale
        self._empty = ground.picture.copy()
        self._before = {spot.stall.id for spot in lot.spots if spot.stall.taken}

    def empty(self, spot: Spot, clean: Sequence[Spot], rng: Generator) -> None:
        """Replace a stall's ground by that of a clean one near it; one without its like stays."""
        fitting = [one for one in clean if one.fits(spot)]
        if not fitting:
            return
        fitting = [one for one in fitting if self._lot.is_alike(one, spot)] or fitting
        near = sorted(fitting, key=lambda one: _distance(one, spot))[:_TEMPLATES]
        template = near[int(rng.integers(len(near)))]
        window = self._ground.window(spot, _END_M + 4 * _FEATHER_M)
        first, second, _, _ = self._lot.common_rims(spot, template)
        left, right = (self._shaded(spot, side, template) for side in (_LEFT, _RIGHT))
        alpha = window.mask(spot.grown((first, second, left, right)), _FEATHER_M / self._scale)[..., None]
        part = window.of(self._empty)
        part += (moved(self._ground.picture, template, spot, window) - part) * alpha

    def _shaded(self, spot: Spot, side: int, template: Spot) -> float:
        """Return how far beside a stall a car's shade may lie that a template can replace, pixels."""
        other = _LEFT + _RIGHT - side if spot.is_opposed(template) else side
        strip = template.beyond(other, _SIDE_M / self._scale)
        farther = spot.beyond(side, 2 * _SIDE_M / self._scale, _SIDE_M / self._scale)
        is_seen = spot.stall.taken and self._lot.is_open(spot, side, self._before)
        if (
            not is_seen
            or not self._ground.is_plain(spot, farther)
            or not self._lot.is_open(template, other, self._before)
        ):
            return 0.0
        return _SIDE_M / self._scale if self._ground.is_plain(template, strip) else 0.0

    def picture(self, moves: Sequence[Move]) -> Floats:
        """Return the picture after all moves: first shade on the ground, then the cars."""
        left = {move.source.stall.id for move in moves}
        come = {move.target.stall.id for move in moves}
        before = self._before
        after = (before - left) | come
        donors = {s: [m.source for m in moves if self._lot.is_open(m.source, s, before)] for s in (_LEFT, _RIGHT)}
        picture = self._empty.copy()
        for move in moves:
            for side in (_LEFT, _RIGHT):
                if self._lot.is_open(move.target, side, after):
                    self._cast(picture, move.target, side, donors[side])
        for move in moves:
            self._put(picture, move)
        return picture

    def _put(self, picture: Floats, move: Move) -> None:
        """Put a car onto its stall, as bright as the ground there."""
        source, target = move.source, move.target
        window = self._ground.window(target, _END_M + 4 * _FEATHER_M)
        rims = self._lot.common_rims(target, source)
        alpha = window.mask(target.grown(rims), _FEATHER_M / self._scale)[..., None]
        inside = alpha[..., 0] > 0.9
        here = window.of(self._empty)[inside]
        there = moved(self._empty, source, target, window)[inside]
        gain = np.clip(np.median(here, axis=0) / np.maximum(1.0, np.median(there, axis=0)), *_GAINS)
        part = window.of(picture)
        part += (moved(self._ground.picture, source, target, window) * as_floats(gain) - part) * alpha

    def _cast(self, picture: Floats, target: Spot, side: int, donors: Sequence[Spot]) -> None:
        """Darken the ground beside a stall by the usual shade of the cars near it whose shade is seen whole."""
        fitting = [one for one in donors if one.fits(target) and not one.is_opposed(target)]
        near = sorted(fitting, key=lambda one: _distance(one, target))[:_DONORS]
        if len(near) < _LEAST_DONORS:
            return
        window = self._ground.window(target, _SIDE_M + 4 * _FEATHER_M)
        share = np.median([self._share(donor, target, window) for donor in near], axis=0)
        alpha = window.mask(target.beyond(side, _SIDE_M / self._scale), 0.5 * _FEATHER_M / self._scale)
        window.of(picture)[...] *= as_floats(1 - alpha * (1 - share))[..., None]

    def _share(self, donor: Spot, target: Spot, window: Window) -> Floats:
        """Return the share of light that a car leaves on the ground about it, where its stall comes onto another."""
        lit, seen = (
            cv2.GaussianBlur(moved(image, donor, target, window).mean(2), (0, 0), _SHADE_BLUR)
            for image in (self._empty, self._ground.picture)
        )
        share = np.clip(seen / np.maximum(1.0, lit), _DARKEST, 1.0)
        share[share > _SHADE] = 1.0
        return as_floats(share)


def _distance(one: Spot, other: Spot) -> float:
    return float(np.linalg.norm(one.centre - other.centre))

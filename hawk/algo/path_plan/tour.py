"""The shortest path that shows the wanted ground: a polyline, the ground that its legs show, and the search for it.

A tour shows what its legs show (`footprint`), and the turns between them; at its end the drone may turn on the spot.
Waypoints are shifted, dropped, added and put in another order; many such moves are weighed at once, and one is drawn
by its cost (heat bath): hot, the search tries much, cold, it only improves. Ground that is not shown costs more than
the path that would sweep it; a little may be left out for nothing.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from hawk.algo.ground import Bools, Floats, Indices, Place
from hawk.algo.path_plan.footprint import Corners, Footprint, Singles, momenta

_PICKS: Final = 4  # waypoints that one step tries to drop or to add
_EXCHANGES: Final = 6
_FIRST_TURN: Final = 2.5


@dataclass(frozen=True, slots=True)
class Wanted:
    """Ground to be shown: ``cells`` (N, 2) of (north, east), worth ``weights`` (N,) square metres each; or boxes (N, 6)
    as in `Footprint.shown`.

    ``spare`` square metres may be left out for nothing.
    """

    cells: Singles
    weights: Singles
    spare: float

    @property
    def total(self) -> float:
        """Square metres to be shown."""
        return float(self.weights.sum())


@dataclass(frozen=True, slots=True)
class Terms:
    """Costs of path and turns, places for waypoints, and the begin of the tour.

    ``short_by``: ground that is not shown costs this multiple of the path that sweeps it. ``turn_m``: metres a right
    angle, ``leg_m`` each waypoint; another first waypoint must be cheaper by ``keep_m``. ``trials`` places are tried
    for each shift; ``allowed`` returns True for those of places (T, 2) that may be waypoints. ``turned_first``: the
    drone turns half round where the tour begins. ``before`` is the direction (north, east; of length 1) in which it
    flies there, (0, 0) while it stands.
    """

    footprint: Footprint
    short_by: float = 4.0
    turn_m: float = 0.0
    leg_m: float = 0.0
    keep_m: float = 0.0
    trials: int = 16
    turned_first: bool = False
    before: Place = (0.0, 0.0)
    allowed: Callable[[Floats], Bools] = lambda places: np.ones(len(places), np.bool_)


def length_of(places: Floats) -> float:
    """Return the length of a polyline (K, 2), metres."""
    return float(_lengths(places[None])[0])


class Tour:
    """A tour (K, 2) that begins at the drone, and the cells its legs show. Each step of the search may change it."""

    def __init__(self, terms: Terms, wanted: Wanted, places: Floats, yaw: float | None, rng: Generator) -> None:
        """``yaw`` (radians) is the picture's heading at the begin; None: the first turn costs nothing."""
        self._rng = rng
        self._places: Floats = places
        self._legs: Bools = np.zeros((0, 0), np.bool_)
        self._count: NDArray[np.int16] = np.zeros(0, np.int16)
        self.meet(terms, wanted, places, yaw)

    def meet(self, terms: Terms, wanted: Wanted, places: Floats, yaw: float | None) -> None:
        """Go on with other places, over the ground that is wanted by now."""
        self._terms, self._wanted = terms, wanted
        self._yaw = yaw
        self._behind = None if yaw is None else places[0] - (math.cos(yaw), math.sin(yaw))
        self._take(places, self._shown(self._lined(places), wanted.cells))

    @property
    def places(self) -> Floats:
        """Waypoints (K, 2), the drone's own place first."""
        return self._places

    @property
    def wanted(self) -> Wanted:
        """The ground that is to be shown."""
        return self._wanted

    @property
    def missing(self) -> float:
        """Square metres wanted that the tour does not show."""
        return float(self._wanted.weights @ (self._count == 0))

    @property
    def cost(self) -> float:
        """Cost of path, turns and ground that is not shown, metres."""
        return float(self._path_costs(self._places[None])[0] + self._penalty(np.array([self.missing]))[0])

    def sweep(self, step: float, heat: float, most: int | None = None) -> None:
        """Make every kind of move once, and shift every waypoint (the first ``most``) by about ``step`` metres."""
        for index in range(1, len(self._places) if most is None else min(len(self._places), most + 1)):
            self.shift(index, step, heat)
        self.drop(heat)
        self.add(heat)
        self.exchange(heat)

    def shift(self, index: int, step: float, heat: float) -> None:
        """Move one waypoint (not the first) by about ``step`` metres."""
        places = self._places
        tried = places[index] + self._rng.normal(0.0, step, (self._terms.trials, 2))
        tried[0] = places[index]
        near = slice(index - 1, index + 2)  # the legs that change, and the one whose corner changes
        unseen = self._count - self._legs[near].sum(0, dtype=np.int16) == 0
        shown = self._shown_about(index, tried, self._wanted.cells[unseen])
        costs = self._penalty(_area(~shown, self._wanted.weights[unseen])) + self._path_costs_about(index, tried)
        costs[1:][~self._terms.allowed(tried[1:])] = math.inf
        chosen = self._draw(costs, heat)
        if chosen == 0:
            return
        places = places.copy()
        places[index] = tried[chosen]
        self._places = places
        legs = self._shown(self._lined(places)[near], self._wanted.cells)
        self._count = self._count + legs.sum(0, dtype=np.int16) - self._legs[near].sum(0, dtype=np.int16)
        self._legs[near] = legs

    def drop(self, heat: float) -> None:
        """Leave out a waypoint."""
        if len(self._places) > 1:
            picks = self._rng.permutation(np.arange(1, len(self._places)))[:_PICKS]
            self._try(np.array([np.delete(self._places, pick, axis=0) for pick in picks]), heat)

    def add(self, heat: float) -> None:
        """Add a waypoint: where something is not shown, or on a leg."""
        unseen = np.flatnonzero(self._count == 0)
        if len(unseen) == 0 and len(self._places) == 1:
            return
        places = np.array([self._added(unseen) for _ in range(_PICKS)])
        places = places[self._terms.allowed(places)]
        self._try(np.array([np.insert(self._places, self._gap(place), place, axis=0) for place in places]), heat)

    def _added(self, unseen: Indices) -> Floats:
        """Draw a place to add, near one of the cells that are not shown or on a leg."""
        width = self._terms.footprint.width
        if len(unseen) and (len(self._places) == 1 or self._rng.random() < 0.7):
            place = self._wanted.cells[unseen[int(self._rng.integers(len(unseen)))], :2].astype(np.float64)
            return np.asarray(place + self._rng.normal(0.0, width / 6, 2))
        at = int(self._rng.integers(1, len(self._places)))
        return np.asarray(self._places[at - 1 : at + 1].mean(0) + self._rng.normal(0.0, width / 10, 2))

    def exchange(self, heat: float) -> None:
        """Reverse a part of the tour, or move it elsewhere."""
        size = len(self._places)
        if size <= 2:
            return
        tours = []
        for _ in range(_EXCHANGES):
            first, last = np.sort(self._rng.integers(1, size, 2))
            part = self._places[first : last + 1]
            rest = np.delete(self._places, slice(first, last + 1), axis=0)
            at = first if self._rng.random() < 0.5 else int(self._rng.integers(1, len(rest) + 1))
            part = part[::-1] if at == first or self._rng.random() < 0.5 else part
            tours.append(np.concatenate([rest[:at], part, rest[at:]]))
        self._try(np.array(tours), heat)

    def _take(self, places: Floats, legs: Bools) -> None:
        self._places, self._legs = places, legs
        self._count = legs.sum(0, dtype=np.int16)

    def _lined(self, tours: Floats) -> Floats:
        """Return (..., K - 1, 8) of the legs of tours (..., K, 2).

        A row is begin, end and the momentum before, each (north, east), 1 for the first leg, 1 for the last.
        """
        legs = _legs(tours)
        lined = np.zeros((*legs.shape[:-1], 8))
        lined[..., 0:2], lined[..., 2:4] = tours[..., :-1, :], tours[..., 1:, :]
        lined[..., :1, 4:6], lined[..., 1:, 4:6] = self._terms.before, momenta(legs[..., :-1, :])
        lined[..., :1, 6] = lined[..., -1:, 7] = 1.0
        return lined

    def _shown(self, legs: Floats, cells: Singles) -> Bools:
        """Return (K, N), True where a leg (K, 8), with the turn before it, shows a cell (N, 2)."""
        foot, is_first = self._terms.footprint, legs[:, 6] > 0
        turned = np.where(is_first, foot.spun if self._terms.turned_first else 0.0, foot.turned)
        corners = Corners(legs[:, 4:6], turned, legs[:, 7] > 0)
        shown = foot.shown(cells, legs[:, :2], legs[:, 2:4], corners)
        if is_first.any():
            shown[is_first] |= self._first_turn_shows(cells, legs[is_first, :2], legs[is_first, 2:4])
        return shown

    def _shown_about(self, index: int, tried: Floats, cells: Singles) -> Bools:
        """Return (T, N), True for cells that the legs about one waypoint show, for T places tried for it."""
        first = max(index - 2, 0)
        line = np.repeat(self._places[None, first : index + 3], len(tried), axis=0)
        line[:, index - first] = tried
        legs = self._lined(line)[:, index - 1 - first :]
        legs[:, -1, 7] = index + 3 >= len(self._places)  # 1 when the tour ends with this part of it
        shown = self._shown(legs.reshape(-1, 8), cells)
        return np.asarray(shown.reshape(*legs.shape[:2], -1).any(1))

    def _first_turn_shows(self, cells: Singles, begins: Floats, ends: Floats) -> Bools:
        """Return (K, N), True for cells that the picture shows as the drone turns to the first of its legs."""
        if self._yaw is None or self._terms.footprint.spun <= 0:
            return np.zeros((len(begins), len(cells)), np.bool_)
        legs = ends - begins
        return self._terms.footprint.swept(cells, begins[0], self._yaw, np.arctan2(legs[:, 1], legs[:, 0]))

    def _penalty(self, missing: NDArray[np.floating]) -> Floats:
        """Return the cost, metres, of leaving out ``missing`` square metres beyond the spare ones."""
        beyond = np.maximum(missing.astype(np.float64) - self._wanted.spare, 0.0)
        return beyond * (self._terms.short_by / self._terms.footprint.width)

    def _path_costs(self, tours: Floats) -> Floats:
        """Return the costs of path and turns of tours (T, K, 2), metres."""
        led = self._led(tours)
        turns = _turns(led) + self._first_turns(led)
        return np.asarray(_lengths(tours) + self._terms.turn_m * turns + self._terms.leg_m * (tours.shape[1] - 1))

    def _first_turns(self, lines: Floats) -> Floats:
        """Return the extra cost of the drone's own turn, right angles: it gives up what was begun."""
        if self._behind is None:
            return np.zeros(len(lines))
        return (_FIRST_TURN - 1.0) * _turns(lines[:, :3])

    def _led(self, tours: Floats) -> Floats:
        """Return tours (T, K, 2) with a place behind the drone before them, so that the first turn has a cost."""
        if self._behind is None:
            return tours
        behind = np.broadcast_to(self._behind, (len(tours), 1, 2))
        return np.concatenate([behind, tours], axis=1)

    def _path_costs_about(self, index: int, tried: Floats) -> Floats:
        """Return the costs of path and turns about one waypoint, for each place tried for it."""
        led, at = self._led(self._places[None]), index + (self._behind is not None)
        part = np.repeat(led[:, max(at - 2, 0) : at + 3], len(tried), axis=0)
        part[:, min(at, 2)] = tried
        first = self._first_turns(part) if at <= 2 else 0.0
        legs = part[:, max(min(at, 2) - 1, 0) : min(at, 2) + 2]
        return _lengths(legs) + self._terms.turn_m * (_turns(part) + first)

    def _try(self, tours: Floats, heat: float) -> None:
        """Draw one of the tours (T, K, 2), or keep the present one."""
        if not len(tours):
            return
        kept = self._shown_by(tours)
        costs = self._path_costs(tours) + self._penalty(_area(np.invert(kept.any(1)), self._wanted.weights))
        costs = np.concatenate([[self.cost], costs + self._terms.keep_m * self._lead_elsewhere(tours)])
        chosen = self._draw(costs, heat)
        if chosen:
            self._take(tours[chosen - 1], kept[chosen - 1])

    def _lead_elsewhere(self, tours: Floats) -> Bools:
        """Return True for those of tours (T, K, 2) that give up the first waypoint."""
        if tours.shape[1] < 2 or len(self._places) < 2:
            return np.ones(len(tours), np.bool_)
        return np.asarray((tours[:, 1] != self._places[1]).any(1))

    def _shown_by(self, tours: Floats) -> Bools:
        """Return (T, K - 1, N), True for cells that the legs of tours (T, K, 2) show; equal legs are checked once."""
        own, lined = self._lined(self._places), self._lined(tours)
        legs = np.concatenate([own, lined.reshape(-1, 8)])
        names = legs.view(f"V{legs.itemsize * 8}").ravel().tolist()
        rows: dict[bytes, int] = {name: row for row, name in enumerate(names[: len(own)])}
        new: list[int] = []
        for number, name in enumerate(names[len(own) :], len(own)):
            if name not in rows:
                rows[name] = len(own) + len(new)
                new.append(number)
        shown = np.concatenate([self._legs, self._shown(legs[new], self._wanted.cells)]) if new else self._legs
        picked = np.array([rows[name] for name in names[len(own) :]], np.intp)
        return shown[picked.reshape(lined.shape[:2])]

    def _draw(self, costs: Floats, heat: float) -> int:
        """Draw one of the alternatives by its cost, metres; without heat the cheapest."""
        if heat <= 0.0:
            return int(np.argmin(costs))
        sums = np.cumsum(np.exp(-(costs - costs.min()) / heat))
        return min(int(np.searchsorted(sums, self._rng.random() * sums[-1])), len(costs) - 1)

    def _gap(self, place: Floats) -> int:
        """Return the index at which a place is inserted on the least detour."""
        away = np.hypot(*(self._places - place).T)
        detours = away[:-1] + away[1:] - np.hypot(*np.diff(self._places, axis=0).T)
        if len(detours) == 0 or away[-1] < detours.min():
            return len(self._places)
        return int(np.argmin(detours)) + 1


def _legs(lines: Floats) -> Floats:
    """Return the legs (..., K - 1, 2) of polylines (..., K, 2): numpy's `diff` takes ten times as long for a few."""
    return np.asarray(lines[..., 1:, :] - lines[..., :-1, :])


def _area(cells: Bools, weights: Singles) -> Floats:
    """Return the ground of cells (T, N) by their finite weights (N,), square metres (T,)."""
    with np.errstate(invalid="ignore"):  # OpenBLAS may flag lanes that it does not use (its issue 1924)
        return np.asarray(cells @ weights)


def _lengths(lines: Floats) -> Floats:
    """Return the lengths of polylines (T, K, 2), metres."""
    legs = _legs(lines)
    return np.asarray(np.hypot(legs[..., 0], legs[..., 1]).sum(1))


def _turns(lines: Floats) -> Floats:
    """Return the sum of turns of polylines (T, K, 2), right angles."""
    legs = _legs(lines)
    headings = np.arctan2(legs[..., 1], legs[..., 0])
    off = np.abs(headings[:, 1:] - headings[:, :-1])
    return np.asarray(np.minimum(off, math.tau - off).sum(1) / (math.pi / 2))


def as_place(row: Floats) -> Place:
    """Return a waypoint (a row of an array) as a pair."""
    return float(row[0]), float(row[1])

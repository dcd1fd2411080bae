"""Cars that stand where nothing else shows a stall, alone or together: their places are suggestions, no stalls."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from hawk.algo.rows.evidence import GroundAt
from hawk.algo.rows.lot import NO_ROW, RowStalls
from hawk.algo.vision import quads
from hawk.algo.vision.detection import FloatArray
from hawk.model.lot_map import OccupancyMap, StallState, variance_of

NEAR_M: Final = 9.0
"""Stalls whose middles are nearer belong together: across an aisle they do not."""
LEAST: Final = 5
"""Fewer stalls together may be cars on any ground, unless free ones show that stalls are marked there."""
LOT_M: Final = 15.0
"""Middles of stalls of one lot are nearer to those of a row: two half stalls, an aisle of 7 m, and some to the side."""
_CLOSE_M, _IN_LINE_M = 3.2, 1.2
"""Between the ends of stalls one behind the other, no car turns; their middles lie as much aside at most."""
_CAR, _SHUT_IN_SHARE = 0.15, 0.15
"""Mean probability of a car before an end, and share of the stalls, from which cars could not leave."""
BESIDE_M: Final = 4.0
"""Stalls side by side are nearer. A lone free one at the end of a few cars is what any row of cars suggests."""


def are_shown(stalls: RowStalls, is_free: NDArray[np.bool_], ground_at: GroundAt) -> NDArray[np.bool_]:
    """Return which stalls (N,) of one picture stay: those of a row that shows itself, and all within `LOT_M` of one.

    A row shows itself by `LEAST` stalls, or by one that is free (N,), unless its cars could not leave. Other cars wait,
    or stand along a kerb: no picture shows which.
    """
    if not len(stalls):
        return np.zeros(0, np.bool_)
    number = np.where(stalls.row == NO_ROW, stalls.row.max() + 1 + np.arange(len(stalls)), stalls.row)
    of_row = (np.bincount(number) >= LEAST) | (np.bincount(number, is_free) > 0)
    shown = (of_row & ~_is_queue(stalls, number, ground_at))[number]
    if shown.any():
        apart, _ = cKDTree(stalls.centres[shown]).query(stalls.centres)
        shown |= apart < LOT_M
    return np.asarray(shown)


def _is_queue(stalls: RowStalls, number: NDArray[np.intp], ground_at: GroundAt) -> NDArray[np.bool_]:
    """Return by the number of each row, (N,) of the stalls, whether rows end to end with it have too many shut in."""
    i, j = cKDTree(stalls.centres).query_pairs(stalls.length.max() + _CLOSE_M + _IN_LINE_M, output_type="ndarray").T
    offset = stalls.centres[j] - stalls.centres[i]
    ahead = np.abs((offset * _directions(stalls)[i]).sum(axis=1))
    aside = np.abs(quads.cross(stalls.angle[i], offset))
    whole = (stalls.length[i] + stalls.length[j]) / 2
    is_behind = (aside < _IN_LINE_M) & (ahead > whole / 2) & (ahead < whole + _CLOSE_M)
    count = int(number.max()) + 1
    links = (number[i[is_behind]], number[j[is_behind]])
    _, group = connected_components(coo_matrix((np.ones(len(links[0])), links), (count, count)), directed=False)
    shut_in = np.bincount(group[number], _are_shut_in(stalls, ground_at), count)
    return np.asarray((shut_in >= _SHUT_IN_SHARE * np.maximum(np.bincount(group[number], None, count), 1))[group])


def _are_shut_in(stalls: RowStalls, ground_at: GroundAt) -> NDArray[np.bool_]:
    """Return which stalls (N,) have a car before both ends."""
    along = _directions(stalls)
    across = np.column_stack([-along[:, 1], along[:, 0]])
    out, aside = np.meshgrid(np.linspace(0.4, 3.0, 8), np.linspace(-0.3, 0.3, 5))
    reach = (stalls.length[:, None] / 2 + out.ravel())[..., None] * along[:, None]
    sides = (aside.ravel() * stalls.width[:, None])[..., None] * across[:, None]
    cars = [ground_at(stalls.centres[:, None] + end * reach + sides).car.mean(axis=1) for end in (1, -1)]
    return np.asarray(np.minimum(*cars) > _CAR)


def _directions(stalls: RowStalls) -> FloatArray:
    return np.column_stack([np.cos(stalls.angle), np.sin(stalls.angle)])


def suggest_lone_cars(current: OccupancyMap) -> OccupancyMap:
    """Return the map; groups of fewer than `LEAST` stalls are suggested, unless two are free or one between others.

    In flight a person sees the picture, and the drone passes again; a folder of photographs has neither.
    """
    marked = [stall for _, stall in sorted(current.stalls.items()) if stall.state is not StallState.SUGGESTED]
    if not marked:
        return current
    places = np.array([(stall.north, stall.east) for stall in marked])
    pairs = cKDTree(places).query_pairs(NEAR_M, output_type="ndarray")
    count = len(marked)
    linked = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    _, group = connected_components(linked, directed=False)
    size = np.bincount(group)
    is_beside = np.hypot(*(places[pairs[:, 0]] - places[pairs[:, 1]]).T) < BESIDE_M
    beside = np.bincount(pairs[is_beside].ravel(), None, count)
    others = np.array([stall.state is not StallState.TAKEN for stall in marked])
    shown = np.bincount(group, others) >= 2
    shown |= np.bincount(group, others & (beside >= 2)) > 0
    lone = {
        stall.id for stall, number in zip(marked, group.tolist(), strict=True)
        if size[number] < LEAST and not shown[number]
    }  # fmt: skip
    if not lone:
        return current
    stalls = {
        number: replace(stall, state=StallState.SUGGESTED) if number in lone else stall
        for number, stall in current.stalls.items()
    }
    kept = [stall for stall in stalls.values() if stall.state is not StallState.SUGGESTED]
    gone = Counter(stall.state for stall in marked if stall.id in lone)
    counts = replace(
        current.counts,
        free=current.counts.free - gone[StallState.FREE],
        taken=current.counts.taken - gone[StallState.TAKEN],
        unknown=current.counts.unknown - gone[StallState.UNKNOWN],
        suggested=current.counts.suggested + len(lone),
        free_variance=variance_of(kept),
    )
    return replace(current, stalls=stalls, counts=counts)

"""Cars that stand together where nothing else shows a stall: their places are suggestions, no stalls."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from typing import Final

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from hawk.model.lot_map import OccupancyMap, StallState, variance_of

NEAR_M: Final = 9.0
"""Stalls whose middles are nearer belong together: across an aisle they do not."""
LEAST: Final = 5
"""Fewer stalls together may be cars on any ground, unless free ones show that stalls are marked there."""
BESIDE_M: Final = 4.0
"""Stalls side by side are nearer. A lone free one at the end of a few cars is what any row of cars suggests."""


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

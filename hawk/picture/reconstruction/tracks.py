"""Tied features of many photographs as places: one place a group of features that ties connect."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from hawk.picture.reconstruction.bundle_adjust import Projections
from hawk.picture.reconstruction.features import Features, Ties


@dataclass(frozen=True, slots=True)
class Group:
    """The photographs ``members`` (K,) of the largest part that hangs together, with their sights; `Projections.shot`
    counts within the members.
    """

    members: NDArray[np.intp]
    sights: Projections = field(repr=False)


def largest_group(ties: Sequence[Ties], count: int, found: Callable[[int], Features]) -> Group | None:
    """Return the largest part of ``count`` photographs that ties connect; None where no two are."""
    if not ties:
        return None
    first, second = np.array([(tie.first, tie.second) for tie in ties]).T
    linked = coo_matrix((np.ones(len(ties)), (first, second)), shape=(count, count))
    _, part = connected_components(linked, directed=False)
    members = np.flatnonzero(part == np.bincount(part).argmax())
    inside = np.isin(first, members)
    return Group(members, _sights([tie for tie, chosen in zip(ties, inside, strict=True) if chosen], members, found))


def _sights(ties: Sequence[Ties], members: NDArray[np.intp], found: Callable[[int], Features]) -> Projections:
    """Return the sights of ties; a group with two features of one photograph is a mistake, and left out."""
    sizes = [len(found(int(number)).pixels) for number in members]
    begins = np.concatenate([[0], np.cumsum(sizes)])
    at = {int(number): int(begin) for number, begin in zip(members, begins, strict=False)}
    here = np.concatenate([tie.here + at[tie.first] for tie in ties])
    there = np.concatenate([tie.there + at[tie.second] for tie in ties])
    total = int(begins[-1])
    linked = coo_matrix((np.ones(len(here)), (here, there)), shape=(total, total))
    _, place = connected_components(linked, directed=False)
    nodes = np.unique(np.concatenate([here, there]))
    shot = np.searchsorted(begins, nodes, side="right") - 1
    place = place[nodes]
    twice = np.unique(place * len(members) + shot, return_counts=True)
    wrong = np.unique(twice[0][twice[1] > 1] // len(members))
    good = ~np.isin(place, wrong)
    nodes, shot, place = nodes[good], shot[good], place[good]
    _, point = np.unique(place, return_inverse=True)
    pixels = np.empty((len(nodes), 2))
    ends = np.searchsorted(shot, np.arange(len(members) + 1))  # nodes rise, and so do their photographs
    for k, number in enumerate(members.tolist()):
        own = slice(int(ends[k]), int(ends[k + 1]))
        pixels[own] = found(number).pixels[nodes[own] - begins[k]]
    return Projections(shot.astype(np.intp), point.astype(np.intp), pixels, int(point.max(initial=-1)) + 1)


def drop_outliers(sights: Projections, wrong: NDArray[np.bool_]) -> Projections:
    """Return sights without those that are wrong (M,), and without places that fewer than two are left of."""
    keep = ~wrong
    counts = np.bincount(sights.point[keep], minlength=sights.points)
    keep &= counts[sights.point] >= 2
    _, point = np.unique(sights.point[keep], return_inverse=True)
    return Projections(sights.shot[keep], point.astype(np.intp), sights.pixels[keep], int(point.max(initial=-1)) + 1)

"""Labels that the edge of a picture or tile cuts, which count neither as missed nor, when found, as false.

A picture that was put together from tiles has labels in two halves where an edge of a tile cut a stall. A cut stall is
labelled now by its visible part, now by a rectangle about that part, now not at all, and a stall of which only a part
can be seen says nothing about the finder.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray

from benchmarks.perception.boxes import Boxes
from benchmarks.perception.eyes import Result
from benchmarks.perception.places import Place
from hawk.survey.accuracy import Finding, FloatArray, LabelledPlace, is_whole, match

EDGE_M = 0.2
"""A label with a corner this near to the edge, or beyond it, is cut: two pixels."""
SEAM_M, FILLED, LARGEST_M = 0.3, 0.85, (3.5, 6.5)
"""Halves of a stall: so near to each other, filling at least this share of a stall no larger than this."""
COVERED = 0.5
"""A find of which more than this share lies in cut labels is a find of those."""


@dataclass(frozen=True, slots=True)
class Counted:
    """Findings and labels of a place without those that are cut; ``cut`` (M,) says which labels were."""

    result: Result
    truth: LabelledPlace
    cut: NDArray[np.bool_]


def counted(result: Result, place: Place) -> Counted:
    """Leave out the labels that are cut, the findings that match one, and unmatched findings that lie in them.

    A label that is matched keeps its match, so that nothing else changes.
    """
    truth, cut = place.truth, cut_labels(place)
    found = result.finding.stalls
    out = finds_of_cut(found, truth.stalls, cut)
    finding = Finding(found[~out], np.asarray(result.finding.states, object)[~out])
    score = result.score[~out] if len(result.score) else result.score
    return Counted(replace(result, finding=finding, taken=result.taken[~out], score=score), without(truth, cut), cut)


def finds_of_cut(found: FloatArray, labels: FloatArray, cut: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return a mask (N,) of the finds that match a label of ``cut`` (M,), or match none and lie in those."""
    pairs = match(found, labels)
    out = np.zeros(len(found), np.bool_)
    out[pairs.found] = cut[pairs.true]
    alone = np.ones(len(found), np.bool_)
    alone[pairs.found] = False
    out[alone] = _share_within(found[alone], labels[cut]) > COVERED
    return out


def without(truth: LabelledPlace, cut: NDArray[np.bool_]) -> LabelledPlace:
    """Return the labels that are not cut."""
    return LabelledPlace(truth.stalls[~cut], np.asarray(truth.states, object)[~cut], truth.lots)


def cut_labels(place: Place) -> NDArray[np.bool_]:
    """Return a mask (N,) of labels that reach to the picture's edge or to ground that the picture does not show, and of
    those that are halves of a stall at a seam of tiles.
    """
    stalls, scale = place.truth.stalls, place.metres_per_pixel
    if not len(stalls):
        return np.zeros(0, np.bool_)
    size = np.array(place.image.shape[1::-1]) * scale
    cut = ((stalls < EDGE_M) | (stalls > size - EDGE_M)).any(axis=(1, 2)) | seam_halves(stalls)
    if place.missing is not None:
        reach = round(EDGE_M / scale)
        kernel = np.ones((2 * reach + 1,) * 2, np.uint8)
        missing = np.asarray(cv2.dilate(place.missing.astype(np.uint8), kernel), np.uint8)
        cut |= np.array([_touches(missing, stall / scale) for stall in stalls])
    return np.asarray(cut)


def seam_halves(stalls: FloatArray) -> NDArray[np.bool_]:
    """Return a mask (N,) of labels that are not whole, where two of one width together are as long as a whole stall."""
    halves = np.zeros(len(stalls), np.bool_)
    parts = np.flatnonzero(~is_whole(stalls))
    if len(parts) < 2:
        return halves
    quads = shapely.convex_hull(shapely.polygons(stalls[parts]))
    first, second = shapely.STRtree(quads).query(quads, predicate="dwithin", distance=SEAM_M)
    first, second = first[first < second], second[first < second]
    together = shapely.minimum_rotated_rectangle(shapely.union(quads[first], quads[second]))
    corners = shapely.get_coordinates(together).reshape(-1, 5, 2)[:, :4]
    whole = Boxes.of(corners)
    one = is_whole(corners) & (whole.width <= LARGEST_M[0]) & (whole.length <= LARGEST_M[1])
    filled = (shapely.area(quads[first]) + shapely.area(quads[second])) / shapely.area(together)
    one &= filled >= FILLED
    for part in (first, second):
        across = np.einsum("nkd,nd->nk", stalls[parts[part]], whole.across)
        one &= np.ptp(across, axis=1) > FILLED * whole.width
    halves[parts[first[one]]] = halves[parts[second[one]]] = True
    return halves


def _touches(mask: NDArray[np.uint8], corners: FloatArray) -> bool:
    low = np.maximum(np.floor(corners.min(axis=0)).astype(int), 0)
    high = np.ceil(corners.max(axis=0)).astype(int) + 1
    part = mask[low[1] : high[1], low[0] : high[0]]
    inside = np.zeros(part.shape, np.uint8)
    cv2.fillPoly(inside, [np.rint(corners - low).astype(np.int32)], (1,))
    return bool((part & inside).any())


def _share_within(stalls: FloatArray, cut: FloatArray) -> FloatArray:
    """Return the share (N,) of each quad that lies in the union of other quads."""
    if not len(stalls) or not len(cut):
        return np.zeros(len(stalls))
    area = shapely.union_all(shapely.convex_hull(shapely.polygons(cut)))
    quads = shapely.convex_hull(shapely.polygons(stalls))
    return np.asarray(shapely.area(shapely.intersection(quads, area)) / shapely.area(quads))

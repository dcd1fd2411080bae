"""Labels that the edge of a picture cuts, which count neither as missed nor, when found, as false.

How a cut stall is labelled differs from label to label: its visible part, a rectangle about that part, or nothing. A
stall of which only a part can be seen says nothing about the finder.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray

from benchmarks.perception.eyes import Result
from benchmarks.perception.places import Place
from hawk.survey.scoring import Finding, FloatArray, LabelledPlace, match

EDGE_M = 0.2
"""A label with a corner this near to the edge, or beyond it, is cut: two pixels."""
COVERED = 0.5
"""A find of which more than this share lies in cut labels is a find of those."""


@dataclass(frozen=True, slots=True)
class Counted:
    """What counts at a place: findings and labels without those that are cut; ``cut`` (M,) says which labels were."""

    result: Result
    truth: LabelledPlace
    cut: NDArray[np.bool_]


def counted(result: Result, place: Place) -> Counted:
    """Leave out the labels that are cut, the findings that match one, and unmatched findings that lie in them.

    A label that is matched keeps its match, so that nothing else changes.
    """
    truth, cut = place.truth, cut_labels(place)
    found = result.finding.stalls
    pairs = match(found, truth.stalls)
    out = np.zeros(len(found), np.bool_)
    out[pairs.found] = cut[pairs.true]
    alone = np.ones(len(found), np.bool_)
    alone[pairs.found] = False
    out[alone] = _share_within(found[alone], truth.stalls[cut]) > COVERED
    finding = Finding(found[~out], np.asarray(result.finding.states, object)[~out])
    kept = LabelledPlace(truth.stalls[~cut], np.asarray(truth.states, object)[~cut], truth.lots)
    return Counted(replace(result, finding=finding, taken=result.taken[~out]), kept, cut)


def whole_labels(place: Place) -> Place:
    """Return the place without its cut labels."""
    kept = ~cut_labels(place)
    truth = LabelledPlace(place.truth.stalls[kept], np.asarray(place.truth.states, object)[kept], place.truth.lots)
    return replace(place, truth=truth)


def cut_labels(place: Place) -> NDArray[np.bool_]:
    """Return a mask (N,) of labels that reach to the picture's edge or to ground that the picture does not show."""
    stalls, scale = place.truth.stalls, place.metres_per_pixel
    if not len(stalls):
        return np.zeros(0, np.bool_)
    size = np.array(place.image.shape[1::-1]) * scale
    cut = ((stalls < EDGE_M) | (stalls > size - EDGE_M)).any(axis=(1, 2))
    if place.missing is not None:
        reach = round(EDGE_M / scale)
        kernel = np.ones((2 * reach + 1,) * 2, np.uint8)
        missing = np.asarray(cv2.dilate(place.missing.astype(np.uint8), kernel), np.uint8)
        cut |= np.array([_touches(missing, stall / scale) for stall in stalls])
    return np.asarray(cut)


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

"""Report of a survey: the flight, the counts, and the comparison with a ground truth."""

from __future__ import annotations

import math
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from hawk.model.lot_map import Cell, StallState
from hawk.results.survey_map import SurveyMap
from hawk.survey import accuracy
from hawk.survey.accuracy import Finding, Tally, match
from hawk.survey.truth import GroundTruth

WHOLE = 0.98
"""Share of a stall's cells that were seen, from which the stall was in view."""


def in_view(
    survey: SurveyMap, truth: GroundTruth, found: NDArray[np.float64], shift: NDArray[np.float64]
) -> dict[str, float]:
    """Return the shares of lot and stalls that were in view and the recall of those stalls, as in ``report.json``.

    ``found`` (N, 4, 2): the stalls that were found, in the truth's world, shifted by ``shift`` (x, y), metres. NaN
    where the truth has no lot or stall, or none was in view. Raises TruthError when the truth has no origin.
    """
    cells = survey.cells()
    corner = truth.to_world(np.array([[cells.north, cells.east]]), survey.datum)[0] + shift
    known = cells.values != Cell.UNKNOWN
    lot_known, lot_all = _cells(known, [(lot - corner) / cells.cell_m for lot in truth.lots])
    stalls = np.asarray(truth.stalls, float).reshape(-1, 4, 2)
    parts = [_cells(known, [(stall - corner) / cells.cell_m]) for stall in stalls]
    seen = np.array([part >= WHOLE * whole for part, whole in parts], np.bool_)
    right = np.zeros(len(stalls), np.bool_)
    right[match(found, stalls).true] = True
    return {
        "lot_seen": _ratio(lot_known, lot_all),
        "stalls_seen": _ratio(int(seen.sum()), len(seen)),
        "stall_recall_seen": _ratio(int((right & seen).sum()), int(seen.sum())),
    }


def _cells(known: NDArray[np.bool_], outlines: list[NDArray[np.float64]]) -> tuple[int, int]:
    """Return how many cells in outlines (M, 2) of (column, row) are known, and how many there are."""
    if not outlines:
        return 0, 0
    everything = np.vstack(outlines)
    low = np.floor(everything.min(axis=0)).astype(int)
    width, height = np.ceil(everything.max(axis=0)).astype(int) - low + 1
    drawn = np.zeros((height, width), np.uint8)
    for outline in outlines:
        cv2.fillPoly(drawn, [np.rint(outline - low - 0.5).astype(np.int32)], 1)
    rows, columns = np.nonzero(drawn)
    rows, columns = rows + low[1], columns + low[0]
    inside = (rows >= 0) & (columns >= 0) & (rows < known.shape[0]) & (columns < known.shape[1])
    return int(known[rows[inside], columns[inside]].sum()), len(rows)


def _ratio(part: int, whole: int) -> float:
    return part / whole if whole else math.nan


LARGEST_OFFSET_M = 5.0
"""A whole map that is farther off than this is wrong, not displaced."""
_NEAR_M = 1.2
_LEAST_PAIRS = 8
_COARSE = 4


def counts(survey: SurveyMap) -> dict[str, int]:
    """Return the stalls of a survey by state."""
    found = survey.counts
    return {
        "stalls": found.total,
        "free": found.free,
        "taken": found.taken,
        "unknown": found.unknown,
        "suggested": found.suggested,
    }


def in_range(true_free: float, bounds: tuple[int, int] | None) -> bool | None:
    """Return whether the interval holds the true number of free stalls; None without one."""
    return None if bounds is None else bounds[0] <= true_free <= bounds[1]


def lot_area(survey: SurveyMap) -> float:
    """Return the area of the lot that was found, square metres."""
    cells = survey.cells()
    return float(np.isin(cells.values, (Cell.LOT, Cell.FREE, Cell.TAKEN)).sum() * cells.cell_m**2)


def compare(survey: SurveyMap, truth: GroundTruth) -> dict[str, float]:
    """Return the measures of a survey against a truth, under the keys of ``report.json``.

    The constant part of the position error (GNSS) is removed first and reported as ``map_offset_north_m`` and
    ``map_offset_east_m``: no drone can know it, and it moves no stall against another. Stalls and lot beyond the edge
    of the world's picture do not count. Raises TruthError when the truth has no origin.
    """
    found = _found(survey, truth)
    true_stalls = np.asarray(truth.stalls, float).reshape(-1, 4, 2)
    shift = map_offset(found.mean(axis=1), true_stalls.mean(axis=1))
    shown = truth.in_picture(found.mean(axis=1) + shift)
    real = accuracy.LabelledPlace(
        true_stalls, np.array([state or StallState.UNKNOWN for state in truth.states], object), truth.lots
    )
    states = np.array([stall.state for stall in survey.marked], object)
    finding = Finding(found[shown] + shift, states[shown])
    tally = accuracy.tally(finding, real)
    return {
        **_measures(tally),
        "position_error_p95_m": _position_error(finding, real),
        "lot_iou": _lot_iou(survey, truth, shift),
        **in_view(survey, truth, finding.stalls, shift),
        "map_offset_north_m": float(-shift[1]),
        "map_offset_east_m": float(shift[0]),
    }


def map_offset(found: NDArray[np.float64], true: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the shift (x, y), metres, from found centres (N, 2) to true ones (M, 2); zero when unclear.

    The median of nearest pairs, repeated: it starts at zero, so a whole stall's width is never jumped over.
    """
    shift = np.zeros(2)
    if len(found) < _LEAST_PAIRS or len(true) < _LEAST_PAIRS:
        return shift
    tree = KDTree(true)
    for _ in range(8):
        distance, index = tree.query(found + shift)
        near = distance < _NEAR_M
        if near.sum() < _LEAST_PAIRS:
            return np.zeros(2)
        step = np.median(true[index[near]] - found[near] - shift, axis=0)
        shift = shift + step
        if np.hypot(*step) < 0.005:
            break
    return shift if np.hypot(*shift) <= LARGEST_OFFSET_M else np.zeros(2)


def finite(values: dict[str, Any]) -> dict[str, Any]:
    """Return the report with None in place of NaN and infinity, which JSON does not have."""
    return {
        key: None if isinstance(value, float) and not math.isfinite(value) else value for key, value in values.items()
    }


def _measures(tally: Tally) -> dict[str, float]:
    values = tally.measures()
    return {
        **{f"stall_{name}": values.pop(name) for name in ("precision", "recall", "f1")},
        **values,
        "free_count_error": tally.free_count_error / tally.free_true if tally.free_true else math.nan,
        "free_count_error_stalls": float(tally.free_count_error),
        "true_stalls": float(tally.true),
        "true_free": float(tally.free_true),
        "found_stalls": float(tally.found),
        "found_free": float(tally.free_found),
    }


def _found(survey: SurveyMap, truth: GroundTruth) -> NDArray[np.float64]:
    """Return the found stalls as quads (N, 4, 2) in the truth's world, by rising id; suggested ones are none."""
    quads = [stall.corners() for stall in survey.marked]
    if not quads:
        return np.zeros((0, 4, 2))
    return truth.to_world(np.concatenate(quads), survey.datum).reshape(-1, 4, 2)


def _position_error(finding: Finding, truth: accuracy.LabelledPlace) -> float:
    matches = accuracy.match(finding.stalls, truth.stalls)
    if not len(matches):
        return math.nan
    apart = finding.stalls[matches.found].mean(axis=1) - truth.stalls[matches.true].mean(axis=1)
    return float(np.percentile(np.hypot(*apart.T), 95))


def _lot_iou(survey: SurveyMap, truth: GroundTruth, shift: NDArray[np.float64]) -> float:
    """Return the IoU within the world's picture, on the survey's raster widened to hold the whole truth, at 40 cm."""
    cells = survey.cells()
    step = cells.cell_m * _COARSE
    mask = np.isin(cells.values, (Cell.LOT, Cell.FREE, Cell.TAKEN))[::_COARSE, ::_COARSE]
    corner = truth.to_world(np.array([[cells.north, cells.east]]), survey.datum)[0] + shift
    outlines = [(lot - corner) / step for lot in truth.lots]
    everything = np.vstack([*outlines, [[0, 0], mask.shape[::-1]]])
    low = np.floor(everything.min(axis=0)).astype(int)
    width, height = np.ceil(everything.max(axis=0)).astype(int) - low
    found = np.zeros((height, width), bool)
    found[-low[1] : -low[1] + mask.shape[0], -low[0] : -low[0] + mask.shape[1]] = mask
    true = np.zeros((height, width), np.uint8)
    for outline in outlines:
        cv2.fillPoly(true, [np.round(outline - low).astype(np.int32)], 1)
    if truth.size is not None:
        edges = np.round((np.array([(0.0, 0.0), truth.size]) - corner) / step - low).astype(int)
        (left, top), (right, bottom) = np.maximum(edges, 0)
        found, true = found[top:bottom, left:right], true[top:bottom, left:right]
    return accuracy.mask_iou(found, true > 0)

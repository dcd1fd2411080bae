"""Share of the true lot and of its stalls that a survey ever had in view, and what it found of those stalls.

A stall that no picture showed is missed by the flight, not by vision. In view is what the survey's own map holds: cells
that are not unknown, the constant part of the position error removed.
"""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.model.lot_map import Cell
from hawk.results.survey_map import SurveyMap
from hawk.survey.scoring import match
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

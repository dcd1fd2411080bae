"""Measures of an eye over labelled places, over pictures without stalls, and how well its probabilities are meant."""

from __future__ import annotations

import time
from collections.abc import Iterable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.perception.eyes import Eye, Result
from benchmarks.perception.places import Place
from hawk.model import StallState
from hawk.survey.scoring import FloatArray, Tally, mask_iou, match, tally

MEASURES = (
    "precision",
    "recall",
    "f1",
    "precision_star",
    "recall_whole",
    "free_precision_star",
    "free_recall",
    "state_accuracy",
    "unknown_share",
)
_BINS = 10


@dataclass(frozen=True, slots=True)
class Judged:
    """Probabilities (N,) of being taken, and whether it was so (N,)."""

    said: FloatArray
    true: NDArray[np.bool_]


def measure(eye: Eye, places: Iterable[Place], *, scale: float = 1.0, verbose: bool = False) -> dict[str, float]:
    """Return the measures over all places, with ``lot_iou``, ``state_ece``, ``found_over_labelled`` and
    ``ms_per_megapixel`` (processor time per million pixels of 0.1 m); a line for each place where ``verbose``.
    """
    total, overlaps, judged = Tally(), list[float](), list[Judged]()
    seconds = megapixels = 0.0
    for place in places:
        begun = time.process_time()
        result = eye.look(place.image, place.metres_per_pixel, scale=scale)
        seconds += time.process_time() - begun
        height, width = place.image.shape[:2]
        megapixels += height * width * (place.metres_per_pixel * scale / 0.1) ** 2 / 1e6
        one = tally(result.finding, place.truth)
        overlap = mask_iou(result.lot, _true_lot(place, result))
        total += one
        overlaps.append(overlap)
        judged.append(_judged(result, place))
        if verbose:
            print(f"  {place.name:24s} {line(one.measures())} lot {overlap:.2f} found/labelled {_share(one):.2f}")
    if not overlaps:
        return {}
    figures = {name: total.measures()[name] for name in MEASURES}
    return figures | {
        "lot_iou": float(np.nanmean(overlaps)),
        "state_ece": calibration_error(judged),
        "found_over_labelled": _share(total),
        "ms_per_megapixel": 1e3 * seconds / megapixels,
        "places": float(len(overlaps)),
        "labels": float(total.true),
    }


def false_alarms(
    eye: Eye, pictures: Iterable[tuple[str, NDArray[np.uint8]]], metres_per_pixel: float, *, verbose: bool = False
) -> dict[str, float]:
    """Return how many stalls are found on each picture without any, on average."""
    counts: list[int] = []
    for name, image in pictures:
        counts.append(len(eye.look(image, metres_per_pixel).finding.stalls))
        if verbose:
            print(f"  {name}: {counts[-1]} false alarms")
    return {"false_per_negative": float(np.mean(counts))} if counts else {}


def calibration_error(judged: Iterable[Judged]) -> float:
    """Return the expected calibration error (Guo et al. 2017) of the probabilities of being taken, in ten bins; NaN of
    nothing.
    """
    parts = list(judged)
    said = np.concatenate([part.said for part in parts]) if parts else np.zeros(0)
    true = np.concatenate([part.true for part in parts]) if parts else np.zeros(0, np.bool_)
    if not len(said):
        return float("nan")
    which = np.minimum((said * _BINS).astype(int), _BINS - 1)
    count = np.bincount(which, minlength=_BINS)
    apart = np.abs(np.bincount(which, said, _BINS) - np.bincount(which, true.astype(float), _BINS))
    return float(apart[count > 0].sum() / len(said))


def line(m: dict[str, float]) -> str:
    """Return the measures in one line."""
    return (
        f"P {m['precision']:.3f} R {m['recall']:.3f} F1 {m['f1']:.3f} P* {m['precision_star']:.3f} "
        f"R-whole {m['recall_whole']:.3f} free P* {m['free_precision_star']:.3f} R {m['free_recall']:.3f} "
        f"state {m['state_accuracy']:.3f}"
    )


def _judged(result: Result, place: Place) -> Judged:
    pairs = match(result.finding.stalls, place.truth.stalls)
    state = np.asarray(place.truth.states, object)[pairs.true]
    known = (state == StallState.FREE) | (state == StallState.TAKEN)
    return Judged(result.taken[pairs.found][known], np.asarray(state[known] == StallState.TAKEN))


def _true_lot(place: Place, result: Result) -> NDArray[np.bool_]:
    """Return the labelled lot as cells of the found one's raster."""
    drawn = np.zeros(result.lot.shape, np.uint8)
    cv2.fillPoly(drawn, [np.rint(lot / result.lot_m - 0.5).astype(np.int32) for lot in place.truth.lots], (1,))
    return drawn > 0


def _share(one: Tally) -> float:
    return one.found / one.true if one.true else float("nan")

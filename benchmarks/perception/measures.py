"""Measures of an eye over labelled places, over pictures without stalls, and how well its probabilities are meant."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.perception.boxes import Boxes
from benchmarks.perception.doubts import unsure_rank
from benchmarks.perception.edges import Counted, counted
from benchmarks.perception.eyes import Eye, Result
from benchmarks.perception.places import Place
from hawk.model.lot_map import StallState
from hawk.survey.accuracy import FloatArray, Tally, mask_iou, match, tally

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


@dataclass(frozen=True, slots=True)
class Looked:
    """One place: findings and labels that count, the counts, and the overlap of the lot (NaN without an outline).

    ``seconds`` is processor time, ``megapixels`` the picture's size in million pixels of 0.1 m.
    """

    place: Place = field(repr=False)
    kept: Counted = field(repr=False)
    tally: Tally
    overlap: float
    judged: Judged = field(repr=False)
    seconds: float
    megapixels: float


def look(eye: Eye, places: Iterable[Place], *, scale: float = 1.0, verbose: bool = False) -> list[Looked]:
    """Look at every place; print a line for each where ``verbose``.

    Labels that a picture's edge cuts count as neither right nor wrong (`benchmarks.perception.edges`).
    """
    looked = []
    for place in places:
        begun = time.process_time()
        result = eye.look(place.image, place.metres_per_pixel, scale=scale)
        seconds = time.process_time() - begun
        height, width = place.image.shape[:2]
        kept = counted(result, place)
        one = tally(kept.result.finding, kept.truth)
        overlap = mask_iou(result.lot, _true_lot(place, result)) if place.truth.lots else math.nan
        size = height * width * (place.metres_per_pixel * scale / 0.1) ** 2 / 1e6
        looked.append(Looked(place, kept, one, overlap, _judged(kept), seconds, size))
        if verbose:
            print(f"  {place.name:24s} {line(one.measures())} lot {overlap:.2f} found/labelled {_share(one):.2f}")
    return looked


def pooled(looked: Sequence[Looked]) -> dict[str, float]:
    """Return the measures over all places, with ``lot_iou``, ``state_ece``, ``found_over_labelled`` and
    ``ms_per_megapixel``; nothing without a place.

    ``labels`` count, ``labels_cut`` do not. ``lot_iou`` is the mean over the ``lots_outlined`` places whose labels
    outline a lot, NaN without any.
    """
    if not looked:
        return {}
    total = sum((one.tally for one in looked), Tally())
    overlaps = [one.overlap for one in looked if one.place.truth.lots]
    figures = {name: total.measures()[name] for name in MEASURES}
    return figures | {
        "lot_iou": float(np.mean(overlaps)) if overlaps else math.nan,
        "state_ece": calibration_error(one.judged for one in looked),
        "found_over_labelled": _share(total),
        "ms_per_megapixel": 1e3 * sum(one.seconds for one in looked) / sum(one.megapixels for one in looked),
        "places": float(len(looked)),
        "lots_outlined": float(len(overlaps)),
        "labels": float(total.true),
        "labels_cut": float(sum(int(one.kept.cut.sum()) for one in looked)),
        **_places_off(looked),
        **_suggestions(looked, total),
        **unsure_rank(looked),
    }


def _places_off(looked: Sequence[Looked]) -> dict[str, float]:
    """Return how far the centres of matched stalls lie from their labels', 95th percentile, metres, also along the
    labels' long sides and across, and the standard deviation of how much longer they are; nothing without a match.
    """
    parts = [_off(one.kept) for one in looked]
    apart = np.vstack([np.zeros((0, 3)), *parts])
    if not len(apart):
        return {}
    return {
        "centre_p95_m": float(np.percentile(np.hypot(apart[:, 0], apart[:, 1]), 95)),
        "centre_along_p95_m": float(np.percentile(np.abs(apart[:, 0]), 95)),
        "centre_across_p95_m": float(np.percentile(np.abs(apart[:, 1]), 95)),
        "length_sigma_m": float(np.std(apart[:, 2])),
    }


def _off(kept: Counted) -> FloatArray:
    """Return (N, 3) of the matched stalls: metres along and across the label, and metres longer than it."""
    pairs = match(kept.result.finding.stalls, kept.truth.stalls)
    found, label = Boxes.of(kept.result.finding.stalls[pairs.found]), Boxes.of(kept.truth.stalls[pairs.true])
    apart = found.centre - label.centre
    along, across = (np.einsum("nd,nd->n", apart, axis) for axis in (label.along, label.across))
    return np.column_stack([along, across, found.length - label.length])


def _suggestions(looked: Sequence[Looked], total: Tally) -> dict[str, float]:
    """Return how many stalls are suggested, how many of those are labelled, and the recall with them.

    ``total`` is the sum of the places' counts.
    """
    count = labelled = 0
    for one in looked:
        result, truth = one.kept.result, one.kept.truth
        missed = np.ones(len(truth.stalls), np.bool_)
        missed[match(result.finding.stalls, truth.stalls).true] = False
        count += len(result.suggested)
        labelled += len(match(result.suggested, truth.stalls[missed]))
    return {
        "suggested": float(count),
        "suggested_labelled": float(labelled),
        "recall_with_suggested": (total.matched + labelled) / total.true if total.true else math.nan,
    }


def measure(eye: Eye, places: Iterable[Place], *, scale: float = 1.0, verbose: bool = False) -> dict[str, float]:
    """Look at every place and return the measures over all of them."""
    return pooled(look(eye, places, scale=scale, verbose=verbose))


def false_alarms(
    eye: Eye,
    pictures: Iterable[tuple[str, NDArray[np.uint8]]],
    metres_per_pixel: float,
    *,
    verbose: bool = False,
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


def _judged(kept: Counted) -> Judged:
    pairs = match(kept.result.finding.stalls, kept.truth.stalls)
    state = np.asarray(kept.truth.states, object)[pairs.true]
    known = (state == StallState.FREE) | (state == StallState.TAKEN)
    return Judged(kept.result.taken[pairs.found][known], np.asarray(state[known] == StallState.TAKEN))


def _true_lot(place: Place, result: Result) -> NDArray[np.bool_]:
    """Return the labelled lot as cells of the found one's raster."""
    drawn = np.zeros(result.lot.shape, np.uint8)
    cv2.fillPoly(drawn, [np.rint(lot / result.lot_m - 0.5).astype(np.int32) for lot in place.truth.lots], (1,))
    return drawn > 0


def _share(one: Tally) -> float:
    return one.found / one.true if one.true else float("nan")

"""Doubt of squares beside their errors: what lists the lots to look at first.

`hawk.picture.orthophoto.lots.unsure_of` of each square, beside the share of its labels that are missed or have a wrong
state, and of finds beside the labelled lots. Distances of a square's colours, sharpness and features of the network
from those of the training's ground were tried in its place: the less alike, the fewer errors.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
import shapely
from scipy.stats import spearmanr

from benchmarks.perception.edges import Counted
from hawk.picture.orthophoto.lots import unsure_of
from hawk.survey.accuracy import FloatArray, lot_area, match

if TYPE_CHECKING:
    from benchmarks.perception.measures import Looked

SQUARE_M: Final = 40.0
"""Side of a square: that of the windows for checking by eye."""
_LEAST_LABELS: Final = 8
_LEAST_SQUARES: Final = 5
_DRAWS: Final = 400
_HELD: Final = (5, 95)


def unsure_rank(looked: Sequence[Looked]) -> dict[str, float]:
    """Return the rank correlation of doubt and errors over squares, and its 90 % interval by places drawn again.

    Nothing where few squares have `_LEAST_LABELS` labels and a find.
    """
    parts = [_squares(one.kept) for one in looked]
    whole = np.concatenate([np.zeros((0, 2)), *parts])
    if len(whole) < _LEAST_SQUARES:
        return {}
    rng = np.random.default_rng(0)
    drawn = [np.concatenate([parts[k] for k in rng.integers(len(parts), size=len(parts))]) for _ in range(_DRAWS)]
    ranks = [_rank(some) for some in drawn if len(some) >= _LEAST_SQUARES]
    least, most = np.nanpercentile(ranks, _HELD) if ranks else (np.nan, np.nan)
    return {
        "unsure_rank": _rank(whole),
        "unsure_rank_least": float(least),
        "unsure_rank_most": float(most),
        "unsure_squares": float(len(whole)),
    }


def _rank(squares: FloatArray) -> float:
    return float(spearmanr(squares[:, 0], squares[:, 1])[0])


def _squares(kept: Counted) -> FloatArray:
    """Return doubt and share of errors (K, 2) of the squares of a place."""
    found, truth, score = kept.result.finding, kept.truth, kept.result.score
    if not len(score):
        return np.zeros((0, 2))
    pairs = match(found.stalls, truth.stalls)
    is_wrong = np.ones(len(truth.stalls), np.bool_)
    states = np.asarray(truth.states, object)[pairs.true]
    is_known = (states == "free") | (states == "taken")
    is_wrong[pairs.true] = is_known & (states != np.asarray(found.states, object)[pairs.found])
    is_false = np.ones(len(score), np.bool_)
    is_false[pairs.found] = False
    is_false &= ~shapely.contains_xy(lot_area(truth.lots), *found.stalls.mean(axis=1).T)
    of_labels, of_finds = (_numbers(quads) for quads in (truth.stalls, found.stalls))
    rows = []
    for square in np.unique(of_labels, axis=0):
        here, finds = (of_labels == square).all(axis=1), (of_finds == square).all(axis=1)
        doubt = unsure_of(score[finds], kept.result.taken[finds])
        if here.sum() >= _LEAST_LABELS and doubt is not None:
            rows.append((doubt, (is_wrong[here].sum() + is_false[finds].sum()) / here.sum()))
    return np.array(rows, np.float64).reshape(-1, 2)


def _numbers(quads: FloatArray) -> FloatArray:
    return np.asarray(np.floor(quads.mean(axis=1) / SQUARE_M))

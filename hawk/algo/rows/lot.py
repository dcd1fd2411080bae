"""The rows of a lot: every row by itself, then what overlaps, then what no row takes."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hawk.algo.frame import Steps, outcome
from hawk.algo.rows.evidence import GroundAt, strip
from hawk.algo.rows.fit import Finds, Indices, Rectangles, Row, fit
from hawk.algo.rows.sequence import Chosen, RowOptions, choose
from hawk.algo.vision import quads
from hawk.algo.vision.detection import FloatArray

NO_ROW: Final = -1
_OVERLAP, _TOUCH = 0.2, 0.12
_OF_ROW, _MOST_OF_ROW = 0.1, 30.0
"""Of two stalls that overlap that one stays which has more log-odds, with this share of its row's, up to a limit."""

_ROWS_A_STEP: Final = 2


@dataclass(frozen=True, slots=True)
class RowStalls(Rectangles):
    """Stalls in and out of rows. ``log_odds`` of being a stall; ``source`` is the index of the given find, -1 for one
    that its row implies; ``row`` the number of its row, `NO_ROW` for a stall alone, ``number`` its place in the row.
    """

    log_odds: FloatArray = field(repr=False)
    source: Indices = field(repr=False)
    row: Indices = field(repr=False)
    number: Indices = field(repr=False)

    @property
    def north(self) -> FloatArray:
        """First coordinates of the centres, (N,)."""
        return self.centres[:, 0]

    @property
    def east(self) -> FloatArray:
        """Second coordinates of the centres, (N,)."""
        return self.centres[:, 1]

    @property
    def inferred(self) -> NDArray[np.bool_]:
        """Which are implied by their row, (N,)."""
        return self.source < 0


def complete_rows(finds: Finds, ground_at: GroundAt, options: RowOptions | None = None) -> RowStalls:
    """Return the stalls that finds and ground show, aligned in their rows, together with those that rows imply.

    Finds against which their row speaks are left out; so are those in no row below the score for that.
    """
    return outcome(completion(finds, ground_at, options or RowOptions()))


def completion(finds: Finds, ground_at: GroundAt, options: RowOptions) -> Steps[RowStalls]:
    """Do the work of `complete_rows` in steps of a few milliseconds."""
    rows = yield from fit(finds, options.finds_from)
    yield
    parts = []
    for number, row in enumerate(rows):
        parts.append(_stalls(number, row, choose(row, strip(row, ground_at, finds), finds, options)))
        if number % _ROWS_A_STEP == _ROWS_A_STEP - 1:
            yield
    stalls = _join([*parts, _none()])
    total = np.bincount(stalls.row, stalls.log_odds, len(rows))
    rank = stalls.log_odds + _OF_ROW * np.minimum(total[stalls.row], _MOST_OF_ROW)
    stalls = stalls[quads.suppress(stalls.corners(), rank, _OVERLAP)]
    return _join([stalls, _alone(finds, stalls, options.lone_score)])


def _stalls(number: int, row: Row, chosen: Chosen) -> RowStalls:
    count = len(chosen.t)
    sides = row.sides(chosen.t)
    return RowStalls(
        centres=row.centres(chosen.t),
        angle=np.arctan2(sides[:, 1], sides[:, 0]) % np.pi,
        width=chosen.width,
        length=np.full(count, row.length),
        log_odds=chosen.log_odds,
        source=chosen.source,
        row=np.full(count, number, np.intp),
        number=np.rint((chosen.t - chosen.t[:1]) / row.pitch).astype(np.intp),
    )


def _alone(finds: Finds, stalls: RowStalls, least_score: float) -> RowStalls:
    """Return the finds of a score that touch no stall of a row."""
    taken = np.zeros(len(finds), np.bool_)
    taken[stalls.source[stalls.source >= 0]] = True
    index = np.flatnonzero((finds.score >= least_score) & ~taken)
    some = finds[index]
    if len(some) and len(stalls):
        reach = float(max(some.length.max(), stalls.length.max())) * 1.2
        i, j = quads.near_pairs(some.centres, stalls.centres, reach)
        clear = np.ones(len(some), np.bool_)
        clear[i[quads.overlap_more(some.corners()[i], stalls.corners()[j], _TOUCH)]] = False
        index, some = index[clear], some[clear]
    odds = np.clip(some.score, 1e-3, 1 - 1e-3)
    none, first = np.full(len(some), NO_ROW, np.intp), np.zeros(len(some), np.intp)
    shape = (some.centres, some.angle, some.width, some.length)
    return RowStalls(*shape, np.log(odds / (1 - odds)), index, none, first)


def _none() -> RowStalls:
    empty, whole = np.zeros(0), np.zeros(0, np.intp)
    return RowStalls(np.zeros((0, 2)), empty, empty, empty, empty, whole, whole, whole)


def _join(parts: list[RowStalls]) -> RowStalls:
    return RowStalls(**{f.name: np.concatenate([getattr(p, f.name) for p in parts]) for f in fields(RowStalls)})

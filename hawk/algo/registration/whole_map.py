"""Registration of a whole map of a lot on an earlier one: a shift and a turn, or "not certain".

Rows repeat at every pitch: many places fit almost as well as the right one. The best place is taken only where it
beats every other by a margin; the others are given too, for a person to choose.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Final

import cv2
import numpy as np
from scipy.spatial import cKDTree

from hawk.algo.frame import Steps, outcome
from hawk.algo.registration.likelihood import DEVIATION_M, Fit, Likelihood, Placement, StallMap
from hawk.algo.rows.fit import Indices
from hawk.algo.vision import quads
from hawk.algo.vision.detection import FloatArray

REACH_M: Final = 6.5
"""Longest shift that is sought: two receivers that are off by 3 m each may differ by 6 m."""
REACH_RAD: Final = math.radians(4.0)
"""Widest turn that is sought."""
MARGIN: Final = math.log(1e4)
"""Nats by which the best place must beat every other: with rates of misses and of false stalls that hold, the wrong
place wins by as much once in ten thousand maps."""
LEAST_PAIRS: Final = 4
LEAST_SHARE: Final = 0.5
"""Share of the stalls in common view that must be paired: with fewer, it is another lot, or not the same any more."""
ROWS_OFF_M: Final = 0.25
"""Rows of another lot lie along themselves anywhere within a pitch: .28 m off or more at the best place, in 40 pairs
of drawn lots. Rows of the same lot are up to .21 m off at labelled places, and .22 m in a flown lot."""
_OTHER_M: Final = 1.2
"""Two placements are two places where they put the stalls this far apart, in the mean: half of the narrowest pitch."""
_ANGLE: Final = 0.25
_BIN_M: Final = 0.25
_PEAKS_A_TURN: Final = 8
_REFINED: Final = 48
_ROUNDS: Final = 6
_STALLS_AWAY: Final = 4


class Doubt(StrEnum):
    """Why a map is not registered."""

    TOO_FEW = "too few stalls on ground that both maps saw"
    ALIKE = "two places fit alike"
    DIFFERENT = "the stalls differ too much"
    FAR = "it fits better farther off than a receiver errs"


@dataclass(frozen=True, slots=True)
class Candidate:
    """A place of the found map on the known one, and how well it fits."""

    placement: Placement
    fit: Fit


@dataclass(frozen=True, slots=True)
class Registration:
    """The ``best`` place, and the ``second`` one, a place of its own, where there is any. ``doubt`` is None where the
    best one is certain.
    """

    best: Candidate | None
    second: Candidate | None
    doubt: Doubt | None

    @property
    def is_certain(self) -> bool:
        """True when the best place is the right one."""
        return self.doubt is None

    @property
    def lead(self) -> float:
        """Nats by which the best place is ahead; infinite without a second one."""
        if self.best is None:
            return 0.0
        return self.best.fit.score - self.second.fit.score if self.second else math.inf

    @property
    def pairs(self) -> Indices:
        """Stalls (K, 2) that are one, known and found: none unless the place is certain."""
        if self.doubt is not None or self.best is None:
            return np.zeros((0, 2), np.intp)
        return self.best.fit.pairs


def register(known: StallMap, found: StallMap) -> Registration:
    """Return where ``found`` lies on ``known``; both are given as they are placed so far."""
    return outcome(registering(known, found))


def registering(known: StallMap, found: StallMap) -> Steps[Registration]:
    """Do the work of `register` in steps of a few milliseconds, for lots of some hundred stalls."""
    if min(len(known.stalls), len(found.stalls)) < LEAST_PAIRS:
        return Registration(None, None, Doubt.TOO_FEW)
    likelihood = Likelihood(known, found)
    yield
    candidates = yield from _candidates(likelihood)
    if not candidates:
        return Registration(None, None, Doubt.TOO_FEW)
    best = max(candidates, key=lambda one: one.fit.score)
    for place in _stalls_away(known, best.placement):
        yield
        candidates.append(refined(likelihood, place))
    best = max(candidates, key=lambda one: one.fit.score)
    places = _spread(found)
    apart = _distances(np.stack([one.placement.of(places) for one in candidates]), best.placement.of(places))
    others = [one for one, metres in zip(candidates, apart.tolist(), strict=True) if metres > _OTHER_M]
    second = max(others, key=lambda one: one.fit.score, default=None)
    return Registration(best, second, _doubt(likelihood, best, second))


def _doubt(likelihood: Likelihood, best: Candidate, second: Candidate | None) -> Doubt | None:
    if len(best.fit.pairs) < LEAST_PAIRS:
        return Doubt.TOO_FEW
    if best.fit.share < LEAST_SHARE:
        return Doubt.DIFFERENT
    if second is not None and best.fit.score - second.fit.score < MARGIN:
        return Doubt.ALIKE
    if not _is_within_reach(best.placement):
        return Doubt.FAR
    return Doubt.DIFFERENT if likelihood.rows_off(best.placement, best.fit.pairs) > ROWS_OFF_M else None


def refined(likelihood: Likelihood, placement: Placement) -> Candidate:
    """Return the placement moved to where its own pairs lie best, by least squares that far pairs hardly move."""
    known, found = likelihood.known.stalls.centres, likelihood.found.stalls.centres
    best = Candidate(placement, likelihood.fit(placement))
    for _ in range(_ROUNDS):
        pairs = best.fit.pairs
        if len(pairs) < 2:
            break
        weight = 1 / (1 + (best.fit.away / DEVIATION_M) ** 2)
        placement = _least_squares(known[pairs[:, 0]], found[pairs[:, 1]], weight, placement.pivot)
        moved = Candidate(placement, likelihood.fit(placement))
        if moved.fit.score <= best.fit.score + 1e-6:
            break
        best = moved
    return best


def _least_squares(known: FloatArray, found: FloatArray, weight: FloatArray, pivot: tuple[float, float]) -> Placement:
    """Return the turn and shift that bring ``found`` (N, 2) onto ``known`` (Kabsch 1976, in the plane)."""
    from_middle, to_middle = ((places * weight[:, None]).sum(0) / weight.sum() for places in (found, known))
    a, b = found - from_middle, known - to_middle
    turn = math.atan2(float(weight @ (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])), float(weight @ (a * b).sum(1)))
    turn = float(np.clip(turn, -REACH_RAD, REACH_RAD))
    without = Placement(turn, (0.0, 0.0), pivot)
    north, east = (to_middle - without.of(from_middle[None])[0]).tolist()
    return Placement(turn, (north, east), pivot)


def _candidates(likelihood: Likelihood) -> Steps[list[Candidate]]:
    """Return the best places, refined, from the shifts that many pairs of stalls have in common at each turn."""
    peaks: list[tuple[float, Placement]] = []
    for at_one_turn in _peaks(likelihood.known, likelihood.found):
        peaks.extend(at_one_turn)
        yield
    peaks.sort(key=lambda peak: -peak[0])
    candidates: list[Candidate] = []
    places = _spread(likelihood.found)
    taken = np.empty((_REFINED, *places.shape))
    for _, placement in peaks:
        if (_distances(taken[: len(candidates)], placement.of(places)) < DEVIATION_M).any():
            continue
        one = refined(likelihood, placement)
        taken[len(candidates)] = one.placement.of(places)
        candidates.append(one)
        if len(candidates) == _REFINED:
            break
        yield
    return candidates


def _peaks(known: StallMap, found: StallMap) -> Iterator[list[tuple[float, Placement]]]:
    """Yield, for each turn, the shifts that most pairs of stalls have in common, with how many."""
    centres = found.stalls.centres
    middle = centres.mean(axis=0)
    pivot = (float(middle[0]), float(middle[1]))
    radius = max(float(np.hypot(*(centres - middle).T).max()), 1.0)
    count = math.ceil(REACH_RAD / (DEVIATION_M / radius))
    tree = cKDTree(known.stalls.centres)
    for turn in np.linspace(-REACH_RAD, REACH_RAD, 2 * count + 1).tolist():
        placed = Placement(turn, (0.0, 0.0), pivot).of(centres)
        common = _common_shifts(known, tree, placed, found.stalls.angle + turn)
        yield [(weight, Placement(turn, shift, pivot)) for weight, shift in common]


def _common_shifts(
    known: StallMap, tree: cKDTree, placed: FloatArray, angle: FloatArray
) -> list[tuple[float, tuple[float, float]]]:
    near = cKDTree(placed).sparse_distance_matrix(tree, REACH_M + 2 * _BIN_M, output_type="coo_matrix")
    alike = quads.angle_between(angle[near.row], known.stalls.angle[near.col]) < _ANGLE
    shifts = known.stalls.centres[near.col[alike]] - placed[near.row[alike]]
    side = math.ceil((REACH_M + 2 * _BIN_M) / _BIN_M)
    edges = (np.arange(2 * side + 2) - side - 0.5) * _BIN_M
    counted, _, _ = np.histogram2d(shifts[:, 0], shifts[:, 1], bins=[edges, edges])
    votes = cv2.GaussianBlur(counted, (0, 0), DEVIATION_M / _BIN_M, borderType=cv2.BORDER_CONSTANT)
    tops = np.argwhere((votes == cv2.dilate(votes, np.ones((3, 3), np.uint8))) & (votes > 0))
    most = tops[np.argsort(-votes[tops[:, 0], tops[:, 1]], kind="stable")][:_PEAKS_A_TURN]
    return [(float(votes[i, j]), ((i - side) * _BIN_M, (j - side) * _BIN_M)) for i, j in most.tolist()]


def _stalls_away(known: StallMap, placement: Placement) -> Iterator[Placement]:
    """Yield the places that lie some stalls farther along the rows, in both directions: those are mistaken most easily.

    They may lie beyond reach: where such a place is the best, none within reach is right.
    """
    for direction, pitch in _pitches(known):
        for steps in (*range(-_STALLS_AWAY, 0), *range(1, _STALLS_AWAY + 1)):
            north = placement.shift[0] + steps * pitch * direction[0]
            east = placement.shift[1] + steps * pitch * direction[1]
            yield Placement(placement.turn, (north, east), placement.pivot)


def _pitches(known: StallMap) -> Sequence[tuple[tuple[float, float], float]]:
    """Return, for each direction in which stalls lie side by side, a unit vector and the usual distance."""
    centres, angle = known.stalls.centres, known.stalls.angle
    pairs = cKDTree(centres).query_pairs(2 * float(np.median(known.stalls.width)), output_type="ndarray")
    alike = quads.angle_between(angle[pairs[:, 0]], angle[pairs[:, 1]]) < _ANGLE
    apart = (centres[pairs[:, 1]] - centres[pairs[:, 0]])[alike]
    toward = np.arctan2(apart[:, 1], apart[:, 0]) % np.pi
    kind = np.rint(toward / np.radians(10)).astype(int) % 18
    found = []
    for number in np.unique(kind).tolist():
        mine = kind == number
        doubled = float(np.angle(np.exp(2j * toward[mine]).mean())) / 2
        found.append(((math.cos(doubled), math.sin(doubled)), float(np.median(np.hypot(*apart[mine].T)))))
    return found


def _is_within_reach(placement: Placement) -> bool:
    return math.hypot(*placement.shift) <= REACH_M + DEVIATION_M and abs(placement.turn) <= REACH_RAD


def _spread(found: StallMap) -> FloatArray:
    """Return the centres (N, 2) of some hundred of the stalls."""
    return found.stalls.centres[:: max(1, len(found.stalls) // 100)]


def _distances(many: FloatArray, one: FloatArray) -> FloatArray:
    """Return the mean distances (K,) of the same places at K placements (K, N, 2) and at one (N, 2)."""
    off = many - one
    return np.asarray(np.hypot(off[..., 0], off[..., 1]).mean(axis=1))

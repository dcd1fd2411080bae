"""The registration of maps as the lots' store asks for it: with its values, and doubts in sentences."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import MultiPolygon, Polygon
from shapely.geometry.base import BaseGeometry

from hawk.algo.registration.likelihood import MATCH_M, StallMap
from hawk.algo.registration.whole_map import LEAST_PAIRS, Candidate, Doubt, register
from hawk.algo.registration.whole_map import Registration as Outcome
from hawk.algo.rows.fit import Rectangles
from hawk.algo.vision import quads
from hawk.lots.plan.values import LayoutStall
from hawk.lots.registration.frames import Move, is_in_place
from hawk.lots.values import Detection, Doubtful, KnownGround, MappedGround, PossiblePlace, Registration
from hawk.model.sentences import say

FITS: Final = 0.5
"""Intersection over union from which a found stall may be the known one at its place."""
_WORDS: Final = {
    Doubt.TOO_FEW: say("too few stalls are on ground that both saw"),
    Doubt.ALIKE: say("two places fit alike"),
    Doubt.DIFFERENT: say("the stalls differ too much"),
    Doubt.FAR: say("it fits better farther off than a receiver errs"),
}


def registration(known: KnownGround, found: MappedGround) -> Registration | Doubtful:
    """Return the place of a survey's stalls among those of a lot, or the doubt with one or two places.

    States are no argument: equal stalls with other cars are the same stalls.
    """
    mine, theirs = _map(known.stalls, known.seen), _map(found.stalls, found.seen)
    outcome = register(mine, theirs)
    if outcome.doubt is Doubt.ALIKE:
        outcome = _as_in_flight(outcome, mine, theirs, _given(known, found))
    if outcome.doubt is not None or outcome.best is None:
        places = tuple(_place(each) for each in (outcome.best, outcome.second) if each is not None)
        return Doubtful(_WORDS[outcome.doubt or Doubt.TOO_FEW], places)
    pairs = outcome.pairs[_fits(mine.stalls, theirs.stalls, outcome)]
    same = {found.stalls[j].id: known.stalls[i].id for i, j in pairs.tolist()}
    move = _move(outcome.best)
    return Registration(move.north, move.east, move.turn, same)


def _given(known: KnownGround, found: MappedGround) -> NDArray[np.intp]:
    """Return the pairs (K, 2) of stalls, known and found, that the flight took for one."""
    numbers = {stall.id: number for number, stall in enumerate(known.stalls)}
    pairs = [(numbers[stall.known], j) for j, stall in enumerate(found.stalls) if stall.known in numbers]
    return np.array(pairs, np.intp).reshape(-1, 2)


def _as_in_flight(outcome: Outcome, mine: StallMap, theirs: StallMap, given: NDArray[np.intp]) -> Outcome:
    """Return the one of two places where the flight saw the plan: its map showed the adjoining lots, too."""
    if len(given) < LEAST_PAIRS:
        return outcome
    there, here = mine.stalls.centres[given[:, 0]], theirs.stalls.centres[given[:, 1]]
    agreeing = [
        each
        for each in (outcome.best, outcome.second)
        if each is not None and np.hypot(*(each.placement.of(here) - there).T).max() < MATCH_M
    ]
    return Outcome(agreeing[0], None, None) if len(agreeing) == 1 else outcome


def _fits(mine: Rectangles, theirs: Rectangles, outcome: Outcome) -> NDArray[np.bool_]:
    """Return which pairs (K,) of a registration are one: a stall of a row at another pitch is another one.

    They overlap by half, and none lies between two.
    """
    if outcome.best is None:
        return np.zeros(0, np.bool_)
    i, j = outcome.pairs.T
    placed = replace(
        theirs[j],
        centres=outcome.best.placement.of(theirs.centres[j]),
        angle=theirs.angle[j] + outcome.best.placement.turn,
    )
    overlap = quads.overlap_more(mine[i].corners(), placed.corners(), FITS)
    return np.asarray(overlap & is_in_place(_shapes(mine[i]), _shapes(placed)))


def _shapes(stalls: Rectangles) -> NDArray[np.float64]:
    return np.column_stack([stalls.centres, stalls.angle, stalls.width, stalls.length])


def _map(stalls: tuple[LayoutStall, ...] | tuple[Detection, ...], seen: BaseGeometry) -> StallMap:
    values = np.array([(s.north, s.east, s.angle, s.width, s.length) for s in stalls], float).reshape(-1, 5)
    return StallMap(Rectangles(values[:, :2], *values[:, 2:].T), _polygons(seen))


def _polygons(ground: BaseGeometry) -> MultiPolygon:
    """Return the ground without lines and points that a cut leaves."""
    parts = shapely.get_parts(shapely.get_parts(ground))
    return MultiPolygon([part for part in parts if isinstance(part, Polygon) and not part.is_empty])


def _move(candidate: Candidate) -> Move:
    """Return a placement, which turns about a pivot, as one that turns about the origin."""
    placement = candidate.placement
    (origin,) = placement.of(np.zeros((1, 2))).tolist()
    return Move(origin[0], origin[1], placement.turn)


def _place(candidate: Candidate) -> PossiblePlace:
    move = _move(candidate)
    return PossiblePlace(move.north, move.east, move.turn, candidate.fit.score)

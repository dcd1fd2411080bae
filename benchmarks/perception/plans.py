"""Pictures of places whose plan is known: the labels, given as a plan that lies beside them.

The plan is shifted and turned as the errors of a receiver and a compass do. Its place is found again by where the
network finds stalls (`hawk.algo.registration`); the state of each of its stalls is then read from the network's maps.
What is found beside the plan would be proposed to a person.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import shapely
from numpy.typing import NDArray

from benchmarks.figures import Figure, Limit, Section, share
from benchmarks.perception.eyes import NetworkEye, boxes_of_maps
from benchmarks.perception.places import Place
from benchmarks.perception.stall_rows import Boxes
from hawk.algo.registration.likelihood import Placement, StallMap
from hawk.algo.registration.whole_map import register
from hawk.algo.rows.fit import Rectangles
from hawk.algo.vision import decode, quads
from hawk.algo.vision.seen import FloatArray
from hawk.model.lot_map import StallState
from hawk.picture.orthophoto.tile_detector import CELL_M, GROUND_M
from hawk.survey.accuracy import NEAR_M

SHIFT_M: Final = 1.5
TURN: Final = math.radians(1.0)
KNOWN_M: Final = 5.0
"""The plan knows the ground about its stalls: labels of places lack whole rows."""
PROPOSED_FROM: Final = 0.9
"""Score (0..1) of a find from which a still picture proposes it; a flight takes several looks."""
_ON_PLAN: Final = 0.05
_NEAR_M: Final = 8.0


@dataclass(frozen=True, slots=True)
class Planned:
    """One place. ``judged`` of its ``stalls`` have a state; ``named`` of those have a label that is free or taken, of
    which ``right`` agree. ``proposed`` finds lie beside the plan, ``false`` of them count as false alarms.
    """

    name: str
    stalls: int
    judged: int = 0
    named: int = 0
    right: int = 0
    proposed: int = 0
    false: int = 0
    off_m: float = math.nan
    doubt: str = ""


def plan_section(eye: NetworkEye, places: Iterable[Place]) -> Section:
    """Look at every place with its labels as the plan; print a line for each."""
    planned = []
    for place in places:
        if len(place.truth.stalls):
            planned.append(look_with_plan(eye, place))
            print(f"  {line(planned[-1])}")
    return Section("with the labels as the plan", figures(planned))


def figures(planned: Sequence[Planned]) -> list[Figure]:
    """Return the figures over all places."""
    stalls, judged, named, right = (sum(getattr(p, n) for p in planned) for n in ("stalls", "judged", "named", "right"))
    false, proposed = (sum(getattr(p, n) for p in planned) for n in ("false", "proposed"))
    off = [p.off_m for p in planned if not p.doubt]
    return [
        Figure("plan_judged", "stalls of the plan with a state", share(judged, stalls), limit=Limit(lowest=1.0)),
        Figure(
            "plan_state_accuracy", "state, where the label names it", share(right, named), limit=Limit(lowest=0.98)
        ),
        Figure("plan_states", "labels that name a state", named),
        Figure(
            "plan_false_proposals", "false proposals a stall", share(false, judged), limit=Limit(highest=0.02)
        ),
        Figure("plan_proposals", "proposals a stall", share(proposed, judged)),
        Figure("plan_off_max_m", "plan off its place, at most", max(off, default=None), "m"),
        Figure("plan_uncertain", "places where it is not certain", sum(bool(p.doubt) for p in planned)),
        Figure("plan_places", "places", len(planned)),
    ]  # fmt: skip


def look_with_plan(eye: NetworkEye, place: Place) -> Planned:
    """Find the plan's place in the picture, then the states of its stalls, and what lies beside it."""
    maps = eye.maps(place.image, place.metres_per_pixel)
    found, score = boxes_of_maps(maps)
    labels = _rectangles(place)
    size = np.array(place.image.shape[1::-1]) * place.metres_per_pixel
    plan, picture = moved_plan(place.name, labels, size), shapely.box(0, 0, *size.tolist())
    ground = shapely.union_all(shapely.polygons(plan.corners())).buffer(KNOWN_M)
    registration = register(StallMap(plan, ground), StallMap(found, picture))
    if not registration.is_certain or registration.best is None:
        return Planned(place.name, len(labels), doubt=str(registration.doubt))
    placed = _back(plan, registration.best.placement)
    taken = decode.occupancy(maps, _in_cells(placed))
    states = np.asarray(place.truth.states, object)
    named = (states == StallState.FREE) | (states == StallState.TAKEN)
    right = ((taken >= 0.5) == (states == StallState.TAKEN)) & named
    beside = found[_beside(found, placed) & (score >= PROPOSED_FROM)]
    return Planned(
        place.name,
        len(labels),
        judged=len(taken),
        named=int(named.sum()),
        right=int(right.sum()),
        proposed=len(beside),
        false=int(_is_false(place, beside.centres).sum()),
        off_m=float(np.hypot(*(placed.centres - labels.centres).T).max()),
    )


def moved_plan(name: str, labels: Rectangles, size: FloatArray) -> Rectangles:
    """Return the labels shifted by up to `SHIFT_M` along each axis and turned by `TURN`; the same each time by name."""
    rng = np.random.default_rng(zlib.crc32(name.encode()))
    turn, shift = TURN * float(rng.choice([-1, 1])), rng.uniform(-SHIFT_M, SHIFT_M, 2)
    cosine, sine = math.cos(turn), math.sin(turn)
    centres = (labels.centres - size / 2) @ np.array([[cosine, sine], [-sine, cosine]]) + size / 2 + shift
    return Rectangles(centres, (labels.angle + turn) % np.pi, labels.width, labels.length)


def line(one: Planned) -> str:
    """Return a place in one line."""
    if one.doubt:
        return f"{one.name:24s} {one.stalls:4d} stalls, not certain where the plan lies: {one.doubt}"
    state = "" if not one.named else f"state {one.right / one.named:.3f} of {one.named}, "
    beside = f"{one.proposed} proposed, {one.false} false, off {one.off_m:.2f} m"
    return f"{one.name:24s} {one.stalls:4d} stalls, {state}{beside}"


def _rectangles(place: Place) -> Rectangles:
    labels = Boxes.of(place.truth.stalls)
    return Rectangles(
        labels.centre, np.arctan2(labels.along[:, 1], labels.along[:, 0]) % np.pi, labels.width, labels.length
    )


def _back(plan: Rectangles, placement: Placement) -> Rectangles:
    return Rectangles(placement.back(plan.centres), plan.angle - placement.turn, plan.width, plan.length)


def _in_cells(stalls: Rectangles) -> decode.Stalls:
    column, row = ((stalls.centres - GROUND_M / 2) / CELL_M).T
    return decode.Stalls(column, row, stalls.angle, stalls.width / CELL_M, stalls.length / CELL_M, np.ones(len(stalls)))


def _beside(found: Rectangles, plan: Rectangles) -> NDArray[np.bool_]:
    beside = np.ones(len(found), np.bool_)
    i, j = quads.near_pairs(found.centres, plan.centres, _NEAR_M)
    beside[i[quads.overlap_more(found.corners()[i], plan.corners()[j], _ON_PLAN)]] = False
    return beside


def _is_false(place: Place, centres: FloatArray) -> NDArray[np.bool_]:
    """Return which finds (N,) are counted false alarms, as `hawk.survey.accuracy` counts them."""
    points = shapely.points(centres)
    stalls = shapely.union_all([shapely.Polygon(corners) for corners in place.truth.stalls])
    lots = shapely.union_all([shapely.Polygon(lot).buffer(0) for lot in place.truth.lots])
    return np.asarray((shapely.distance(points, stalls) < NEAR_M) | ~shapely.contains(lots, points), np.bool_)

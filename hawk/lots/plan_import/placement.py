"""Place of a file's plan in a lot: by its coordinates or two pinned points, then by the stalls that the lot knows.

The registration is that of surveys (`hawk.lots.values.Register`). Where it is not certain, the plan stays where its
coordinates or points have it, and the doubt is said.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np
import shapely
from shapely import MultiPoint
from shapely.geometry.base import BaseGeometry
from sqlalchemy import Connection, select

from hawk.lots.plan.queries import all_stalls
from hawk.lots.plan.values import LayoutStall
from hawk.lots.plan_files.values import PlanFile
from hawk.lots.registration.frames import Floats, Move, frame_of, same_stalls
from hawk.lots.registration.georeference import about
from hawk.lots.registration.survey_place import ABOUT_M, Findings, datum_of, known_ground, move_of
from hawk.lots.storage.schema import SURVEY
from hawk.lots.survey.order import newest_first
from hawk.lots.values import Detection, Doubtful, KnownGround, LotInputError, MappedGround, Register
from hawk.model.lot_map import StallState
from hawk.model.poses import Ring

WORST_SCALE: Final = 0.02
"""Share by which two points may be farther apart on Earth than in the drawing."""
LEAST_APART_M: Final = 10.0
"""Of points nearer to each other, 0.2 m of error is more than a degree."""
FARTHEST_M: Final = 20_000.0
"""A plan farther from the lot is another lot's."""
MOST_REGISTERED: Final = 1500
"""Stalls that a registration compares: those about one place. Its time rises with the square of their number."""
_REFINED: Final = 3
"""Times that the place of all stalls follows from their nearest ones, after that of some of them."""


_SAME_M: Final = 0.5
"""Farther apart, two stalls are not the same at the same place."""


@dataclass(frozen=True, slots=True)
class Pin:
    """A point of a drawing, x and y in its units, and its place on Earth (latitude, longitude)."""

    x: float
    y: float
    latitude: float
    longitude: float


@dataclass(frozen=True, slots=True)
class Placement:
    """Place of a plan: ``move`` brings the file's frame onto the lot's, whose ``datum`` is (latitude, longitude).

    ``by``: "coordinates" or "points". ``on``: "stalls" or "survey", on which it was registered; "" for neither.
    ``doubt``: why the registration is not certain. ``shift``: the move that it made. ``residual``: metres by which
    two points are farther apart on Earth than in the drawing.
    """

    move: Move
    datum: tuple[float, float]
    by: str
    on: str = ""
    doubt: str = ""
    shift: Move = field(default_factory=Move)
    residual: float = 0.0


def placed(
    connection: Connection, lot: str | None, plan: PlanFile, pins: Sequence[Pin], register: Register | None
) -> Placement:
    """Return the place of a plan in a lot; None: in a new one, about the plan itself. Raises LotInputError."""
    datum = None if lot is None else datum_of(connection, lot)
    first = _by_coordinates(plan, pins, datum) if plan.datum is not None else _by_points(plan, pins, datum)
    if lot is None or register is None or not plan.stalls:  # sections alone lie where their coordinates say
        return first
    return _registered(connection, lot, plan, first, register)


def _by_coordinates(plan: PlanFile, pins: Sequence[Pin], datum: tuple[float, float] | None) -> Placement:
    assert plan.datum is not None  # noqa: S101 - it has coordinates
    if pins:
        raise LotInputError("pin", "is for drawings without coordinates on Earth: this plan has them, leave it out")
    if datum is None:
        return Placement(Move(), plan.datum, "coordinates")
    (away,) = about(datum, np.array([plan.datum]))[:, :2]
    is_near = abs(plan.datum[0] - datum[0]) < 1.0 and np.isfinite(away).all() and np.hypot(*away) <= FARTHEST_M
    if not is_near:
        where = f"{plan.datum[0]:.5f}, {plan.datum[1]:.5f}"
        raise LotInputError("file", f"lies at {where}, more than 20 km from this lot: name its lot, or a new one")
    return Placement(frame_of(datum, plan.datum), datum, "coordinates")


def _by_points(plan: PlanFile, pins: Sequence[Pin], datum: tuple[float, float] | None) -> Placement:
    if len(pins) != 2:
        (low_y, low_x), (high_y, high_x) = _extent(plan)
        words = (
            "must be given twice: the plan has no coordinates on Earth. Write x,y,latitude,longitude of two points of "
            f"the drawing, which has x {low_x:.6g} to {high_x:.6g} and y {low_y:.6g} to {high_y:.6g}; "
            "or name the system of its coordinates (crs)"
        )
        raise LotInputError("pin", words)
    datum = datum or (pins[0].latitude, pins[0].longitude)
    x, y = np.array([(pin.x, pin.y) for pin in pins]).T
    here = np.column_stack([y - plan.origin[1], x - plan.origin[0]]) * plan.metres
    there = about(datum, np.array([(pin.latitude, pin.longitude) for pin in pins]))[:, :2]
    if not np.isfinite(there).all() or np.hypot(*there.T).max() > FARTHEST_M:
        raise LotInputError("pin", "is more than 20 km from this lot: write latitude and longitude of its own points")
    before, after = here[1] - here[0], there[1] - there[0]
    apart, measured = float(np.hypot(*before)), float(np.hypot(*after))
    if min(apart, measured) < LEAST_APART_M:
        words = (
            f"names points {min(apart, measured):.1f} m apart: take two that are {LEAST_APART_M:.0f} m apart or more"
        )
        raise LotInputError("pin", words)
    if abs(measured / apart - 1) > WORST_SCALE:
        words = (
            f"names points that are {apart:.2f} m apart in the drawing and {measured:.2f} m on Earth "
            f"({measured / apart - 1:+.1%}), {WORST_SCALE:.0%} is the most: check the points, or name other units"
        )
        raise LotInputError("pin", words)
    turn = math.atan2(float(before[0] * after[1] - before[1] * after[0]), float(before @ after))
    north, east = (there.mean(axis=0) - Move(turn=turn).of(here.mean(axis=0)[None])[0]).tolist()
    return Placement(Move(north, east, turn), datum, "points", residual=measured - apart)


def _extent(plan: PlanFile) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the least and the greatest (y, x) of stalls' middles and sections' corners, in units of the drawing."""
    places = plan.places() / plan.metres + np.array([plan.origin[1], plan.origin[0]])
    (low_y, low_x), (high_y, high_x) = places.min(axis=0).tolist(), places.max(axis=0).tolist()
    return (low_y, low_x), (high_y, high_x)


def shapes_after(shapes: Floats, move: Move) -> Floats:
    """Return shapes (N, 5) after a move."""
    found = shapes.copy()
    found[:, :2] = move.of(shapes[:, :2])
    found[:, 2] = (shapes[:, 2] + move.turn) % math.pi
    return found


def ring_after(ring: Ring, move: Move) -> Ring:
    """Return a ring after a move, to the micrometre."""
    return tuple((north, east) for north, east in np.round(move.of(np.array(ring)), 6).tolist())


def _registered(connection: Connection, lot: str, plan: PlanFile, first: Placement, register: Register) -> Placement:
    """Return the place of a plan by the stalls that the lot has, or by those that its newest survey found."""
    known, ground, on = _known(connection, lot)
    if not known:
        return first
    mine = shapes_after(plan.shapes(), first.move)
    found = tuple(_as_found(number, shape) for number, shape in enumerate(mine.tolist(), 1))
    seen = MultiPoint(mine[:, :2]).convex_hull.buffer(ABOUT_M)
    outcome = register(*_parts(KnownGround(known, ground), MappedGround(found, seen)))
    if isinstance(outcome, Doubtful):
        return replace(first, on=on, doubt="" if _are_same(known, found) else outcome.why)
    shift = move_of(outcome)
    if len(known) > MOST_REGISTERED or len(found) > MOST_REGISTERED:
        shift = _refined(known, found, shift)
    return replace(first, move=shift.after(first.move), on=on, shift=shift)


def _are_same(known: Sequence[LayoutStall], found: Sequence[Detection]) -> bool:
    """Return whether both are the same stalls where they are: a plan that comes again leaves no doubt."""
    if len(known) != len(found) or len(same := same_stalls(known, found)) != len(found):
        return False
    there = {stall.id: (stall.north, stall.east) for stall in known}
    return all(math.dist((stall.north, stall.east), there[same[stall.id]]) <= _SAME_M for stall in found)


def _as_found(number: int, shape: Sequence[float]) -> Detection:
    north, east, angle, width, length = shape
    return Detection(number, north, east, angle, width, length, 0.5, StallState.UNKNOWN, 1.0, 1, 0.0)


def _known(connection: Connection, lot: str) -> tuple[tuple[LayoutStall, ...], BaseGeometry, str]:
    """Return the stalls and ground that place a plan, in the lot's frame, and the name of what they are."""
    present = tuple(all_stalls(connection, lot))
    if present:
        return present, known_ground(connection, lot), "stalls"
    is_seen = SURVEY.c.seen_ground.is_not(None)
    asked = select(SURVEY).where(SURVEY.c.lot == lot, is_seen).order_by(*newest_first()).limit(1)
    row = connection.execute(asked).mappings().first()
    if row is None:
        return (), MultiPoint(), ""
    looked = Findings.stored(row)
    move = frame_of(datum_of(connection, lot), looked.datum)
    if row["north"] is not None:
        move = Move.stored(row)
    stalls = [stall for stall in move.stalls(looked.stalls) if stall.is_witness]
    shown = (LayoutStall(str(s.id), "", s.north, s.east, s.angle, s.width, s.length, "", False, False) for s in stalls)
    return tuple(shown), looked.ground(move), "survey"


def _parts(known: KnownGround, found: MappedGround) -> tuple[KnownGround, MappedGround]:
    """Return both without the stalls that are far from the middle of those that both have, where they are many."""
    if max(len(known.stalls), len(found.stalls)) <= MOST_REGISTERED:
        return known, found
    here, there = (np.array([(s.north, s.east) for s in each]) for each in (known.stalls, found.stalls))
    both = shapely.intersection(known.seen, found.seen)
    is_shared = shapely.contains_xy(both, here)
    middle = np.median(here[is_shared] if is_shared.any() else here, axis=0)
    reach = min(_reach(here, middle), _reach(there, middle))
    box = shapely.box(*(middle - reach).tolist(), *(middle + reach).tolist())
    near, beside = (np.abs(places - middle).max(axis=1) <= reach for places in (here, there))
    return (
        KnownGround(tuple(s for s, k in zip(known.stalls, near, strict=True) if k), known.seen.intersection(box)),
        MappedGround(tuple(s for s, k in zip(found.stalls, beside, strict=True) if k), found.seen.intersection(box)),
    )


def _reach(places: Floats, middle: Floats) -> float:
    """Return half the side of the square about a place that has `MOST_REGISTERED` of some places (N, 2)."""
    away = np.sort(np.abs(places - middle).max(axis=1))
    return float(away[min(MOST_REGISTERED, len(away)) - 1]) if len(away) > MOST_REGISTERED else math.inf


def _refined(known: Sequence[LayoutStall], found: Sequence[Detection], move: Move) -> Move:
    """Return the rigid move that brings all stalls nearest to those that they are: least squares of their middles."""
    there = {stall.id: (stall.north, stall.east) for stall in known}
    here = {stall.id: (stall.north, stall.east) for stall in found}
    for _ in range(_REFINED):
        same = same_stalls(known, move.stalls(found))
        if len(same) < 2:
            return move
        before = np.array([here[number] for number in same])
        after = np.array([there[known_id] for known_id in same.values()])
        move = Move.nearest(before, after)
    return move

"""Place of a survey among the stalls of its lot: certain, or in doubt with places for a person to choose from.

What decides is given (`hawk.lots.values.Register`); here the survey is brought into the lot's frame, and the result
back to the survey's own.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, Final, Self

import numpy as np
from shapely import MultiPoint, union_all
from shapely.geometry.base import BaseGeometry
from sqlalchemy import Connection, RowMapping, select

from hawk.lots.plan.queries import all_stalls
from hawk.lots.plan.values import shapes_of
from hawk.lots.registration.frames import Floats, Move, frame_of, frames_of, is_in_place, same_stalls, turned
from hawk.lots.registration.georeference import ground_about, on_earth
from hawk.lots.storage.outlines import outline_of, unpack_outline
from hawk.lots.storage.rows import is_among
from hawk.lots.storage.schema import LOT, STALL, SURVEY
from hawk.lots.storage.tables import unpack_stalls
from hawk.lots.values import (
    PLACED,
    Detection,
    Doubtful,
    FinishedSurvey,
    KnownGround,
    LotInputError,
    MappedGround,
    PossiblePlace,
    Register,
    Registration,
)
from hawk.model.plans import Outline
from hawk.model.sentences import say

ABOUT_M: Final = 8.0
"""Ground about the stalls of a plan that no survey made, on which that plan has every stall: an aisle."""
USUAL_M: Final = 1.5
"""Accuracy of a receiver that says none, metres: that of GNSS without corrections, in the open."""
MAP_M: Final = 0.3
"""Error of a survey's map beside its receiver's, metres: no survey, however good its receiver, outweighs all others."""
_Row = Mapping[str, Any] | RowMapping


@dataclass(frozen=True, slots=True)
class Findings:
    """Stalls and ground that a survey found, in its own frame about its ``datum`` (latitude, longitude)."""

    datum: tuple[float, float]
    stalls: tuple[Detection, ...] = field(repr=False)
    seen_ground: Outline = field(repr=False)

    @classmethod
    def of(cls, survey: FinishedSurvey) -> Self:
        """Return that of a survey that has ended."""
        return cls((survey.datum.latitude, survey.datum.longitude), survey.stalls, survey.seen_ground)

    @classmethod
    def stored(cls, row: _Row) -> Self:
        """Return that of a row of the table of surveys. Raises LotStoreError."""
        return cls(
            (row["latitude"], row["longitude"]), unpack_stalls(row["stalls"]), unpack_outline(row["seen_ground"])
        )

    def ground(self, move: Move) -> BaseGeometry:
        """Return the ground that was seen, after a move of the survey's frame."""
        return move.ground(ground_about(self.datum, self.seen_ground))


@dataclass(frozen=True, slots=True)
class Doubt:
    """A doubt as the store keeps it. ``chosen``: the number of the place that a person chose, from 0."""

    why: str
    places: tuple[PossiblePlace, ...]
    chosen: int | None = None

    @classmethod
    def read(cls, text: str | None) -> Self | None:
        """Return the doubt of a column; None for an empty one."""
        if text is None:
            return None
        found = json.loads(text)
        return cls(found["why"], tuple(PossiblePlace(**place) for place in found["places"]), found["chosen"])

    def json(self) -> str:
        """Return the value of the column."""
        return json.dumps(asdict(self), allow_nan=False)

    def choice(self, number: object) -> int:
        """Return the number of a place from a JSON value. Raises LotInputError."""
        if not self.places:
            raise LotInputError("place", f"cannot be chosen, there is none: {self.why}. Fly the lot again")
        if type(number) is not int or not 0 <= number < len(self.places):
            raise LotInputError("place", f"must be the number of one of the places: 0 to {len(self.places) - 1}")
        return number

    @property
    def move(self) -> Move | None:
        """The place that a person chose."""
        return None if self.chosen is None else move_of(self.places[self.chosen])


def move_of(place: PossiblePlace | Registration) -> Move:
    """Return the move of a place."""
    return Move(place.north, place.east, place.turn)


def registered(
    connection: Connection, lot: str, looked: Findings, register: Register, but: str | None = None
) -> Registration | Doubtful:
    """Return where a survey lies among the stalls of a lot. Moves bring the survey's frame onto the lot's.

    ``but``: as of `other_ground`.
    """
    if not looked.seen_ground.polygons:
        return Doubtful(say("the ground that the survey saw is not known"))
    known = KnownGround(tuple(all_stalls(connection, lot)), known_ground(connection, lot, but))
    if known.seen.is_empty:
        return Doubtful(say("the ground of the lot's first survey is not known"))
    frame = frame_of(datum_of(connection, lot), looked.datum)
    witnesses = [stall for stall in looked.stalls if stall.is_witness]
    outcome = register(known, MappedGround(frame.stalls(witnesses), looked.ground(frame)))
    if isinstance(outcome, Registration):
        given = {stall.id: stall.known for stall in looked.stalls if stall.known}
        if any(given.get(number, stall) != stall for number, stall in outcome.same.items()):
            return Doubtful(say("the flight saw the plan in another place"))
        left = {stall.id for stall in known.stalls} - {*outcome.same.values()}
        same = {number: stall for number, stall in given.items() if stall in left}
        move = move_of(outcome).after(frame)
        return Registration(move.north, move.east, move.turn, {**same, **outcome.same})
    places = []
    for place in outcome.places:
        move = move_of(place).after(frame)
        places.append(PossiblePlace(move.north, move.east, move.turn, place.score))
    return Doubtful(outcome.why, tuple(places))


def placed_by(connection: Connection, lot: str, looked: Findings, move: Move) -> Registration:
    """Return the registration of a survey by a known move: its stalls are the nearest of the lot in their place."""
    present = {stall.id: stall for stall in all_stalls(connection, lot)}
    placed = {stall.id: stall for stall in move.stalls(looked.stalls)}
    same = same_stalls(tuple(present.values()), tuple(placed.values()))
    known, found = shapes_of([present[each] for each in same.values()]), shapes_of([placed[each] for each in same])
    fitting = zip(same.items(), is_in_place(known, found).tolist(), strict=True)
    return Registration(move.north, move.east, move.turn, dict(pair for pair, fits in fitting if fits))


def datum_of(connection: Connection, lot: str) -> tuple[float, float]:
    """Return the origin of a lot's frame: latitude, longitude; the one that a person pinned, else `mean_datum`."""
    row = connection.execute(select(LOT).where(LOT.c.id == lot)).mappings().one()
    return _kept(row) if row["datum_is_pinned"] else mean_datum(connection, lot)


def mean_datum(connection: Connection, lot: str) -> tuple[float, float]:
    """Return the origin of a lot's frame by its surveys: latitude, longitude.

    Each survey that is placed puts the origin where its own GNSS has it. The mean is weighted by the inverse of the
    variance: the receiver's own accuracy at the landing, and that of the map. A survey that says none counts as one of
    `USUAL_M`.
    """
    kept = _kept(connection.execute(select(LOT).where(LOT.c.id == lot)).mappings().one())
    origins, weights = _origins(connection, lot, kept)
    if not len(weights):
        return kept
    mean = np.average(origins, axis=0, weights=weights)[None]
    ((latitude, longitude),) = on_earth(kept, mean).tolist()
    return latitude, longitude


def datum_accuracy(connection: Connection, lot: str) -> float | None:
    """Return the standard deviation of `mean_datum`, metres; None where no survey is placed.

    That of a weighted mean of independent errors, the root of the inverse sum of the weights: the receivers of two
    surveys err independently when they fly hours apart.
    """
    kept = _kept(connection.execute(select(LOT).where(LOT.c.id == lot)).mappings().one())
    _, weights = _origins(connection, lot, kept)
    return math.sqrt(1 / float(weights.sum())) if len(weights) else None


def _origins(connection: Connection, lot: str, kept: tuple[float, float]) -> tuple[Floats, Floats]:
    """Return where each of S placed surveys has a lot's origin, (S, 2) metres about ``kept``, and the inverses of their
    variances, (S,). A thousand surveys are one calculation: every answer about a lot needs its datum.
    """
    is_placed = SURVEY.c.placed.in_(PLACED) & SURVEY.c.north.is_not(None)
    asked = select(*(SURVEY.c[name] for name in ("latitude", "longitude", "north", "east", "turn", "accuracy")))
    surveys = connection.execute(asked.where(SURVEY.c.lot == lot, is_placed)).all()
    if not surveys:
        return np.zeros((0, 2)), np.zeros(0)
    found = np.array([[np.nan if value is None else value for value in row] for row in surveys], np.float64)
    shifts, turns = frames_of(kept, found[:, :2])
    backwards = turned(-found[:, 2:4], -found[:, 4])
    accuracy = np.where(np.isnan(found[:, 5]), USUAL_M, found[:, 5])
    return turned(backwards, turns) + shifts, 1 / (accuracy**2 + MAP_M**2)


def _kept(row: _Row) -> tuple[float, float]:
    return float(row["latitude"]), float(row["longitude"])


def known_ground(connection: Connection, lot: str, but: str | None = None) -> BaseGeometry:
    """Return the ground on which a lot's layout would have every stall, in its frame. ``but``: as of `other_ground`.

    It is what those surveys saw whose stalls make the layout, without the ground of other lots: a stall that a later
    survey finds elsewhere is no contradiction. Of a plan that no survey made it is the ground about its stalls.
    """
    was_in_plan = STALL.c.ends.is_(None) | (STALL.c.ends > STALL.c.begins)
    made_by = select(STALL.c.first_survey).where(STALL.c.lot == lot, was_in_plan).distinct()
    makers = connection.execute(made_by).scalars().all()
    surveys = [seq for seq in makers if seq is not None]
    is_placed = is_among(SURVEY.c.seq, surveys) & SURVEY.c.north.is_not(None) & SURVEY.c.seen_ground.is_not(None)
    rows = connection.execute(select(SURVEY).where(is_placed)).mappings().all()
    seen = union_all([Findings.stored(row).ground(Move.stored(row)) for row in rows])
    if makers and not surveys:
        places = [(stall.north, stall.east) for stall in all_stalls(connection, lot)]
        seen = MultiPoint(places).convex_hull.buffer(ABOUT_M)
    return seen.difference(other_ground(connection, lot, but))


def other_ground(connection: Connection, lot: str, but: str | None = None) -> BaseGeometry:
    """Return the ground of all other lots, in the frame of a lot, without that of the lot ``but``."""
    others = select(LOT.c.outline).where(LOT.c.merged_into.is_(None), LOT.c.id.not_in([lot, but or lot]))
    datum = datum_of(connection, lot)
    return union_all([ground_about(datum, outline_of(text)) for text in connection.execute(others).scalars()])

"""A survey of the store as an export: the layout's stalls with that survey's looks, in WGS-84."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from typing import Final, NamedTuple

import numpy as np
from sqlalchemy import Connection, RowMapping, and_, exists, or_, select

from hawk.exports.values import UNSEEN, ExportRecord, LatLon, Observation, SeenSection
from hawk.lots.names import chosen_survey
from hawk.lots.plan.queries import hidden_stalls, in_plan, stalls_in, stalls_of_keys
from hawk.lots.plan.values import LayoutStall, shapes_of
from hawk.lots.registration.frames import Move
from hawk.lots.registration.georeference import corners_on_earth, on_earth, ring_on_earth
from hawk.lots.registration.survey_place import datum_accuracy, datum_of
from hawk.lots.sections.lists import seen_by
from hawk.lots.storage.database import version_of
from hawk.lots.storage.digests import check_whole
from hawk.lots.storage.outlines import outline_of
from hawk.lots.storage.schema import LOT, OBSERVATION, SECTION_LOOK, STALL, SURVEY
from hawk.lots.storage.tables import unpack_stalls
from hawk.lots.survey.order import is_sure, oldest_first
from hawk.lots.survey.private_ground import hidden_in
from hawk.lots.survey.source import PictureSource
from hawk.lots.survey.vehicle_places import may_be_seen
from hawk.lots.time_zone import time_zone_of
from hawk.lots.values import PLACED, Detection, NotFoundError
from hawk.model.lot_map import StallState
from hawk.model.plans import Outline
from hawk.results.label_parts import in_order

NEWEST: Final = "newest"


def survey_of(connection: Connection, lot: str, given: str = NEWEST) -> str:
    """Return the id of a lot's survey by its id, or by the beginning of it; `NEWEST`: the last one of `surveys_of`.

    Raises NotFoundError.
    """
    if given == NEWEST:
        return surveys_of(connection, lot)[-1]
    asked = select(SURVEY.c.id, SURVEY.c.ended).where(SURVEY.c.lot == lot).order_by(*oldest_first())
    rows = connection.execute(asked).all()
    return chosen_survey([(str(row.id), float(row.ended)) for row in rows], given, "of this lot")


def surveys_of(connection: Connection, lot: str) -> list[str]:
    """Return the ids of a lot's registered surveys, in their order; without stalls, those with looks at sections.

    Raises NotFoundError where there is none.
    """
    of_sections = and_(
        ~exists().where(in_plan(STALL.c, lot)), exists().where(SECTION_LOOK.c.survey == SURVEY.c.seq)
    )  # fmt: skip
    counts = or_(SURVEY.c.placed.in_(PLACED), of_sections)
    asked = select(SURVEY.c.id).where(SURVEY.c.lot == lot, counts).order_by(*oldest_first())
    found = [str(each) for each in connection.execute(asked).scalars()]
    if not found:
        raise NotFoundError("--survey: none of the lot's surveys is registered; give the id of one")
    return found


def read_survey(connection: Connection, survey: str, *, has_labels_of_now: bool = False) -> ExportRecord:
    """Return a survey by its id.

    A registered one has the stalls of its layout, each with the look of that survey; another one has those that it
    found, where it found them. ``has_labels_of_now``: labels are those of the present plan, not those of the survey's
    time; a stall that has gone keeps its last one. Raises NotFoundError.
    """
    return _read(connection, _Layouts(connection, () if has_labels_of_now else _THEN), survey)


def read_surveys(connection: Connection, surveys: Sequence[str]) -> list[ExportRecord]:
    """Return surveys as `read_survey` returns one; surveys of a layout share its stalls. Raises NotFoundError."""
    layouts = _Layouts(connection, _THEN)
    return [_read(connection, layouts, survey) for survey in surveys]


def survey_frame(connection: Connection, survey: str) -> tuple[LatLon, Move]:
    """Return the origin of the frame that a survey is exported in, and the move of its own frame onto that one.

    Raises NotFoundError.
    """
    row = _row(connection, survey)
    if row["placed"] not in PLACED:
        return (float(row["latitude"]), float(row["longitude"])), Move()
    move = Move() if row["north"] is None else Move.stored(row)
    return datum_of(connection, str(row["lot"])), move


def _row(connection: Connection, survey: str) -> RowMapping:
    """Return the row of a survey that has a lot. Raises NotFoundError."""
    asked = select(SURVEY, is_sure().label("is_sure")).where(SURVEY.c.id == survey)
    row = connection.execute(asked).mappings().one_or_none()
    if row is None or row["lot"] is None:
        raise NotFoundError(f"survey: there is no survey {survey} of a lot")
    check_whole(connection, "survey", row["seq"], "survey", version_of(connection))
    return row


def _read(connection: Connection, layouts: _Layouts, survey: str) -> ExportRecord:
    row = _row(connection, survey)
    lot = layouts.lot(str(row["lot"]))
    is_placed = row["placed"] in PLACED
    datum = lot.datum if is_placed else (float(row["latitude"]), float(row["longitude"]))
    return ExportRecord(
        lot=lot.name,
        lot_id=str(row["lot"]),
        survey=str(row["id"]),
        began=float(row["began"]),
        ended=float(row["ended"]),
        time_is_sure=bool(row["is_sure"]),
        layout=row["layout"] if is_placed else None,
        software=f"hawk-drone {row['program']}",
        is_simulated=bool(row["simulated"]),
        accuracy=lot.accuracy if is_placed else None if row["accuracy"] is None else float(row["accuracy"]),
        is_pinned=is_placed and lot.is_pinned,
        origin=datum,
        time_zone=lot.time_zone,
        outline=lot.outline,
        stalls=_registered(connection, layouts, row) if is_placed else _found(connection, row, datum),
        doubt="" if is_placed else f"{row['placed']}: its place among the lot's stalls is not certain",
        blurred=row["blurred"],
        pictures=PictureSource.read(row),
        sections=tuple(
            SeenSection(section, look, ring_on_earth(lot.datum, np.array(section.outline)))
            for section, look in seen_by(connection, int(row["seq"]))
        ),
    )


@dataclass(frozen=True, slots=True)
class _Lot:
    name: str
    outline: Outline
    datum: LatLon
    is_pinned: bool
    accuracy: float | None
    time_zone: str


_THEN: Final = ("label", "is_named")
"""Columns that a survey's layout says; place and kind are as they are known now."""


@dataclass(slots=True)
class _Layouts:
    """Lots, and the stalls of their layouts on Earth, each read once."""

    connection: Connection
    then: Sequence[str]
    lots: dict[str, _Lot] = field(default_factory=dict)
    stalls: dict[tuple[str, int], list[_Placed]] = field(default_factory=dict)
    hidden: dict[str, frozenset[int]] = field(default_factory=dict)

    def hidden_in(self, lot: str) -> frozenset[int]:
        """Return the keys of a lot's stalls on private ground."""
        if lot not in self.hidden:
            self.hidden[lot] = hidden_stalls(self.connection, [lot])
        return self.hidden[lot]

    def lot(self, lot: str) -> _Lot:
        """Return a lot by its id."""
        if lot not in self.lots:
            row = self.connection.execute(select(LOT).where(LOT.c.id == lot)).mappings().one()
            is_pinned = bool(row["datum_is_pinned"])
            accuracy = None if is_pinned else datum_accuracy(self.connection, lot)
            datum = datum_of(self.connection, lot)
            zone = time_zone_of(self.connection, row)
            self.lots[lot] = _Lot(str(row["name"]), outline_of(row["outline"]), datum, is_pinned, accuracy, zone)
        return self.lots[lot]

    def placed(self, lot: str, version: int) -> list[_Placed]:
        """Return the stalls of a version of a lot's layout in the order of their labels."""
        key = lot, version
        if key not in self.stalls:
            hidden = self.hidden_in(lot)
            there = stalls_in(self.connection, lot, version, self.then)
            stalls = in_order([each for each in there if each.key not in hidden])
            self.stalls[key] = _on_earth(self.lot(lot).datum, stalls)
        return self.stalls[key]

    def brought_back(self, lot: str, placed: Sequence[_Placed], away: Collection[int]) -> list[_Placed]:
        """Return the stalls of a layout with those of some keys: they were split off and merged again since."""
        ours = {each.stall.key: each for each in placed}
        others = stalls_of_keys(self.connection, lot, away)
        ours |= {each.stall.key: each for each in _on_earth(self.lot(lot).datum, others)}
        return [ours[stall.key] for stall in in_order([each.stall for each in ours.values()])]


_LOOK: Final = tuple(
    OBSERVATION.c[name] for name in ("stall", "state", "taken_probability", "looked_at", "picture_count")
)


def _registered(connection: Connection, layouts: _Layouts, survey: RowMapping) -> tuple[Observation, ...]:
    rows = connection.execute(select(*_LOOK).where(OBSERVATION.c.survey == survey["seq"]))
    looks = {key: _Look(*look) for key, *look in rows}
    placed = layouts.placed(str(survey["lot"]), int(survey["layout"]))
    if away := looks.keys() - {each.stall.key for each in placed} - layouts.hidden_in(str(survey["lot"])):
        placed = layouts.brought_back(str(survey["lot"]), placed, away)
    return tuple(_exported(each, looks.get(each.stall.key)) for each in placed)


def _found(connection: Connection, survey: RowMapping, datum: LatLon) -> tuple[Observation, ...]:
    """Return the stalls as the survey found them, in its own frame, with its own numbers; none on private ground."""
    stalls = [stall for stall in unpack_stalls(survey["stalls"]) if not stall.is_extra]
    shapes = np.array([stall.shape for stall in stalls], np.float64).reshape(-1, 5)
    shown = may_be_seen(shapes, hidden_in(connection, str(survey["id"])))
    return found_stalls([stall for stall, is_shown in zip(stalls, shown, strict=True) if is_shown], datum)


def found_stalls(found: Sequence[Detection], datum: LatLon) -> tuple[Observation, ...]:
    """Return the stalls that a survey found, about its own datum (latitude, longitude), with its own numbers."""
    placed = _on_earth(datum, [_alone(stall) for stall in found])
    looks = (
        _Look(stall.state.value, stall.taken_probability, stall.looked_at, stall.picture_count, stall.score)
        for stall in found
    )
    return tuple(_exported(each, look) for each, look in zip(placed, looks, strict=True))


def _alone(stall: Detection) -> LayoutStall:
    return LayoutStall(str(stall.id), "", *stall.shape, "", is_confirmed=False, is_named=False)


class _Look(NamedTuple):
    state: str
    taken_probability: float
    looked_at: float
    picture_count: int
    score: float | None = None


class _Placed(NamedTuple):
    """A stall with its middle and corners on Earth, and the direction of its long side, degrees."""

    stall: LayoutStall
    place: LatLon
    corners: tuple[LatLon, ...]
    direction: float


def _exported(placed: _Placed, look: _Look | None) -> Observation:
    stall = placed.stall
    state = UNSEEN if look is None or look.state not in _SEEN else look.state
    return Observation(
        id=stall.id,
        label=stall.label,
        kind=stall.kind,
        state=state,
        taken_probability=None if look is None else look.taken_probability,
        looked_at=None if look is None else look.looked_at,
        picture_count=0 if look is None else look.picture_count,
        place=placed.place,
        corners=placed.corners,
        width=stall.width,
        length=stall.length,
        direction=placed.direction,
        is_confirmed=stall.is_confirmed,
        score=None if look is None else look.score,
        is_named=stall.is_named,
    )


_SEEN: Final = (StallState.FREE.value, StallState.TAKEN.value)


def _on_earth(datum: LatLon, stalls: Sequence[LayoutStall]) -> list[_Placed]:
    """Return stalls with their middles and corners, counter-clockwise as seen from above."""
    if not stalls:
        return []
    shapes = shapes_of(stalls)
    middles = on_earth(datum, shapes[:, :2]).tolist()
    around = np.roll(corners_on_earth(datum, shapes), 2, axis=1).tolist()
    return [
        _Placed(stall, (m[0], m[1]), tuple((a, b) for a, b in corners), math.degrees(stall.angle) % 180.0)
        for stall, m, corners in zip(stalls, middles, around, strict=True)
    ]

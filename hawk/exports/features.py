"""Lots, stalls, sections and surveys of a store as GeoJSON features (RFC 7946), for map programs: chosen by place and
time.

Stalls are those of the present plans, each with its last look. Places are WGS-84, longitude first.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
import shapely
from numpy.typing import NDArray
from sqlalchemy import ColumnElement, Connection, Row, Select, func, select

from hawk.exports.shapes import lot_shape
from hawk.lots.answers import Feature, Geometry, ListedSection
from hawk.lots.plan.queries import in_plan
from hawk.lots.reach import is_within
from hawk.lots.registration.georeference import corners_on_earth
from hawk.lots.registration.survey_place import datum_of
from hawk.lots.sections import lists as section_lists
from hawk.lots.storage.outlines import Rings, outline_of_rings, rings_of
from hawk.lots.storage.schema import LOT, OBSERVATION, STALL, SURVEY
from hawk.lots.survey.counts import counts_of
from hawk.lots.survey.order import has_been, is_last_look, is_sure, last_of
from hawk.lots.survey.source import SOURCE_COLUMNS, source_json
from hawk.lots.values import Placed, utc

_DEGREES: Final = 8
"""Decimals: a millimetre."""
_AROUND: Final = 0.0005
"""Degrees about a lot's outline within which its stalls lie."""
_IS_THERE: Final = SURVEY.c.placed != Placed.DELETED.value
Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Box:
    """A part of the Earth, degrees; ``west`` is greater than ``east`` where it crosses the date line."""

    west: float
    south: float
    east: float
    north: float

    def meets(self, boxes: Floats) -> NDArray[np.bool_]:
        """Return which of boxes (N, 4) of (west, south, east, north) share a place with this one, (N,)."""
        west, south, east, north = boxes.T
        if self.west <= self.east:
            across = (west <= self.east) & (east >= self.west)
        else:
            across = (east >= self.west) | (west <= self.east)
        return np.asarray(across & (south <= self.north) & (north >= self.south), np.bool_)


@dataclass(frozen=True, slots=True)
class Choice:
    """Features that are asked for: ``limit`` of them behind the first ``offset``, within a ``box`` and a period.

    ``begin``, ``end``: UTC, Unix seconds, both within; None: without that end. ``ids``: those alone. ``lots``: ids of
    lots; what is of these alone.
    """

    limit: int = 100
    offset: int = 0
    box: Box | None = None
    begin: float | None = None
    end: float | None = None
    ids: Sequence[str] | None = None
    lots: Collection[str] | None = None

    def during(self, first: ColumnElement[float], last: ColumnElement[float]) -> list[ColumnElement[bool]]:
        """Return the conditions that a time from ``first`` to ``last`` meets the period."""
        ends = [] if self.begin is None else [last >= self.begin]
        return ends if self.end is None else [*ends, first <= self.end]


@dataclass(frozen=True, slots=True)
class Found:
    """Features that were found; ``matched``: how many there are in all."""

    features: list[Feature] = field(repr=False)
    matched: int


@dataclass(frozen=True, slots=True)
class Extent:
    """Ground and time of all features: ``box`` None without any, ``begin`` and ``end`` None without a time."""

    box: Box | None
    begin: float | None
    end: float | None


def extent(connection: Connection, lots: Collection[str] | None = None) -> Extent:
    """Return the ground of lots and of the surveys without one, and the time from the first survey to the last.

    ``lots``: what is of these alone, by their ids; None: all.
    """
    is_ours = is_within(SURVEY.c.lot, lots)
    is_alone = SURVEY.c.lot.is_(None) & _IS_THERE & is_ours
    there = select(LOT.c.outline).where(LOT.c.merged_into.is_(None), is_within(LOT.c.id, lots))
    texts = [*connection.execute(there).scalars()]
    texts += connection.execute(select(SURVEY.c.outline).where(is_alone)).scalars()
    boxes = np.array([box for text in texts if (box := _box_of(rings_of(text))) is not None]).reshape(-1, 4)
    begin, end = (
        connection.execute(select(at).where(_IS_THERE, has_been(), is_ours).order_by(order).limit(1)).scalar()
        for at, order in ((SURVEY.c.began, SURVEY.c.began), (SURVEY.c.ended, SURVEY.c.ended.desc()))
    )  # each by its index: a million rows are not read
    if not len(boxes):
        return Extent(None, begin, end)
    west, south = boxes[:, :2].min(axis=0).tolist()
    east, north = boxes[:, 2:].max(axis=0).tolist()
    return Extent(Box(west, south, east, north), begin, end)


def _box_of(outline: Rings) -> tuple[float, float, float, float] | None:
    """Return west, south, east and north of an outline; None for one without corners."""
    corners = [corner for ring in outline["polygons"] for corner in ring]
    if not corners:
        return None
    latitudes, longitudes = zip(*corners, strict=True)
    return min(longitudes), min(latitudes), max(longitudes), max(latitudes)


def lots(connection: Connection, choice: Choice) -> Found:
    """Return lots, the oldest first, with the counts of the last survey. A lot's time is that of this survey."""
    last = ("seq", "lot", "layout", "ended", "placed", "free", "taken", "unknown")
    present = select(func.count()).select_from(STALL).where(in_plan(STALL.c, LOT.c.id)).correlate(LOT).scalar_subquery()
    rows = select(LOT.c.id, LOT.c.name, LOT.c.outline, present.label("stalls"), *(SURVEY.c[name] for name in last))
    rows = rows.select_from(LOT.outerjoin(SURVEY, SURVEY.c.seq == last_of(LOT.c.id))).where(LOT.c.merged_into.is_(None))
    rows = rows.where(*choice.during(SURVEY.c.ended, SURVEY.c.ended), *_among(LOT.c.id, choice))
    rows = rows.where(is_within(LOT.c.id, choice.lots))
    return _outlined(connection, rows.order_by(LOT.c.made, LOT.c.id), choice, _lot)


def _lot(row: Row[Any], counts: Mapping[str, Any]) -> dict[str, Any]:
    return {
        "name": row.name, "stalls": row.stalls, **counts,
        "surveyed": None if row.ended is None else utc(row.ended), "placed": row.placed,
    }  # fmt: skip


def surveys(connection: Connection, choice: Choice) -> Found:
    """Return surveys in the order of their landings, each with the ground that it mapped."""
    shown = ("id", "lot", "outline", "began", "ended", "placed", "free", "taken", "unknown", "layout")
    source = ("seq", "simulated", "program", "blurred", *SOURCE_COLUMNS)
    columns = (SURVEY.c[name] for name in (*shown, *source))
    rows = select(*columns, is_sure().label("time_is_sure"), LOT.c.name)
    rows = rows.select_from(SURVEY.outerjoin(LOT, LOT.c.id == SURVEY.c.lot))
    rows = rows.where(_IS_THERE, *choice.during(SURVEY.c.began, SURVEY.c.ended), *_among(SURVEY.c.id, choice))
    rows = rows.where(is_within(SURVEY.c.lot, choice.lots))
    return _outlined(connection, rows.order_by(SURVEY.c.seq), choice, _survey)


def _survey(row: Row[Any], counts: Mapping[str, Any]) -> dict[str, Any]:
    return {
        "lot": row.lot, "lot_name": row.name, "began": utc(row.began), "ended": utc(row.ended), "placed": row.placed,
        **counts, "layout": row.layout,
        "time_is_sure": row.time_is_sure, "simulated": row.simulated, "program": row.program,
        "blurred": row.blurred,
        **source_json(row._mapping),
    }  # fmt: skip


def _outlined(
    connection: Connection, rows: Select[Any], choice: Choice,
    shown: Callable[[Row[Any], Mapping[str, Any]], dict[str, Any]],
) -> Found:  # fmt: skip
    """Return the features of rows with an outline, with the counts of their surveys, as ``shown`` makes them.

    The database counts and cuts the rows where no place is asked for.
    """
    if choice.box is None:
        matched = connection.execute(select(func.count()).select_from(rows.order_by(None).subquery())).scalar_one()
        part = connection.execute(rows.limit(choice.limit).offset(choice.offset)).all()
        outlines = [rings_of(row.outline) for row in part]
    else:
        found = connection.execute(rows).all()
        drawn = [rings_of(row.outline) for row in found]
        boxes = np.array([_box_of(outline) or (np.nan,) * 4 for outline in drawn], np.float64).reshape(-1, 4)
        within = np.flatnonzero(choice.box.meets(boxes)).tolist()
        chosen = within[choice.offset : choice.offset + choice.limit]
        matched, part, outlines = len(within), [found[k] for k in chosen], [drawn[k] for k in chosen]
    grounds = _grounds(outlines)
    counted = counts_of(connection, [row._mapping for row in part])
    return Found(
        [
            Feature(type="Feature", id=row.id, geometry=ground, properties=shown(row, counts))
            for row, ground, counts in zip(part, grounds, counted, strict=True)
        ],
        matched,
    )


def _grounds(outlines: Sequence[Rings]) -> list[Geometry | None]:
    """Return outlines as MultiPolygons, None without ground: those of one whole ring all at once."""
    rings = [_ring_of(outline) for outline in outlines]
    whole = {number: ring for number, ring in enumerate(rings) if ring is not None}
    found: dict[int, Geometry] = {}
    if whole:
        corners = np.array([corner for ring in whole.values() for corner in ring])
        lengths = [len(ring) for ring in whole.values()]
        drawn = shapely.linearrings(corners, indices=np.repeat(np.arange(len(whole)), lengths))
        facts = zip(shapely.is_valid(shapely.polygons(drawn)).tolist(), shapely.is_ccw(drawn).tolist(), strict=True)
        for (number, ring), (is_valid, is_ccw) in zip(whole.items(), facts, strict=True):
            if is_valid:
                found[number] = Geometry(type="MultiPolygon", coordinates=[[ring if is_ccw else ring[::-1]]])
    return [found.get(number) or _mended(outline) for number, outline in enumerate(outlines)]


def _ring_of(outline: Rings) -> list[list[float]] | None:
    """Return the closed ring of an outline of one polygon without a hole; None for another one."""
    if len(outline["polygons"]) != 1 or outline["holes"] or len(outline["polygons"][0]) < 3:
        return None
    ring = [[longitude, latitude] for latitude, longitude in outline["polygons"][0]]
    return ring if ring[0] == ring[-1] else [*ring, ring[0]]


def _mended(outline: Rings) -> Geometry | None:
    shape = shapely.transform(lot_shape(outline_of_rings(outline)), lambda places: np.round(places, _DEGREES))
    return None if shape.is_empty else Geometry.model_validate_json(shapely.to_geojson(shape))


_STALL: Final = ("key", "id", "lot", "label", "kind", "north", "east", "angle", "width", "length", "is_confirmed")


def stalls(connection: Connection, choice: Choice) -> Found:
    """Return the stalls of all plans, lot by lot, with the last look at each, whose time is the stall's."""
    of_lots = select(LOT.c.id, LOT.c.outline).where(LOT.c.merged_into.is_(None), is_within(LOT.c.id, choice.lots))
    of_lots = of_lots.order_by(LOT.c.made, LOT.c.id)
    matched = 0
    features: list[Feature] = []
    for lot in connection.execute(of_lots).all():
        if choice.box is not None and not choice.box.meets(_around(lot.outline)).any():
            continue
        rest = choice.limit - len(features)
        found = _stalls_of(connection, lot.id, choice, max(choice.offset - matched, 0), rest)
        matched += found.matched
        features += found.features
    return Found(features, matched)


def _around(outline: str) -> Floats:
    box = _box_of(rings_of(outline))
    wide = np.array([-_AROUND / 0.05, -_AROUND, _AROUND / 0.05, _AROUND])  # a meridian is near at 87 degrees
    return np.array([(-180.0, -90.0, 180.0, 90.0)]) if box is None else np.array([box]) + wide


def _stalls_of(connection: Connection, lot: str, choice: Choice, skipped: int, limit: int) -> Found:
    """Return up to ``limit`` stalls of a lot behind the first ``skipped``, and how many of it are asked for."""
    is_in = [STALL.c.lot == lot, STALL.c.ends.is_(None), *_among(STALL.c.id, choice)]
    keys = select(STALL.c.key).where(*is_in).order_by(STALL.c.key)
    if choice.begin is not None or choice.end is not None:
        keys = keys.select_from(STALL.join(OBSERVATION, is_last_look(connection))).where(
            *choice.during(OBSERVATION.c.looked_at, OBSERVATION.c.looked_at)
        )
    if choice.box is None:
        matched = connection.execute(select(func.count()).select_from(keys.order_by(None).subquery())).scalar_one()
        if skipped >= matched or limit <= 0:
            return Found([], matched)
        keys = keys.limit(limit).offset(skipped)
    rows = _with_looks(connection, keys)
    if not rows:
        return Found([], 0)
    rings = _rings(datum_of(connection, lot), rows)
    if choice.box is not None:
        boxes = np.concatenate([rings.min(axis=1), rings.max(axis=1)], axis=1)
        within = np.flatnonzero(choice.box.meets(boxes))
        chosen = within[skipped : skipped + max(limit, 0)]
        return Found([_stall(rows[k], rings[k]) for k in chosen.tolist()], len(within))
    return Found([_stall(row, ring) for row, ring in zip(rows, rings, strict=True)], matched)


def _with_looks(connection: Connection, keys: Select[Any]) -> Sequence[Row[Any]]:
    chosen = keys.subquery()
    joined = STALL.join(chosen, chosen.c.key == STALL.c.key).outerjoin(OBSERVATION, is_last_look(connection))
    columns = (
        *(STALL.c[name] for name in _STALL),
        OBSERVATION.c.state,
        OBSERVATION.c.taken_probability,
        OBSERVATION.c.looked_at,
    )
    return connection.execute(select(*columns).select_from(joined).order_by(STALL.c.key)).all()


def _rings(datum: tuple[float, float], rows: Sequence[Row[Any]]) -> Floats:
    """Return the corners of stalls as (N, 5, 2) of (longitude, latitude), closed, counter-clockwise from above."""
    shapes = np.array([(row.north, row.east, row.angle, row.width, row.length) for row in rows])
    places = np.round(corners_on_earth(datum, shapes)[..., ::-1], _DEGREES)
    return np.concatenate([places, places[:, :1]], axis=1)


def _stall(row: Row[Any], ring: Floats) -> Feature:
    properties = {
        "lot": row.lot, "label": row.label, "kind": row.kind, "state": row.state,
        "taken_probability": row.taken_probability,
        "observed": None if row.looked_at is None else utc(row.looked_at), "width_m": row.width, "length_m": row.length,
        "confirmed": row.is_confirmed,
    }  # fmt: skip
    shape = Geometry(type="Polygon", coordinates=[ring.tolist()])
    return Feature(type="Feature", id=row.id, geometry=shape, properties=properties)


def sections(connection: Connection, choice: Choice) -> Found:
    """Return the sections of all plans, lot by lot, with the newest look at each, whose time is the section's."""
    of_lots = select(LOT.c.id).where(LOT.c.merged_into.is_(None), is_within(LOT.c.id, choice.lots))
    of_lots = of_lots.order_by(LOT.c.made, LOT.c.id)
    found = []
    for lot in connection.execute(of_lots).scalars():
        for section in section_lists.sections_with_looks(connection, lot):
            feature = _section(lot, section)
            if _is_chosen(section, feature, choice):
                found.append(feature)
    return Found(found[choice.offset : choice.offset + choice.limit], len(found))


def _section(lot: str, section: ListedSection) -> Feature:
    look = section.look
    ring = shapely.Polygon([(longitude, latitude) for latitude, longitude in section.ground])
    shape = shapely.geometry.polygon.orient(ring)
    properties = {
        "lot": lot, "name": section.name, "kind": section.kind, "note": section.note, "length_m": section.length_m,
        "capacity": section.capacity, "capacity_given": section.is_capacity_given,
        **{name: None if look is None else getattr(look, name) for name in _OF_LOOK},
        "observed": None if look is None else utc(look.observed.timestamp()),
    }  # fmt: skip
    corners = [[longitude, latitude] for longitude, latitude in shape.exterior.coords]
    return Feature(
        type="Feature", id=section.id, geometry=Geometry(type="Polygon", coordinates=[corners]), properties=properties
    )


_OF_LOOK: Final = ("source", "parked", "least", "most", "occupancy", "room", "hidden_share", "seen_share", "survey")


def _is_chosen(section: ListedSection, feature: Feature, choice: Choice) -> bool:
    if choice.ids is not None and section.id not in choice.ids:
        return False
    if choice.begin is not None or choice.end is not None:
        at = None if section.look is None else section.look.observed.timestamp()
        if at is None or at < (choice.begin or at) or at > (at if choice.end is None else choice.end):
            return False
    if choice.box is None or feature.geometry is None:
        return True
    corners = np.array(feature.geometry.coordinates[0])
    return bool(choice.box.meets(np.concatenate([corners.min(axis=0), corners.max(axis=0)])[None]).any())


def _among(column: ColumnElement[str], choice: Choice) -> list[ColumnElement[bool]]:
    return [] if choice.ids is None else [column.in_(choice.ids)]

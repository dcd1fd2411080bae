"""Merge and split of lots, and the move of a survey: the rows that each changes, from the rows as they are.

Ids and labels last: a stall that comes into another lot keeps its id, and its label unless that lot ever gave it. Where
two lots are the same ground, no stall is taken for another by guess: the layout of the lot that stays is kept, and the
surveys of the other one become unregistered surveys of it.
"""

from __future__ import annotations

import json
import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import shapely

from hawk.lots.changes import Change, Row, changed
from hawk.lots.labels import lasting_labels, parts_of
from hawk.lots.place import SAME_SHARE, about, ground_about, joined, shared_area, without
from hawk.lots.saving import FIRST_FLIGHT, PROGRAM, looks_of, new_id, shape
from hawk.lots.values import LotInputError, Placed, SurveyStall, outline_json, outline_of, unpack_stalls
from hawk.model.plans import Outline
from hawk.results.row_labels import letters


@dataclass(frozen=True, slots=True)
class LotRows:
    """A lot with all that is of it.

    ``datum``: origin of its frame as it is shown, latitude and longitude. ``used``: every label that it ever gave.
    """

    lot: Row
    datum: tuple[float, float]
    layouts: tuple[Row, ...]
    stalls: tuple[Row, ...] = field(repr=False)
    zones: tuple[Row, ...]
    surveys: tuple[Row, ...]
    used: Collection[str] = field(repr=False)

    @property
    def id(self) -> str:
        """UUID of the lot."""
        return str(self.lot.key[0])

    @property
    def version(self) -> int:
        """Newest version of its layout."""
        return max((int(row.key[1]) for row in self.layouts), default=0)

    @property
    def outline(self) -> Outline:
        """Its outline."""
        return outline_of(_column(self.lot, "outline"))

    def present(self) -> list[Row]:
        """Return the stalls of the newest layout."""
        version = self.version
        return [
            row for row in self.stalls
            if _column(row, "begins") <= version and (_column(row, "ends") is None or _column(row, "ends") > version)
        ]  # fmt: skip


def _column(row: Row, name: str) -> Any:
    assert row.values is not None  # noqa: S101 - rows of a lot are there
    return row.values[name]


def merged(kept: LotRows, other: LotRows, who: str, now: float) -> Change:
    """Return the change that makes one lot of two. Raises LotInputError for a lot with itself, or far from the other.

    The layout gets a new version. Stalls of the other lot come into it, unless both are the same ground.
    """
    if kept.id == other.id:
        raise LotInputError("with", "is the lot itself: name another one")
    ground, beside = (ground_about(kept.datum, each.outline) for each in (kept, other))
    if beside.is_empty:
        raise LotInputError("with", "is more than 20 km away: merge lots that are one place")
    share = shared_area(ground, beside) / max(min(ground.area, beside.area), 1.0)
    version = kept.version + 1
    why = f"merged with {_column(other.lot, 'name')}"
    rows = [_layout(kept.id, version, why, who, now)]
    if share >= SAME_SHARE:
        rows += [changed(row, ends=other.version) for row in (*other.present(), *_present_zones(other))]
        rows += [_unregistered(row, kept.id) for row in other.surveys]
    else:
        rows += _brought(kept, other, version)
        rows += _zones_brought(kept, other, version)
        rows += [_carried(row, kept, other) for row in other.surveys]
    outline = outline_json(joined([kept.outline, other.outline]))
    rows += [changed(kept.lot, outline=outline), changed(other.lot, merged_into=kept.id)]
    return Change("merge", kept.id, tuple(rows))


def _brought(kept: LotRows, other: LotRows, version: int) -> list[Row]:
    """Return the other lot's stalls in the frame of the kept one, with labels that it never gave, and these labels."""
    present = other.present()
    if not present:
        return []
    north, east = _offset(kept, other)
    labels = new_labels([str(_column(row, "label")) for row in present], kept.used)
    rows = []
    for row, label in zip(present, labels, strict=True):
        place = {"north": _column(row, "north") + north, "east": _column(row, "east") + east}
        rows.append(changed(row, lot=kept.id, label=label, begins=version, ends=None, **place))
        rows.append(label_row(kept.id, label, _column(row, "id")))
    return rows


def _present_zones(lot: LotRows) -> list[Row]:
    return [row for row in lot.zones if _column(row, "ends") is None]


def _zones_brought(kept: LotRows, other: LotRows, version: int) -> list[Row]:
    """Return the other lot's areas without stalls in the frame of the kept one."""
    north, east = _offset(kept, other)
    rows = []
    for row in _present_zones(other):
        outline = [[a + north, b + east] for a, b in json.loads(_column(row, "outline"))]
        rows.append(changed(row, lot=kept.id, begins=version, ends=None, outline=json.dumps(outline)))
    return rows


def new_labels(labels: Sequence[str], used: Collection[str]) -> list[str]:
    """Return labels that were never given: those that are free, and the next letter for each row that is not."""
    taken = {*used}
    rows = {parts[0] for label in taken if (parts := parts_of(label)) is not None}
    again: dict[str, str] = {}
    given = []
    for label in labels:
        parts = parts_of(label)
        if parts is None:
            number = next(n for n in range(2, len(taken) + 3) if f"{label}-{n}" not in taken) if label in taken else 0
            given.append(f"{label}-{number}" if number else label)
        else:
            letter, number = parts
            if letter in rows and letter not in again:
                own = {found[0] for each in labels if (found := parts_of(each)) is not None}
                again[letter] = next(each for each in letters() if each not in rows | own | {*again.values()})
            given.append(f"{again.get(letter, letter)} {number}")
        taken.add(given[-1])
    return given


def split(lot: LotRows, part: Outline, name: str, made: str, who: str, now: float) -> Change:
    """Return the change that makes a lot of its own of a part of a lot: its stalls go there, with ids and labels.

    Surveys stay with the first lot; what they saw of a stall stays with the stall.

    Args:
        lot: The lot.
        part: Ground of the new lot, WGS-84.
        name: Name of the new lot.
        made: Id of the new lot.
        who: Who asked.
        now: UTC, Unix seconds.

    Raises:
        LotInputError: The part holds no stall of the lot, or all of them.
    """
    ground = ground_about(lot.datum, part)
    present = lot.present()
    places = np.array([(_column(row, "north"), _column(row, "east")) for row in present]).reshape(-1, 2)
    inside = shapely.contains_xy(ground, places)
    if not inside.any():
        raise LotInputError("outline", "holds no stall of the lot: draw it around the stalls of the new lot")
    if inside.all():
        raise LotInputError("outline", "holds every stall of the lot: leave some to the first lot")
    assert lot.lot.values is not None  # noqa: S101 - it is there
    shown = {"id": made, "name": name, "outline": outline_json(part), "merged_into": None, "made": now}
    shown |= {"latitude": lot.datum[0], "longitude": lot.datum[1]}  # no survey goes along that would say it
    moved = [row for row, goes in zip(present, inside.tolist(), strict=True) if goes]
    zones = [row for row in _present_zones(lot) if ground.contains(_middle(row))]
    rows = [
        Row("lot", (made,), {**lot.lot.values, **shown}),
        _layout(made, 1, f"split from {lot.lot.values['name']}", who, now),
        _layout(lot.id, lot.version + 1, f"{name} split off", who, now),
        *(changed(row, lot=made, begins=1, ends=None) for row in (*moved, *zones)),
        *(label_row(made, str(_column(row, "label")), _column(row, "id")) for row in moved),
        changed(lot.lot, outline=outline_json(without(lot.outline, part))),
    ]
    return Change("split", lot.id, tuple(rows))


def _middle(zone: Row) -> shapely.Point:
    return shapely.Polygon(json.loads(_column(zone, "outline"))).representative_point()


def moved(survey: Row, looks: Sequence[Row], lot: str) -> Change:
    """Return the change that moves a survey to another lot, where it is unregistered. Raises LotInputError.

    ``looks``: its observations, which are of stalls of the former lot.
    """
    if _column(survey, "lot") == lot:
        raise LotInputError("lot", "has this survey already: name another one")
    gone = [Row(row.table, row.key, None) for row in looks]
    return Change("move", lot, (_unregistered(survey, lot), *gone))


def deleted(survey: Row, looks: Sequence[Row]) -> Change:
    """Return the change that deletes a survey of a lot with its ``looks``; the stalls that it found stay."""
    gone = [Row(row.table, row.key, None) for row in looks]
    place: Mapping[str, Any] = dict.fromkeys(("lot", "north", "east", "turn", "layout", "doubt"))
    row = changed(survey, placed=Placed.DELETED.value, candidates=json.dumps([]), **place)
    return Change("delete", _column(survey, "lot"), (row, *gone))


def begun(survey: Row, name: str, made: str, first_key: int, now: float) -> Change:
    """Return the change that makes a new lot of a survey that has none, or leaves another one.

    Args:
        survey: The survey; its stalls make the first layout.
        name: Name of the lot.
        made: Id of the lot.
        first_key: Key of the first new stall; the next ones follow.
        now: UTC, Unix seconds.

    Raises:
        LotInputError: The survey has no stall.
    """
    found = unpack_stalls(_column(survey, "stalls"))
    if not found:
        raise LotInputError("lot", "cannot be made of a survey without stalls: name a known lot")
    seq, began = int(survey.key[0]), _column(survey, "began")
    place = {name: _column(survey, name) for name in ("latitude", "longitude", "outline")}
    lot = {"id": made, "name": name, **place, "datum_is_pinned": False, "merged_into": None, "made": now}
    labels = lasting_labels({stall.id: stall.on_map() for stall in found}, {}, ())
    home: dict[str, Any] = {"lot": made, "layout": 1, "placed": Placed.FIRST.value, "candidates": json.dumps([])}
    home |= {"doubt": None}
    rows = [Row("lot", (made,), lot), _layout(made, 1, FIRST_FLIGHT, PROGRAM, began)]
    rows.append(changed(survey, **home, north=0.0, east=0.0, turn=0.0))
    keys = {stall.id: key for key, stall in enumerate(found, first_key)}
    for stall in found:
        key = keys[stall.id]
        ids = {"key": key, "id": new_id(), "lot": made, "label": labels[stall.id], "first_survey": seq}
        state = {"kind": "", "is_confirmed": False, "begins": 1, "ends": None, "first_id": stall.id}
        rows.append(Row("stall", (key,), {**ids, **shape(stall), **state}))
        rows.append(label_row(made, labels[stall.id], str(ids["id"])))
    return Change("move", made, (*rows, *look_rows(seq, keys, found)))


def look_rows(seq: int, keys: Mapping[int, int], stalls: Sequence[SurveyStall]) -> list[Row]:
    """Return the observations of a survey as rows to write. ``keys``: id in the survey -> key of the stall."""
    return [Row("observation", (look["survey"], look["stall"]), look) for look in looks_of(seq, keys, stalls)]


def _offset(kept: LotRows, other: LotRows) -> tuple[float, float]:
    """Return the origin of the other lot in the frame of the kept one, metres north and east."""
    ((north, east, _),) = about(kept.datum, np.array([other.datum]))
    return float(north), float(east)


def _carried(survey: Row, kept: LotRows, other: LotRows) -> Row:
    """Return a survey of the other lot as one of the kept lot: its place among the stalls goes along."""
    if _column(survey, "north") is None:
        return changed(survey, lot=kept.id)
    north, east = _offset(kept, other)
    place = {"north": _column(survey, "north") + north, "east": _column(survey, "east") + east}
    return changed(survey, lot=kept.id, layout=kept.version + 1, placed=Placed.REGISTERED.value, **place)


def _unregistered(survey: Row, lot: str) -> Row:
    place: Mapping[str, Any] = dict.fromkeys(("north", "east", "turn", "layout", "doubt"))
    return changed(survey, lot=lot, placed=Placed.UNREGISTERED.value, candidates=json.dumps([]), **place)


def _layout(lot: str, version: int, why: str, who: str, now: float) -> Row:
    values = {"lot": lot, "version": version, "valid_from": now, "why": why, "who": who}
    return Row("layout", (lot, version), values)


def label_row(lot: str, label: str, stall: str) -> Row:
    """Return the row of a label that a lot gives to a stall."""
    return Row("label", (lot, label), {"lot": lot, "label": label, "stall": stall})


def checked_outline(given: object) -> Outline:
    """Return an outline from JSON values: a list of [latitude, longitude], degrees. Raises LotInputError."""
    if not isinstance(given, list) or not 3 <= len(given) <= 500:
        raise LotInputError("outline", "must be a list of 3 to 500 corners [latitude, longitude]")
    corners = []
    for number, corner in enumerate(given):
        is_pair = isinstance(corner, list) and len(corner) == 2 and all(type(each) in (int, float) for each in corner)
        if not is_pair or not (math.isfinite(corner[0]) and math.isfinite(corner[1])):
            raise LotInputError(f"outline[{number}]", "must be [latitude, longitude], two finite numbers of degrees")
        if abs(corner[0]) > 90 or abs(corner[1]) > 180:
            raise LotInputError(f"outline[{number}]", "must be degrees: latitude -90 to 90, longitude -180 to 180")
        corners.append((float(corner[0]), float(corner[1])))
    return Outline((tuple(corners),))

"""Merge and split of lots, and the move of a survey: the rows that each changes, from the rows as they are.

A stall that comes into another lot keeps its id, and its label unless a stall of that lot has it. Where two
lots are the same ground, no stall is taken for another by guess: the layout of the lot that stays is kept, and the
surveys of the other one become unregistered surveys of it.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
import shapely

from hawk.lots.change_log import Change
from hawk.lots.ingest import FIRST_FLIGHT, PROGRAM, looks_of, shape
from hawk.lots.labels import lasting_labels, parts_of
from hawk.lots.registration.georeference import about, ground_about, joined, shared_area, without
from hawk.lots.registration.lot_match import SAME_SHARE
from hawk.lots.storage.outlines import outline_json, outline_to_change, ring_of
from hawk.lots.storage.rows import Row
from hawk.lots.storage.schema import SECTION
from hawk.lots.storage.tables import unpack_stalls
from hawk.lots.values import Detection, LotInputError, Placed, checked_degrees, free_name, new_id
from hawk.model.plans import Outline
from hawk.results.row_labels import letters

_NONE: Final = json.dumps([])
"""Text of a list of lots to choose from that has none."""


@dataclass(frozen=True, slots=True)
class Estate:
    """A lot with all that is of it.

    ``datum``: origin of its frame as it is shown, latitude and longitude.
    """

    lot: Row
    datum: tuple[float, float]
    layouts: tuple[Row, ...]
    stalls: tuple[Row, ...] = field(repr=False)
    zones: tuple[Row, ...]
    sections: tuple[Row, ...]
    surveys: tuple[Row, ...]

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
        """Its outline. Raises LotStoreError for a damaged one."""
        return outline_to_change(self.lot["outline"])

    def present(self) -> list[Row]:
        """Return the stalls of the newest layout."""
        version = self.version
        return [
            row for row in self.stalls
            if row["begins"] <= version and (row["ends"] is None or row["ends"] > version)
        ]  # fmt: skip


def merged(kept: Estate, other: Estate, who: str, now: float) -> Change:
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
    why = f"merged with {other.lot['name']}"
    rows = [layout_row(kept.id, version, why, who, now)]
    if share >= SAME_SHARE:
        rows += [row.setting(ends=other.version) for row in (*other.present(), *_present_areas(other))]
        rows += [unplaced(row, kept.id, Placed.UNREGISTERED) for row in other.surveys]
    else:
        rows += _brought(kept, other, version)
        rows += _areas_brought(kept, other, version)
        rows += [_carried(row, kept, other) for row in other.surveys]
    outline = outline_json(joined([kept.outline, other.outline]))
    rows += [kept.lot.setting(outline=outline), other.lot.setting(merged_into=kept.id)]
    return Change("merge", kept.id, tuple(rows))


def _brought(kept: Estate, other: Estate, version: int) -> list[Row]:
    """Return the other lot's stalls in the frame of the kept one, with labels that it has not."""
    present = other.present()
    if not present:
        return []
    north, east = _offset(kept, other)
    labels = free_labels([str(row["label"]) for row in present], {str(row["label"]) for row in kept.present()})
    return [
        row.setting(
            lot=kept.id, label=label, begins=version, ends=None, north=row["north"] + north, east=row["east"] + east,
            is_named=bool(row["is_named"]) and label == row["label"],
        )
        for row, label in zip(present, labels, strict=True)
    ]  # fmt: skip


def _present_areas(lot: Estate) -> list[Row]:
    """Return the zones and the sections of a lot's plan."""
    return [row for row in (*lot.zones, *lot.sections) if row["ends"] is None]


def _areas_brought(kept: Estate, other: Estate, version: int) -> list[Row]:
    """Return the other lot's zones and sections in the frame of the kept one, sections with names that it has not."""
    north, east = _offset(kept, other)
    used = {str(row["name"]) for row in _present_areas(kept) if row.table == SECTION.name}
    rows = []
    for row in _present_areas(other):
        ring = [[a + north, b + east] for a, b in ring_of(row["outline"])]
        outline = json.dumps(ring) if ring else row["outline"]
        brought = {"lot": kept.id, "begins": version, "ends": None, "outline": outline}
        if row.table == SECTION.name:
            brought["name"] = free_name(str(row["name"]), used)
            used.add(str(brought["name"]))
        rows.append(row.setting(**brought))
    return rows


def free_labels(labels: Sequence[str], used: Collection[str]) -> list[str]:
    """Return labels that no stall has: those that are free, and the next letter for each row that is not."""
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


def split(lot: Estate, part: Outline, name: str, made: str, who: str, now: float) -> Change:
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
    places = np.array([(row["north"], row["east"]) for row in present]).reshape(-1, 2)
    inside = shapely.contains_xy(ground, places)
    if not inside.any():
        raise LotInputError("outline", "holds no stall of the lot: draw it around the stalls of the new lot")
    if inside.all():
        raise LotInputError("outline", "holds every stall of the lot: leave some to the first lot")
    shown = {"id": made, "name": name, "outline": outline_json(part), "merged_into": None, "made": now}
    shown |= {"latitude": lot.datum[0], "longitude": lot.datum[1]}  # no survey goes along that would say it
    moved = [row for row, goes in zip(present, inside.tolist(), strict=True) if goes]
    areas = [row for row in _present_areas(lot) if (middle := _middle(row)) and ground.contains(middle)]
    rows = [
        Row("lot", (made,), {**(lot.lot.values or {}), **shown}),
        layout_row(made, 1, f"split from {lot.lot['name']}", who, now),
        layout_row(lot.id, lot.version + 1, f"{name} split off", who, now),
        *(row.setting(lot=made, begins=1, ends=None) for row in (*moved, *areas)),
        lot.lot.setting(outline=outline_json(without(lot.outline, part))),
    ]
    return Change("split", lot.id, tuple(rows))


def _middle(area: Row) -> shapely.Point | None:
    """Return a place in a zone or section; None for a damaged one, which stays."""
    ring = ring_of(area["outline"])
    return shapely.Polygon(ring).representative_point() if ring else None


PLACE: Final = ("lot", "layout", "placed", "candidates", "north", "east", "turn", "doubt")
"""Columns of a survey that say where it lies."""


def placed(survey: Row, **values: object) -> Row:
    """Return the change of a survey's place: all columns that say it, so that its undo finds every later change."""
    return survey.setting(**{name: survey[name] for name in PLACE} | values)


def unplaced(survey: Row, lot: str | None, relation: Placed, doubt: str | None = None) -> Row:
    """Return the change of a survey to one of a lot, or of none, without a place among stalls."""
    nowhere: dict[str, object] = dict.fromkeys(PLACE)
    return survey.setting(**nowhere | {"lot": lot, "placed": relation.value, "candidates": _NONE, "doubt": doubt})


def moved(survey: Row, looks: Sequence[Row], lot: str) -> Change:
    """Return the change that moves a survey to another lot, where it is unregistered. Raises LotInputError.

    ``looks``: its observations, which are of stalls of the former lot.
    """
    if survey["lot"] == lot:
        raise LotInputError("lot", "has this survey already: name another one")
    return Change("move", lot, (unplaced(survey, lot, Placed.UNREGISTERED), *(row.removed() for row in looks)))


def deleted(survey: Row, looks: Sequence[Row]) -> Change:
    """Return the change that deletes a survey of a lot with its ``looks``; the stalls that it found stay."""
    gone = unplaced(survey, None, Placed.DELETED)
    return Change("delete", survey["lot"], (gone, *(row.removed() for row in looks)))


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
    found = unpack_stalls(survey["stalls"])
    if not found:
        raise LotInputError("lot", "cannot be made of a survey without stalls: name a known lot")
    seq, began = int(survey.key[0]), survey["began"]
    place = {name: survey[name] for name in ("latitude", "longitude", "outline")}
    lot = {"id": made, "name": name, **place, "datum_is_pinned": False, "merged_into": None, "made": now}
    labels = lasting_labels({stall.id: stall.on_map() for stall in found}, {}, ())
    home: dict[str, Any] = {"layout": 1, "north": 0.0, "east": 0.0, "turn": 0.0}
    rows = [Row("lot", (made,), lot), layout_row(made, 1, FIRST_FLIGHT, PROGRAM, began)]
    rows.append(placed(unplaced(survey, made, Placed.FIRST), **home))
    keys = {stall.id: key for key, stall in enumerate(found, first_key)}
    stalls = [stall_row(keys[stall.id], made, labels[stall.id], shape(stall), first=(seq, stall.id)) for stall in found]
    return Change("move", made, (*rows, *stalls, *look_rows(seq, keys, found)))


def stall_row(
    key: int, lot: str, label: str, where: Mapping[str, float], *, stall: str = "", begins: int = 1, kind: str = "",
    is_confirmed: bool = False, is_named: bool = False, first: tuple[int | None, int | None] = (None, None),
) -> Row:  # fmt: skip
    """Return the row of a stall that begins with a version of a lot's layout.

    Args:
        key: Its key.
        lot: The lot.
        label: Its label.
        where: Place and size by their columns, metres and radians in the lot's frame.
        stall: Its id; "": a new one.
        begins: The version.
        kind: Its kind.
        is_confirmed: A person has seen it where it is.
        is_named: A person gave the label.
        first: The survey that found it, and its number there.
    """
    values = {"key": key, "id": stall or new_id(), "lot": lot, "label": label, **where, "kind": kind}
    values |= {"is_confirmed": is_confirmed, "is_named": is_named, "begins": begins, "ends": None}
    return Row("stall", (key,), {**values, "first_survey": first[0], "first_id": first[1]})


def look_rows(seq: int, keys: Mapping[int, int], stalls: Sequence[Detection]) -> list[Row]:
    """Return the observations of a survey as rows to write. ``keys``: id in the survey -> key of the stall."""
    return [Row("observation", (look["survey"], look["stall"]), look) for look in looks_of(seq, keys, stalls)]


def _offset(kept: Estate, other: Estate) -> tuple[float, float]:
    """Return the origin of the other lot in the frame of the kept one, metres north and east."""
    ((north, east, _),) = about(kept.datum, np.array([other.datum]))
    return float(north), float(east)


def _carried(survey: Row, kept: Estate, other: Estate) -> Row:
    """Return a survey of the other lot as one of the kept lot: its place among the stalls goes along."""
    if survey["north"] is None:
        return placed(survey, lot=kept.id)
    north, east = _offset(kept, other)
    place = {"north": survey["north"] + north, "east": survey["east"] + east}
    return placed(survey, lot=kept.id, layout=kept.version + 1, placed=Placed.REGISTERED.value, **place)


def layout_row(lot: str, version: int, why: str, who: str, now: float) -> Row:
    """Return the row of a version of a lot's layout that begins now."""
    values = {"lot": lot, "version": version, "valid_from": now, "why": why, "who": who}
    return Row("layout", (lot, version), values)


def checked_outline(given: object) -> Outline:
    """Return an outline from JSON values: a list of [latitude, longitude], degrees. Raises LotInputError."""
    if not isinstance(given, list) or not 3 <= len(given) <= 500:
        raise LotInputError("outline", "must be a list of 3 to 500 corners [latitude, longitude]")
    return Outline((tuple(checked_degrees(corner, f"outline[{number}]") for number, corner in enumerate(given)),))

"""Changes that drones made of a plan which was changed here, too: proposals that a person takes or drops.

A document holds all versions of its plan. Versions that the lot here has not are the drone's own: what begins, ends or
changes with one of them is proposed, as far as the plan here has it otherwise.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from sqlalchemy import Connection, select

from hawk.lots import change_log
from hawk.lots.answers import Done, DroneProposals, DroneStall
from hawk.lots.change_log import Change
from hawk.lots.documents import plan_rows
from hawk.lots.documents.lot_document import LotPart, PlanSection, PlanStall, is_in_plan
from hawk.lots.documents.lot_states import LotState, body_of, is_followed, states_of
from hawk.lots.documents.source import lot_part
from hawk.lots.plan import edits, geometry, queries
from hawk.lots.plan.checks import MOST_OVERLAP
from hawk.lots.plan.values import LASTING, NO_STALLS, Draft, LayoutSection, LayoutStall, PlanZone, shapes_of
from hawk.lots.registration.georeference import corners_on_earth
from hawk.lots.registration.survey_place import datum_of
from hawk.lots.storage.rows import Row, is_among
from hawk.lots.storage.schema import LOT_DOCUMENT, STALL
from hawk.lots.values import LotInputError, check_fields, checked_name
from hawk.results.label_parts import in_order

KIND: Final = "drone"
"""Name of the operation among the steps of an edit."""
DROP: Final = "drop"
_TAKES: Final = ("drone", "base", "why")
_DROPS: Final = ("drone", "base")
_SECTION: Final = ("id", "name", "outline", "kind", "length_m", "capacity", "is_capacity_given", "note")


@dataclass(frozen=True, slots=True)
class PlanEdits:
    """Changes of a drone, as the draft of a change of the plan here."""

    state: LotState
    draft: Draft


def plan_edits(connection: Connection, lot: str) -> list[PlanEdits]:
    """Return the changes of a lot's plan that wait for a person, by drone. Raises LotStoreError for a damaged lot."""
    waiting = [each for each in states_of(connection, lot) if each.writer and not is_followed(each)]
    if not waiting:
        return []
    here = lot_part(connection, lot)
    present = queries.all_stalls(connection, lot)
    found = []
    for state in waiting:
        draft = _draft(connection, here, present, body_of(connection, lot, state))
        if not draft.is_empty:
            found.append(PlanEdits(state, draft))
    return found


def proposed(connection: Connection, lot: str) -> list[DroneProposals]:
    """Return them as an answer shows them. Corners are WGS-84."""
    datum = datum_of(connection, lot)
    return [
        DroneProposals(
            drone=each.state.writer, base=each.state.base, begin=_shown(datum, each.draft.added),
            end=_shown(datum, each.draft.ended), change=_shown(datum, [new for _, new in each.draft.changed]),
            areas=_areas(each.draft),
        )
        for each in plan_edits(connection, lot)
    ]  # fmt: skip


def take_over(connection: Connection, lot: str, asked: Mapping[str, Any], who: str, now: float) -> Done:
    """Make the changes of a drone here, as one version of the layout that is undone once.

    Raises LotInputError for changes that do not fit the plan, and BeingEditedError.
    """
    found = _named(connection, lot, asked, _TAKES)
    why = f"changes of {found.state.writer}" if asked.get("why") in (None, "") else checked_name(asked["why"], "why")
    opened = edits.open_edit(connection, lot, {"who": who}, now)
    edit = edits.held(connection, lot, {"edit": opened.edit}, now, ("edit",))
    edits.done(connection, edit, KIND, found.draft, now)
    closed = edits.close(connection, lot, {"edit": edit.id, "why": why}, now)
    plan_rows.tie(connection, [stall.id for stall in found.draft.added])
    assert closed.seq is not None  # noqa: S101 - the draft is not empty
    return Done(seq=closed.seq, kind=edits.KIND, lot=lot)


def drop(connection: Connection, lot: str, asked: Mapping[str, Any], who: str, now: float) -> Done:
    """Drop the changes of a drone: they are proposed no more. Raises LotInputError."""
    state = _named(connection, lot, asked, _DROPS).state
    row = Row(LOT_DOCUMENT.name, (lot, state.writer, state.base), {"decided": state.state})
    return change_log.write(connection, Change(DROP, lot, (row,)), who, now)


def _named(connection: Connection, lot: str, asked: Mapping[str, Any], known: Sequence[str]) -> PlanEdits:
    check_fields(asked, known)
    for found in plan_edits(connection, lot):
        if (found.state.writer, found.state.base) == (asked.get("drone"), asked.get("base", "")):
            return found
    raise LotInputError("drone", "has no changes that wait for this lot: read the changes again")


def _shown(datum: tuple[float, float], stalls: Sequence[LayoutStall]) -> list[DroneStall]:
    ordered = in_order(stalls)
    corners = np.round(corners_on_earth(datum, shapes_of(ordered)), 8).tolist()
    return [
        DroneStall(id=stall.id, label=stall.label, corners=each) for stall, each in zip(ordered, corners, strict=True)
    ]


def _areas(draft: Draft) -> list[str]:
    """Return the names of zones and sections that begin, end or change."""
    zones, sections = (*draft.begun_zones, *draft.ended_zones), (*draft.begun_sections, *draft.ended_sections)
    return sorted({*(each.name for each in zones), *(each.name for each in sections)})


def _draft(connection: Connection, here: LotPart, present: Sequence[LayoutStall], part: LotPart) -> Draft:
    """Return the changes of a drone's plan, ``part``, as far as the plan here has them otherwise."""
    own = {each.version for each in {*part.layouts} - {*here.layouts}}
    known = {stall.id: stall for stall in present}
    ended = tuple(known[each.id] for each in part.stalls if each.ends in own and each.id in known)
    going = {stall.id for stall in ended}
    changed = _changed(part, own, {named: stall for named, stall in known.items() if named not in going})
    kept = {**{stall.id: stall for stall in present if stall.id not in going}, **{new.id: new for _, new in changed}}
    added = _added(connection, part, [*kept.values()])
    draft = Draft(changed=changed, ended=ended, added=added)
    return _with_sections(connection, _with_zones(draft, here, part, own), here, part, own)


def _added(connection: Connection, part: LotPart, kept: Sequence[LayoutStall]) -> tuple[LayoutStall, ...]:
    """Return stalls that no plan here has ever had, without those on ground where a stall is."""
    asked = select(STALL.c.id).where(STALL.c.ends.is_(None) | (STALL.c.ends > STALL.c.begins))
    there = {*connection.execute(asked.where(is_among(STALL.c.id, [each.id for each in part.stalls]))).scalars()}
    used = {stall.label for stall in kept}
    new = [_stall(each, used) for each in part.stalls if each.ends is None and each.id not in there]
    over = {k for k, _, _ in geometry.overlaps_between(shapes_of(new), shapes_of(kept), MOST_OVERLAP)}
    return tuple(stall for k, stall in enumerate(new) if k not in over)


def _stall(each: PlanStall, used: set[str]) -> LayoutStall:
    """Return a stall of a document as a plan has it; without its label, where a stall here has that."""
    values = {name: getattr(each, name) for name in LASTING}
    stall = LayoutStall(id=each.id, **values)
    return replace(stall, label="", is_named=False) if stall.label in used else stall


def _changed(
    part: LotPart, own: set[int], known: Mapping[str, LayoutStall]
) -> tuple[tuple[LayoutStall, LayoutStall], ...]:
    """Return stalls here with what the drone's own versions changed of each."""
    before = {each.stall: each for each in sorted(part.former, key=lambda one: -one.ends) if each.ends in own}
    changed = []
    for each in part.stalls:
        stall, former = known.get(each.id), before.get(each.id)
        if stall is None or former is None or each.ends is not None:
            continue
        names = [name for name in LASTING if getattr(each, name) != getattr(former, name)]
        new = replace(stall, **{name: getattr(each, name) for name in names})
        if new != stall:
            changed.append((stall, new))
    return tuple(changed)


def _with_zones(draft: Draft, here: LotPart, part: LotPart, own: set[int]) -> Draft:
    """Return a draft with the zones that a drone has drawn and erased."""
    known, names = {each.id: each for each in here.zones}, {each.name for each in here.zones if each.ends is None}
    begun = [
        PlanZone(each.id, each.name, each.outline, each.kind)
        for each in part.zones
        if each.begins in own and each.ends is None and each.id not in known
    ]
    ended = [
        PlanZone(zone.id, zone.name, zone.outline, zone.kind)
        for each in part.zones
        if each.ends in own and (zone := known.get(each.id)) is not None and zone.ends is None
    ]
    return replace(
        draft,
        forbidden=tuple(zone for zone in begun if zone.kind == NO_STALLS),
        drawn=tuple(zone for zone in begun if zone.kind != NO_STALLS and zone.name not in names),
        allowed=tuple(zone for zone in ended if zone.kind == NO_STALLS),
        erased=tuple(zone for zone in ended if zone.kind != NO_STALLS),
    )


def _with_sections(connection: Connection, draft: Draft, here: LotPart, part: LotPart, own: set[int]) -> Draft:
    """Return a draft with the sections that a drone has drawn, changed and removed."""
    known = {each.id: each for each in queries.sections_of(connection, here.id)}
    ever = {each.id for each in here.sections if is_in_plan(each)}
    now = {each.id: each for each in part.sections if each.ends is None}
    begun, ended = [], []
    for each in part.sections:
        there = known.get(each.id)
        if each.ends is None and each.begins in own and (each.id not in ever or there is not None):
            section = _section(each)
            if there is None or replace(there, key=section.key) != section:
                begun.append(section)
                ended += [] if there is None else [there]
        elif each.ends in own and each.id not in now and there is not None and there not in ended:
            ended.append(there)
    return replace(draft, begun_sections=tuple(begun), ended_sections=tuple(ended))


def _section(each: PlanSection) -> LayoutSection:
    return LayoutSection(**{name: getattr(each, name) for name in _SECTION})

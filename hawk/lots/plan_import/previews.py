"""Previews of imports: the change that a file would make, kept in memory until it is taken. Nothing is written."""

from __future__ import annotations

import math
import secrets
from collections import OrderedDict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

from sqlalchemy import Connection

from hawk.lots.plan.queries import all_stalls, sections_of, zones_of
from hawk.lots.plan.values import SHAPE, Draft, LayoutStall, PlanStall
from hawk.lots.plan.versions import revision_of
from hawk.lots.plan_files.values import MOST_LEFT_OUT, LeftOut, PlanFile
from hawk.lots.plan_import.answers import (
    BeginningShape,
    EndingShape,
    LeftOutFeature,
    PlanLayer,
    PlanPlace,
    PlanPreview,
    Renamed,
    SectionShape,
    StayingShape,
)
from hawk.lots.plan_import.choices import ImportAsked
from hawk.lots.plan_import.match import Matched, matched
from hawk.lots.plan_import.placement import Placement, placed, ring_after, shapes_after
from hawk.lots.plan_import.section_match import matched_sections
from hawk.lots.values import LotStoreError, Register, new_id

LONGEST_S: Final = 30 * 60.0
"""Seconds that a preview is kept."""
MOST: Final = 4
"""Previews that are kept: each of 20,000 stalls takes some 20 MB."""


@dataclass(frozen=True, slots=True)
class Preview:
    """An import that was not taken yet. ``lot``: None for a new one; ``revision``: of its plan at the preview."""

    lot: str | None
    revision: int
    file: str
    placement: Placement
    matched: Matched = field(repr=False)
    plan: PlanFile = field(repr=False)


def new_token() -> str:
    """Return a token that nobody guesses."""
    return secrets.token_hex(16)


class Previews:
    """Keeps the newest previews by their tokens. It belongs to one thread."""

    def __init__(self) -> None:
        """Keep none yet."""
        self._kept: OrderedDict[str, tuple[float, Preview]] = OrderedDict()

    def keep(self, token: str, preview: Preview, now: float) -> None:
        """Keep a preview; the oldest one goes."""
        self._kept[token] = (now, preview)
        while len(self._kept) > MOST:
            self._kept.popitem(last=False)

    def of(self, token: str, lot: str | None, now: float) -> Preview:
        """Return a preview of a lot. Raises LotStoreError for one that is gone."""
        made, preview = self._kept.get(token, (-math.inf, None))
        if preview is None or preview.lot != lot or not 0 <= now - made <= LONGEST_S:
            raise LotStoreError("import: the preview is gone: send the file again")
        return preview

    def drop(self, token: str) -> None:
        """Forget a preview that was taken."""
        self._kept.pop(token, None)


def preview(
    connection: Connection, lot: str | None, plan: PlanFile, asked: ImportAsked, register: Register | None
) -> Preview:
    """Return the import of a plan into a lot; None: into a new one. Raises LotInputError."""
    placement = placed(connection, lot, plan, asked.pins, register)
    shapes = shapes_after(plan.shapes(), placement.move)
    present: list[LayoutStall] = [] if lot is None else all_stalls(connection, lot)
    zones = [] if lot is None else zones_of(connection, lot)
    change = matched(plan.stalls, shapes, present, zones, asked.choices, new_id)
    if plan.sections:
        rings = [ring_after(each.ring, placement.move) for each in plan.sections]
        sections = [] if lot is None else sections_of(connection, lot)
        change = change.beside(matched_sections(
            plan.sections, rings, sections, new_id, is_replaced=asked.choices.replace, is_renamed=asked.choices.rename,
        ))  # fmt: skip
    revision = 0 if lot is None else revision_of(connection, lot)
    return Preview(lot, revision, asked.name, placement, change, plan)


def shown_preview(found: Preview, token: str) -> PlanPreview:
    """Return the answer about a preview: what begins, stays and ends, in the lot's frame, and what is left out."""
    draft, plan, place = found.matched.draft, found.plan, found.placement
    same = len(plan.stalls) - len(found.matched.left_out) - len(draft.added) - len(draft.changed)
    return PlanPreview(
        token=token,
        lot=found.lot,
        file=found.file,
        format=plan.format,
        crs=plan.crs,
        datum=list(place.datum),
        placed=PlanPlace(
            by=place.by, on=place.on, is_certain=not place.doubt, doubt=place.doubt, north=round(place.shift.north, 3),
            east=round(place.shift.east, 3), turn=round(math.degrees(place.shift.turn), 4),
            residual=round(place.residual, 3), accuracy=plan.accuracy,
        ),
        begin=[BeginningShape(**_shape(stall), kind=stall.kind) for stall in draft.added],
        stay=[StayingShape(**_shape(new), kind=new.kind, id=new.id, former=old.label) for old, new in draft.changed],
        same=same,
        end=[EndingShape(**_shape(stall), id=stall.id) for stall in draft.ended],
        left_out=_named([*found.matched.left_out, *plan.left_out]),
        left_out_count=plan.left_out_count + len(found.matched.left_out),
        notes=[*plan.assumed],
        clashes=_named(found.matched.clashes),
        clash_count=len(found.matched.clashes),
        renamed=[Renamed(label=old, to=new) for old, new in found.matched.renamed[:MOST_LEFT_OUT]],
        sections=[*_sections(draft)],
        same_sections=found.matched.same_sections,
        layers=[PlanLayer(name=name, outlines=count) for name, count in plan.layers],
    )  # fmt: skip


def _sections(draft: Draft) -> Iterator[SectionShape]:
    """Yield the sections that begin, change and end, in this order."""
    former, begun = ({each.id: each for each in sections} for sections in (draft.ended_sections, draft.begun_sections))
    for each in (*draft.begun_sections, *draft.ended_sections):
        is_ended = each.id in former and former[each.id] is each
        if is_ended and each.id in begun:
            continue
        yield SectionShape(
            change="end" if is_ended else "stay" if each.id in former else "begin",
            name=each.name, former=former[each.id].name if each.id in former else "",
            outline=each.outline, kind=each.kind, length_m=each.length_m, capacity=each.capacity,
            is_capacity_given=each.is_capacity_given, note=each.note,
        )  # fmt: skip


def _shape(stall: PlanStall) -> dict[str, Any]:
    return {**{name: round(getattr(stall, name), 4) for name in SHAPE}, "label": stall.label}


def _named(left_out: Sequence[LeftOut]) -> list[LeftOutFeature]:
    return [LeftOutFeature(name=each.name, reason=each.reason) for each in left_out[:MOST_LEFT_OUT]]

"""Form of documents of lots: versioned JSON, by which a lot with its plan goes to a desk and back."""

from __future__ import annotations

import hashlib
import zlib
from collections.abc import Sequence
from typing import Annotated, Final, Literal

from pydantic import Field

from hawk.lots.documents.parts import (
    FARTHEST_M,
    MOST,
    Angle,
    Ground,
    Label,
    Latitude,
    Longitude,
    Metres,
    Moment,
    Name,
    Part,
    Ring,
    Side,
    Uuid,
    Version,
    Whole,
    Words,
    check_single,
    read_document,
)
from hawk.lots.plan.kinds import Kind
from hawk.lots.plan.values import BareKind, SectionKind
from hawk.lots.values import LONGEST_ZONE, LotInputError

FORMAT: Final = "hawk lots"
VERSION: Final = 1
"""Version of documents that are written. Each that was ever written can be read."""
MOST_SCHEDULED: Final = 1000
"""Lots of a document that are due at some time."""
MOST_DUE: Final = 1000
"""Moments of a lot of them."""


class Layout(Part):
    """A version of the lot's layout."""

    version: Version
    valid_from: Moment
    why: Words
    who: Words


class StallShape(Part):
    """Place, label and kind of a stall, in the lot's frame."""

    label: Label
    north: Metres
    east: Metres
    angle: Angle
    width: Side
    length: Side
    kind: Kind
    is_confirmed: bool
    is_named: bool


class PlanStall(StallShape):
    """A stall: `begins` is the first version of the layout that has it, `ends` the first that has not."""

    id: Uuid
    begins: Version
    ends: Version | None


class FormerStall(StallShape):
    """A stall as it was in the versions before `ends`."""

    stall: Uuid
    ends: Version


class PlanZone(Part):
    """A zone of the plan, or an area without stalls."""

    id: Uuid
    name: Label
    kind: Kind | BareKind
    outline: Ring
    begins: Version
    ends: Version | None


class PlanSection(Part):
    """A section of the plan, as some versions have it."""

    id: Uuid
    name: Name
    outline: Ring
    kind: SectionKind
    length_m: Annotated[float, Field(ge=0, le=FARTHEST_M, allow_inf_nan=False)]
    capacity: Whole | None
    is_capacity_given: bool
    note: Words
    begins: Version
    ends: Version | None


class LotBase(Part):
    """State of a lot at the desk: digest of its `plan`, name and time zone. A store that changes it names it so."""

    plan: Annotated[str, Field(pattern="^[0-9a-f]{64}$")]
    name: Name
    time_zone: Annotated[str, Field(max_length=LONGEST_ZONE)] | None

    @classmethod
    def of(cls, lot: LotPart) -> LotBase:
        """Return that of a lot as it is."""
        return cls(plan=plan_digest(lot), name=lot.name, time_zone=lot.time_zone)


class LotPart(Part):
    """A lot with its plan, all versions. `state` rises with each change in its store.

    `turn`: radians clockwise by which pins have turned its frame. `merged_into`: the lot that it became part of.
    `base`: of the lot as a desk gave it; null: none did.
    """

    id: Uuid
    state: Whole
    name: Name
    outline: Ground
    latitude: Latitude
    longitude: Longitude
    datum_is_pinned: bool
    turn: Angle
    made: Moment
    time_zone: Annotated[str, Field(max_length=LONGEST_ZONE)] | None
    merged_into: Uuid | None
    layouts: Annotated[tuple[Layout, ...], Field(fail_fast=True, max_length=MOST)]
    stalls: Annotated[tuple[PlanStall, ...], Field(fail_fast=True, max_length=MOST)]
    former: Annotated[tuple[FormerStall, ...], Field(fail_fast=True, max_length=MOST)]
    zones: Annotated[tuple[PlanZone, ...], Field(fail_fast=True, max_length=MOST)]
    sections: Annotated[tuple[PlanSection, ...], Field(fail_fast=True, max_length=MOST)]
    base: LotBase | None = None


class LotDue(Part):
    """When surveys of a lot are due by the schedule of a desk. `last`: end of its newest survey there."""

    lot: Uuid
    last: Moment | None
    moments: Annotated[tuple[Moment, ...], Field(fail_fast=True, max_length=MOST_DUE)]


class LotDocument(Part):
    """Lots with their plans, and those that became part of them. `state`: number of the newest change of a lot that
    this document, or an earlier one, has. `due`: of a desk's, what is due there.
    """

    format: Literal["hawk lots"]
    version: Literal[1]
    state: Whole
    lots: Annotated[tuple[LotPart, ...], Field(fail_fast=True, max_length=1000)]
    due: Annotated[tuple[LotDue, ...], Field(fail_fast=True, max_length=MOST_SCHEDULED)] = ()


def unpacked(data: bytes) -> LotDocument:
    """Return the document of `hawk.lots.documents.parts.packed`. Raises LotInputError with the field."""
    document = read_document(data, LotDocument, FORMAT, VERSION)
    check_lots(document.lots)
    check_single("due", [each.lot for each in document.due])
    return document


def check_lots(lots: Sequence[LotPart]) -> None:
    """Refuse lots that do not fit each other, or contradict themselves. Raises LotInputError."""
    named = {each.id for each in lots}
    check_single("lots", [each.id for each in lots])
    for number, lot in enumerate(lots):
        field = f"lots[{number}]"
        check_single(f"{field}.layouts", [each.version for each in lot.layouts])
        check_single(f"{field}.stalls", [each.id for each in lot.stalls])
        check_single(f"{field}.former", [(each.stall, each.ends) for each in lot.former])
        check_single(f"{field}.zones", [each.id for each in lot.zones])
        if {each.stall for each in lot.former} - {each.id for each in lot.stalls}:
            raise LotInputError(f"{field}.former", "must name stalls of the lot")
        if lot.merged_into == lot.id:
            raise LotInputError(f"{field}.merged_into", "is the lot itself: name the lot that it became part of")
        if lot.merged_into is not None and lot.merged_into not in named:
            raise LotInputError(f"{field}.merged_into", "must be the id of one of the lots of the document")
        _check_versions(field, lot)


def _check_versions(field: str, lot: LotPart) -> None:
    """Refuse parts of a plan that begin or end with a version that the lot has not. Raises LotInputError."""
    versions = {each.version for each in lot.layouts}
    every: dict[str, Sequence[PlanStall | PlanZone | PlanSection]] = {
        "stalls": lot.stalls, "zones": lot.zones, "sections": lot.sections,
    }  # fmt: skip
    for name, parts in every.items():
        for number, part in enumerate(parts):
            for when, version in (("begins", part.begins), ("ends", part.ends)):
                if is_in_plan(part) and version is not None and version not in versions:
                    words = f"is {version}, and the lot has no such layout: send the lot again as it is"
                    raise LotInputError(f"{field}.{name}[{number}].{when}", words)


def is_in_plan(part: PlanStall | PlanZone | PlanSection) -> bool:
    """Return whether a version of the layout has a part: one that was undone ends where it begins."""
    return part.ends is None or part.ends > part.begins


def plan_digest(lot: LotPart) -> str:
    """Return the SHA-256 of a lot's plan: of all that its versions have, without state, name and time zone."""
    stalls = tuple(each for each in lot.stalls if is_in_plan(each))
    there = {each.id for each in stalls}
    plan = lot.model_copy(
        update={
            "stalls": stalls,
            "former": tuple(each for each in lot.former if each.stall in there),
            "zones": tuple(each for each in lot.zones if is_in_plan(each)),
            "sections": tuple(each for each in lot.sections if is_in_plan(each)),
        }
    )
    text = plan.model_dump_json(exclude={"state", "name", "time_zone", "made", "base"}, exclude_defaults=True)
    return hashlib.sha256(text.encode()).hexdigest()


def lot_body(lot: LotPart) -> bytes:
    """Return a lot as the table of its states keeps it."""
    return zlib.compress(lot.model_dump_json().encode(), 6)


def kept_lot(body: bytes) -> LotPart:
    """Return the lot of `lot_body`."""
    return LotPart.model_validate_json(zlib.decompress(body))

"""Form of the document of a survey: versioned JSON, packed by gzip, readable without this program.

No vehicle is in it: counts of sections are (docs/privacy.md).
"""

from __future__ import annotations

from typing import Annotated, Final, Literal

from pydantic import Base64Bytes, Field

from hawk.formats.image import jpeg_size
from hawk.lots.documents.lot_document import LotPart, check_lots
from hawk.lots.documents.parts import (
    FARTHEST_M,
    LARGEST_WHOLE,
    MOST,
    Angle,
    Finite,
    Ground,
    JournalName,
    Latitude,
    Longitude,
    Metres,
    Moment,
    Part,
    Share,
    Side,
    Uuid,
    Version,
    Whole,
    Words,
    check_single,
    read_document,
)
from hawk.lots.survey.source import Limit, SourceKind, SurveyKind
from hawk.lots.values import LotInputError, Placed
from hawk.model.lot_map import TILE_CELLS, EncodedTile, StallState, TileKey

FORMAT: Final = "hawk survey"
VERSION: Final = 1
"""Version of documents that are written. Each that was ever written can be read."""
_LARGEST_TILE: Final = 1_400_000
"""Characters of a tile of 1 MiB in base64."""


class Place(Part):
    """Move that brings the survey's frame onto its lot's: a turn about the origin, then a shift."""

    north: Metres
    east: Metres
    turn: Angle


class DoubtfulPlace(Place):
    """A place where the survey may lie."""

    score: Finite


class Doubt(Part):
    """Reason why the place is not certain, and the places to choose from. `chosen`: number of one of them."""

    why: Words
    places: Annotated[tuple[DoubtfulPlace, ...], Field(fail_fast=True, max_length=1000)]
    chosen: Annotated[int, Field(ge=0, le=999)] | None


class SurveyPart(Part):
    """The survey. `state` rises with each change in its store; `landing`: its number there."""

    id: Uuid
    state: Whole
    landing: Whole
    name: JournalName
    kind: SurveyKind
    source: SourceKind | Literal[""]
    source_name: Words
    limits: Annotated[tuple[Limit, ...], Field(fail_fast=True, max_length=len(Limit))]
    program: Words
    simulated: bool
    began: Moment
    ended: Moment
    time_is_sure: bool
    latitude: Latitude
    longitude: Longitude
    accuracy: Annotated[float, Field(ge=0, le=FARTHEST_M, allow_inf_nan=False)] | None
    outline: Ground
    seen_ground: Ground | None
    placed: Placed
    lot: Uuid | None
    layout: Version | None
    place: Place | None
    candidates: Annotated[tuple[Uuid, ...], Field(fail_fast=True, max_length=1000)]
    doubt: Doubt | None


class FoundStall(Part):
    """A stall as the survey found it, in its own frame."""

    id: Annotated[int, Field(ge=-LARGEST_WHOLE, le=LARGEST_WHOLE)]
    north: Metres
    east: Metres
    angle: Angle
    width: Side
    length: Side
    taken_probability: Share
    state: StallState
    score: Finite
    picture_count: Whole
    looked_at: Finite
    known: Uuid | Literal[""]
    is_extra: bool
    is_blurred: bool | None


class Look(Part):
    """Look of the survey at a stall of its lot, by the stall's id."""

    stall: Uuid
    looked_at: Finite
    taken_probability: Share
    state: StallState
    picture_count: Whole


class SectionLook(Part):
    """Count of the survey at a section of its lot, by the section's id."""

    section: Uuid
    looked_at: Finite
    source: Literal["vehicles", "stalls"]
    parked: Whole
    least: Whole
    most: Whole
    hidden_share: Share
    seen_share: Share
    room: Whole | None


class Tile(Part):
    """A tile of the survey's picture, a JPEG of 256 x 256 pixels of 0.1 m, by its row and column."""

    row: Annotated[int, Field(ge=-999_999, le=999_999)]
    column: Annotated[int, Field(ge=-999_999, le=999_999)]
    jpeg: Annotated[Base64Bytes, Field(max_length=_LARGEST_TILE, description="base64")]


class SurveyDocument(Part):
    """A survey with all that is said of it: its stalls, looks and counts, its picture, and lots with their plans.

    `lots`: its own, those that became part of it, and those whose stalls it looked at.
    """

    format: Literal["hawk survey"]
    version: Literal[1]
    survey: SurveyPart
    stalls: Annotated[tuple[FoundStall, ...], Field(fail_fast=True, max_length=MOST)]
    looks: Annotated[tuple[Look, ...], Field(fail_fast=True, max_length=MOST)]
    sections: Annotated[tuple[SectionLook, ...], Field(fail_fast=True, max_length=MOST)]
    lots: Annotated[tuple[LotPart, ...], Field(fail_fast=True, max_length=1000)]
    mosaic: Annotated[tuple[Tile, ...], Field(fail_fast=True, max_length=10_000)]

    @property
    def pictures(self) -> dict[TileKey, EncodedTile]:
        """The tiles of the picture."""
        return {(each.row, each.column): EncodedTile(1, each.jpeg) for each in self.mosaic}


def unpacked(data: bytes) -> SurveyDocument:
    """Return the document of `hawk.lots.documents.parts.packed`, of any version that was ever written.

    Raises LotInputError with the field: for a document that is cut, too large, of a newer version, and for a value that
    cannot be.
    """
    document = read_document(data, SurveyDocument, FORMAT, VERSION)
    _check(document)
    return document


def _check(document: SurveyDocument) -> None:
    """Refuse parts that do not fit each other. Raises LotInputError."""
    survey, lots = document.survey, {each.id: each for each in document.lots}
    if survey.ended < survey.began:
        raise LotInputError("survey.ended", "is before survey.began: correct the clock of the drone")
    if (survey.kind is SurveyKind.PICTURE) != (survey.source != ""):
        raise LotInputError("survey.source", "must name the kind of pictures of a survey by pictures, and of no other")
    if survey.lot is not None and survey.lot not in lots:
        raise LotInputError("survey.lot", "must be the id of one of the lots of the document")
    chosen = None if survey.doubt is None else survey.doubt.chosen
    if survey.doubt is not None and chosen is not None and chosen >= len(survey.doubt.places):
        raise LotInputError("survey.doubt.chosen", "must be the number of one of the places")
    check_lots(document.lots)
    layouts = {each.version for each in lots[survey.lot].layouts} if survey.lot is not None else set()
    if survey.lot is not None and survey.layout is not None and survey.layout not in layouts:
        words = f"is {survey.layout}, and its lot has no such layout: send the survey again as it is"
        raise LotInputError("survey.layout", words)
    check_single("stalls", [each.id for each in document.stalls])
    check_single("looks", [each.stall for each in document.looks])
    check_single("sections", [each.section for each in document.sections])
    check_single("mosaic", [(each.row, each.column) for each in document.mosaic])
    for number, tile in enumerate(document.mosaic):
        if _size(tile.jpeg) != (TILE_CELLS, TILE_CELLS):
            raise LotInputError(f"mosaic[{number}].jpeg", f"must be a JPEG of {TILE_CELLS} x {TILE_CELLS} pixels")


def _size(jpeg: bytes) -> tuple[int, int] | None:
    """Return width and height of a JPEG, by its head alone: nothing is unpacked."""
    try:
        return jpeg_size(jpeg)
    except ValueError:
        return None

"""Form of the document of a survey: versioned JSON, packed by gzip, readable without this program.

One declaration is the value inside, the check at the edge and the schema of the API. A name of a column of the store is
the name here. Lengths are metres, angles radians clockwise from north, times UTC in Unix seconds, places on Earth
degrees of WGS-84, latitude first. No vehicle is in it: counts of sections are (docs/privacy.md).
"""

from __future__ import annotations

import gzip
import hashlib
import zlib
from typing import Annotated, Any, Final, Literal

from pydantic import AfterValidator, Base64Bytes, BaseModel, ConfigDict, Field, ValidationError
from pydantic_core import from_json

from hawk.formats.image import jpeg_size
from hawk.formats.validation import wrong_values
from hawk.lots.plan.kinds import Kind
from hawk.lots.plan.values import BareKind, SectionKind
from hawk.lots.survey.source import Limit, SourceKind, SurveyKind
from hawk.lots.values import LONGEST_NAME, LONGEST_ZONE, LotInputError, Placed, is_shown
from hawk.model.lot_map import TILE_CELLS, EncodedTile, StallState, TileKey

FORMAT: Final = "hawk survey"
VERSION: Final = 1
"""Version of documents that are written. Each that was ever written can be read."""
LARGEST_BYTES: Final = 32_000_000
"""Of a packed document: the picture of 20 ha is 16 MB of it."""
LARGEST_UNPACKED_BYTES: Final = 96_000_000
MOST: Final = 50_000
"""Stalls, looks or rows of a table of a plan."""
_UUID: Final = "^[0-9a-f]{8}-[0-9a-f]{4}-[0-9a-f]{4}-[0-9a-f]{4}-[0-9a-f]{12}$"
_HEX: Final = "must be a UUID in lower case, as 123e4567-e89b-42d3-a456-426614174000"
_FORMS: Final = {_UUID: _HEX}
_LARGEST_WHOLE: Final = 2**53
"""Whole numbers above are not the same in every program that reads JSON (RFC 8259, 6)."""
_LATEST_S: Final = 9_999_999_999.0
"""In the year 2286."""
_FARTHEST_M: Final = 1e6
_LARGEST_TILE: Final = 1_400_000
"""Characters of a tile of 1 MiB in base64."""


def _shown(text: str) -> str:
    if not is_shown(text):
        raise ValueError("holds characters that cannot be shown: write it without")
    return text


def _journal_name(text: str) -> str:
    """Return the name of a journal: erasing looks for a folder of this name."""
    if not is_shown(text) or any(each in text for each in ("/", "\\", "..")) or text.startswith("."):
        raise ValueError("must be a name without / and .., as 000001-20260504T103000Z")
    return text


Uuid = Annotated[str, Field(pattern=_UUID)]
Finite = Annotated[float, Field(allow_inf_nan=False)]
Metres = Annotated[float, Field(ge=-_FARTHEST_M, le=_FARTHEST_M, allow_inf_nan=False)]
Angle = Annotated[float, Field(ge=-100, le=100, allow_inf_nan=False, description="radians")]
Side = Annotated[float, Field(gt=0, le=100, allow_inf_nan=False, description="metres")]
Share = Annotated[float, Field(ge=0, le=1, allow_inf_nan=False)]
Moment = Annotated[float, Field(ge=0, le=_LATEST_S, allow_inf_nan=False, description="UTC, Unix seconds")]
Whole = Annotated[int, Field(ge=0, le=_LARGEST_WHOLE)]
Version = Annotated[int, Field(ge=1, le=1_000_000)]
Latitude = Annotated[float, Field(ge=-90, le=90, allow_inf_nan=False)]
Longitude = Annotated[float, Field(ge=-180, le=180, allow_inf_nan=False)]
Ring = Annotated[tuple[tuple[Metres, Metres], ...], Field(min_length=3, max_length=10_000)]
EarthRing = Annotated[tuple[tuple[Latitude, Longitude], ...], Field(min_length=3, max_length=100_000)]
Name = Annotated[str, Field(min_length=1, max_length=LONGEST_NAME), AfterValidator(_shown)]
JournalName = Annotated[
    str, Field(min_length=1, max_length=120, description="name of its journal"), AfterValidator(_journal_name)
]
Label = Annotated[str, Field(max_length=LONGEST_NAME), AfterValidator(_shown)]
Words = Annotated[str, Field(max_length=500), AfterValidator(_shown)]


class Part(BaseModel):
    """A part of a document. Another key than these is refused."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class Ground(Part):
    """Ground on Earth: what lies in a polygon and in no hole."""

    polygons: Annotated[tuple[EarthRing, ...], Field(max_length=10_000)] = ()
    holes: Annotated[tuple[EarthRing, ...], Field(max_length=10_000)] = ()


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
    places: Annotated[tuple[DoubtfulPlace, ...], Field(max_length=1000)]
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
    limits: Annotated[tuple[Limit, ...], Field(max_length=len(Limit))]
    program: Words
    simulated: bool
    began: Moment
    ended: Moment
    time_is_sure: bool
    latitude: Latitude
    longitude: Longitude
    accuracy: Annotated[float, Field(ge=0, le=_FARTHEST_M, allow_inf_nan=False)] | None
    outline: Ground
    seen_ground: Ground | None
    placed: Placed
    lot: Uuid | None
    layout: Version | None
    place: Place | None
    candidates: Annotated[tuple[Uuid, ...], Field(max_length=1000)]
    doubt: Doubt | None


class FoundStall(Part):
    """A stall as the survey found it, in its own frame."""

    id: Annotated[int, Field(ge=-_LARGEST_WHOLE, le=_LARGEST_WHOLE)]
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
    length_m: Annotated[float, Field(ge=0, le=_FARTHEST_M, allow_inf_nan=False)]
    capacity: Whole | None
    is_capacity_given: bool
    note: Words
    begins: Version
    ends: Version | None


class LotPart(Part):
    """A lot with its plan, all versions. `state` rises with each change in its store.

    `turn`: radians clockwise by which pins have turned its frame. `merged_into`: the lot that it became part of.
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
    layouts: Annotated[tuple[Layout, ...], Field(max_length=MOST)]
    stalls: Annotated[tuple[PlanStall, ...], Field(max_length=MOST)]
    former: Annotated[tuple[FormerStall, ...], Field(max_length=MOST)]
    zones: Annotated[tuple[PlanZone, ...], Field(max_length=MOST)]
    sections: Annotated[tuple[PlanSection, ...], Field(max_length=MOST)]


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
    stalls: Annotated[tuple[FoundStall, ...], Field(max_length=MOST)]
    looks: Annotated[tuple[Look, ...], Field(max_length=MOST)]
    sections: Annotated[tuple[SectionLook, ...], Field(max_length=MOST)]
    lots: Annotated[tuple[LotPart, ...], Field(max_length=1000)]
    mosaic: Annotated[tuple[Tile, ...], Field(max_length=10_000)]

    @property
    def pictures(self) -> dict[TileKey, EncodedTile]:
        """The tiles of the picture."""
        return {(each.row, each.column): EncodedTile(1, each.jpeg) for each in self.mosaic}


def packed(document: SurveyDocument) -> bytes:
    """Return a document as it travels; the same bytes each time."""
    return gzip.compress(document.model_dump_json().encode(), 6, mtime=0)


def unpacked(data: bytes) -> SurveyDocument:
    """Return the document of `packed`, of any version that was ever written.

    Raises LotInputError with the field: for a document that is cut, too large, of a newer version, and for a value that
    cannot be.
    """
    try:
        plain = _plain(data)
        found = from_json(plain, allow_inf_nan=False)
    except ValueError as error:
        raise LotInputError("document", f"is no JSON: {error}. Send the document again") from None
    if not isinstance(found, dict) or found.get("format") != FORMAT:
        raise LotInputError("format", f'must be "{FORMAT}": send a document of a survey')
    version = found.get("version")
    if type(version) is not int or version < 1:
        raise LotInputError("version", "must be a whole number from 1")
    if version > VERSION:
        words = (
            f"is {version}, of a newer hawk-drone, and this one reads up to {VERSION}: install a newer one here first"
        )
        raise LotInputError("version", words)
    try:
        document = SurveyDocument.model_validate_json(plain, strict=True)
    except ValidationError as error:
        wrong = wrong_values(error, forms=_FORMS)[0]
        raise LotInputError(wrong.field or "document", wrong.reason) from None
    _check(document)
    return document


def digest_of(part: Part) -> str:
    """Return the SHA-256 of a part: of two states with one number the one with the greater digest counts."""
    return hashlib.sha256(part.model_dump_json().encode()).hexdigest()


def _plain(data: bytes) -> bytes:
    if len(data) > LARGEST_BYTES:
        raise LotInputError("document", f"is too large: {LARGEST_BYTES // 1_000_000} MB are read at most")
    unpack = zlib.decompressobj(wbits=31)
    try:
        plain = unpack.decompress(data, LARGEST_UNPACKED_BYTES + 1)
    except zlib.error as error:
        raise LotInputError("document", f"cannot be unpacked: {error}. Send it again, packed by gzip") from None
    if len(plain) > LARGEST_UNPACKED_BYTES:
        most = LARGEST_UNPACKED_BYTES // 1_000_000
        raise LotInputError("document", f"is too large: it unpacks to more than {most} MB")
    if not unpack.eof or unpack.unused_data:
        raise LotInputError("document", "is cut, or longer than one document: send it again")
    return plain


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
    keys: dict[str, list[Any]] = {
        "stalls": [each.id for each in document.stalls],
        "looks": [each.stall for each in document.looks],
        "sections": [each.section for each in document.sections],
        "lots": [each.id for each in document.lots],
        "mosaic": [(each.row, each.column) for each in document.mosaic],
    }
    for number, lot in enumerate(document.lots):
        named = f"lots[{number}]"
        keys |= {
            f"{named}.layouts": [each.version for each in lot.layouts],
            f"{named}.stalls": [each.id for each in lot.stalls],
            f"{named}.former": [(each.stall, each.ends) for each in lot.former],
            f"{named}.zones": [each.id for each in lot.zones],
        }
        if {each.stall for each in lot.former} - {each.id for each in lot.stalls}:
            raise LotInputError(f"{named}.former", "must name stalls of the lot")
        if lot.merged_into is not None and lot.merged_into not in lots:
            raise LotInputError(f"{named}.merged_into", "must be the id of one of the lots of the document")
    for name, found in keys.items():
        if len(set(found)) < len(found):
            raise LotInputError(name, "names one of them twice: send each once")
    for number, tile in enumerate(document.mosaic):
        if _size(tile.jpeg) != (TILE_CELLS, TILE_CELLS):
            raise LotInputError(f"mosaic[{number}].jpeg", f"must be a JPEG of {TILE_CELLS} x {TILE_CELLS} pixels")


def _size(jpeg: bytes) -> tuple[int, int] | None:
    """Return width and height of a JPEG, by its head alone: nothing is unpacked."""
    try:
        return jpeg_size(jpeg)
    except ValueError:
        return None

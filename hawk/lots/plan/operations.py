"""Operations on a plan as the API takes them, one model each; ``do`` names it.

Places are [north, east], metres in the lot's frame; angles are radians, clockwise from north.
"""

from __future__ import annotations

import math
from typing import Annotated, Final, Literal, Self, get_args

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, TypeAdapter, ValidationError, model_validator

from hawk.formats.validation import FieldError, wrong_values
from hawk.lots.plan.kinds import Kind
from hawk.lots.plan.values import SectionKind
from hawk.lots.values import LotInputError

FARTHEST_M: Final = 20_000.0
"""Places farther from the lot's datum do not belong to the lot."""
WIDTHS_M: Final = (0.5, 10.0)
LENGTHS_M: Final = (0.5, 25.0)
MOST_STALLS: Final = 1000
"""Stalls that one operation names, and that one row has."""
MOST_CORNERS: Final = 100
LONGEST_LABEL: Final = 20
"""Characters of an owner's label."""
STEEPEST: Final = math.radians(65)
"""Lean of the stalls of an angled row: at 65° they stand at 25° to the aisle."""


def _tidy(label: str) -> str:
    found = " ".join(label.split())
    if not found or not found.isprintable():
        raise ValueError("is empty or holds characters that cannot be shown: write letters and digits")
    return found


Metres = Annotated[float, Field(allow_inf_nan=False, ge=-FARTHEST_M, le=FARTHEST_M)]
Radians = Annotated[float, Field(allow_inf_nan=False, ge=-2 * math.pi, le=2 * math.pi)]
Width = Annotated[float, Field(allow_inf_nan=False, ge=WIDTHS_M[0], le=WIDTHS_M[1])]
Length = Annotated[float, Field(allow_inf_nan=False, ge=LENGTHS_M[0], le=LENGTHS_M[1])]
Place = Annotated[tuple[Metres, Metres], Field(strict=False)]
Id = Annotated[str, Field(min_length=1, max_length=36)]
Label = Annotated[str, Field(max_length=LONGEST_LABEL), AfterValidator(_tidy)]
LONGEST_ROW: Final = 12
"""Characters of a row's name: a number follows it in a label."""
RowName = Annotated[str, Field(max_length=LONGEST_ROW), AfterValidator(_tidy)]


class Asked(BaseModel):
    """An operation."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, regex_engine="python-re")


class AddStall(Asked):
    """Adds a stall by its middle. Without a ``label`` it gets the next one of the row that it joins."""

    do: Literal["add_stall"]
    north: Metres
    east: Metres
    angle: Radians
    width: Width
    length: Length
    kind: Kind = ""
    label: Label | None = None

    @model_validator(mode="after")
    def _is_long(self) -> Self:
        if self.width > self.length:
            raise FieldError("width", "is more than the length: exchange both, and turn the angle by 90°")
        return self


class AddRow(Asked):
    """Adds a row: its ``front`` from end to end, and a place on its far side.

    The count is ``count``, else the one whose pitch is nearest to ``pitch``, else to the lot's own. ``lean``: radians
    by which the stalls lean towards the second end of the front. ``parallel``: cars stand along the front. ``double``:
    two rows back to back; the far side is the front of the second one.
    """

    do: Literal["add_row"]
    front: Annotated[tuple[Place, Place], Field(strict=False)]
    far: Place
    count: Annotated[int, Field(ge=1, le=MOST_STALLS)] | None = None
    pitch: Annotated[float, Field(allow_inf_nan=False, ge=WIDTHS_M[0], le=LENGTHS_M[1])] | None = None
    lean: Annotated[float, Field(allow_inf_nan=False, ge=-STEEPEST, le=STEEPEST)] = 0.0
    parallel: bool = False
    double: bool = False
    kind: Kind = ""

    @model_validator(mode="after")
    def _is_one_row(self) -> Self:
        if self.count is not None and self.pitch is not None:
            raise FieldError("pitch", "follows from the count: leave one of both out")
        if self.parallel and self.lean:
            raise FieldError("lean", "must be left out: a parallel row does not lean")
        return self


class Selecting(Asked):
    """An operation on stalls: those with the ids ``stalls``, those of the ``row`` with a name, or ``all``."""

    stalls: Annotated[list[Id], Field(min_length=1, max_length=MOST_STALLS)] | None = None
    row: RowName | None = None
    every: Annotated[bool, Field(alias="all")] = False

    @model_validator(mode="after")
    def _is_one_selection(self) -> Self:
        if (self.stalls is not None) + (self.row is not None) + self.every != 1:
            raise FieldError("stalls", 'names no stalls, or twice: write ids, "row" with its name, or "all": true')
        if self.stalls is not None and len(set(self.stalls)) < len(self.stalls):
            raise FieldError("stalls", "names a stall twice: name each once")
        return self


class Remove(Selecting):
    """Removes stalls."""

    do: Literal["remove"]


class Move(Selecting):
    """Moves stalls."""

    do: Literal["move"]
    north: Metres
    east: Metres


class Turn(Selecting):
    """Turns stalls ``by`` an angle, about the ``middle`` of all, or ``each`` about its own."""

    do: Literal["turn"]
    by: Radians
    about: Literal["middle", "each"] = "middle"


class Widen(Selecting):
    """Gives stalls another width or length, or both, about their middles."""

    do: Literal["widen"]
    width: Width | None = None
    length: Length | None = None

    @model_validator(mode="after")
    def _is_size(self) -> Self:
        if self.width is None and self.length is None:
            raise FieldError("width", "is missing: write a width, a length, or both")
        return self


class SetKind(Selecting):
    """Sets the kind of stalls."""

    do: Literal["set_kind"]
    kind: Kind


class Confirm(Selecting):
    """Confirms stalls: they are where the plan has them, and their labels as painted."""

    do: Literal["confirm"]


class LabelChange(Selecting):
    """An operation on the labels of stalls. Labels that hawk gave, and no person confirmed, yield to them."""

    @model_validator(mode="after")
    def _is_some(self) -> Self:
        if self.every:
            raise FieldError("all", "has no order: name the stalls, or a row")
        return self


class Renumber(LabelChange):
    """Gives stalls other labels, in the order of ``stalls``, else in that of their numbers.

    They are those of the row ``letter`` with numbers from ``first`` on, or the owner's own ``labels``.
    """

    do: Literal["renumber"]
    letter: RowName | None = None
    first: Annotated[int, Field(ge=0, le=99_999)] = 1
    labels: Annotated[list[Label], Field(min_length=1, max_length=MOST_STALLS)] | None = None

    @model_validator(mode="after")
    def _is_one_numbering(self) -> Self:
        if (self.letter is None) == (self.labels is None):
            raise FieldError("letter", "and labels are both there or both missing: write one of them")
        if self.labels is not None and len(set(self.labels)) < len(self.labels):
            raise FieldError("labels", "holds a label twice: write each once")
        return self


class Rename(LabelChange):
    """Gives a row the name ``to``; its numbers stay."""

    do: Literal["rename"]
    to: RowName


class Reverse(LabelChange):
    """Numbers a row from its other end; its labels stay the same ones."""

    do: Literal["reverse"]


class Shift(LabelChange):
    """Adds ``by`` to the numbers of stalls."""

    do: Literal["shift"]
    by: Annotated[int, Field(ge=-99_999, le=99_999)]


class Swap(Asked):
    """Exchanges the names of two ``rows``; their numbers stay."""

    do: Literal["swap"]
    rows: Annotated[tuple[RowName, RowName], Field(strict=False)]

    @model_validator(mode="after")
    def _are_two(self) -> Self:
        if self.rows[0] == self.rows[1]:
            raise FieldError("rows", "names a row twice: name two rows")
        return self


class Split(Asked):
    """Splits a stall into ``parts`` beside each other. The first one keeps its id and label."""

    do: Literal["split"]
    stall: Id
    parts: Annotated[int, Field(ge=2, le=20)]


class Forbid(Asked):
    """Makes an area without stalls; those whose middle is in it are removed. Pictures leave ``private`` ground out."""

    do: Literal["forbid"]
    outline: Annotated[list[Place], Field(min_length=3, max_length=MOST_CORNERS)]
    name: Annotated[str, Field(max_length=80)] = ""
    private: bool = False


class Allow(Asked):
    """Removes an area without stalls."""

    do: Literal["allow"]
    zone: Id


class DrawZone(Asked):
    """Draws a zone with a ``name``: statistics count the stalls whose middle is in it together.

    ``kind``: whom its stalls are for. No stall changes.
    """

    do: Literal["draw_zone"]
    outline: Annotated[list[Place], Field(min_length=3, max_length=MOST_CORNERS)]
    name: Annotated[str, Field(max_length=80), AfterValidator(_tidy)]
    kind: Kind = ""


class EraseZone(Asked):
    """Removes a zone with a name. Its stalls stay."""

    do: Literal["erase_zone"]
    zone: Id


LONGEST_NOTE: Final = 200
"""Characters of the words about a section."""
MOST_PLACES: Final = 10_000
"""Capacity of one section."""
STRIP_WIDTHS_M: Final = (1.0, 40.0)
PLACE_LENGTHS_M: Final = (1.0, 30.0)
"""Metres of kerb for one vehicle."""


def _tidy_note(note: str) -> str:
    return _tidy(note) if note.strip() else ""


SectionName = Annotated[str, Field(max_length=80), AfterValidator(_tidy)]
Note = Annotated[str, Field(max_length=LONGEST_NOTE), AfterValidator(_tidy_note)]
Capacity = Annotated[int, Field(ge=1, le=MOST_PLACES)]


class DrawSection(Asked):
    """Draws a section, whose parked vehicles are counted against its capacity. No stall changes.

    It is the strip on one ``side`` of a ``line``, as one goes along it, ``width`` metres wide, or an ``outline``. A
    ``capacity`` is a person's; without one it follows from the length along the kerb: one place every ``place_m``
    metres, else every 5.5 m where vehicles stand parallel to the kerb, every 2.5 m where they stand across it.
    """

    do: Literal["draw_section"]
    name: SectionName
    line: Annotated[list[Place], Field(min_length=2, max_length=MOST_CORNERS)] | None = None
    side: Literal["left", "right"] | None = None
    width: Annotated[float, Field(allow_inf_nan=False, ge=STRIP_WIDTHS_M[0], le=STRIP_WIDTHS_M[1])] | None = None
    outline: Annotated[list[Place], Field(min_length=3, max_length=MOST_CORNERS)] | None = None
    kind: SectionKind = ""
    capacity: Capacity | None = None
    place_m: Annotated[float, Field(allow_inf_nan=False, ge=PLACE_LENGTHS_M[0], le=PLACE_LENGTHS_M[1])] | None = None
    note: Note = ""

    @model_validator(mode="after")
    def _is_one_shape(self) -> Self:
        if (self.line is None) == (self.outline is None):
            raise FieldError("line", "and outline are both there or both missing: write one of them")
        for name in ("side", "width"):
            if self.line is not None and getattr(self, name) is None:
                raise FieldError(name, "is missing: a line has a side, left or right, and a width in metres")
            if self.line is None and getattr(self, name) is not None:
                raise FieldError(name, "belongs to a line: leave it out beside an outline")
        if self.capacity is not None and self.place_m is not None:
            raise FieldError("place_m", "makes the capacity: leave one of both out")
        return self


class ChangeSection(Asked):
    """Changes what is said of a section; what is left out stays.

    ``capacity``: null takes a person's away: it follows from the length again.
    """

    do: Literal["change_section"]
    section: Id
    name: SectionName | None = None
    kind: SectionKind | None = None
    capacity: Capacity | None = None
    note: Note | None = None


class RemoveSection(Asked):
    """Removes a section. Stalls on it stay."""

    do: Literal["remove_section"]
    section: Id


Operation = (
    AddStall | AddRow | Remove | Move | Turn | Widen | SetKind | Confirm | Renumber | Rename | Reverse | Shift | Swap
    | Split | Forbid | Allow | DrawZone | EraseZone | DrawSection | ChangeSection | RemoveSection
)  # fmt: skip
OPERATIONS: Final[tuple[type[Asked], ...]] = get_args(Operation)
"""Models of all operations."""
NAMES: Final = tuple(get_args(each.model_fields["do"].annotation)[0] for each in OPERATIONS)
"""Names of all operations."""
_OPERATION: Final[TypeAdapter[Operation]] = TypeAdapter(Annotated[Operation, Field(discriminator="do")])


def operation_of(given: object) -> Operation:
    """Return the operation of a JSON value. Raises LotInputError with the field and the remedy."""
    if not isinstance(given, dict):
        raise LotInputError("operation", f"must be an object with do: {', '.join(NAMES)}")
    try:
        return _OPERATION.validate_python(given)
    except ValidationError as error:
        wrong = wrong_values(error, tags=NAMES)[0]
        raise LotInputError(wrong.field or "operation", wrong.reason) from None

"""Values and checks that documents of surveys and lots share, and the form in which they travel: JSON, packed by gzip.

One declaration is the value inside, the check at the edge and the schema of the API. A name of a column of the store is
the name here. Lengths are metres, angles radians clockwise from north, times UTC in Unix seconds, places on Earth
degrees of WGS-84, latitude first.
"""

from __future__ import annotations

import gzip
import hashlib
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Final, TypeVar, get_args

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError
from pydantic_core import from_json

from hawk.formats.validation import LONGEST_FIELD, PLAIN, wrong_values
from hawk.lots.values import LONGEST_NAME, FormatVersionError, LotInputError, is_shown

P = TypeVar("P", bound="Part")
LARGEST_BYTES: Final = 32_000_000
"""Of a packed document: the picture of 20 ha is 16 MB of it."""
LARGEST_UNPACKED_BYTES: Final = 96_000_000
MOST_VALUES: Final = 3_000_000
MOST_GROUPS: Final = 500_000
"""Lists and objects of a document: each takes half a kilobyte of memory while it is read, however few bytes it has. A
survey of 50,000 stalls with its plan has 150,000 of them, and 1,550,000 values."""
MOST: Final = 50_000
"""Stalls, looks or rows of a table of a plan."""
_UUID: Final = "^[0-9a-f]{8}-[0-9a-f]{4}-[0-9a-f]{4}-[0-9a-f]{4}-[0-9a-f]{12}$"
_HEX: Final = "must be a UUID in lower case, as 123e4567-e89b-42d3-a456-426614174000"
_FORMS: Final = {_UUID: _HEX}
LARGEST_WHOLE: Final = 2**53
"""Whole numbers above are not the same in every program that reads JSON (RFC 8259, 6)."""
_LATEST_S: Final = 9_999_999_999.0
"""In the year 2286."""
FARTHEST_M: Final = 1e6


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
Metres = Annotated[float, Field(ge=-FARTHEST_M, le=FARTHEST_M, allow_inf_nan=False)]
Angle = Annotated[float, Field(ge=-100, le=100, allow_inf_nan=False, description="radians")]
Side = Annotated[float, Field(gt=0, le=100, allow_inf_nan=False, description="metres")]
Share = Annotated[float, Field(ge=0, le=1, allow_inf_nan=False)]
Moment = Annotated[float, Field(ge=0, le=_LATEST_S, allow_inf_nan=False, description="UTC, Unix seconds")]
Whole = Annotated[int, Field(ge=0, le=LARGEST_WHOLE)]
Version = Annotated[int, Field(ge=1, le=1_000_000)]
Latitude = Annotated[float, Field(ge=-90, le=90, allow_inf_nan=False)]
Longitude = Annotated[float, Field(ge=-180, le=180, allow_inf_nan=False)]
Ring = Annotated[tuple[tuple[Metres, Metres], ...], Field(fail_fast=True, min_length=3, max_length=10_000)]
EarthRing = Annotated[tuple[tuple[Latitude, Longitude], ...], Field(fail_fast=True, min_length=3, max_length=100_000)]
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

    polygons: Annotated[tuple[EarthRing, ...], Field(fail_fast=True, max_length=10_000)] = ()
    holes: Annotated[tuple[EarthRing, ...], Field(fail_fast=True, max_length=10_000)] = ()


def packed(document: Part) -> bytes:
    """Return a document as it travels; the same bytes each time."""
    return gzip.compress(document.model_dump_json().encode(), 6, mtime=0)


def read_document(data: bytes, form: type[P], named: str, newest: int) -> P:
    """Return the document of `packed`, of any version that was ever written.

    Args:
        data: The bytes.
        form: The document's.
        named: Its ``format``.
        newest: Version of documents that are written.

    Raises LotInputError with the field: for a document that is cut or too large, and for a value that cannot be;
    FormatVersionError for one of a newer version.
    """
    plain = _plain(data)
    if plain.count(b",") > MOST_VALUES or plain.count(b"[") + plain.count(b"{") > MOST_GROUPS:
        words = f"is too large: {MOST_VALUES:,} values, and {MOST_GROUPS:,} lists and objects, are read at most"
        raise LotInputError("document", words)
    try:
        found = from_json(plain, allow_inf_nan=False)
    except ValueError as error:
        raise LotInputError("document", f"is no JSON: {error}. Send the document again") from None
    if not isinstance(found, dict) or found.get("format") != named:
        raise LotInputError("format", f'must be "{named}": send such a document')
    version = found.get("version")
    if type(version) is not int or version < 1:
        raise LotInputError("version", "must be a whole number from 1")
    if version > newest:
        raise FormatVersionError(version, newest)
    _check_names(form, found)
    del found  # a large document is in memory once
    try:
        return form.model_validate_json(plain, strict=True)
    except ValidationError as error:
        wrong = wrong_values(error, forms=_FORMS)[0]
        raise LotInputError(wrong.field or "document", wrong.reason) from None


def check_single(named: str, keys: Sequence[object]) -> None:
    """Refuse a list that names one of its parts twice. Raises LotInputError."""
    if len(set(keys)) < len(keys):
        raise LotInputError(named, "names one of them twice: send each once")


def digest_of(part: Part) -> str:
    """Return the SHA-256 of a part: of two states with one number the one with the greater digest counts."""
    return hashlib.sha256(part.model_dump_json().encode()).hexdigest()


def _check_names(form: type[Part], found: object, field: str = "") -> None:
    """Refuse an object that lacks a value, or has another one. Pydantic has an error for each, and copies the whole
    object into that of one that is missing: a file of some kilobytes takes gigabytes then.
    """
    if not isinstance(found, dict):
        return
    names = _names_in(form)
    for name in found.keys() - names.known:
        raise LotInputError(f"{field}{name}"[:LONGEST_FIELD], PLAIN["extra_forbidden"])
    for name in (each for each in names.required if each not in found):
        raise LotInputError(f"{field}{name}", PLAIN["missing"])
    for name, inner in names.parts.items():
        given = found.get(name)
        for number, each in enumerate(given if isinstance(given, list) else [given]):
            _check_names(inner, each, f"{field}{name}{f'[{number}]' * isinstance(given, list)}.")


@dataclass(frozen=True, slots=True)
class _Names:
    """Names of a part's fields; ``parts``: those that hold parts, or lists of them, with the form of these."""

    known: frozenset[str]
    required: tuple[str, ...]
    parts: Mapping[str, type[Part]]


@lru_cache
def _names_in(form: type[Part]) -> _Names:
    fields = form.model_fields
    held = {name: _part_of(known.annotation) for name, known in fields.items()}
    required = tuple(name for name, known in fields.items() if known.is_required())
    return _Names(frozenset(fields), required, {name: part for name, part in held.items() if part is not None})


def _part_of(annotation: object) -> type[Part] | None:
    if isinstance(annotation, type) and issubclass(annotation, Part):
        return annotation
    return next((found for each in get_args(annotation) if (found := _part_of(each)) is not None), None)


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

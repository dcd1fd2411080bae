"""Payloads of a recording: what it shows to viewers, and JSON and frames with their picture as bytes."""

from __future__ import annotations

import json
import struct
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field, fields, is_dataclass
from functools import cache
from typing import Any, Final, TypeVar, cast

from pydantic import ConfigDict, TypeAdapter, ValidationError

from hawk.model.lot_map import Stall
from hawk.model.operation import Level
from hawk.model.poses import GlobalPose, VehiclePose

FRAME_INPUT: Final = "frame_input"
"""Topic of the frames of the algorithms."""
T = TypeVar("T")
_LENGTH = struct.Struct("<I")
_PICTURE = "jpeg"
_FINITE = TypeAdapter[Any](Any, config=ConfigDict(ser_json_inf_nan="strings"))


class FrameFormatError(ValueError):
    """Bytes that are no frame; the text says what is wrong."""


def encode_frame(frame: Any) -> bytes:
    """Return a dataclass with a ``jpeg: bytes`` field as bytes. Raises TypeError for anything else."""
    values, picture = parts_of(frame)
    return join_frame(json.dumps(values, default=to_plain, separators=(",", ":")).encode(), picture)


def parts_of(frame: Any) -> tuple[dict[str, Any], bytes]:
    """Return a frame's fields without its picture, and the picture. Raises TypeError for what is no frame."""
    if not is_dataclass(frame) or isinstance(frame, type) or not isinstance(getattr(frame, _PICTURE, None), bytes):
        raise TypeError(f"{type(frame).__name__} is no dataclass with a {_PICTURE} field of bytes")
    values = field_values(frame)
    return values, values.pop(_PICTURE)


def join_frame(header: bytes, picture: bytes) -> bytes:
    """Return the bytes of `encode_frame` for its fields as JSON and its picture."""
    return b"".join((_LENGTH.pack(len(header)), header, picture))


def decode_frame(
    data: bytes, kind: type[T], renewed: Callable[[dict[str, Any]], dict[str, Any]] = lambda values: values
) -> T:
    """Return the dataclass of `encode_frame`, equal to the one that went in. Raises FrameFormatError.

    ``renewed`` returns the fields of an earlier version as those of this one.
    """
    if len(data) < _LENGTH.size:
        raise FrameFormatError("the frame has no header")
    (length,) = _LENGTH.unpack_from(data)
    end = _LENGTH.size + length
    if end > len(data):
        raise FrameFormatError(f"the frame's header has {length} bytes, only {len(data) - _LENGTH.size} are there")
    try:
        values = renewed(json.loads(data[_LENGTH.size : end]))
        frame: T = _adapter(cast("Hashable", kind)).validate_python({**values, _PICTURE: data[end:]})
        return frame
    except (ValidationError, ValueError, TypeError) as error:
        raise FrameFormatError(f"the frame is no {kind.__name__}: {error}") from error


@cache
def _adapter(kind: Any) -> TypeAdapter[Any]:
    return TypeAdapter(kind)


def picture_of(data: bytes) -> bytes:
    """Return the picture of `encode_frame` alone. Raises FrameFormatError."""
    return data[_header_end(data) :]


def values_of(data: bytes) -> dict[str, Any]:
    """Return the fields of `encode_frame` without the picture, as JSON keeps them. Raises FrameFormatError."""
    end = _header_end(data)
    try:
        values = json.loads(data[_LENGTH.size : end])
    except ValueError as error:
        raise FrameFormatError(f"the frame's header is not JSON: {error}") from error
    if not isinstance(values, dict):
        raise FrameFormatError("the frame's header is no object")
    return values


def _header_end(data: bytes) -> int:
    if len(data) < _LENGTH.size or (end := _LENGTH.size + _LENGTH.unpack_from(data)[0]) > len(data):
        raise FrameFormatError("the frame's header is torn")
    return int(end)


def to_json(payload: Any) -> str:
    """Return a payload as JSON. JSON has no infinity: such numbers become "Infinity", "-Infinity" or "NaN"."""
    try:
        return json.dumps(payload, default=to_plain, separators=(",", ":"), allow_nan=False)
    except ValueError:
        return _FINITE.dump_json(json.loads(json.dumps(payload, default=to_plain))).decode()


@cache
def field_names(kind: Any) -> tuple[str, ...]:
    """Return the names of a dataclass's fields in their order: found once, a recording needs them for each value."""
    return tuple(item.name for item in fields(kind))


def field_values(value: Any) -> dict[str, Any]:
    """Return the fields of a dataclass by name; `dataclasses.asdict` would copy what is within."""
    kind: Any = type(value)
    return {name: getattr(value, name) for name in field_names(kind)}


def to_plain(value: Any) -> Any:
    """Return what JSON can hold of a dataclass, array scalar, set or path; for ``json.dumps(default=...)``."""
    if is_dataclass(value) and not isinstance(value, type):
        return field_values(value)
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, bytes):
        return f"<{len(value)} bytes>"
    if isinstance(value, set | frozenset):
        return sorted(value, key=str)
    return str(value)


@dataclass(frozen=True, slots=True)
class Words:
    """A message for the operator."""

    level: Level
    text: str
    details: str = ""


@dataclass(frozen=True, slots=True)
class MapStalls:
    """The stalls of a map, and the WGS-84 place of its origin."""

    datum: GlobalPose
    stalls: Mapping[int, Stall] = field(repr=False)


View = VehiclePose | Words | MapStalls

"""Words for what pydantic refuses: by the name and the facts of an error, never by its English.

A reason stands behind the name of the field: "width: must be a number". It says the remedy.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Final, get_args

from pydantic import BaseModel, ValidationError

LONGEST_FIELD: Final = 80
"""Characters of a field's name that are repeated: a stranger may have chosen it."""
_NUMBER: Final = "must be a number"
_WHOLE: Final = "must be a whole number"
_TEXT: Final = "must be text"
_LIST: Final = "must be a list"
_OBJECT: Final = "must be an object with named values"
_OTHERWISE: Final = "cannot be used here"
PLAIN: Final[Mapping[str, str]] = {
    "missing": "is missing: write it",
    "extra_forbidden": "is not known here: leave it out",
    "string_type": _TEXT,
    "string_unicode": "must be text in UTF-8",
    "bool_type": "must be true or false",
    "bool_parsing": "must be true or false",
    "int_type": _WHOLE,
    "int_parsing": _WHOLE,
    "int_from_float": _WHOLE,
    "int_parsing_size": "has too many digits",
    "float_type": _NUMBER,
    "float_parsing": _NUMBER,
    "finite_number": "must be a finite number",
    "list_type": _LIST,
    "tuple_type": _LIST,
    "set_type": _LIST,
    "frozen_set_type": _LIST,
    "iterable_type": _LIST,
    "dict_type": _OBJECT,
    "mapping_type": _OBJECT,
    "model_type": _OBJECT,
    "model_attributes_type": _OBJECT,
    "dataclass_type": _OBJECT,
    "none_required": "must be null: leave it out",
    "path_type": "must be the path of a file",
    "json_invalid": "is no JSON: look for a comma or a bracket too many",
    "json_type": "must be JSON text",
    "recursion_loop": "holds itself: write it once",
    "datetime_type": "must be a time, as 2026-05-04T10:30:00Z",
    "timezone_aware": "must have its offset, as 2026-05-04T10:30:00+02:00",
    "datetime_parsing": "must be a time, as 2026-05-04T10:30:00Z",
    "datetime_from_date_parsing": "must be a time, as 2026-05-04T10:30:00Z",
}
"""Pydantic's name of an error -> reason."""
BOUNDED: Final[Mapping[str, tuple[str, str]]] = {
    "greater_than": ("gt", "must be more than {}"),
    "greater_than_equal": ("ge", "must be {} or more"),
    "less_than": ("lt", "must be less than {}"),
    "less_than_equal": ("le", "must be {} or less"),
    "multiple_of": ("multiple_of", "must be a multiple of {}"),
    "too_short": ("min_length", "must be a list of {} or more"),
    "too_long": ("max_length", "must be a list of {} or fewer"),
    "string_too_short": ("min_length", "must have {} or more characters"),
    "string_too_long": ("max_length", "must have {} or fewer characters"),
    "string_pattern_mismatch": ("pattern", "must have the form {}"),
    "literal_error": ("expected", "must be {}"),
    "enum": ("expected", "must be {}"),
    "is_instance_of": ("class", "must be a {}"),
    "union_tag_invalid": ("expected_tags", "must be {}"),
}
"""The same for an error with a limit: its name among the facts, and the reason around it."""


class FieldError(ValueError):
    """A problem of one ``field`` that a model finds as a whole; the text is the reason."""

    def __init__(self, field: str, reason: str) -> None:
        super().__init__(reason)
        self.field = field


@dataclass(frozen=True, slots=True)
class WrongValue:
    """A value that a model refuses. ``kind``: pydantic's name of the error; ``given``: the value."""

    location: tuple[int | str, ...]
    kind: str
    reason: str
    given: Any

    @property
    def field(self) -> str:
        """The field as it is written in JSON: "outline[0].to"; "" for the whole."""
        text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in self.location)
        return text.removeprefix(".")[:LONGEST_FIELD]

    @property
    def path(self) -> str:
        """The field with dots alone: "outline.0.to"."""
        return ".".join(map(str, self.location))[:LONGEST_FIELD]


def wrong_values(
    error: ValidationError,
    model: type[BaseModel] | None = None,
    tags: Collection[str] = (),
    forms: Mapping[str, str] = MappingProxyType({}),
) -> list[WrongValue]:
    """Return what a model refuses, in its order.

    Args:
        error: Pydantic's.
        model: That which refused; with it a number out of bounds is reported with both.
        tags: Names of the members of unions, which pydantic puts among those of the fields.
        forms: Pattern of a text -> reason for a text that has not this form.
    """
    return [_wrong(each, model, tags, forms) for each in error.errors(include_url=False)]


def first_wrong(error: ValidationError, model: type[BaseModel] | None = None) -> str:
    """Return the first field that a model refuses, with its reason: "lens.0.model: is missing: write it"."""
    wrong = wrong_values(error, model)[0]
    return f"{wrong.path}: {wrong.reason}" if wrong.path else wrong.reason


def _wrong(
    found: Mapping[str, Any], model: type[BaseModel] | None, tags: Collection[str], forms: Mapping[str, str]
) -> WrongValue:  # fmt: skip
    kind, facts = found["type"], found.get("ctx", {})
    location = tuple(part for part in found["loc"] if part not in tags)
    cause = facts.get("error")
    if isinstance(cause, FieldError):
        location = (*location, cause.field)
    if kind.startswith("union_tag"):
        location = (*location, str(facts["discriminator"]).strip("'"))
    limits = _limits(model, location) if kind in ("greater_than_equal", "less_than_equal") else None
    reason = reason_of(kind, facts, forms) if limits is None else "must lie between {:.10g} and {:.10g}".format(*limits)
    return WrongValue(location, kind, reason, found["input"])


def reason_of(kind: str, facts: Mapping[str, Any], forms: Mapping[str, str] = MappingProxyType({})) -> str:
    """Return the reason of an error by pydantic's name of it and the facts that it gives."""
    if kind in ("value_error", "assertion_error"):
        return str(facts["error"])
    if kind == "union_tag_not_found":
        return PLAIN["missing"]
    if kind == "string_pattern_mismatch" and facts["pattern"] in forms:
        return forms[facts["pattern"]]
    if kind in BOUNDED:
        name, words = BOUNDED[kind]
        limit = facts[name]
        reason = words.format(f"{limit:.10g}" if isinstance(limit, float) else limit)
        count = facts.get("actual_length")
        return f"{reason}, not {count}" if count is not None else reason
    return PLAIN.get(kind, _OTHERWISE)


def _limits(model: type[BaseModel] | None, location: tuple[int | str, ...]) -> tuple[float, float] | None:
    """Return the lowest and the highest value of a model's number, both allowed; None where one of them is open."""
    if model is None or not location:
        return None
    name, *rest = location
    field = next((each for key, each in model.model_fields.items() if name in (key, each.alias)), None)
    if field is None:
        return None
    if rest:
        kinds = [each for each in (field.annotation, *get_args(field.annotation)) if isinstance(each, type)]
        inner = next((each for each in kinds if issubclass(each, BaseModel)), None)
        return _limits(inner, tuple(rest))
    found = [*field.metadata]
    for part in get_args(field.annotation):
        found += [limit for each in get_args(part)[1:] for limit in getattr(each, "metadata", [each])]
    lowest = next((each.ge for each in found if hasattr(each, "ge")), None)
    highest = next((each.le for each in found if hasattr(each, "le")), None)
    return None if lowest is None or highest is None else (float(lowest), float(highest))

"""Base classes of every message, and the numbers in them."""

from __future__ import annotations

import math
import operator
from collections.abc import Iterator
from functools import cache
from typing import Annotated, Any, TypeVar, get_args

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ValidatorFunctionWrapHandler,
    WithJsonSchema,
    WrapValidator,
)

from hawk.model.sentences import Sentence, parts_of


def wire_key(name: str) -> str:
    """Return the JSON key of a field: its words capitalised, "pose_age" → "Pose Age"."""
    return " ".join(word.capitalize() for word in name.split("_"))


def _none_unless_finite(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value


Finite = Annotated[float, Field(allow_inf_nan=False)]
Known = Annotated[float | None, BeforeValidator(_none_unless_finite)]
"""A number, or None when it is not known: NaN and infinity become None."""
Metres = Annotated[float, Field(allow_inf_nan=False, ge=-10_000.0, le=10_000.0)]
Height = Annotated[float, Field(allow_inf_nan=False, gt=0.0, le=1_000.0)]


def _kept(value: Any, check: ValidatorFunctionWrapHandler) -> Any:
    return value if isinstance(value, Sentence) else check(value)


_WORDS = WrapValidator(_kept)
Words = Annotated[str, _WORDS, WithJsonSchema({"type": "string"})]
"""English text; a `Sentence` keeps its code and values."""


class Model(BaseModel):
    """Strict base: unknown keys are errors, numbers are numbers, every key is spelled by `wire_key`."""

    model_config = ConfigDict(extra="forbid", strict=True, populate_by_name=True, frozen=True, alias_generator=wire_key)


class Command(Model):
    """Base of the operator's messages; ``Id`` comes back in the Ack."""

    type: str
    id: Annotated[str, Field(max_length=64)] | int | None = None


class Outgoing(Model):
    """Base of the drone's messages."""

    def to_json(self) -> str:
        """Return the message as JSON."""
        return self.model_dump_json(by_alias=True)


class SentenceItem(Outgoing):
    """A sentence among the texts of a message: a program that has words of its own for the code shows those."""

    text: str
    """The text as it stands in the message."""
    code: str
    values: dict[str, str | int | float]
    """Values by name. A text that is itself a sentence of this message is listed as such."""

    @classmethod
    def of(cls, said: Sentence) -> SentenceItem:
        """Return the message's form of a sentence."""
        return cls(text=str(said), code=said.code, values=dict(said.values))


_Listed = Annotated[tuple[SentenceItem, ...], Field(exclude_if=operator.not_, json_schema_extra={"optional": True})]


class Spoken(Outgoing):
    """Base of the drone's messages with sentences of the program."""

    sentences: _Listed = ()
    """The sentences among the texts, each once; left out when there are none. Texts that others worded, such as the
    autopilot's, are not listed."""

    def to_json(self) -> str:
        """Return the message as JSON, its sentences listed."""
        return listed(self).model_dump_json(by_alias=True)


Message = TypeVar("Message", bound=Spoken)


def listed(message: Message) -> Message:
    """Return the message with its sentences listed; a `Spoken` within it lists its own."""
    found = {str(said): said for said in _said_in(message)}
    return message.model_copy(update={"sentences": tuple(map(SentenceItem.of, found.values()))}) if found else message


def _said_in(value: object) -> Iterator[Sentence]:
    match value:
        case Sentence():
            yield from parts_of(value)
        case BaseModel():
            for name in _worded(type(value)):
                yield from _said_in(getattr(value, name))
        case tuple() | list():
            for item in value:
                yield from _said_in(item)


@cache
def _worded(model: type[BaseModel]) -> tuple[str, ...]:
    """Return the fields of a message that may hold sentences: most are numbers, and routes are long."""
    return tuple(
        name
        for name, info in model.model_fields.items()
        if any(each is _WORDS for each in info.metadata) or _may_hold_words(info.annotation)
    )


def _may_hold_words(annotation: Any) -> bool:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return not issubclass(annotation, Spoken) and bool(_worded(annotation))
    return any(each is _WORDS or _may_hold_words(each) for each in _arguments(annotation))


def _arguments(annotation: Any) -> tuple[Any, ...]:
    return (*get_args(annotation), *getattr(annotation, "__metadata__", ()))

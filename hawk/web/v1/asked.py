"""Parameters of requests: read from the address, checked by pydantic, and refused with their name and the remedy."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Annotated, Any, Final, Generic, Literal, TypeVar

from aiohttp import web
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError

from hawk.lots.plan.kinds import Kind
from hawk.lots.values import LotInputError
from hawk.web.access.admission import TOKEN_PARAMETER

MOST_ITEMS: Final = 1000
USUAL_ITEMS: Final = 100
LONGEST_PLACE: Final = 36
"""Characters of a place in a list: those of an id."""
_LONGEST_NUMBER: Final = 9
_LONGEST_FIELD: Final = 80
_LONGEST_ZONE: Final = 64
_LONGEST_TIME: Final = 40


def _number(given: object) -> object:
    """Return the number of a text: digits alone, since pydantic takes "1_0" and " 10" as well."""
    if isinstance(given, str):
        if not (given.isascii() and given.isdecimal() and len(given) <= _LONGEST_NUMBER):
            raise ValueError("must be a whole number, 0 or more")
        return int(given)
    return given


OF_DIGITS: Final = BeforeValidator(_number)
"""Put behind the limits of a number: pydantic shows these in the schema as what they are then."""
Limit = Annotated[
    int, Field(ge=1, le=MOST_ITEMS, description=f"most items of the answer; {USUAL_ITEMS} without it"), OF_DIGITS
]  # fmt: skip
Place = Annotated[
    str,
    Field(
        min_length=1, max_length=LONGEST_PLACE, pattern=r"^[0-9A-Za-z.-]+$",
        description="`next` of the part before; the list begins behind it",
    ),
]  # fmt: skip
Id = Annotated[str, Field(pattern="^[0-9a-f-]{36}$")]
_TIME: Final = {"anyOf": [{"type": "string", "format": "date"}, {"type": "string", "format": "date-time"}]}


def _time(words: str) -> Any:
    return Field(min_length=1, max_length=_LONGEST_TIME, description=words, json_schema_extra=_as_time)


def _as_time(schema: dict[str, Any]) -> None:
    """Show a time as what it is: a date, or a date with a time."""
    description = schema["description"]
    schema.clear()
    schema.update(_TIME, description=description)


Begin = Annotated[str, _time("first day, or first moment; without an offset it is the clock's")]
End = Annotated[str, _time("last day, all of it, or the moment before which the period ends")]


class Query(BaseModel):
    """Parameters of an address. Another one than these is refused."""

    model_config = ConfigDict(extra="forbid", frozen=True, populate_by_name=True)


class Listed(Query):
    """The part of a list that is asked for."""

    limit: Limit = USUAL_ITEMS
    after: Place | None = None


class Period(Query):
    """A period by the clock of a time zone."""

    begin: Annotated[Begin | None, Field(alias="from")] = None
    end: Annotated[End | None, Field(alias="to")] = None
    time_zone: Annotated[
        str | None,
        Field(
            min_length=1, max_length=_LONGEST_ZONE,
            description="name of the clock, as Europe/Amsterdam; that of the drone's computer without it",
        ),
    ] = None  # fmt: skip


Order = Annotated[
    Literal["oldest", "newest"], Field(description="which surveys come first; the oldest ones without it")
]


class Surveys(Listed, Period):
    """Surveys that ended within a period."""

    order: Order = "oldest"
    placed: Annotated[
        Literal["first", "registered", "unregistered", "undecided", "nothing", "deleted"] | None,
        Field(description="relation of the survey to its lot's stalls; without it those that are not deleted"),
    ] = None


class Observations(Listed, Period):
    """Looks of surveys that ended within a period."""

    order: Order = "oldest"
    survey: Annotated[Id | None, Field(description="looks of this survey alone")] = None
    stall: Annotated[Id | None, Field(description="looks at this stall alone")] = None


class Stalls(Listed):
    """Stalls of a lot."""

    row: Annotated[str | None, Field(pattern="^[A-Z]{1,3}$", description="letter of the row")] = None
    kind: Annotated[Kind | None, Field(description="kind of the stalls, as in `stalls`")] = None
    state: Annotated[
        Literal["free", "taken", "unknown"] | None, Field(description="state at the last look at the stall")
    ] = None


class Statistics(Period):
    """Division of the figures of a period."""

    by: Annotated[
        Literal["hour", "row", "zone", "kind"] | None,
        Field(description="parts of the lot that are counted by themselves, beside the whole"),
    ] = None


class Between(Period):
    """Two surveys of a lot."""

    before: Annotated[Id, Field(description="the earlier survey")]
    after: Annotated[Id, Field(description="the later survey")]


Q = TypeVar("Q", bound=Query)
M = TypeVar("M", bound=BaseModel)


@dataclass(frozen=True, slots=True)
class Request(Generic[Q]):
    """A request without its connection: ``path`` holds the values of the address's fields, ``base`` is the address of
    this server as the client has it, without a last slash, ``now`` the time, UTC, Unix seconds.
    """

    path: Mapping[str, str]
    query: Q
    base: str
    now: float

    @property
    def id(self) -> str:
        """The id in the address."""
        return self.path["id"]


def query_of(request: web.Request, model: type[Q]) -> Q:
    """Return the parameters of an address. Raises LotInputError with the parameter and the remedy."""
    given: dict[str, str] = {}
    for name, value in request.query.items():
        if name == TOKEN_PARAMETER:
            continue
        if name in given:
            raise LotInputError(name, "is there twice: write it once")
        given[name] = value
    return validated(model.model_validate, given, names_of(model), ranges=_ranges(model))


def _ranges(model: type[BaseModel]) -> dict[str, str]:
    """Return words for the allowed values of each whole number of a model."""
    found = {}
    for name, field in model.model_fields.items():
        least = next((each.ge for each in field.metadata if hasattr(each, "ge")), None)
        most = next((each.le for each in field.metadata if hasattr(each, "le")), 10**_LONGEST_NUMBER - 1)
        if least is not None:
            found[field.alias or name] = f"must be a whole number, {least} to {most}"
    return found


def validated(
    validate: Callable[[Any], M],
    given: Any,
    names: str,
    tags: Collection[str] = (),
    ranges: Mapping[str, str] = MappingProxyType({}),
) -> M:
    """Return what a model makes of values. Raises LotInputError with the first field that cannot be used.

    ``names``: those that there are, for the words about another one. ``tags``: names of models, which pydantic puts
    among those of the fields. ``ranges``: words for a field that is a number, in place of pydantic's.
    """
    try:
        return validate(given)
    except ValidationError as error:
        problem = error.errors(include_url=False)[0]
        parts = [part for part in problem["loc"] if part not in tags]
        field = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in parts).removeprefix(".")
        raise LotInputError(field[:_LONGEST_FIELD] or "body", ranges.get(field) or _reason(problem, names)) from None


def names_of(model: type[BaseModel]) -> str:
    """Return the names of a model's fields, for a sentence."""
    return ", ".join(field.alias or name for name, field in model.model_fields.items()) or "no parameter"


def _reason(problem: Any, names: str) -> str:
    kind, context = problem["type"], problem.get("ctx", {})
    if kind == "extra_forbidden":
        return f"is not known here: leave it out; there is {names}"
    if kind == "value_error":
        return str(context["error"])
    if kind == "missing":
        return "is missing: write it"
    words = str(problem["msg"]).removeprefix("Input should be ").removeprefix("String should ")
    return (
        f"must be {words}" if words != problem["msg"] and not words.startswith(("have", "match")) else f"should {words}"
    )

"""Parameters of requests: read from the address, checked by pydantic, and refused with their name and the remedy."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Annotated, Any, Final, Generic, Literal, TypeVar

from aiohttp import web
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError

from hawk.exports.formats import VALID_S
from hawk.formats.validation import wrong_values
from hawk.lots.documents.arrival import OutcomeName
from hawk.lots.plan.kinds import Kind
from hawk.lots.plan.operations import LONGEST_ROW
from hawk.lots.plan.values import ID
from hawk.lots.values import LONGEST_NAME, LONGEST_ZONE, LotInputError
from hawk.report.options import MOST_LOTS, Language, Paper
from hawk.stats.partition import Partition
from hawk.web.access.admission import TOKEN_PARAMETER

MOST_ITEMS: Final = 1000
MOST_DAYS: Final = 62
USUAL_ITEMS: Final = 100
LONGEST_PLACE: Final = 36
"""Characters of a place in a list: those of an id."""
_LONGEST_NUMBER: Final = 9
_LONGEST_TIME: Final = 40
_LONGEST_LIST: Final = 100
_MOST_PARTS: Final = 100
AGAIN: Final = "x-again"
"""Mark of a parameter that may be there more than once; `hawk.web.v1.openapi` reads it."""


_PLACE: Final = "^[0-9A-Za-z.-]+$"


def _number(given: object) -> object:
    """Return the number of a text: digits alone, since pydantic takes "1_0" and " 10" as well."""
    if isinstance(given, str):
        if not (given.isascii() and given.isdecimal() and len(given) <= _LONGEST_NUMBER):
            raise ValueError("must be a whole number: write digits alone")
        return int(given)
    return given


OF_DIGITS: Final = BeforeValidator(_number)
"""Put behind the limits of a number: pydantic shows these in the schema as what they are then."""
Whole = Annotated[int, Field(ge=0), OF_DIGITS]
Limit = Annotated[
    int, Field(ge=1, le=MOST_ITEMS, description=f"most items of the answer; {USUAL_ITEMS} without it"), OF_DIGITS
]  # fmt: skip
Place = Annotated[
    str,
    Field(
        min_length=1, max_length=LONGEST_PLACE, pattern=_PLACE,
        description="`next` of the part before; the list begins behind it",
    ),
]  # fmt: skip
Id = Annotated[str, Field(pattern=ID)]
FORMS: Final[Mapping[str, str]] = {
    ID: "must be an id, 36 characters, as the lists have it",
    _PLACE: "is no place in this list: write `next` of the part before, or leave it out",
}
"""Pattern of a text -> reason for one that has not this form."""
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


class ChangedLots(Query):
    """States of lots that are asked for."""

    after: Annotated[int, Field(ge=0, description="`state` of the document before; without it all lots"), OF_DIGITS] = 0
    limit: Annotated[int, Field(ge=1, le=100, description="most lots of the answer; 10 without it"), OF_DIGITS] = 10
    seen: Annotated[bool, Field(description="true: lots alone that the drone of the token has sent")] = False


class Period(Query):
    """A period by the clock of a time zone."""

    begin: Annotated[Begin | None, Field(alias="from")] = None
    end: Annotated[End | None, Field(alias="to")] = None
    time_zone: Annotated[
        str | None,
        Field(
            min_length=1, max_length=LONGEST_ZONE,
            description="name of the clock, as Europe/Amsterdam; the lot's without it, UTC for surveys of all lots",
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


class Changes(Listed):
    """Changes that persons made."""

    lot: Annotated[Id | None, Field(description="changes of this lot alone")] = None


class Arrivals(Listed):
    """Arrivals from drones and programs."""

    sender: Annotated[
        str | None,
        Field(max_length=LONGEST_NAME, description="name of the token; empty for what came without one that is known"),
    ] = None  # fmt: skip
    lot: Annotated[Id | None, Field(description="of this lot alone")] = None
    outcome: Annotated[OutcomeName | None, Field(description="what became of it")] = None


class Stalls(Listed):
    """Stalls of a lot."""

    row: Annotated[str | None, Field(max_length=LONGEST_ROW, description="name of the row")] = None
    kind: Annotated[Kind | None, Field(description="kind of the stalls, as in `stalls`")] = None
    state: Annotated[
        Literal["free", "taken", "unknown"] | None, Field(description="state at the last look at the stall")
    ] = None


class Statistics(Period):
    """Division of the figures of a period."""

    by: Annotated[
        Partition | None,
        Field(description="parts of the lot that are counted by themselves, beside the whole"),
    ] = None


def _parts(words: str) -> Any:
    return Field(max_length=_MOST_PARTS, description=f"{words}; again for another one", json_schema_extra={AGAIN: True})


Part = Annotated[str, Field(min_length=1, max_length=LONGEST_NAME)]


class HoursQuery(Period):
    """Hours of the week in a period."""

    weekday: Annotated[
        str | None, Field(max_length=_LONGEST_LIST, description="days, as mon-fri, sat or mon,wed; all without it")
    ] = None
    hour: Annotated[
        str | None,
        Field(max_length=_LONGEST_LIST, description="hours, as 7-11, 8 or 7-9,16-18; all without it"),
    ] = None


class UseQuery(HoursQuery):
    """Question about parts of a lot at some hours of the week."""

    row: Annotated[tuple[Part, ...], _parts("row, as statistics by `row` name it")] = ()
    zone: Annotated[tuple[Part, ...], _parts("zone, as statistics by `zone` name it")] = ()
    kind: Annotated[tuple[Part, ...], _parts("kind of stalls, as statistics by `kind` name it")] = ()
    section: Annotated[tuple[Part, ...], _parts("section, whose vehicles are counted, not with stalls")] = ()


class ReportOptions(Query):
    """Language and paper of a report."""

    language: Annotated[Language, Field(description="language of the report; en without it")] = "en"
    paper: Annotated[Paper, Field(description="paper of the document; a4 without it")] = "a4"


class ReportQuery(ReportOptions, UseQuery):
    """Question, language and paper of a report."""


class LotsReportQuery(ReportOptions, HoursQuery):
    """Lots, hours, language and paper of a report over several lots."""

    lot: Annotated[
        tuple[Id, ...],
        Field(
            description=f"lot, {MOST_LOTS} at most; again for another one; all without it",
            json_schema_extra={AGAIN: True},
        ),
    ] = ()


class FeedOptions(Period):
    """Survey, or period, of a feed."""

    survey: Annotated[
        Id | None, Field(description="of a feed over a survey: this one; the newest registered one without it")
    ] = None
    valid_s: Annotated[
        float | None,
        Field(
            gt=0, allow_inf_nan=False,
            description=f"of a feed over a survey: seconds after which a state is unknown; {VALID_S:g} without it",
        ),
    ] = None  # fmt: skip


class PlanPart(Query):
    """The part of a plan that is asked for."""

    since: Annotated[
        Whole | None, Field(description="revision; stalls that changed after it, without it all of the plan")
    ] = None
    layout: Annotated[Whole | None, Field(description="version of the layout, for the plan as it was in it")] = None


class SurveysOf(Period):
    """Surveys of a period: all, one, or the newest."""

    survey: Annotated[Id | None, Field(description="this survey alone")] = None
    newest: Annotated[
        int | None, Field(ge=1, le=MOST_ITEMS, description="number of the newest that are asked for"), OF_DIGITS
    ] = None  # fmt: skip


class Days(Query):
    """Some days from now on."""

    days: Annotated[int, Field(ge=1, le=MOST_DAYS, description="number of days from now on"), OF_DIGITS] = 7


class Between(Query):
    """Two surveys of a lot."""

    before: Annotated[Id, Field(description="the earlier survey")]
    after: Annotated[Id, Field(description="the later survey")]


Q = TypeVar("Q", bound=Query)
M = TypeVar("M", bound=BaseModel)


@dataclass(frozen=True, slots=True)
class Request(Generic[Q]):
    """A request without its connection: ``path`` holds the values of the address's fields, ``base`` is the address of
    this server as the client has it, without a last slash, ``now`` the time, UTC, Unix seconds. ``due``: as
    `hawk.lots.queries.NextDue`. ``lots``: ids of those that the role of the client is for; None: all.
    """

    path: Mapping[str, str]
    query: Q
    base: str
    now: float
    due: Callable[[str, str, float | None], datetime | None] = lambda *_: None
    lots: frozenset[str] | None = None

    @property
    def id(self) -> str:
        """The id in the address."""
        return self.path["id"]


def query_of(request: web.Request, model: type[Q]) -> Q:
    """Return the parameters of an address. Raises LotInputError with the parameter and the remedy."""
    given: dict[str, str | list[str]] = {}
    lists = {
        name for name, field in model.model_fields.items()
        if isinstance(field.json_schema_extra, dict) and AGAIN in field.json_schema_extra
    }  # fmt: skip
    for name, value in request.query.items():
        if name == TOKEN_PARAMETER:
            continue
        if name in given and name not in lists:
            raise LotInputError(name, "is there twice: write it once")
        given[name] = request.query.getall(name) if name in lists else value
    return validated(model, given)


def validated(model: type[M], given: Any, tags: Collection[str] = ()) -> M:
    """Return what a model makes of values. Raises LotInputError with the first field that cannot be used.

    ``tags``: names of models, which pydantic puts among those of the fields.
    """
    try:
        return model.model_validate(given)
    except ValidationError as error:
        wrong = wrong_values(error, model, tags, FORMS)[0]
        known = f"; there is {names_of(model)}" if wrong.kind == "extra_forbidden" and len(wrong.location) == 1 else ""
        raise LotInputError(wrong.field or "body", f"{wrong.reason}{known}") from None


def names_of(model: type[BaseModel]) -> str:
    """Return the names of a model's fields, for a sentence."""
    return ", ".join(field.alias or name for name, field in model.model_fields.items()) or "no parameter"

"""When surveys are due by the schedule, and the day's rounds by a forecast. This starts and changes nothing."""

from __future__ import annotations

from collections.abc import Iterator
from http import HTTPStatus
from itertools import pairwise
from typing import TYPE_CHECKING, Final

from aiohttp import web

from hawk.lots.answers import SpokenSentence
from hawk.lots.values import LotInputError, NotFoundError
from hawk.model.day_plan import DayPlan, DayPlanError, Forecast, WeatherHour
from hawk.model.sentences import parts_of, words_of
from hawk.runtime.late import late_functions
from hawk.web.services import SERVICES
from hawk.web.v1 import bodies
from hawk.web.v1.answers import BUSY, NO_LOTS, Answer, answered, due_of, in_time, made, opened
from hawk.web.v1.changes import Body, poster
from hawk.web.v1.parameters import Days, Query, query_of, validated
from hawk.web.v1.refusals import RefusedError

if TYPE_CHECKING:
    from sqlalchemy import Connection

    from hawk.lots import known_lot, names
else:
    known_lot, names = late_functions("hawk.lots.known_lot"), late_functions("hawk.lots.names")

FOR_OPERATORS: Final = "A day is planned by operators: log in as operator."
SLOW: Final = "The flights take too long to plan: ask again; give fewer lots the same time where this stays so."


@answered
async def due(request: web.Request) -> web.StreamResponse:
    """The moments at which surveys of a lot are due; one that has come and is not flown is among them."""
    query, lot = query_of(request, Days), request.match_info["id"]
    async with in_time(BUSY):
        store = await opened(request)
        found = await store.read(lambda connection: _newest(connection, lot))
    if found is None:
        raise NotFoundError("lot: there is no lot with this id; reload the list")
    moments = due_of(request)(*found, query.days)
    return await made(request, lambda: Answer(bodies.DueList(items=moments)))


def _newest(connection: Connection, lot: str) -> tuple[str, str, float | None] | None:
    """Return what `due_of` asks for of a lot."""
    found = known_lot.newest_survey(connection, lot)
    if found is None:
        return None
    return found[0], names.schedule_names(connection, [found[1]])[found[1]], found[2]


@answered
async def listed(request: web.Request) -> web.StreamResponse:
    """The rounds without a forecast, for one battery: none has a start."""
    query_of(request, Query)
    async with in_time(SLOW):
        found = await _planned(request, None, 1)
    return await made(request, lambda: Answer(found))


async def _proposed(request: web.Request, body: Body) -> bodies.DayPlan:
    """Return the rounds for a forecast and batteries. Raises RefusedError, LotInputError."""
    question = validated(bodies.DayPlanQuery, body)
    return await _planned(request, None if question.forecast is None else forecast_of(question.forecast),
                          question.batteries)  # fmt: skip


proposed: Final = poster(bodies.DayPlanQuery, _proposed, FOR_OPERATORS, SLOW)


def forecast_of(given: bodies.Forecast) -> Forecast:
    """Return the forecast of a body. Raises LotInputError where two of its hours overlap."""
    hours = sorted(
        (
            WeatherHour(
                hour.begin.timestamp(),
                hour.begin.timestamp() + 3600.0 * hour.hours,
                hour.wind,
                hour.gust,
                hour.cloud / 100.0,
                hour.rain,
            )
            for hour in given.hours
        ),
        key=lambda hour: hour.begin,
    )
    if any(after.begin < before.end for before, after in pairwise(hours)):
        raise LotInputError("forecast.hours", "two of them are of the same time: give each hour once")
    return Forecast(given.made.timestamp(), tuple(hours))


async def _planned(request: web.Request, forecast: Forecast | None, batteries: int) -> bodies.DayPlan:
    plan = request.app[SERVICES].day_plan
    if plan is None:
        raise RefusedError(HTTPStatus.CONFLICT, "", NO_LOTS)
    try:
        return _answer(await plan(forecast, batteries))
    except DayPlanError as error:
        raise RefusedError(HTTPStatus.CONFLICT, "", words_of(error)) from error


def _answer(plan: DayPlan) -> bodies.DayPlan:
    rounds = [
        bodies.DayRound(
            lots=[bodies.RoundLotName(id=lot, name=name) for lot, name in each.lots],
            due=each.due,
            start=each.start,
            end=each.end,
            seconds=round(each.seconds, 1),
            batteries=each.batteries,
            distance_m=round(each.distance_m, 1),
            problem=each.problem,
            hours=[bodies.RoundStart(at=hour.at, reasons=list(hour.reasons)) for hour in each.hours],
        )
        for each in plan.rounds
    ]
    said = {str(part): SpokenSentence.of(part) for text in _texts(plan) for part in parts_of(text)}
    return bodies.DayPlan(rounds=rounds, problems=list(plan.problems), sentences=list(said.values()))


def _texts(plan: DayPlan) -> Iterator[str]:
    yield from plan.problems
    for each in plan.rounds:
        yield each.problem
        for hour in each.hours:
            yield from hour.reasons

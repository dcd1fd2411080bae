"""The day's rounds by the API: a forecast is refused by its field, and the plan is answered as it was made."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from typing import Any

import pytest

from hawk.model.day_plan import DayPlan, DayPlanError, DayRound, Forecast, StartHour
from hawk.model.sentences import say
from hawk.web.v1 import bodies
from hawk.web.v1.day_plan import forecast_of
from tests.unit.web.v1.archive import Archive

LOT = "0f0e0d0c-0000-4000-8000-000000000001"
NOON = datetime(2026, 5, 4, 12, 0, tzinfo=UTC)
HOUR = {"begin": "2026-05-04T12:00Z", "hours": 3, "wind": 3, "gust": 6.5, "cloud": 40, "rain": 0.2}
GIVEN = {"made": "2026-05-04T11:00+02:00", "hours": [HOUR]}
REASON = say("{rain:g} mm of rain", rain=0.2)


class Planner:
    """Answers one plan, and keeps the questions."""

    def __init__(self) -> None:
        self.asked: list[tuple[Forecast | None, int]] = []
        self.is_flying = False

    async def plan(self, forecast: Forecast | None, batteries: int) -> DayPlan:
        if self.is_flying:
            raise DayPlanError(say("The drone flies: plan the day after its landing."))
        self.asked.append((forecast, batteries))
        hours = (StartHour(NOON, (REASON,)), StartHour(NOON + timedelta(hours=1)))
        one = DayRound(((LOT, "North"),), NOON, hours[1].at, NOON + timedelta(hours=2), 3600.0, 2, 432.1, "", hours)
        return DayPlan((one,), (say("There is no forecast: enter one."),) if forecast is None else ())


@pytest.fixture
def planner(archive: Archive) -> Planner:
    made = Planner()
    archive.stand.rig.day_plan = made.plan
    return made


async def test_a_forecast_is_read_by_hours_and_the_plan_says_why_an_hour_does_not_fit(
    archive: Archive, planner: Planner
) -> None:
    found = await archive.done("/day-plan", batteries=4, forecast=GIVEN)
    bodies.DayPlan.model_validate(found)
    ((forecast, batteries),) = planner.asked
    assert (batteries, forecast and forecast.issued) == (4, (NOON - timedelta(hours=3)).timestamp())
    assert forecast is not None
    (hour,) = forecast.hours
    assert (hour.begin, hour.end) == (NOON.timestamp(), NOON.timestamp() + 3 * 3600)
    assert (hour.wind, hour.gust, hour.cloud, hour.rain) == (3.0, 6.5, 0.4, 0.2)
    (one,) = found["rounds"]
    assert (one["lots"], one["seconds"], one["batteries"]) == ([{"id": LOT, "name": "North"}], 3600.0, 2)
    assert (one["start"], one["end"]) == ("2026-05-04T13:00:00Z", "2026-05-04T14:00:00Z")
    assert [each["reasons"] for each in one["hours"]] == [["0.2 mm of rain"], []]
    assert found["sentences"] == [{"text": "0.2 mm of rain", "code": REASON.code, "values": {"rain": 0.2}}]


async def test_a_viewer_reads_the_rounds_without_a_forecast_and_plans_nothing(
    archive: Archive, planner: Planner
) -> None:
    found = await archive.shown("/day-plan", bodies.DayPlan)
    assert (planner.asked, found["problems"]) == ([(None, 1)], ["There is no forecast: enter one."])
    status, problem = await archive.refused("/day-plan", method="POST", body={})
    assert (status, problem["detail"]) == (403, "A day is planned by operators: log in as operator.")


@pytest.mark.parametrize(
    ("changed", "field", "words"),
    [
        ({"made": "2026-05-04T11:00"}, "forecast.made", "offset"),
        ({"made": "today"}, "forecast.made", "must be a time"),
        ({"hours": []}, "forecast.hours", "1"),
        ({"source": "x"}, "forecast.source", "not known here"),
        ({"hours": [HOUR | {"wind": -1}]}, "forecast.hours[0].wind", "0 or more"),
        ({"hours": [HOUR | {"gust": "strong"}]}, "forecast.hours[0].gust", "must be a number"),
        ({"hours": [HOUR | {"gust": 2}]}, "forecast.hours[0].gust", "must not be less than wind"),
        ({"hours": [HOUR | {"cloud": 101}]}, "forecast.hours[0].cloud", "100 or less"),
        ({"hours": [HOUR | {"rain": None}]}, "forecast.hours[0].rain", "must be a number"),
        ({"hours": [HOUR | {"hours": 0}]}, "forecast.hours[0].hours", "1 or more"),
        ({"hours": [HOUR, HOUR | {"begin": "2026-05-04T14:00Z"}]}, "forecast.hours", "give each hour once"),
    ],
)
async def test_a_wrong_forecast_is_refused_by_its_field(
    archive: Archive, planner: Planner, changed: dict[str, Any], field: str, words: str
) -> None:
    options: dict[str, Any] = {"method": "POST", "operator": True, "body": {"forecast": GIVEN | changed}}
    status, problem = await archive.refused("/day-plan", **options)
    assert (status, problem["field"]) == (422, field)
    assert words in problem["detail"]
    assert planner.asked == []


def test_an_hour_of_the_last_year_is_read() -> None:
    last = HOUR | {"begin": "9999-12-31T23:00Z", "hours": 72}
    (hour,) = forecast_of(bodies.Forecast.model_validate(GIVEN | {"hours": [last]})).hours
    assert hour.end - hour.begin == 72 * 3600


async def test_in_flight_the_day_is_not_planned(archive: Archive, planner: Planner) -> None:
    planner.is_flying = True
    status, problem = await archive.refused("/day-plan")
    assert (status, problem["detail"]) == (409, "The drone flies: plan the day after its landing.")
    assert problem["sentences"]

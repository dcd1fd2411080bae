"""The command plan-day: the forecast of a file or of options, and the lines of the plan."""

from __future__ import annotations

import argparse
import json
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest
from aiohttp import web
from aiohttp.test_utils import TestServer

from hawk.cli import make_parser
from hawk.config.sections import ConfigError
from hawk.survey.day import WHOLE_DAY_H, _asked, given_forecast, plan_lines
from hawk.web.v1 import bodies

NOW = datetime(2026, 5, 4, 10, 40, tzinfo=UTC)
PLAN: dict[str, Any] = {
    "problems": ["schedule: no lot has the name or id Nort: write one of North."],
    "rounds": [
        {
            "lots": [{"id": "a", "name": "North"}, {"id": "b", "name": "South"}],
            "due": "2026-05-04T12:00:00+02:00",
            "start": "2026-05-04T13:00:00+02:00",
            "end": "2026-05-04T13:24:00+02:00",
            "seconds": 1452.0,
            "batteries": 2,
            "distance_m": 512.4,
            "problem": "",
            "hours": [
                {"at": "2026-05-04T11:30:00+02:00", "reasons": ["0.2 mm of rain", "too dark"]},
                {"at": "2026-05-04T12:00:00+02:00", "reasons": ["0.2 mm of rain", "too dark"]},
                {"at": "2026-05-04T13:00:00+02:00", "reasons": []},
            ],
        }
    ],
    "sentences": [],
}


def options(*given: str) -> argparse.Namespace:
    return make_parser().parse_args(["plan-day", *given])


def test_the_weather_of_options_is_a_forecast_of_now_for_the_whole_day() -> None:
    found = given_forecast(options("--wind", "3", "--gust", "6", "--cloud", "40"), NOW)
    read = bodies.Forecast.model_validate(found)
    (hour,) = read.hours
    assert (read.made, hour.begin, hour.hours) == (NOW, NOW.replace(minute=0), WHOLE_DAY_H)
    assert (hour.wind, hour.gust, hour.cloud, hour.rain) == (3.0, 6.0, 40.0, 0.0)
    assert given_forecast(options(), NOW) is None


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (["--wind", "3"], "--gust: is missing"),
        (["--rain", "1"], "--wind: is missing"),
        (["--wind", "8", "--gust", "7"], "--gust: must not be less than --wind (8)"),
        (["--wind", "8", "--forecast", __file__], "--wind: not together with --forecast"),
        (["--forecast", __file__], "is no JSON"),
    ],
)
def test_weather_that_does_not_fit_together_is_refused(given: list[str], words: str) -> None:
    with pytest.raises(ConfigError) as refused:
        given_forecast(options(*given), NOW)
    assert words in str(refused.value)


def test_a_file_is_sent_as_it_is_and_a_huge_one_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "forecast.json"
    file.write_text('{"made": "2026-05-04T06:00Z", "hours": []}', encoding="utf-8")
    assert given_forecast(options("--forecast", str(file)), NOW) == json.loads(file.read_bytes())
    file.write_bytes(b" " * 1_000_001)
    with pytest.raises(ConfigError, match="larger than a forecast can be"):
        given_forecast(options("--forecast", str(file)), NOW)


def test_lines_name_times_lots_batteries_and_each_hour_that_does_not_fit() -> None:
    assert list(plan_lines(PLAN)) == [
        "schedule: no lot has the name or id Nort: write one of North.",
        "13:00-13:24  North, South (due 12:00, UTC+02:00): 24 min, 512 m, batteries: 2",
        "  not at 11:30, 12:00: 0.2 mm of rain; too dark",
        "Nothing flies by itself: a person chooses the lots, arms and takes off.",
    ]
    none = PLAN["rounds"][0] | {"start": None, "end": None, "problem": "It needs 2 batteries; left: 1."}
    assert list(plan_lines({"problems": [], "rounds": [none | {"hours": []}]})) == [
        "no start  North, South (due 12:00, UTC+02:00): 24 min, 512 m, batteries: 2",
        "  It needs 2 batteries; left: 1.",
    ]
    assert list(plan_lines({"problems": [], "rounds": []})) == ["No survey is due in the next 24 hours."]


async def test_an_answer_is_a_plan_and_a_refusal_names_the_field() -> None:
    asked = []

    async def answer(request: web.Request) -> web.Response:
        asked.append(await request.json())
        if asked[-1]["batteries"] == 2:
            return web.json_response({"detail": "must be a time", "field": "forecast.made"}, status=422)
        return web.json_response(PLAN)

    app = web.Application()
    app.router.add_post("/api/v1/day-plan", answer)
    server = TestServer(app)
    await server.start_server()
    try:
        given = options("--url", str(server.make_url("/")))
        assert await _asked(given, {"batteries": 1}) == PLAN
        with pytest.raises(ValueError, match=r"forecast\.made: must be a time"):
            await _asked(given, {"batteries": 2})
    finally:
        await server.close()
    with pytest.raises(OSError, match="cannot be asked"):
        await _asked(given, {"batteries": 1})

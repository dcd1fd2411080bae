"""The command ``hawk-drone plan-day``: prints the day's rounds as a daemon or a desk proposes them. Nothing starts."""

from __future__ import annotations

import argparse
import asyncio
import json
import sys
from collections.abc import Iterator, Mapping
from datetime import UTC, datetime
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from hawk.config import options as values
from hawk.config.sections import ConfigError
from hawk.runtime.late import late

if TYPE_CHECKING:  # the web client: not for the other commands
    import aiohttp

    from hawk.comm import base_socket
    from hawk.survey import run
else:
    aiohttp, base_socket, run = late("aiohttp"), late("hawk.comm.base_socket"), late("hawk.survey.run")

COMMAND: Final = "plan-day"
ANSWER_S: Final = 60.0
"""Real seconds for the answer: a tour over 300 stalls takes seconds to plan."""
LARGEST_BYTES: Final = 1_000_000
"""Largest file of a forecast."""
WHOLE_DAY_H: Final = 30
"""Hours of the weather that options give: rounds of the next 24 hours, and their flights."""
_WEATHER: Final = ("wind", "gust", "cloud", "rain")


def add_plan_day_command(commands: Any) -> None:
    """Add the command to the subparsers of the command line."""
    parser = commands.add_parser(
        COMMAND, help="propose the day's rounds by the schedule of a running daemon or desk: times, batteries, weather"
    )
    parser.add_argument("--url", type=values.some, default="127.0.0.1", metavar="URL", help="page of daemon or desk")
    parser.add_argument("--token", type=values.some, help="the operator's token there")
    parser.add_argument("--certificate", type=values.file, metavar="FILE", help="trust this certificate alone")
    parser.add_argument("--batteries", type=values.whole(1, 100), default=1, metavar="N", help="full batteries (1)")
    parser.add_argument("--forecast", type=values.file, metavar="FILE", help="forecast by hour (JSON)")
    weather = parser.add_argument_group("weather of the whole day, without --forecast")
    weather.add_argument("--wind", type=values.number(0, 100), metavar="M_S", help="wind 10 m above the ground, m/s")
    weather.add_argument("--gust", type=values.number(0, 100), metavar="M_S", help="strongest gusts, m/s")
    weather.add_argument("--cloud", type=values.number(0, 100), metavar="PERCENT", help="cloud in the sky (0)")
    weather.add_argument("--rain", type=values.number(0, 500), metavar="MM", help="rain in an hour (0)")
    parser.add_argument("--json", action="store_true", help="print the answer of the API")
    parser.set_defaults(action=_run)


def _run(options: argparse.Namespace) -> int:
    question = {"batteries": options.batteries, "forecast": given_forecast(options, datetime.now(UTC))}
    try:
        plan = asyncio.run(_asked(options, question))
    except (OSError, ValueError) as error:
        print(f"hawk-drone {COMMAND}: {error}", file=sys.stderr)
        return 1
    for line in [json.dumps(plan, ensure_ascii=False, indent=2)] if options.json else plan_lines(plan):
        print(line)
    return 0


def given_forecast(options: argparse.Namespace, now: datetime) -> object:
    """Return the forecast of a file, or that of the options from an aware time on; None without any.

    Raises:
        ConfigError: The file cannot be read, or the options do not fit together.
    """
    given = [name for name in _WEATHER if getattr(options, name) is not None]
    if options.forecast is not None:
        if given:
            raise ConfigError(f"--{given[0]}: not together with --forecast, which says it for each hour")
        return _read(options.forecast)
    if not given:
        return None
    for name in ("wind", "gust"):
        if getattr(options, name) is None:
            raise ConfigError(f"--{name}: is missing: the weather of a day has --wind and --gust")
    if options.gust < options.wind:
        raise ConfigError(f"--gust: must not be less than --wind ({options.wind:g})")
    begin = now.replace(minute=0, second=0, microsecond=0)
    hour = {
        "begin": begin.isoformat(),
        "hours": WHOLE_DAY_H,
        "wind": options.wind,
        "gust": options.gust,
        "cloud": options.cloud or 0.0,
        "rain": options.rain or 0.0,
    }
    return {"made": now.isoformat(), "hours": [hour]}


def _read(file: Path) -> object:
    try:
        with file.open("rb") as opened:
            data = opened.read(LARGEST_BYTES + 1)
    except OSError as error:
        raise ConfigError(f"--forecast: {file} cannot be read: {error.strerror or error}") from error
    if len(data) > LARGEST_BYTES:
        raise ConfigError(f"--forecast: {file} is larger than a forecast can be: give the hours of this day")
    try:
        return json.loads(data)
    except (ValueError, RecursionError) as error:
        raise ConfigError(f"--forecast: {file} is no JSON: {error}") from error


async def _asked(options: argparse.Namespace, question: Mapping[str, object]) -> dict[str, Any]:
    """Return the answer. Raises OSError without one, ValueError for a refusal, ConfigError for a wrong address."""
    address = run.address_of(options.url)
    run.check_certificate(options.certificate, address)
    tls = run.trusted(options.certificate) if address.is_secure else None
    base = base_socket.BaseSocket(address.host, address.port, token=options.token, tls=tls)
    timeout = aiohttp.ClientTimeout(total=ANSWER_S)
    try:
        async with base.session().post(f"{base.url}/api/v1/day-plan", json=question, timeout=timeout) as response:
            answer = await response.json(content_type=None)
            if not response.ok:
                detail, field = answer["detail"], answer.get("field", "")
                raise ValueError(detail if not field or detail.startswith(field) else f"{field}: {detail}")
            return dict(answer)
    except TimeoutError:
        raise OSError(f"{base.url} did not answer within {ANSWER_S:g} s") from None
    except (aiohttp.ClientError, KeyError, TypeError) as error:
        raise OSError(f"{base.url} cannot be asked: {error}") from error
    finally:
        await base.close()


def plan_lines(plan: Mapping[str, Any]) -> Iterator[str]:
    """Yield the lines of a plan as the API answers it."""
    yield from plan["problems"]
    if not plan["rounds"]:
        yield "No survey is due in the next 24 hours."
    for each in plan["rounds"]:
        lots = ", ".join(lot["name"] for lot in each["lots"])
        start = "no start" if each["start"] is None else f"{_time(each['start'])}-{_time(each['end'])}"
        need = f"{each['seconds'] / 60:.0f} min, {each['distance_m']:.0f} m, batteries: {each['batteries']}"
        has_flight = each["distance_m"] > 0.0
        due = datetime.fromisoformat(each["due"])  # every time of a round is by one clock
        yield f"{start}  {lots} (due {due:%H:%M}, {due.tzname()}){f': {need}' if has_flight else ''}"
        if each["problem"] and each["problem"] not in plan["problems"]:
            yield f"  {each['problem']}"
        for reasons, hours in groupby(each["hours"], lambda hour: "; ".join(hour["reasons"])):
            if reasons:
                yield f"  not at {', '.join(_time(hour['at']) for hour in hours)}: {reasons}"
    if any(each["start"] for each in plan["rounds"]):
        yield "Nothing flies by itself: a person chooses the lots, arms and takes off."


def _time(moment: str) -> str:
    return f"{datetime.fromisoformat(moment):%H:%M}"

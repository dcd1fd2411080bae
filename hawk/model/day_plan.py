"""The plan of a day: which known lots are flown together, when, and with how many batteries. Nothing starts by it."""

from __future__ import annotations

from dataclasses import dataclass, field
from datetime import datetime


@dataclass(frozen=True, slots=True)
class WeatherHour:
    """Weather of a forecast from ``begin`` to ``end``, Unix seconds.

    ``wind`` and ``gust`` are 10 m above the ground, m/s; ``cloud`` is the share (0..1) of the sky; ``rain`` in mm.
    """

    begin: float
    end: float
    wind: float
    gust: float
    cloud: float
    rain: float


@dataclass(frozen=True, slots=True)
class Forecast:
    """A forecast that a person gave. ``issued``: when its source made it, Unix seconds."""

    issued: float
    hours: tuple[WeatherHour, ...] = field(repr=False)


@dataclass(frozen=True, slots=True)
class StartHour:
    """A time at which a round could start, and the reasons against it; none where it fits."""

    at: datetime
    reasons: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class DayRound:
    """A flight over some lots, by id and name, in the order of their tour.

    ``due``: when their surveys are due. ``start`` and ``end``: None where the day has no hour for it, and ``problem``
    or each of ``hours`` says why. ``seconds`` from the first take-off to the last landing, swaps included.
    """

    lots: tuple[tuple[str, str], ...]
    due: datetime
    start: datetime | None
    end: datetime | None
    seconds: float
    batteries: int
    distance_m: float
    problem: str = ""
    hours: tuple[StartHour, ...] = ()


@dataclass(frozen=True, slots=True)
class DayPlan:
    """Rounds of the day in the order of their times. ``problems`` concern the whole day."""

    rounds: tuple[DayRound, ...] = ()
    problems: tuple[str, ...] = ()


class DayPlanError(Exception):
    """No plan can be made now; the text is the reason with the remedy."""
